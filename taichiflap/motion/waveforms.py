"""Formulas of prescribed motions: each a function of time with its exact first and second derivatives.

Every function takes times (s) and returns shape (times, 3): value, rate and acceleration, in units of the amplitude per
second. Angles are in radians. All except the piecewise polynomial `table` accept complex times, so that tests can
differentiate them with a complex step.
"""

import functools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import fourier

Array = NDArray[Any]
Points = tuple[tuple[float, float], ...]


def harmonic(
    times: Array,
    *,
    frequency: float = 0.0,
    amplitude: float,
    phase: float,
    mean: float,
    harmonics: Sequence[tuple[int, float, float]] = (),
) -> Array:
    """`mean + amplitude sin(2 pi f t + phase) + sum of amplitude_n sin(2 pi n f t + phase_n)`.

    Table 2 of Reade & Jankauski (2020), with a mean and higher harmonics `(n, amplitude_n, phase_n)`.
    """
    found = np.zeros((len(times), 3), times.dtype)
    for order, size, advance in ((1, amplitude, phase), *harmonics):
        rate = 2.0 * math.pi * order * frequency
        angle = rate * times + advance
        sine, cosine = np.sin(angle), np.cos(angle)
        found += size * np.stack((sine, rate * cosine, -(rate**2) * sine), axis=1)
    found[:, 0] += mean
    return found


def triangle(times: Array, *, frequency: float, amplitude: float, sharpness: float, phase: float, mean: float) -> Array:
    """Between a sine (sharpness 0) and a triangular wave (towards 1): `amplitude asin(K sin a)/asin K`.

    The stroke of Berman & Wang, J. Fluid Mech. 582 (2007) (section 2), with `a = 2 pi f t + phase`, K the sharpness.
    """
    if sharpness == 0.0:
        return harmonic(times, frequency=frequency, amplitude=amplitude, phase=phase, mean=mean)
    rate = 2.0 * math.pi * frequency
    sine, cosine = np.sin(rate * times + phase), np.cos(rate * times + phase)
    scale = amplitude / math.asin(sharpness)
    # 1 - K^2 sin^2 without the cancellation near K = 1.
    inner = (1.0 - sharpness) * (1.0 + sharpness) + (sharpness * cosine) ** 2
    value = scale * np.arcsin(sharpness * sine)
    first = scale * sharpness * cosine / np.sqrt(inner)
    second = -scale * sharpness * (1.0 - sharpness**2) * sine / inner**1.5
    return np.stack((mean + value, rate * first, rate**2 * second), axis=1)


def trapezoid(
    times: Array, *, frequency: float, amplitude: float, sharpness: float, phase: float, mean: float
) -> Array:
    """Between a sine (sharpness 0) and a square wave (large): `amplitude tanh(C sin a)/tanh C`.

    The pitch of Berman & Wang, J. Fluid Mech. 582 (2007) (section 2), with `a = 2 pi f t + phase`, C the sharpness.
    """
    if sharpness == 0.0:
        return harmonic(times, frequency=frequency, amplitude=amplitude, phase=phase, mean=mean)
    rate = 2.0 * math.pi * frequency
    sine, cosine = np.sin(rate * times + phase), np.cos(rate * times + phase)
    scale = amplitude / math.tanh(sharpness)
    level, slope = np.tanh(sharpness * sine), sharpness * _sech2(sharpness * sine)
    second = -slope * (sine + 2.0 * sharpness * cosine**2 * level)
    return np.stack((mean + scale * level, rate * scale * slope * cosine, rate**2 * scale * second), axis=1)


def ramp(
    times: Array,
    *,
    initial: float,
    amplitude: float,
    start: float,
    ramp: float,
    hold: float | None,
    smoothing: float,
) -> Array:
    """A ramp from `initial` by `amplitude` at a constant rate with rounded corners, and a return after `hold` if it is
    given.

    The pitch-up, hold and return of Eldredge, Wang & Ol, AIAA 2009-3687: ln cosh functions replace the corners at the
    times `start`, `start + ramp`, `start + ramp + hold` and `start + 2 ramp + hold`, relative to the mid value;
    `smoothing` is their `a U/c`, 1/s.
    """

    def rise(t: Any, begin: float) -> Any:
        early, late = smoothing * (t - begin), smoothing * (t - begin - ramp)
        span = 2.0 * smoothing * ramp
        value = 0.5 + (_ln_cosh(early) - _ln_cosh(late)) / span
        rate = smoothing * (np.tanh(early) - np.tanh(late)) / span
        accel = smoothing**2 * (_sech2(early) - _sech2(late)) / span
        return np.stack((value, rate, accel), axis=-1)

    found = rise(times, start)
    if hold is not None:
        back = start + ramp + hold
        middle = np.asarray(start + ramp + 0.5 * hold)
        found = (found - rise(times, back)) / (rise(middle, start) - rise(middle, back))[0]
    return np.asarray(amplitude * found + [initial, 0.0, 0.0])


def table(
    times: Array,
    *,
    points: Points,
    frequency: float | None = None,
    smooth: int | None = None,
    tolerance: float | None = None,
) -> Array:
    """A cubic spline through `points` (time, value): its second derivative is continuous, also across the ends of a
    period.

    Times of points are in s; with a `frequency` the table is periodic and times are in periods.

    Args:
        smooth, tolerance: harmonics fitted to the points instead of a spline through them; see `fourier.series`.
    """
    if smooth or tolerance:
        found = fourier.series(points, smooth, tolerance)
        return harmonic(
            times, frequency=frequency or 0.0, amplitude=0.0, phase=0.0, mean=found.mean, harmonics=found.terms
        )
    spline = _spline(points, frequency is not None)
    scale = frequency or 1.0
    turns = scale * times
    return np.stack((spline(turns), scale * spline(turns, 1), scale**2 * spline(turns, 2)), axis=1)


def start_up(times: Array, duration: float) -> Array:
    """From 0 at t = 0 to 1 at `duration`, with three continuous derivatives: `x^4 (35 - 84 x + 70 x^2 - 20 x^3)`."""
    x = times / duration
    x = np.where(x.real < 0.0, 0.0, np.where(x.real > 1.0, 1.0, x))
    value = x**4 * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)))
    rate = 140.0 * (x * (1.0 - x)) ** 3
    accel = 420.0 * (x * (1.0 - x)) ** 2 * (1.0 - 2.0 * x)
    return np.stack((value, rate / duration, accel / duration**2), axis=1)


def product(one: Array, other: Array) -> Array:
    """The product of two functions with its derivatives."""
    (a, a1, a2), (b, b1, b2) = one.T, other.T
    return np.stack((a * b, a1 * b + a * b1, a2 * b + 2.0 * a1 * b1 + a * b2), axis=1)


@functools.lru_cache(maxsize=16)
def _spline(points: Points, periodic: bool) -> Any:
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - slow to import, and few motions need it

    times, values = np.array(points).T
    if not periodic:
        return CubicSpline(times, values, bc_type="not-a-knot")
    if times[-1] < times[0] + 1.0:
        times, values = np.append(times, times[0] + 1.0), np.append(values, values[0])
    return CubicSpline(times, values, bc_type="periodic")


def _ln_cosh(x: Any) -> Any:
    """`ln cosh x` without overflow, less its constant `ln 2`, which cancels in a difference."""
    size = np.where(np.real(x) < 0.0, -x, x)
    return size + np.log1p(np.exp(-2.0 * size))


def _sech2(x: Any) -> Any:
    """`1/cosh^2 x` without overflow."""
    small = np.exp(-2.0 * np.where(np.real(x) < 0.0, -x, x))
    return 4.0 * small / (1.0 + small) ** 2
