"""Plunge, surge and pitch of a wing section from measured flapping angles.

The arcs of a section at distance r from the hinge are unrolled into the plane (Y, Z), as in blade element theory: r
times the stroke angle along the stroke plane, and r times the deviation normal to it. With the unit vectors F, forward
in the stroke plane, and N, its upward normal, the path is `r (stroke F + deviation N)`; at a stroke plane angle b, for
the right wing, `F = (sin b, cos b)` and `N = (-cos b, sin b)` in (Y, Z), Y pointing down. A left wing is the mirror
image, with the sign of Z reversed. The shortening of the stroke's arc by the cosine of the deviation is neglected.
"""

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.clock import period
from ..case.measured import NAMES, Measured
from ..case.motion import HarmonicPitch, HarmonicPlunge
from . import fourier, waveforms

Array = NDArray[np.float64]
Harmonics = dict[int, complex]
"""Complex amplitudes z of the harmonics `Im(z exp(2 pi i n t))` by order n, and the mean."""

UNEQUAL = 0.08
"""Maximum time shift of a beat's stroke, in periods, for a single frequency."""
RETURNS = 0.1, 1.0
"""Maximum mismatch between both ends of a beat, as a share of the angle's range and in degrees."""
DRIFT = 0.3
"""Maximum change of an angle's mean between beats, as a share of its range within a beat."""
BETWEEN = 2.5
"""Maximum rate of an angle between last and first point, relative to its maximum elsewhere."""
REVERSED = 60.0
"""Maximum jump of the geometric angle of attack at stroke reversal, degrees."""
PHASES = 128
LEAST = 1e-13
"""Share of the largest harmonic below which a harmonic is round-off."""


@dataclass(frozen=True)
class Fit:
    """Fit of one angle.

    Attributes:
        series: mean and harmonics, degrees.
        spread: standard deviation from beat to beat, rms over the beat, degrees; None for one beat.
    """

    series: fourier.Series
    spread: float | None

    @property
    def reach(self) -> tuple[float, float]:
        """Its minimum and maximum, degrees."""
        curve = waveforms.harmonic(
            np.arange(PHASES) / PHASES, frequency=1.0, amplitude=0.0, phase=0.0, mean=self.series.mean,
            harmonics=self.series.terms,
        )[:, 0]  # fmt: skip
        return float(curve.min()), float(curve.max())


def fits(measured: Measured, frequency: float) -> dict[str, Fit]:
    """Fits of stroke (positive forward), deviation (positive up) and rotation (from the normal, positive leaning
    forward).
    """
    times, angles = canonical(measured, frequency)
    return {
        name: Fit(fourier.series(_points(times, values), measured.smooth), _spread(times, values, measured.smooth))
        for name, values in zip(NAMES, angles, strict=True)
    }


def travels(measured: Measured, frequency: float, span: float) -> dict[str, Any]:
    """Plunge, pitch and surge of the section, by key, and its stroke along the stroke plane.

    Args:
        frequency: Hz.
        span: wing.span, m, the reference of radius_share.
    """
    stroke, deviation, rotation = (_harmonics(fit.series) for fit in fits(measured, frequency).values())
    cosine, sine = _direction(measured.stroke_plane_deg)
    across = 1.0 if measured.side == "right" else -1.0
    arc = math.radians(measured.from_hinge(span))
    lean = _sum((-across, rotation), (-across, {0: complex(measured.stroke_plane_deg)}))
    return {
        "plunge": _plunge(_sum((across * arc * cosine, stroke), (across * arc * sine, deviation))),
        "surge": _plunge(_sum((arc * sine, stroke), (-arc * cosine, deviation))),
        "stroke": _plunge(_sum((across * arc, stroke))),
        "pitch": HarmonicPitch(mean_deg=_mean(lean), harmonics_deg=_terms(lean)),
    }


def canonical(measured: Measured, frequency: float) -> tuple[Array, tuple[Array, Array, Array]]:
    """Times in periods, and stroke, deviation and rotation in degrees with the signs of `fits`."""
    rows = np.array(measured.angles_deg)
    times = rows[:, 0] / period(measured.clock, frequency)
    stroke = rows[:, 1] if measured.stroke_positive == "forward" else -rows[:, 1]
    deviation = rows[:, 2] if measured.deviation_positive == "up" else -rows[:, 2]
    rotation = rows[:, 3]
    if measured.rotation_from == "plane":
        rotation = 90.0 - rotation
    elif measured.rotation_from == "attack":
        swept = waveforms.table(times, points=_points(times, stroke), frequency=1.0, smooth=measured.smooth)[:, 1]
        rotation = np.where(swept > 0.0, 90.0 - rotation, rotation - 90.0)
    return times, (stroke, deviation, rotation)


def problem(measured: Measured, frequency: float) -> str:
    """Why the angles are not periodic; empty if they are."""
    times, angles = canonical(measured, frequency)
    count = math.floor(times[-1] - times[0] + 1e-6 + np.median(np.diff(times)))
    for name, values in zip(NAMES, angles, strict=True):
        found = _of_return(times, values, count)
        if found:
            return f"{name} {found}"
    if measured.rotation_from == "attack":
        jump = float(np.abs(np.diff(angles[2])).max())
        if jump > REVERSED:
            there = 90.0 - 0.5 * jump
            return (
                f"the angle of attack is {there:.3g} deg at stroke reversal, where it must pass 90 deg; "
                'give rotation_from = "plane" or "normal", and angles that are counted so'
            )
    return _of_beats(times, angles[0], count, frequency)


def _of_return(times: Array, values: Array, count: int) -> str:
    reach = float(np.ptp(values))
    share, least = RETURNS
    if count < 2:
        missing = max(times[0] + 1.0 - times[-1], 0.0)
        steepest = float(np.abs(np.diff(values) / np.diff(times)).max())
        apart = abs(float(values[-1] - values[0]))
        overlap = times[-1] > times[0] + 1.0 + 1.5 * np.median(np.diff(times))
        if not overlap and apart > BETWEEN * steepest * missing + share * reach + least:
            return f"begins with {values[0]:.3g} deg but ends the beat with {values[-1]:.3g}; give a whole beat"
        return ""
    means = [float(values[one].mean()) for one in _beats(times, count)]
    within = max(float(np.ptp(values[one])) for one in _beats(times, count))
    if max(means) - min(means) > DRIFT * within + least:
        return (
            f"has a mean that drifts from {means[0]:.3g} to {means[-1]:.3g} deg over {count} beats; give beats of "
            "steady flight, or remove the drift"
        )
    return ""


def _of_beats(times: Array, stroke: Array, count: int, frequency: float) -> str:
    """Whether the strokes of all beats are evenly spaced in time."""
    if count < 2:
        return ""
    phases = []
    for one in _beats(times, count):
        (_, _, phase), *_ = fourier.series(_points(times[one], stroke[one]), 1).terms
        phases.append(phase)
    late = np.unwrap(phases) / (2.0 * math.pi)
    if np.ptp(late) <= UNEQUAL:
        return ""
    slope = float(np.polyfit(np.arange(count), late, 1)[0])
    steady = float(np.ptp(late - slope * np.arange(count))) <= UNEQUAL
    cure = (
        f"they look like {frequency * (1.0 + slope):.4g} Hz"
        if steady
        else "give beats of equal length, or times in periods of each beat"
    )
    return (
        f"its {count} beats have unequal lengths: at {frequency:g} Hz their strokes start up to "
        f"{float(np.ptp(late)):.2g} "
        f"periods apart; {cure}"
    )


def _beats(times: Array, count: int) -> list[NDArray[np.bool_]]:
    beat = np.floor(times - times[0] + 1e-9)
    return [beat == number for number in range(count)]


def _spread(times: Array, values: Array, harmonics: int) -> float | None:
    """Standard deviation of an angle from beat to beat, rms over the beat; None with fewer than two whole beats."""
    count = math.floor(times[-1] - times[0] + 1e-6 + np.median(np.diff(times)))
    if count < 2:
        return None
    phases = np.arange(PHASES) / PHASES
    curves = []
    for one in _beats(times, count):
        points = _points(times[one], values[one])
        few = max(1, min(harmonics, fourier.most(points) // 2))
        curves.append(waveforms.table(phases, points=points, frequency=1.0, smooth=few)[:, 0])
    return float(np.sqrt(np.mean(np.var(curves, axis=0, ddof=1))))


def _points(times: Array, values: Array) -> fourier.Points:
    return tuple(zip(times.tolist(), values.tolist(), strict=True))


def _harmonics(series: fourier.Series) -> Harmonics:
    return {0: complex(series.mean)} | {n: cmath.rect(size, phase) for n, size, phase in series.terms}


def _sum(*terms: tuple[float, Harmonics]) -> Harmonics:
    found: Harmonics = {}
    for factor, harmonics in terms:
        for n, z in harmonics.items():
            found[n] = found.get(n, 0.0) + factor * z
    return found


def _plunge(harmonics: Harmonics) -> HarmonicPlunge:
    return HarmonicPlunge(mean=_mean(harmonics), harmonics=_terms(harmonics))


def _mean(harmonics: Harmonics) -> float:
    mean = harmonics[0].real
    return mean if abs(mean) > _least(harmonics) else 0.0


def _terms(harmonics: Harmonics) -> tuple[tuple[int, float, float], ...]:
    least = _least(harmonics)
    return tuple(
        (n, abs(z), math.degrees(cmath.phase(z))) for n, z in sorted(harmonics.items()) if n and abs(z) > least
    )


def _least(harmonics: Harmonics) -> float:
    return LEAST * max(map(abs, harmonics.values()))


def _direction(degrees: float) -> tuple[float, float]:
    """Cosine and sine, exact at right angles."""
    if degrees % 90.0 == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(degrees / 90.0) % 4]
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
