"""Summary of a run: means over its settled beats and their spread, harmonics and phase, peaks, power."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..march.reference import Reference, reference
from ..motion import sampling
from ..motion.stream import in_stream
from ..results.reader import Result
from .beats import Beats, transient, whole_beats
from .similarity import Similarity
from .uncertainty import standard_errors
from .waves import after_reversal, exponentials, exponentials_at_steps, phase, project

REPEATS_WITHIN = 0.01
"""A run is settled if the mean forces of its beats agree within this share of the root-mean-square force."""
FEWEST_BEATS = 3
"""Minimum number of settled beats for this test."""
SAME = 1e-6
"""Standard error, as a share of the mean, below which beats are printed as equal."""
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


@dataclass(frozen=True)
class Statistic:
    """Statistics of a metric over the settled beats.

    Attributes:
        mean: mean of its beat values.
        spread: their standard deviation.
        error: standard error of the mean, see `standard_errors`; None of fewer than ten beats.
    """

    mean: float
    spread: float
    error: float | None

    def over(self, scale: float) -> "Statistic":
        """The statistics divided by a positive number."""
        error = None if self.error is None else self.error / scale
        return Statistic(self.mean / scale, self.spread / scale, error)

    def shown(self, factor: float, digits: int = 4) -> str:
        """The mean times a factor as text, with its standard error if it has one and the beats differ."""
        known = self.error or 0.0
        error = f" ± {factor * known:.2g}" if known > SAME * abs(self.mean) else ""
        return f"{factor * self.mean:.{digits}g}{error}"

    @classmethod
    def each(cls, values: Array) -> list[list["Statistic"]]:
        """Statistics of several metrics of each case, with one value per beat: shape (cases, metrics, beats)."""
        count = values.shape[-1]
        means = values.sum(axis=-1) / count
        spreads = np.sqrt(((values - means[..., None]) ** 2).sum(axis=-1) / count)
        errors = standard_errors(values).astype(object)
        errors[np.isnan(errors.astype(float))] = None
        cases = zip(means.tolist(), spreads.tolist(), errors.tolist(), strict=True)
        return [list(map(cls, *one)) for one in cases]


@dataclass(frozen=True)
class Summary:
    """Settled behaviour of a run. Each attribute is annotated with its units; times are fractions of the period.

    For a non-periodic motion the whole run counts as one beat.

    Attributes:
        beats: number of settled beats, the last of the run, over which statistics are taken.
        settled: whether drift and spread of the mean force over these beats are below 1 % of the root-mean-square
            force. None for a non-periodic motion.
        force_drift: change of the mean force over these beats by a linear fit, relative to the root-mean-square force.
        force_spread: standard deviation of the mean force of these beats, relative to the root-mean-square force.
        force_vertical, force_vertical_normal: mean vertical force, full vector and e_z component alone.
        force_normal, force_axial, force_y, force_z, moment, tip_deflection: means of these variables.
        lift, thrust: mean force normal to the free stream, 90 degrees counter-clockwise from it (along Z for a stream
            along Y), and against it; None without a stream.
        reference_speed, reference_area: what coefficients are made with, see `march.reference`.
        lift_coefficient: lift, or vertical force in hover, over `rho U^2 S / 2`. None if the reference speed or the
            density is zero.
        drag_coefficient, thrust_coefficient: from the force along and against the stream; None without a stream.
        power_coefficient: mean power over `rho U^3 S / 2`.
        propulsive_efficiency: thrust times stream speed over power; None without a stream or if the power is not
            positive.
        lift_over_weight: vertical force of all wings over the weight that they carry; None without `body.mass`.
        reynolds, reduced_frequency, pivot_speed, wing_tip_speed, angle_of_attack_mean, angle_of_attack_rms: see
            `metrics.similarity`.
        strouhal: frequency times the extent of the bent wing's trailing edge across the stream over the stream's speed;
            None without a stream, or where nothing repeats.
        force_normal_peak: largest magnitude of the normal force.
        force_normal_phase: phase lead of its first harmonic over that of the plunge (of the pitch, without plunge),
            degrees in (-180, 180]; None without plunge and pitch, or without a force.
        tip_peak: largest magnitude of the tip deflection.
        tip_peak_time: time of the tip peak, as t/T within the beat.
        tip_peak_after_reversal: the same, from the last stroke reversal; None without plunge.
        power, power_aerodynamic, power_inertial: mean mechanical power of the actuator, and its parts.
        power_positive: mean of the positive part of the power: the power of an actuator without energy storage.
        wake_lost: mean velocity at the wing lost by dropping or absorbing vortices (`wake_lost` of the result),
            relative to the wing's root-mean-square speed: an estimate of the relative error of the forces. None for a
            model without a wake.
        wake_far_error: largest measured error of a wake vortex's velocity by multipoles, m/s; None with direct sums.
        wake_crossings: number of wake-wing crossings in the whole run; None without a wake.
        force_coefficient_peak: largest normal force without the part due to acceleration, over `rho V^2 S / 2`, with
            the root-mean-square speed V of all points of the bent wing through the fluid. Typical values are of order
            one. None if V is zero.
        energy_residual: difference between the work done on the wing and the change of its energy, relative to the
            actuator's gross work (or the gross work on the wing, if larger).
        harmonics: complex amplitudes of the first harmonics of some variables, see `harmonics`; empty for a
            non-periodic motion.
    """

    beats: Annotated[int, "1"]
    settled: Annotated[bool | None, "1"]
    force_drift: Annotated[float, "1"]
    force_spread: Annotated[float, "1"]
    force_vertical: Annotated[Statistic, "N"]
    force_vertical_normal: Annotated[Statistic, "N"]
    force_normal: Annotated[Statistic, "N"]
    force_axial: Annotated[Statistic, "N"]
    force_y: Annotated[Statistic, "N"]
    force_z: Annotated[Statistic, "N"]
    lift: Annotated[Statistic | None, "N"]
    thrust: Annotated[Statistic | None, "N"]
    reference_speed: Annotated[float, "m s-1"]
    reference_area: Annotated[float, "m2"]
    lift_coefficient: Annotated[Statistic | None, "1"]
    drag_coefficient: Annotated[Statistic | None, "1"]
    thrust_coefficient: Annotated[Statistic | None, "1"]
    power_coefficient: Annotated[Statistic | None, "1"]
    propulsive_efficiency: Annotated[float | None, "1"]
    lift_over_weight: Annotated[float | None, "1"]
    reynolds: Annotated[float | None, "1"]
    reduced_frequency: Annotated[float | None, "1"]
    strouhal: Annotated[float | None, "1"]
    pivot_speed: Annotated[float, "m s-1"]
    wing_tip_speed: Annotated[float | None, "m s-1"]
    angle_of_attack_mean: Annotated[float | None, "degree"]
    angle_of_attack_rms: Annotated[float | None, "degree"]
    force_normal_peak: Annotated[Statistic, "N"]
    force_normal_phase: Annotated[float | None, "degree"]
    moment: Annotated[Statistic, "N m"]
    tip_deflection: Annotated[Statistic, "m"]
    tip_peak: Annotated[Statistic, "m"]
    tip_peak_time: Annotated[float, "1"]
    tip_peak_after_reversal: Annotated[float | None, "1"]
    power: Annotated[Statistic, "W"]
    power_aerodynamic: Annotated[Statistic, "W"]
    power_inertial: Annotated[Statistic, "W"]
    power_positive: Annotated[Statistic, "W"]
    force_coefficient_peak: Annotated[float | None, "1"]
    energy_residual: Annotated[float | None, "1"]
    wake_lost: Annotated[float | None, "1"]
    wake_far_error: Annotated[float | None, "m s-1"]
    wake_crossings: Annotated[int | None, "1"]
    harmonics: dict[str, list[complex]]


class Alone:
    """A result as the only one of several runs: its variables have the shape (1, steps)."""

    def __init__(self, result: Result) -> None:
        self.cases, self._result = [result.case], result
        self.scales = [reference(result.case)]

    @property
    def variables(self) -> Sequence[str]:
        """Names of the result's variables."""
        return self._result.variables

    def __getattr__(self, name: str) -> Array:
        values: Array = getattr(self._result, name)
        return values[None]


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

    def __getattr__(self, name: str) -> Array:
        values: Array = getattr(self._runs, name)
        self.__dict__[name] = values = values if self._members is None else values[self._members]
        return values

    def within(self, name: str) -> Array:
        """A variable over the beats that are summarised."""
        values: Array = getattr(self, name)
        return values[:, self.frames]


def summarise(result: Result, beats: Beats | None = None) -> Summary | None:
    """Summary of a run; None without a whole beat.

    Args:
        beats: beats to summarise; the settled beats if None.
    """
    return summaries(Alone(result), beats)[0]


def summaries(runs: Any, beats: Beats | None = None) -> list[Summary | None]:
    """Summary of each of several runs over the same steps; None without a whole beat.

    Args:
        runs: an object with the attributes of a result that a summary reads, the variables of shape (cases, steps), and
            with `cases` and `scales`, their reference values.
        beats: beats to summarise; the settled beats of each if None.
    """
    found: list[Summary | None] = [None] * len(runs.cases)
    for members, own in _alike(runs, beats):
        if own:
            some = Some(runs, members, own)
            for b, summary in zip(members, _summaries(some), strict=True):
                found[b] = summary
    return found


def _alike(runs: Any, beats: Beats | None) -> Iterator[tuple[list[int], Beats]]:
    """Runs with the same beats, and the beats to summarise."""
    clocks: dict[tuple[float, float], list[int]] = {}
    for b, case in enumerate(runs.cases):
        clocks.setdefault((case.step, case.beat), []).append(b)
    for members in clocks.values():
        if beats is not None:
            yield members, beats
            continue
        whole = whole_beats(runs.cases[members[0]], runs.time[members[0]])
        if not whole:
            yield members, whole
            continue
        dropped = transient(whole, *(getattr(runs, name)[members] for name in ("force_y", "force_z"))).tolist()
        for count in dict.fromkeys(dropped):
            yield [b for b, own in zip(members, dropped, strict=True) if own == count], whole.after(count)


def _summaries(runs: Some) -> list[Summary]:
    """Summary of each of some runs that are alike."""
    time, beats, periodic = runs.time, runs.beats, runs.case.periodic
    of_beats = {name: beats.means(getattr(runs, name)) for name in MEANS}
    of_beats["power_positive"] = beats.means(np.maximum(runs.power, 0.0))
    tip = runs.tip_deflection
    of_beats["force_normal_peak"], of_beats["tip_peak"] = beats.peaks(runs.force_normal), beats.peaks(tip)
    means = _each(of_beats)
    streams = [b for b, case in enumerate(runs.cases) if case.fluid.streams]
    along = {b: in_stream(runs.cases[b], of_beats["force_y"][b], of_beats["force_z"][b]) for b in streams}
    in_streams = {b: _each({"lift": lift[None], "thrust": thrust[None]})[0] for b, (lift, thrust) in along.items()}
    peaks = np.argmax(np.abs(tip[:, beats.last]), axis=1)
    peak_times = (time[beats.last][peaks] / runs.case.beat).tolist()
    sizes = beats.force_size(runs.force_y, runs.force_z)
    unrest = _unrest(np.stack((of_beats["force_y"], of_beats["force_z"]), axis=1), sizes)
    waves = _waves(runs) if periodic else [{}] * len(runs.cases)
    coefficients, residuals = _force_coefficients(runs), _energy_residuals(runs)
    has = runs.variables
    summaries = []
    for b, (case, scale) in enumerate(zip(runs.cases, runs.scales, strict=True)):
        found: Any = means[b] | in_streams.get(b, {"lift": None, "thrust": None})
        drift, spread = unrest[b]
        after = case, peak_times[b]
        summaries.append(Summary(
            **found,
            **_coefficients(scale, found["lift"] or found["force_vertical"], found["thrust"], found["power"]),
            **vars(Similarity.of(case, scale)),
            lift_over_weight=_over_weight(case, found["force_vertical"].mean),
            strouhal=_strouhal(case, time, tip[b], runs.frames),
            beats=len(beats),
            settled=len(beats) >= FEWEST_BEATS and max(drift, spread) <= REPEATS_WITHIN if periodic else None,
            force_drift=drift,
            force_spread=spread,
            force_normal_phase=phase(case, float(time[runs.frames][-1]), waves[b]["force_normal"][0])
            if waves[b] else None,
            tip_peak_time=_fraction(peak_times[b]) if periodic else peak_times[b],
            tip_peak_after_reversal=after_reversal(*after),
            force_coefficient_peak=coefficients[b],
            energy_residual=residuals[b],
            wake_lost=_wake_lost(runs, b) if "wake_lost" in has else None,
            wake_far_error=float(runs.wake_far_error[b, -1]) if "wake_far_error" in has else None,
            wake_crossings=int(runs.wake_crossings[b, -1]) if "wake_crossings" in has else None,
            harmonics=waves[b],
        ))  # fmt: skip
    return summaries


def _each(of_beats: dict[str, Array]) -> list[dict[str, Statistic]]:
    """Statistics of each case by name, of values of shape (cases, beats)."""
    names, values = list(of_beats), np.stack(list(of_beats.values()), axis=1)
    return [dict(zip(names, found, strict=True)) for found in Statistic.each(values)]


def _coefficients(scale: Reference, lift: Statistic, thrust: Statistic | None, power: Statistic) -> Any:
    """Coefficients and efficiency of a summary, with their reference values."""
    drag = thrust and Statistic(-thrust.mean, thrust.spread, thrust.error)
    forces = {"lift_coefficient": lift, "drag_coefficient": drag, "thrust_coefficient": thrust}
    size = scale.force
    found = {name: one.over(size) if one and size else None for name, one in forces.items()}
    return {
        **found,
        "power_coefficient": power.over(scale.power) if scale.power else None,
        "propulsive_efficiency": thrust.mean * scale.speed / power.mean if thrust and power.mean > 0.0 else None,
        "reference_speed": scale.speed,
        "reference_area": scale.area,
    }


def _over_weight(case: Case, lift: float) -> float | None:
    """See `Summary.lift_over_weight`."""
    body = case.body
    return body.wings * lift / (body.mass * GRAVITY) if body.mass else None


def _strouhal(case: Case, time: Array, tip: Array, frames: slice) -> float | None:
    """See `Summary.strouhal`."""
    if not (case.periodic and case.motion.frequency and case.fluid.streams):
        return None
    moved = sampling.sample(case.motion, time[frames])
    cosine, sine = np.cos(moved[:, sampling.PITCH]), np.sin(moved[:, sampling.PITCH])
    behind = (1.0 - case.wing.pivot) * case.wing.chord
    y = moved[:, sampling.SURGE] + behind * cosine - tip[frames] * sine
    z = moved[:, sampling.PLUNGE] + behind * sine + tip[frames] * cosine
    across, _ = in_stream(case, y, z)
    return float(case.motion.frequency * np.ptp(across) / math.hypot(*case.fluid.velocity))


def _force_coefficients(runs: Some) -> list[float | None]:
    """See `Summary.force_coefficient_peak`."""
    frames, time = runs.frames, runs.time
    if "force_normal_unsteady" not in runs.variables or frames.stop - frames.start < 2:
        return [None] * len(runs.cases)
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
    """Mean square of the rate of change of values that are `apart` seconds apart, shape (cases, steps)."""
    rate = np.empty_like(values)
    np.subtract(values[:, 2:], values[:, :-2], out=rate[:, 1:-1])
    rate[:, 1:-1] *= 0.5 / apart
    rate[:, 0], rate[:, -1] = (values[:, 1] - values[:, 0]) / apart, (values[:, -1] - values[:, -2]) / apart
    found: list[float] = (np.square(rate, out=rate).sum(axis=1) / rate.shape[1]).tolist()
    return found


def _energy_residuals(runs: Some) -> list[float | None]:
    """See `Summary.energy_residual`."""
    # From the state at the end of the previous beat.
    over = slice(max(runs.frames.start - 1, 0), runs.frames.stop)
    time = runs.time[over]
    if "energy" not in runs.variables or len(time) < 2 or time[1] - time[0] > 1.5 * runs.case.step:
        return [None] * len(runs.cases)
    net, energy, power = (getattr(runs, name)[:, over] for name in ("power_net", "energy", "power"))
    gross = np.maximum(np.trapezoid(np.abs(power), time), np.trapezoid(np.abs(net), time)).tolist()
    left = np.abs(np.trapezoid(net, time) - (energy[:, -1] - energy[:, 0])).tolist()
    return [one / whole if whole else 0.0 for one, whole in zip(left, gross, strict=True)]


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


def _wake_lost(runs: Some, b: int) -> float:
    """Velocity lost with the wake, relative to the speed of mid-chord through the fluid."""
    case = runs.cases[b]
    behind = (0.5 - case.wing.pivot) * case.wing.chord
    speed = _speed(case, behind, runs.time, runs.frames)
    lost = float(np.mean(runs.within("wake_lost")[b]))
    return lost / speed if speed else 0.0


def _unrest(forces: Array, sizes: Array) -> list[tuple[float, float]]:
    """Drift and spread of the mean forces of beats, shape (cases, 2, beats), relative to the `sizes` of the cases."""
    count = forces.shape[-1]
    if count < 2:
        return [(0.0, 0.0)] * len(forces)
    place = np.arange(count) - 0.5 * (count - 1)
    slopes = (forces * place).sum(axis=-1) / (place**2).sum()
    drifts = np.hypot(slopes[:, 0], slopes[:, 1]) * (count - 1)
    spreads = np.sqrt(np.var(forces, axis=-1).sum(axis=-1))
    each = zip(drifts.tolist(), spreads.tolist(), sizes.tolist(), strict=True)
    return [(drift / size, spread / size) if size else (0.0, 0.0) for drift, spread, size in each]


def _waves(runs: Some) -> list[dict[str, list[complex]]]:
    case, frames = runs.case, runs.frames
    if _has_every_step(case, runs.time):
        turns = exponentials_at_steps(case.beat, case.step, frames.start, frames.stop, ORDERS)
    else:
        turns = exponentials(case.beat, runs.time[frames], ORDERS)
    found = project(np.stack([runs.within(name) for name in WAVING], axis=1), turns)
    return [dict(zip(WAVING, waves, strict=True)) for waves in found.transpose(1, 2, 0).tolist()]


def _fraction(value: float) -> float:
    """`value` modulo 1, with round-off below 1 taken as zero."""
    rest = value % 1.0
    return 0.0 if math.isclose(rest, 1.0) else rest
