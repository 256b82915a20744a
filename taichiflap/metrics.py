"""What a run amounts to: means over its settled beats and their spread, harmonics and phase, peaks, power."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import motion
from .beats import Beats, settled_beats
from .case import Case
from .motion import PITCH, PLUNGE
from .results import Result

REPEATS_WITHIN = 0.01
"""A run has settled when the mean force of its beats stays within this share of the force's root mean square."""
FEWEST_BEATS = 3
"""Settled beats that it takes to say so."""
MOMENTS = 512
"""Times a beat at which the motion is looked at."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Statistic:
    """A quantity over the settled beats: the mean of its beat values and their standard deviation."""

    mean: float
    spread: float

    @classmethod
    def over(cls, values: Array) -> "Statistic":
        """Statistic of one value a beat."""
        mean = float(values.sum()) / len(values)
        return cls(mean, math.sqrt(float(((values - mean) ** 2).sum()) / len(values)))


@dataclass(frozen=True)
class Summary:
    """Settled behaviour of a run. SI units; `phase` in degrees; times as fractions of the period.

    Of a motion that has no frequency the whole run counts as one beat.

    Attributes:
        beats: number of beats that the statistics are over, the last of the run: its settled beats.
        settled: whether these beats repeat: neither does their mean force drift, nor does it spread, by more than
            1 % of the force's root mean square. None where nothing repeats.
        force_drift: change of the mean force across these beats, by a straight line through them, as a share of the
            force's root mean square.
        force_spread: standard deviation of the mean force of these beats, as such a share.
        force_vertical, force_vertical_normal: mean vertical force, full vector and e_z component alone.
        lift, thrust: mean force across a free stream, a quarter turn counter-clockwise from it (along Z for one along
            Y), and against it; None without a stream.
        force_normal_peak: largest magnitude of the normal force.
        force_normal_phase: phase advance of its first harmonic over that of the plunge (of the pitch, if the
            wing does not plunge), degrees in (-180, 180]; None if the wing does neither.
        tip_peak: largest magnitude of the tip deflection.
        tip_peak_time: when, as t/T within the beat.
        tip_peak_after_reversal: when, after the last stroke reversal; None if the wing does not plunge.
        power, power_aerodynamic, power_inertial: mean mechanical power of the actuator and its parts.
        power_positive: mean of the power where it is positive: what an actuator that stores nothing spends.
        wake_lost: mean velocity at the wing of the wake that was dropped or absorbed (`wake_lost` of the result), over
            the wing's root mean square speed: about what the forces err by. None for a model without a wake.
        wake_far_error: largest error found in a wake vortex's velocity by multipoles, m/s; None where every pair is
            summed.
        wake_crossings: how often a wake vortex came upon the wing, in the whole run; None without a wake.
    """

    beats: int
    settled: bool | None
    force_drift: float
    force_spread: float
    force_vertical: Statistic
    force_vertical_normal: Statistic
    lift: Statistic | None
    thrust: Statistic | None
    force_normal_peak: Statistic
    force_normal_phase: float | None
    tip_peak: Statistic
    tip_peak_time: float
    tip_peak_after_reversal: float | None
    power: Statistic
    power_aerodynamic: Statistic
    power_inertial: Statistic
    power_positive: Statistic
    wake_lost: float | None
    wake_far_error: float | None
    wake_crossings: int | None


def summarise(result: Result, beats: Beats | None = None) -> Summary | None:
    """Summary of a run; None while it has no whole beat.

    Args:
        beats: what to take it over; its settled beats, if None.
    """
    case = result.case
    time = result.time
    beats = settled_beats(result) if beats is None else beats
    if not beats:
        return None

    def mean(values: Array) -> Statistic:
        return Statistic.over(beats.means(values))

    def peak(values: Array) -> Statistic:
        return Statistic.over(beats.peaks(values))

    tip, normal, power = result.tip_deflection, result.force_normal, result.power
    peak_time = float(time[beats.last][np.argmax(np.abs(tip[beats.last]))]) / case.beat
    speed = math.hypot(*case.fluid.velocity)
    stream_y, stream_z = (component / speed if speed else 0.0 for component in case.fluid.velocity)
    drift, spread = _unrest(beats.mean_forces(result), beats.force_size(result))
    return Summary(
        beats=len(beats),
        settled=len(beats) >= FEWEST_BEATS and max(drift, spread) <= REPEATS_WITHIN if case.periodic else None,
        force_drift=drift,
        force_spread=spread,
        force_vertical=mean(result.force_vertical),
        force_vertical_normal=mean(result.force_vertical_normal),
        lift=mean(result.force_z * stream_y - result.force_y * stream_z) if speed else None,
        thrust=mean(-(result.force_y * stream_y + result.force_z * stream_z)) if speed else None,
        force_normal_peak=peak(normal),
        force_normal_phase=_phase(case, time, normal, beats) if case.periodic else None,
        tip_peak=peak(tip),
        tip_peak_time=_fraction(peak_time, 1.0) if case.periodic else peak_time,
        tip_peak_after_reversal=after_reversal(case, peak_time),
        power=mean(power),
        power_aerodynamic=mean(result.power_aerodynamic),
        power_inertial=mean(result.power_inertial),
        power_positive=mean(np.maximum(power, 0.0)),
        wake_lost=_wake_lost(result, beats.frames) if "wake_lost" in result.variables else None,
        wake_far_error=float(result.wake_far_error[-1]) if "wake_far_error" in result.variables else None,
        wake_crossings=int(result.wake_crossings[-1]) if "wake_crossings" in result.variables else None,
    )


def _wake_lost(result: Result, frames: slice) -> float:
    """Velocity that the wake left out, over the speed of the middle of the chord through the fluid."""
    stream_y, stream_z = result.case.fluid.velocity
    plunge_rate, pitch_rate = (np.gradient(values, result.time)[frames] for values in (result.plunge, result.pitch))
    turning = 0.5 * result.case.wing.chord * pitch_rate
    speed = math.sqrt(float(np.mean((plunge_rate - stream_z) ** 2 + stream_y**2 + turning**2)))
    lost = float(np.mean(result.wake_lost[frames]))
    return lost / speed if speed else 0.0


def _unrest(forces: Array, size: float) -> tuple[float, float]:
    """Drift and spread of the mean forces of beats, as shares of `size`."""
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
        values: at `time`, along the last axis.

    Returns:
        Shape (count, ...), as the other axes of `values`.
    """
    turn = np.exp(-2j * math.pi / case.beat * time)
    found, power = [], turn
    for _ in range(count):
        found.append(2.0 * np.mean(values * power, axis=-1))
        power = power * turn
    return np.array(found)


def harmonic(case: Case, time: Array, values: Array, order: int = 1) -> complex:
    """Complex amplitude of one harmonic of a series; see `harmonics`."""
    return complex(harmonics(case, time, values, order)[-1])


def reversals(case: Case, first: float, last: float) -> Array:
    """Times (beats) of stroke reversal, where the plunge velocity changes sign, from `first` to `last`."""
    step = case.beat / MOMENTS if case.periodic else case.step
    return motion.reversals(case.motion, first * case.beat, last * case.beat, step) / case.beat


def after_reversal(case: Case, beats: float) -> float | None:
    """Time (beats) from the last stroke reversal to a time (beats); None if there was none within a beat."""
    found = reversals(case, max(0.0, beats - 1.0), beats)
    return max(0.0, beats - float(found[-1])) if len(found) else None


def _phase(case: Case, time: Array, values: Array, beats: Beats) -> float | None:
    frames = beats.frames
    moments = case.beat * (round(float(time[frames][-1]) / case.beat) - np.arange(MOMENTS) / MOMENTS)
    moved = motion.sample(case.motion, moments)
    for axis in (PLUNGE, PITCH):
        driver = harmonic(case, moments, moved[:, axis])
        if abs(driver) > motion.NOISE * np.abs(moved[:, axis]).max():
            advance = np.angle(harmonic(case, time[frames], values[frames]) / driver, deg=True)
            return 180.0 - (180.0 - float(advance)) % 360.0
    return None


def _fraction(value: float, period: float) -> float:
    """`value` modulo `period`, with round-off below the period taken as zero."""
    rest = value % period
    return 0.0 if math.isclose(rest, period, abs_tol=1e-9) else rest
