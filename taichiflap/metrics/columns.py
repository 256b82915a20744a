"""The numbers of a summary, each of several runs at once: single runs and studies have one implementation.

A column is a `Statistics`, a list with a number or None for each run, or None if it is defined for none of them. The
harmonics are a dictionary of lists.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..march.reference import reference
from ..motion import sampling
from ..motion.stream import in_stream
from ..results.reader import Result
from .beats import Beats, transient, whole_beats
from .similarity import Similarity
from .statistic import Statistics
from .waves import after_reversal, exponentials, exponentials_at_steps, phase, project

REPEATS_WITHIN = 0.01
"""A run is settled if the mean forces of its beats agree within this share of the root-mean-square force."""
FEWEST_BEATS = 3
"""Minimum number of settled beats for this test."""
FIRST_MODE = 0.25
"""Mean over the chord of the squared first mode of a clamped plate, with tip value 1."""
GRAVITY = 9.80665
"""Standard acceleration of gravity, m/s2."""
MEANS = (
    "force_vertical", "force_vertical_normal", "force_normal", "force_axial", "force_y", "force_z", "moment",
    "tip_deflection", "power", "power_aerodynamic", "power_inertial",
)  # fmt: skip
"""Variables with a mean over each beat in the summary."""
WAVING, ORDERS = ("force_normal", "force_vertical", "tip_deflection"), 3
"""Variables with harmonics in the summary, and the number of harmonics."""

Array = NDArray[np.float64]


class Alone:
    """A result as the only one of several runs: its variables have the shape (1, steps)."""

    def __init__(self, result: Result, places: Any = slice(None)) -> None:
        self.cases, self._result, self._places = [result.case], result, places
        self.scales = [reference(result.case)]

    @property
    def variables(self) -> Sequence[str]:
        """Names of the result's variables."""
        return self._result.variables

    def at(self, places: Sequence[int]) -> "Alone":
        """The variables at some of the steps."""
        return Alone(self._result, places)

    def __getattr__(self, name: str) -> Array:
        values: Array = getattr(self._result, name)
        return values[None, self._places]


class Some:
    """Some of several runs, whose variables and beats are alike.

    Attributes:
        case: one of them, for what they have in common.
        time: s, shape (steps,).
        beats, frames: the beats that are summarised, and their steps.
    """

    def __init__(self, runs: Any, members: Sequence[int], beats: Beats) -> None:
        self._runs, self._members = runs, None if len(members) == len(runs.cases) else list(members)
        self.cases, self.scales = ([of[b] for b in members] for of in (runs.cases, runs.scales))
        self.case, self.time, self.variables = self.cases[0], runs.time[members[0]], runs.variables
        self.beats, self.frames = beats, beats.frames

    def within(self, name: str, over: slice | None = None) -> Array:
        """A variable over the beats that are summarised, or over other steps, shape (runs, steps)."""
        return self._own(getattr(self._runs, name)[:, self.frames if over is None else over])

    def at(self, name: str, places: Sequence[int]) -> Array:
        """A variable at some of the steps."""
        return self._own(getattr(self._runs.at(places), name))

    def _own(self, values: Array) -> Array:
        return values if self._members is None else values[self._members]


def columns(runs: Any, beats: Beats | None = None) -> Iterator[tuple[list[int], dict[str, Any]]]:
    """Columns by the names of the summary's attributes, for groups of runs; runs without a whole beat are left out.

    Args:
        runs: an object with the attributes of a result that a summary reads, the variables of shape (runs, steps); with
            `cases` and `scales`, their reference values; and with `at`, which gives the same at some of the steps.
            Either all are in a free stream or none, and likewise with something that moves.
        beats: beats to summarise; the settled beats of each if None.
    """
    clocks: dict[tuple[float, float], list[int]] = {}
    for b, case in enumerate(runs.cases):
        clocks.setdefault((case.step, case.beat), []).append(b)
    for members in clocks.values():
        whole = whole_beats(runs.cases[members[0]], runs.time[members[0]]) if beats is None else beats
        if not whole:
            continue
        values, squares = _over_beats(Some(runs, members, whole))
        dropped = [0] * len(members)
        if beats is None:
            forces = np.stack((values["force_y"], values["force_z"]), axis=1)
            dropped = transient(forces, whole.force_size(squares)).tolist()
        for count in dict.fromkeys(dropped):
            places = [i for i, own in enumerate(dropped) if own == count]
            some = Some(runs, [members[i] for i in places], whole.after(count))
            kept = {name: one[places, count:] for name, one in values.items()}
            yield [members[i] for i in places], _columns(some, kept, squares[places, count:])


def _over_beats(runs: Some) -> tuple[dict[str, Array], Array]:
    """Values of each beat, shape (runs, beats): means and peaks by name, and sums of the squared force."""
    beats, steps = runs.beats, slice(None)
    of = {name: runs.within(name, steps) for name in MEANS}
    found = {name: beats.means(values) for name, values in of.items()}
    found["power_positive"] = beats.means(np.maximum(of["power"], 0.0))
    found["force_normal_peak"], found["tip_peak"] = beats.peaks(of["force_normal"]), beats.peaks(of["tip_deflection"])
    return found, beats.squares(of["force_y"], of["force_z"])


def _columns(runs: Some, of_beats: dict[str, Array], squares: Array) -> dict[str, Any]:
    """Columns of some runs that are alike, from their values of each beat."""
    case, time, beats, periodic = runs.case, runs.time, runs.beats, runs.case.periodic
    if case.fluid.streams:
        along = [in_stream(*one) for one in zip(runs.cases, of_beats["force_y"], of_beats["force_z"], strict=True)]
        of_beats["lift"], of_beats["thrust"] = map(np.array, zip(*along, strict=True))
    found: dict[str, Any] = {"lift": None, "thrust": None, **Statistics.each(of_beats)}
    peaks = np.argmax(np.abs(runs.within("tip_deflection", beats.last)), axis=1)
    peak_times = (time[beats.last][peaks] / case.beat).tolist()
    drifts, spreads = _unrest(np.stack((of_beats["force_y"], of_beats["force_z"]), axis=1), beats.force_size(squares))
    settled = [len(beats) >= FEWEST_BEATS and max(one) <= REPEATS_WITHIN for one in zip(drifts, spreads, strict=True)]
    waves = _waves(runs) if periodic else {}
    alike = [vars(Similarity.of(*one)) for one in zip(runs.cases, runs.scales, strict=True)]
    return {
        **found,
        **_coefficients(runs, found),
        **{name: [one[name] for one in alike] for name in alike[0]},
        "lift_over_weight": _over_weight(runs.cases, found["force_vertical"].mean.tolist()),
        "strouhal": _strouhal(runs) if case.fluid.streams and periodic else None,
        "beats": [len(beats)] * len(runs.cases),
        "settled": settled if periodic else None,
        "force_drift": drifts,
        "force_spread": spreads,
        "force_normal_phase": _phases(runs, waves["force_normal"]) if waves else None,
        "tip_peak_time": [_fraction(one) for one in peak_times] if periodic else peak_times,
        "tip_peak_after_reversal": [after_reversal(*one) for one in zip(runs.cases, peak_times, strict=True)],
        "force_coefficient_peak": _force_coefficients(runs),
        "energy_residual": _energy_residuals(runs),
        "wake_lost": _wake_lost(runs) if "wake_lost" in runs.variables else None,
        "wake_far_error": _last(runs, "wake_far_error", float),
        "wake_crossings": _last(runs, "wake_crossings", int),
        "harmonics": waves,
    }


def _coefficients(runs: Some, found: Mapping[str, Any]) -> dict[str, Any]:
    """Coefficients and efficiency, with their reference values."""
    sizes, powers = (np.array([getattr(scale, name) for scale in runs.scales]) for name in ("force", "power"))
    lift, thrust, power = found["lift"] or found["force_vertical"], found["thrust"], found["power"]
    drag = thrust and Statistics(-thrust.mean, thrust.spread, thrust.error)
    forces = {"lift_coefficient": lift, "drag_coefficient": drag, "thrust_coefficient": thrust}
    coefficients = {name: one.over(sizes) if one and sizes.all() else None for name, one in forces.items()}
    speeds = [scale.speed for scale in runs.scales]
    each = zip(thrust.mean.tolist(), speeds, power.mean.tolist(), strict=True) if thrust else ()
    efficiencies = [pull * speed / spent if spent > 0.0 else None for pull, speed, spent in each]
    return {
        **coefficients,
        "power_coefficient": power.over(powers) if powers.all() else None,
        "propulsive_efficiency": efficiencies or None,
        "reference_speed": speeds,
        "reference_area": [scale.area for scale in runs.scales],
    }


def _over_weight(cases: Sequence[Case], lifts: Sequence[float]) -> list[float | None]:
    """See `Summary.lift_over_weight`."""
    bodies = zip((case.body for case in cases), lifts, strict=True)
    return [body.wings * lift / (body.mass * GRAVITY) if body.mass else None for body, lift in bodies]


def _strouhal(runs: Some) -> list[float | None]:
    """See `Summary.strouhal`."""
    found: list[float | None] = []
    for case, tip in zip(runs.cases, runs.within("tip_deflection"), strict=True):
        moved = sampling.sample(case.motion, runs.time[runs.frames])
        cosine, sine = np.cos(moved[:, sampling.PITCH]), np.sin(moved[:, sampling.PITCH])
        behind = (1.0 - case.wing.pivot) * case.wing.chord
        y = moved[:, sampling.SURGE] + behind * cosine - tip * sine
        z = moved[:, sampling.PLUNGE] + behind * sine + tip * cosine
        across, _ = in_stream(case, y, z)
        found.append(float(case.motion.frequency * np.ptp(across) / math.hypot(*case.fluid.velocity)))
    return found


def _force_coefficients(runs: Some) -> list[float | None] | None:
    """See `Summary.force_coefficient_peak`."""
    frames, time = runs.frames, runs.time
    if "force_normal_unsteady" not in runs.variables or frames.stop - frames.start < 2:
        return None
    apart = (time[frames.stop - 1] - time[frames.start]) / (frames.stop - frames.start - 1)
    turning, bending = (_mean_square_rate(runs.within(name), apart) for name in ("pitch", "tip_deflection"))
    steady = np.abs(runs.within("force_normal") - runs.within("force_normal_unsteady")).max(axis=1).tolist()
    found: list[float | None] = []
    for b, (case, scale) in enumerate(zip(runs.cases, runs.scales, strict=True)):
        chord = case.wing.chord
        square = _speed(case, (0.5 - case.wing.pivot) * chord, time, frames) ** 2
        square += turning[b] * chord**2 / 12.0 + bending[b] * FIRST_MODE
        size = 0.5 * case.fluid.density * square * scale.area
        found.append(steady[b] / size if size else None)
    return found


def _mean_square_rate(values: Array, apart: float) -> list[float]:
    """Mean square of the rate of change of values that are `apart` seconds apart, shape (runs, steps)."""
    rate = np.empty_like(values)
    np.subtract(values[:, 2:], values[:, :-2], out=rate[:, 1:-1])
    rate[:, 1:-1] *= 0.5 / apart
    rate[:, 0], rate[:, -1] = (values[:, 1] - values[:, 0]) / apart, (values[:, -1] - values[:, -2]) / apart
    found: list[float] = (np.square(rate, out=rate).sum(axis=1) / rate.shape[1]).tolist()
    return found


def _energy_residuals(runs: Some) -> list[float] | None:
    """See `Summary.energy_residual`."""
    # From the state at the end of the previous beat.
    over = slice(max(runs.frames.start - 1, 0), runs.frames.stop)
    time = runs.time[over]
    if "energy" not in runs.variables or len(time) < 2 or time[1] - time[0] > 1.5 * runs.case.step:
        return None
    half = 0.5 * np.diff(time)
    weights = np.append(half, 0.0) + np.append(0.0, half)
    net, power = runs.within("power_net", over), runs.within("power", over)
    gross = np.maximum(_integral(np.abs(power), weights), _integral(np.abs(net), weights)).tolist()
    before, after = runs.at("energy", [over.start, over.stop - 1]).T
    left = np.abs(_integral(net, weights) - (after - before)).tolist()
    return [one / whole if whole else 0.0 for one, whole in zip(left, gross, strict=True)]


def _integral(values: Array, weights: Array) -> Array:
    """Integral over time by the trapezoidal rule, shape (runs,)."""
    found: Array = np.einsum("bt,t->b", values, weights)
    return found


def _has_every_step(case: Case, time: Array) -> bool:
    """Whether series have every step, so that values that depend only on time can be reused."""
    return bool(time[-1] == case.step * (len(time) - 1))


def _speed(case: Case, behind: float, time: Array, frames: slice) -> float:
    """Root-mean-square speed (m/s) through the fluid of a point of the rigid chord over some frames."""
    if not _has_every_step(case, time):
        return sampling.typical_speed(case.motion, behind, case.fluid.velocity, time[frames])
    return sampling.speed_at_steps(
        case.motion, behind, case.fluid.velocity, case.step, case.steps + 1, frames.start, frames.stop
    )


def _wake_lost(runs: Some) -> list[float]:
    """Velocity lost with the wake, relative to the speed of mid-chord through the fluid."""
    found = []
    for case, lost in zip(runs.cases, runs.within("wake_lost"), strict=True):
        behind = (0.5 - case.wing.pivot) * case.wing.chord
        speed = _speed(case, behind, runs.time, runs.frames)
        found.append(float(np.mean(lost)) / speed if speed else 0.0)
    return found


def _last(runs: Some, name: str, kind: Any) -> list[Any] | None:
    """A variable at the end of the run; None if there is no such variable."""
    if name not in runs.variables:
        return None
    return [kind(one) for one in runs.within(name, slice(-1, None))[:, 0]]


def _unrest(forces: Array, sizes: Array) -> tuple[list[float], list[float]]:
    """Drift and spread of the mean forces of beats, shape (runs, 2, beats), relative to the `sizes` of the runs."""
    count = forces.shape[-1]
    if count < 2:
        return [0.0] * len(forces), [0.0] * len(forces)
    place = np.arange(count) - 0.5 * (count - 1)
    slopes = (forces * place).sum(axis=-1) / (place**2).sum()
    drifts = np.hypot(slopes[:, 0], slopes[:, 1]) * (count - 1)
    spreads = np.sqrt(np.var(forces, axis=-1).sum(axis=-1))
    drift, spread = (np.divide(one, sizes, out=np.zeros(len(sizes)), where=sizes > 0.0) for one in (drifts, spreads))
    return drift.tolist(), spread.tolist()


def _waves(runs: Some) -> dict[str, list[list[complex]]]:
    """Harmonics of each run by the variable's name."""
    case, frames = runs.case, runs.frames
    if _has_every_step(case, runs.time):
        turns = exponentials_at_steps(case.beat, case.step, frames.start, frames.stop, ORDERS)
    else:
        turns = exponentials(case.beat, runs.time[frames], ORDERS)
    return {name: project(runs.within(name), turns).T.tolist() for name in WAVING}


def _phases(runs: Some, waves: Sequence[Sequence[complex]]) -> list[float | None]:
    """See `Summary.force_normal_phase`."""
    last = float(runs.time[runs.frames][-1])
    return [phase(case, last, wave[0]) for case, wave in zip(runs.cases, waves, strict=True)]


def _fraction(value: float) -> float:
    """`value` modulo 1, with round-off below 1 taken as zero."""
    rest = value % 1.0
    return 0.0 if math.isclose(rest, 1.0) else rest
