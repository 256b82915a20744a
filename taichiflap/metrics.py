"""What a run amounts to: cycle means and their spread, harmonics and phase, peaks, power."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .case import Case
from .results import Result

SETTLED_BEATS = 5
"""Statistics are over the last beats of a run: so many, or half of them if there are fewer than twice that."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Statistic:
    """A quantity over the settled beats: the mean of its beat values and their standard deviation."""

    mean: float
    spread: float

    @classmethod
    def over(cls, values: list[float]) -> "Statistic":
        """Statistic of one value a beat."""
        return cls(float(np.mean(values)), float(np.std(values)))


@dataclass(frozen=True)
class Summary:
    """Settled behaviour of a run. SI units; `phase` in degrees; times as fractions of the period.

    Attributes:
        beats: number of beats that the statistics are over.
        force_vertical, force_vertical_normal: mean vertical force, full vector and e_z component alone.
        force_normal_peak: largest magnitude of the normal force.
        force_normal_phase: phase advance of its first harmonic over that of the plunge (of the pitch, if the
            wing does not plunge), degrees in (-180, 180]; None if the wing does neither.
        tip_peak: largest magnitude of the tip deflection.
        tip_peak_time: when, as t/T within the beat.
        tip_peak_after_reversal: when, after the last stroke reversal; None if the wing does not plunge.
        power, power_aerodynamic, power_inertial: mean mechanical power of the actuator and its parts.
        power_positive: mean of the power where it is positive: what an actuator that stores nothing spends.
    """

    beats: int
    force_vertical: Statistic
    force_vertical_normal: Statistic
    force_normal_peak: Statistic
    force_normal_phase: float | None
    tip_peak: Statistic
    tip_peak_time: float
    tip_peak_after_reversal: float | None
    power: Statistic
    power_aerodynamic: Statistic
    power_inertial: Statistic
    power_positive: Statistic


def summarise(result: Result) -> Summary | None:
    """Summary of a run over its settled beats; None while it has no whole beat."""
    case = result.case
    time = result.time
    beats = list(settled_beats(case, time))
    if not beats:
        return None

    def mean(values: Array) -> Statistic:
        return Statistic.over([float(np.mean(values[beat])) for beat in beats])

    def peak(values: Array) -> Statistic:
        return Statistic.over([float(np.max(np.abs(values[beat]))) for beat in beats])

    tip, normal, power = result.tip_deflection, result.force_normal, result.power
    last = beats[-1]
    peak_time = case.motion.frequency * float(time[last][np.argmax(np.abs(tip[last]))])
    return Summary(
        beats=len(beats),
        force_vertical=mean(result.force_vertical),
        force_vertical_normal=mean(result.force_vertical_normal),
        force_normal_peak=peak(normal),
        force_normal_phase=_phase(case, time, normal, beats),
        tip_peak=peak(tip),
        tip_peak_time=_fraction(peak_time, 1.0),
        tip_peak_after_reversal=after_reversal(case, peak_time),
        power=mean(power),
        power_aerodynamic=mean(result.power_aerodynamic),
        power_inertial=mean(result.power_inertial),
        power_positive=mean(np.maximum(power, 0.0)),
    )


def settled_beats(case: Case, time: Array) -> Iterator[NDArray[np.intp]]:
    """Indices of the frames of each settled beat: those after its start, up to and with its end."""
    beat = np.ceil(np.round(time * case.motion.frequency, 9)).astype(int)
    whole = round(float(time[-1]) * case.motion.frequency, 9) // 1 if len(time) else 0
    count = min(SETTLED_BEATS, math.ceil(whole / 2))
    for number in range(int(whole) - count + 1, int(whole) + 1):
        frames = np.flatnonzero(beat == number)
        if len(frames):
            yield frames


def harmonic(case: Case, time: Array, values: Array, order: int = 1) -> complex:
    """Complex amplitude `a` of a harmonic over whole beats: `values` holds `Re(a exp(2 pi i order f t))`."""
    turn = np.exp(-2j * math.pi * order * case.motion.frequency * time)
    return complex(2.0 * np.mean(values * turn))


def after_reversal(case: Case, beats: float) -> float | None:
    """Time (beats) since the plunge velocity last vanished; None if the wing does not plunge."""
    if not case.motion.plunge.amplitude:
        return None
    return _fraction(beats + case.motion.plunge.phase_deg / 360.0 - 0.25, 0.5)


def _phase(case: Case, time: Array, values: Array, beats: list[NDArray[np.intp]]) -> float | None:
    motion = case.motion
    driver = motion.plunge if motion.plunge.amplitude else motion.pitch if motion.pitch.amplitude_deg else None
    if driver is None:
        return None
    frames = np.concatenate(beats)
    advance = np.angle(harmonic(case, time[frames], values[frames]), deg=True) + 90.0 - driver.phase_deg
    return 180.0 - (180.0 - float(advance)) % 360.0


def _fraction(value: float, period: float) -> float:
    """`value` modulo `period`, with round-off below the period taken as zero."""
    rest = value % period
    return 0.0 if math.isclose(rest, period, abs_tol=1e-9) else rest
