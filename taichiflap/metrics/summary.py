"""Summary of a run: means over its settled beats and their spread, harmonics and phase, peaks, power."""

import functools
import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..case.motion import Travel
from ..march.reference import reference
from ..motion import sampling
from ..motion.stream import in_stream
from ..results.reader import Result
from .beats import Beats, settled_beats
from .similarity import Similarity
from .uncertainty import standard_errors

REPEATS_WITHIN = 0.01
"""A run is settled if the mean forces of its beats agree within this share of the root-mean-square force."""
FEWEST_BEATS = 3
"""Minimum number of settled beats for this test."""
MOMENTS = 512
"""Number of times per beat at which the motion is sampled."""
RESOLVED = 1e-12
"""Difference (beats) below which two times count as equal."""
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
        """The mean times a factor as text, with its standard error if it has one."""
        error = f" ± {factor * self.error:.2g}" if self.error else ""
        return f"{factor * self.mean:.{digits}g}{error}"

    @classmethod
    def each(cls, values: Array) -> list["Statistic"]:
        """Statistics of several metrics, each with one value per beat: shape (metrics, beats)."""
        count = values.shape[1]
        means = values.sum(axis=1) / count
        spreads = np.sqrt(((values - means[:, None]) ** 2).sum(axis=1) / count)
        errors = [None if math.isnan(error) else error for error in standard_errors(values).tolist()]
        return [cls(*one) for one in zip(means.tolist(), spreads.tolist(), errors, strict=True)]


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
            degrees in (-180, 180]; None without plunge and pitch.
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


def summarise(result: Result, beats: Beats | None = None) -> Summary | None:
    """Summary of a run; None without a whole beat.

    Args:
        beats: beats to summarise; the settled beats if None.
    """
    case = result.case
    time = result.time
    beats = settled_beats(result) if beats is None else beats
    if not beats:
        return None
    series = {name: getattr(result, name) for name in MEANS}
    tip, normal = series["tip_deflection"], series["force_normal"]
    of_beats = dict(zip(series, beats.means(np.stack(list(series.values()))), strict=True))
    of_beats["power_positive"] = beats.means(np.maximum(series["power"], 0.0))
    if case.fluid.streams:
        of_beats["lift"], of_beats["thrust"] = in_stream(case, of_beats["force_y"], of_beats["force_z"])
    of_beats["force_normal_peak"], of_beats["tip_peak"] = beats.peaks(np.stack((normal, tip)))
    found: Any = dict(zip(of_beats, Statistic.each(np.stack(list(of_beats.values()))), strict=True))
    lift, thrust = found.pop("lift", None), found.pop("thrust", None)
    peak_time = float(time[beats.last][np.argmax(np.abs(tip[beats.last]))]) / case.beat
    drift, spread = _unrest(np.stack((of_beats["force_y"], of_beats["force_z"])), beats.force_size(result))
    waves = _waves(case, time, series, beats.frames) if case.periodic else {}
    return Summary(
        **found,
        **_coefficients(case, lift or found["force_vertical"], thrust, found["power"]),
        **vars(Similarity.of(case)),
        lift=lift,
        thrust=thrust,
        lift_over_weight=_over_weight(case, found["force_vertical"].mean),
        strouhal=_strouhal(case, time, tip, beats.frames),
        beats=len(beats),
        settled=len(beats) >= FEWEST_BEATS and max(drift, spread) <= REPEATS_WITHIN if case.periodic else None,
        force_drift=drift,
        force_spread=spread,
        force_normal_phase=_phase(case, float(time[beats.frames][-1]), waves["force_normal"][0]) if waves else None,
        tip_peak_time=_fraction(peak_time) if case.periodic else peak_time,
        tip_peak_after_reversal=after_reversal(case, peak_time),
        force_coefficient_peak=_force_coefficient(result, beats.frames),
        energy_residual=_energy_residual(result, beats.frames),
        wake_lost=_wake_lost(result, beats.frames) if "wake_lost" in result.variables else None,
        wake_far_error=float(result.wake_far_error[-1]) if "wake_far_error" in result.variables else None,
        wake_crossings=int(result.wake_crossings[-1]) if "wake_crossings" in result.variables else None,
        harmonics=waves,
    )


def _coefficients(case: Case, lift: Statistic, thrust: Statistic | None, power: Statistic) -> Any:
    """Coefficients and efficiency of a summary, with their reference values."""
    scale = reference(case)
    drag = thrust and Statistic(-thrust.mean, thrust.spread, thrust.error)
    forces = {"lift_coefficient": lift, "drag_coefficient": drag, "thrust_coefficient": thrust}
    found = {name: one.over(scale.force) if one and scale.force else None for name, one in forces.items()}
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


def _force_coefficient(result: Result, frames: slice) -> float | None:
    """See `Summary.force_coefficient_peak`."""
    case = result.case
    if "force_normal_unsteady" not in result.variables or frames.stop - frames.start < 2:
        return None
    chord = case.wing.chord
    behind = (0.5 - case.wing.pivot) * chord
    square = _speed(case, behind, result.time, frames) ** 2
    apart = (result.time[frames.stop - 1] - result.time[frames.start]) / (frames.stop - frames.start - 1)
    turning = np.gradient(result.pitch[frames], apart)
    bending = np.gradient(result.tip_deflection[frames], apart)
    square += float(np.mean(turning**2)) * chord**2 / 12.0 + float(np.mean(bending**2)) * FIRST_MODE
    scale = 0.5 * case.fluid.density * square * reference(case).area
    steady = result.force_normal[frames] - result.force_normal_unsteady[frames]
    return float(np.abs(steady).max()) / scale if scale else None


def _energy_residual(result: Result, frames: slice) -> float | None:
    """See `Summary.energy_residual`."""
    # From the state at the end of the previous beat.
    over = slice(max(frames.start - 1, 0), frames.stop)
    time = result.time[over]
    if "energy" not in result.variables or len(time) < 2 or time[1] - time[0] > 1.5 * result.case.step:
        return None
    net, energy, power = (getattr(result, name)[over] for name in ("power_net", "energy", "power"))
    gross = max(np.trapezoid(np.abs(power), time), np.trapezoid(np.abs(net), time))
    return float(abs(np.trapezoid(net, time) - (energy[-1] - energy[0])) / gross) if gross else 0.0


def _has_every_step(case: Case, time: Array) -> bool:
    """Whether series have every step, so that values that depend only on time can be reused."""
    return bool(time[-1] == case.step * (len(time) - 1))


def _speed(case: Case, behind: float, time: Array, frames: slice) -> float:
    """Root-mean-square speed (m/s) through the fluid of a point of the rigid chord over some frames."""
    if not _has_every_step(case, time):
        return sampling.typical_speed(case.motion, behind, case.fluid.velocity, time[frames])
    return sampling.speed_at_steps(case.motion, behind, case.fluid.velocity, case.step, case.steps + 1, frames)


def _wake_lost(result: Result, frames: slice) -> float:
    """Velocity lost with the wake, relative to the speed of mid-chord through the fluid."""
    case = result.case
    behind = (0.5 - case.wing.pivot) * case.wing.chord
    speed = _speed(case, behind, result.time, frames)
    lost = float(np.mean(result.wake_lost[frames]))
    return lost / speed if speed else 0.0


def _unrest(forces: Array, size: float) -> tuple[float, float]:
    """Drift and spread of the mean forces of beats, relative to `size`."""
    count = forces.shape[1]
    if count < 2 or not size:
        return 0.0, 0.0
    place = np.arange(count) - 0.5 * (count - 1)
    slope = (forces * place).sum(axis=1) / (place**2).sum()
    spread = math.sqrt(np.sum(np.var(forces, axis=1)))
    return float(np.hypot(*slope)) * (count - 1) / size, spread / size


def harmonics(case: Case, time: Array, values: Array, count: int) -> NDArray[np.complex128]:
    """Complex amplitudes `a_n`, n = 1 ... count, over whole beats: `values` holds `Re(a_n exp(2 pi i n f t))`.

    Args:
        values: values at `time`, along the last axis.

    Returns:
        Shape (count, ...), with the other axes of `values`.
    """
    return _project(values, _turns(case.beat, time, count))


def _turns(beat: float, time: Array, count: int) -> tuple[Array, Array]:
    """Real and imaginary part of `exp(-2 pi i n f t)`, n = 1 ... count, each of shape (count, times)."""
    angle = 2.0 * math.pi / beat * time
    turn = np.cos(angle) - 1j * np.sin(angle)
    powers = np.empty((count, len(time)), np.complex128)
    powers[0] = turn
    for n in range(1, count):
        np.multiply(powers[n - 1], turn, out=powers[n])
    return powers.real.copy(), powers.imag.copy()


@functools.lru_cache(maxsize=32)
def _turns_at_steps(beat: float, step: float, first: int, last: int) -> tuple[Array, Array]:
    """Those of the harmonics of a summary at some steps; the cases of a study have them in common."""
    return _turns(beat, step * np.arange(first, last, dtype=np.float64), ORDERS)


def _project(values: Array, turns: tuple[Array, Array]) -> NDArray[np.complex128]:
    # Real and imaginary part apart: einsum's sums of real numbers are several times faster, and need no BLAS,
    # whose rounding goes by the number of its threads.
    real, imaginary = (np.einsum("...t,nt->n...", values, part) for part in turns)
    return (real + 1j * imaginary) * (2.0 / values.shape[-1])


def harmonic(case: Case, time: Array, values: Array, order: int = 1) -> complex:
    """Complex amplitude of one harmonic of a series; see `harmonics`."""
    return complex(harmonics(case, time, values, order)[-1])


def reversals(case: Case, first: float, last: float) -> Array:
    """Times (beats) of stroke reversal from `first` to `last`, where the velocity along the stroke changes sign."""
    step = case.beat / MOMENTS if case.periodic else case.step
    return sampling.reversals(case.motion, first * case.beat, last * case.beat, step) / case.beat


def after_reversal(case: Case, beats: float) -> float | None:
    """Time (beats) since the last stroke reversal; None if there was none within a beat."""
    # Of whole beats: the cases of a study have them in common.
    whole = math.floor(beats) if case.periodic else 0
    found = reversals(case, max(whole - 1, 0), whole + 1)
    before = found[(found > beats - 1.0 - RESOLVED) & (found < beats + RESOLVED)]
    return max(0.0, beats - float(before[-1])) if len(before) else None


def _waves(case: Case, time: Array, series: dict[str, Array], frames: slice) -> dict[str, list[complex]]:
    if _has_every_step(case, time):
        turns = _turns_at_steps(case.beat, case.step, frames.start, frames.stop)
    else:
        turns = _turns(case.beat, time[frames], ORDERS)
    found = _project(np.stack([series[name][frames] for name in WAVING]), turns)
    return dict(zip(WAVING, found.T.tolist(), strict=True))


def _phase(case: Case, last: float, force: complex) -> float | None:
    """Phase lead (degrees) of a first harmonic, up to the time `last` (s), over that of the driving motion."""
    driver = _driver(case, round(last / case.beat))
    return None if driver is None else 180.0 - (180.0 - float(np.angle(force / driver, deg=True))) % 360.0


def _driver(case: Case, count: int) -> complex | None:
    """First harmonic of the plunge (or of the pitch, without plunge) in the last of `count` beats."""
    moves = case.motion
    firsts = (_swing(axis, moves.frequency, moves.growth, case.beat, count) for axis in (moves.stroke, moves.pitch))
    return next((first for first in firsts if first), None)


@functools.lru_cache(maxsize=256)
def _swing(axis: Travel, frequency: float | None, growth: float, beat: float, count: int) -> complex:
    """First harmonic of plunge or pitch in the last of `count` beats; zero if it is only round-off."""
    turns = count - np.arange(MOMENTS) / MOMENTS
    moved = sampling.sample_axis(axis, frequency, growth, beat * turns)[:, 0]
    first = complex(2.0 * np.mean(moved * np.exp(-2j * math.pi * turns)))
    return first if abs(first) > sampling.NOISE * np.abs(moved).max() else 0j


def _fraction(value: float) -> float:
    """`value` modulo 1, with round-off below 1 taken as zero."""
    rest = value % 1.0
    return 0.0 if math.isclose(rest, 1.0) else rest
