"""Runs reduced to numbers: those of each beat, and those of the beats that are summarised.

This is all that a summary reads of the series, each of which is passed over a few times while it is in the processor's
cache.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..march.reference import reference
from ..motion import sampling
from ..motion.stream import in_stream
from ..results.reader import Result
from .beats import Beats, transient
from .waves import exponentials, exponentials_at_steps, project

MEANS = (
    "force_vertical", "force_vertical_normal", "force_normal", "force_axial", "force_y", "force_z", "moment",
    "tip_deflection", "power", "power_aerodynamic", "power_inertial",
)  # fmt: skip
"""Variables with a mean over each beat in the summary."""
OF_BEATS = (*MEANS, "power_positive", "force_normal_peak", "tip_peak")
"""Numbers of a beat with statistics in the summary."""
WAVING, ORDERS = ("force_normal", "force_vertical", "tip_deflection"), 3
"""Variables with harmonics in the summary, and the number of harmonics."""

Array = NDArray[np.float64]


class Some:
    """Some of several runs, with the same steps and beats.

    Attributes:
        case: one of them, for what they have in common.
        time: s, shape (steps,).
        step: time between two steps, s.
        beats: all beats of which some are summarised.
        every_step: whether the series have every step, so that values that depend only on time can be reused.
    """

    def __init__(self, runs: Any, members: Sequence[int], beats: Beats) -> None:
        self._runs, self._members = runs, None if len(members) == len(runs.cases) else list(members)
        self.cases, self.scales = ([of[b] for b in members] for of in (runs.cases, runs.scales))
        self.beats = beats
        self.case, self.time, self.variables = self.cases[0], runs.time[members[0]], runs.variables
        first, last = beats.frames.start, beats.frames.stop - 1
        self.step = float(self.time[last] - self.time[first]) / max(last - first, 1)
        self.every_step = bool(self.time[-1] == self.case.step * (len(self.time) - 1))

    def __getattr__(self, name: str) -> Array:
        """A variable, shape (runs, steps)."""
        return self._own(getattr(self._runs, name))

    def at(self, name: str, places: Any) -> Array:
        """A variable at some of the steps."""
        return self._own(getattr(self._runs.at(places), name))

    def _own(self, values: Array) -> Array:
        return values if self._members is None else values[self._members]


class Alone:
    """A result as the only one of several runs: its variables have the shape (1, steps)."""

    def __init__(self, result: Result, places: Any = slice(None)) -> None:
        self.cases, self._result, self._places = [result.case], result, places
        self.scales = [reference(result.case)]

    @property
    def variables(self) -> Sequence[str]:
        """Names of the result's variables."""
        return self._result.variables

    def at(self, places: Any) -> "Alone":
        """The variables at some of the steps."""
        return Alone(self._result, places)

    def __getattr__(self, name: str) -> Array:
        values: Array = getattr(self._result, name)
        return values[None, self._places]


class Kept:
    """The beats of several runs that are summarised: all but the first `dropped` of each.

    Attributes:
        start, stop: first frame of each run, shape (runs,), and the frame after the last.
        count: number of frames of each run.
        weights: one for each beat that is kept and zero for others, shape (runs, beats).
    """

    def __init__(self, beats: Beats, dropped: NDArray[np.intp]) -> None:
        self.beats, self.dropped = beats, dropped
        self.start, self.stop = beats.edges[dropped], int(beats.edges[-1])
        self.count = self.stop - self.start
        self.weights = np.where(np.arange(len(beats)) < dropped[:, None], 0.0, 1.0)

    def total(self, values: Array) -> Array:
        """Sum of a variable, shape (runs,)."""
        found: Array = (self.beats.sums(values) * self.weights).sum(axis=1)
        return found

    def frame(self, values: Array, after: int) -> Array:
        """A variable some frames after the start of each run."""
        return np.take_along_axis(values, self.start[:, None] + after, axis=1)[:, 0]

    def square_rate(self, values: Array, step: float) -> Array:
        """Mean square of the rate of change of a variable with `step` seconds between two frames, shape (runs,).

        The differences are central, and one-sided at both ends.
        """
        # What all runs share has one row.
        values = values[:1] if values.strides[0] == 0 else values
        first, last = int(self.beats.edges[0]), self.stop - 1
        squares = np.empty(values.shape)
        squares[:, : first + 1], squares[:, last:] = 0.0, 0.0
        inner = squares[:, first + 1 : last]
        np.square(np.subtract(values[:, first + 2 : self.stop], values[:, first : last - 1], out=inner), out=inner)
        begin, end = self.frame(values, 1) - self.frame(values, 0), values[:, last] - values[:, last - 1]
        ends = 4.0 * (begin**2 + end**2) - self.frame(squares, 0)
        return (self.total(squares) + ends) * ((0.5 / step) ** 2 / self.count)

    def integral(self, values: Array) -> Array:
        """Sum of a variable by the trapezoidal rule from the end of the beat before, shape (runs,)."""
        before = np.where(self.start > 0, self.frame(values, -1), -self.frame(values, 0))
        return self.total(values) + 0.5 * (before - values[:, self.stop - 1])


def reduce(runs: Some, settle: bool) -> dict[str, Array]:
    """Numbers of runs by name, each an array with the runs as leading axis.

    Args:
        settle: whether the starting transient is dropped.

    Returns:
        `of_beats`, values of each beat, shape (runs, OF_BEATS, beats), and `squares`, sums of the squared force, shape
        (runs, beats); `dropped`, the number of beats before those that are summarised; and of these `speed` of
        mid-chord through the fluid and `tip_peak_time`, and, if they are defined, `steady`, `turning`, `bending`,
        `energy_residual`, `waves`, shape (runs, WAVING, ORDERS), `extent`, and those of a wake.
    """
    beats = runs.beats
    values = {name: beats.means(getattr(runs, name)) for name in MEANS}
    values["power_positive"] = beats.means(np.maximum(runs.power, 0.0))
    values["force_normal_peak"], values["tip_peak"] = beats.peaks(runs.force_normal), beats.peaks(runs.tip_deflection)
    squares = beats.squares(runs.force_y, runs.force_z)
    dropped = np.zeros(len(squares), np.intp)
    if settle:
        dropped = transient(np.stack((values["force_y"], values["force_z"]), axis=1), beats.force_size(squares))
    kept, last = Kept(beats, dropped), beats.last
    peaks = np.argmax(np.abs(runs.tip_deflection[:, last]), axis=1)
    found = {
        "of_beats": np.stack([values[name] for name in OF_BEATS], axis=1),
        "squares": squares,
        "dropped": dropped,
        "speed": _speeds(runs, kept),
        "tip_peak_time": runs.time[last][peaks] / runs.case.beat,
    }
    if "force_normal_unsteady" in runs.variables and last.stop - last.start > 1:
        peaks = beats.peaks(runs.force_normal - runs.force_normal_unsteady)
        found["steady"] = (peaks * kept.weights).max(axis=1)
        found["turning"] = kept.square_rate(runs.pitch, runs.step)
        found["bending"] = kept.square_rate(runs.tip_deflection, runs.step)
    if "energy" in runs.variables and 0.0 < runs.step <= 1.5 * runs.case.step:
        found["energy_residual"] = _energy_residual(runs, kept)
    if runs.case.periodic:
        found["waves"] = _waves(runs, kept)
        if runs.case.fluid.streams:
            found["extent"] = _extents(runs, kept)
    return found | _of_wake(runs, kept)


def _speeds(runs: Some, kept: Kept) -> Array:
    """Root-mean-square speed (m/s) of mid-chord of the rigid wing through the fluid."""
    found = []
    for case, start in zip(runs.cases, kept.start.tolist(), strict=True):
        how = case.motion, (0.5 - case.wing.pivot) * case.wing.chord, case.fluid.velocity
        if runs.every_step:
            found.append(sampling.speed_at_steps(*how, case.step, case.steps + 1, start, kept.stop))
        else:
            found.append(sampling.typical_speed(*how, runs.time[start : kept.stop]))
    return np.array(found)


def _energy_residual(runs: Some, kept: Kept) -> Array:
    """See `Summary.energy_residual`."""
    net, power = runs.power_net, runs.power
    gross = runs.step * np.maximum(kept.integral(np.abs(power)), kept.integral(np.abs(net)))
    # From the state at the end of the previous beat.
    before = np.maximum(kept.beats.edges - 1, 0)
    energy = runs.at("energy", before)
    gained = energy[:, -1] - np.take_along_axis(energy, kept.dropped[:, None], axis=1)[:, 0]
    left = np.abs(runs.step * kept.integral(net) - gained)
    return np.divide(left, gross, out=np.zeros(len(left)), where=gross != 0.0)


def _waves(runs: Some, kept: Kept) -> NDArray[np.complex128]:
    """Harmonics of each run, shape (runs, WAVING, ORDERS)."""
    edges, first = kept.beats.edges, int(kept.beats.edges[0])
    each = np.diff(edges)
    if runs.every_step:
        turns = exponentials_at_steps(runs.case.beat, runs.case.step, first, kept.stop, ORDERS)
    else:
        turns = exponentials(runs.case.beat, runs.time[first : kept.stop], ORDERS)
    found = []
    # Beats of as many steps are added first: the exponentials are the same in all of them.
    alike = runs.every_step and (each == each[0]).all()
    for name in WAVING:
        values = getattr(runs, name)[:, first : kept.stop]
        if alike:
            folded = np.einsum("rbt,rb->rt", values.reshape(len(values), len(each), -1), kept.weights)
            sums = project(folded, (turns[0][:, : each[0]], turns[1][:, : each[0]]))
        else:
            sums = project(values * np.repeat(kept.weights, each, axis=1), turns)
        found.append(sums.T * (2.0 / kept.count)[:, None])
    return np.stack(found, axis=1)


def _extents(runs: Some, kept: Kept) -> Array:
    """Extent (m) of the bent wing's trailing edge across the stream."""
    found = []
    for case, tip, start in zip(runs.cases, runs.tip_deflection, kept.start, strict=True):
        moved = sampling.sample(case.motion, runs.time[start : kept.stop])
        cosine, sine = np.cos(moved[:, sampling.PITCH]), np.sin(moved[:, sampling.PITCH])
        behind, bent = (1.0 - case.wing.pivot) * case.wing.chord, tip[start : kept.stop]
        y = moved[:, sampling.SURGE] + behind * cosine - bent * sine
        z = moved[:, sampling.PLUNGE] + behind * sine + bent * cosine
        across, _ = in_stream(case, y, z)
        found.append(np.ptp(across))
    return np.array(found)


def _of_wake(runs: Some, kept: Kept) -> dict[str, Array]:
    """Mean velocity lost with the wake, and its largest error and number of crossings at the end of the run."""
    found = {
        name: getattr(runs, name)[:, -1] for name in ("wake_far_error", "wake_crossings") if name in runs.variables
    }
    if "wake_lost" in runs.variables:
        found["wake_lost"] = kept.total(runs.wake_lost) / kept.count
    return found
