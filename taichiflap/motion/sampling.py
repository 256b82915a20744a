"""Prescribed motion of the pivot: plunge Z, pitch theta and surge Y, with exact first and second derivatives.

Table 2 of Reade & Jankauski (2020) and other motions. A motion is sampled once, at all steps of a case, before the
march.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..case.motion import Motion
from ..case.travel import Travel
from . import waveforms

PLUNGE, PLUNGE_RATE, PLUNGE_ACCEL, PITCH, PITCH_RATE, PITCH_ACCEL, SURGE, SURGE_RATE, SURGE_ACCEL = range(9)
"""Columns of a sampled motion."""

NOISE = 1e-9
"""Share of the maximum plunge velocity below which a velocity is round-off."""
ROUND_OFF = 1e-14
"""Relative tolerance of the time of a reversal."""
ROUNDS = 60

Array = NDArray[np.float64]


def sample(motion: Motion, times: ArrayLike) -> Array:
    """Motion at `times` (s), shape (times,).

    Returns:
        Shape (times, 9): Z (m), dZ/dt, d2Z/dt2, theta (rad), dtheta/dt, d2theta/dt2, Y (m), dY/dt, d2Y/dt2.
    """
    at = 1.0 * np.asarray(times)
    axes = (motion.plunge, motion.pitch, motion.surge)
    return np.hstack([sample_axis(axis, motion.frequency, motion.growth, at) for axis in axes])


def reversals(motion: Motion, first: float, last: float, step: float) -> Array:
    """Times (s) of stroke reversal from `first` to `last`: where the velocity along the stroke changes sign or becomes
    zero.

    Args:
        step: s; two reversals within a step may be missed.
    """
    return _reversals(motion.stroke, motion.frequency, motion.growth, first, last, step)


@functools.lru_cache(maxsize=256)
def _reversals(plunge: Travel, frequency: float | None, growth: float, first: float, last: float, step: float) -> Array:
    """Cached part of `reversals`, since the cases of a study often share their plunge."""
    # Shifted by half a step, so that reversals at grid times lie inside an interval.
    count = math.ceil((last - first) / step) + 2
    times = first + step * (np.arange(count) - 0.5)
    rate = sample_axis(plunge, frequency, growth, times)[:, PLUNGE_RATE]
    moving = np.flatnonzero(np.abs(rate) > NOISE * np.abs(rate).max())
    times, forth = times[moving], rate[moving] > 0.0
    turns = np.flatnonzero(forth[1:] != forth[:-1])
    found = _turns(
        functools.partial(sample_axis, plunge, frequency, growth), times[turns], times[turns + 1], forth[turns]
    )
    found = found[(found > first - NOISE * step) & (found < last + NOISE * step)]
    found.setflags(write=False)
    return found


def _turns(plunge: Callable[[Array], Array], early: Any, late: Any, forth: NDArray[np.bool_]) -> Any:
    """Zero of the plunge velocity between each `early` and `late`; `forth`: the velocity is positive before.

    Newton's method with the exact acceleration, and bisection where a step leaves the bracket or is not half the last.
    """
    times, moved = 0.5 * (early + late), late - early
    resolved = ROUND_OFF * np.maximum(np.abs(late), moved)
    for _ in range(ROUNDS):
        _, rate, accel = plunge(times).T
        before = np.where(forth, rate, -rate) > 0.0
        early, late = np.where(before, times, early), np.where(before, late, times)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = times - rate / accel
        trusted = (newton >= early) & (newton <= late) & (2.0 * np.abs(newton - times) <= moved)
        found = np.where(trusted, newton, 0.5 * (early + late))
        times, moved = found, np.maximum(np.abs(found - times), resolved)
        if np.all(moved <= resolved):
            break
    return times


def typical_speed(motion: Motion, behind: float, stream: tuple[float, float], times: Array) -> float:
    """Root mean square over `times` of the speed (m/s) of a rigid wing's trailing edge relative to the stream.

    Args:
        behind: distance of the trailing edge behind the pivot, m.
    """
    return speed_of(sample(motion, times), behind, stream)


def speed_of(moved: Array, behind: float, stream: tuple[float, float]) -> float:
    """What `typical_speed` gives, of a motion that is sampled already."""
    turned = np.stack((np.cos(moved[:, PITCH]), np.sin(moved[:, PITCH])), axis=1)
    return rms_speed(moved[:, PLUNGE_RATE], moved[:, PITCH_RATE], moved[:, SURGE_RATE], turned, behind, stream)


def rms_speed(
    plunge_rate: Array, pitch_rate: Array, surge_rate: Array, turned: Array, behind: float, stream: tuple[float, float]
) -> float:
    """What `typical_speed` gives, of rates that are sampled already and cosine and sine of the pitch, (times, 2)."""
    turning = behind * pitch_rate
    along_y = surge_rate - turning * turned[:, 1] - stream[0]
    along_z = plunge_rate + turning * turned[:, 0] - stream[1]
    return math.sqrt(np.mean(along_y**2 + along_z**2))


@functools.lru_cache(maxsize=256)
def speed_at_steps(
    motion: Motion, behind: float, stream: tuple[float, float], step: float, count: int, first: int, last: int
) -> float:
    """What `typical_speed` gives over the steps from `first` to `last - 1` of a march, which has sampled them before.

    Args:
        step, count: length and number of the steps of the march, s.
    """
    steps = slice(first, last)
    how = motion.frequency, motion.growth, step, count
    plunge, pitch, surge = (axis_at_steps(axis, *how) for axis in (motion.plunge, motion.pitch, motion.surge))
    turned = turned_at_steps(motion.pitch, *how)
    return rms_speed(plunge[steps, 1], pitch[steps, 1], surge[steps, 1], turned[steps], behind, stream)


@functools.lru_cache(maxsize=256)
def axis_at_steps(axis: Travel, frequency: float | None, growth: float, step: float, count: int) -> Array:
    """Plunge, pitch or surge at the first steps of a march, `step` s apart, as `sample_axis` gives it; not to change.

    The cases of a study often have one of them in common.
    """
    found = sample_axis(axis, frequency, growth, step * np.arange(count, dtype=np.float64))
    found.setflags(write=False)
    return found


@functools.lru_cache(maxsize=256)
def turned_at_steps(pitch: Travel, frequency: float | None, growth: float, step: float, count: int) -> Array:
    """Cosine and sine of the pitch at the first steps of a march, shape (count, 2); not to change."""
    angle = axis_at_steps(pitch, frequency, growth, step, count)[:, 0]
    found = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    found.setflags(write=False)
    return found


def flow_to_chord(moved: Array, behind: float, stream: tuple[float, float]) -> tuple[Array, Array]:
    """Velocity (m/s) of the stream relative to the rigid chord, along it and across it.

    Args:
        moved: motion as `sample` returns it.
        behind: distance of the point on the chord behind the pivot, m.
    """
    cosine, sine = np.cos(moved[:, PITCH]), np.sin(moved[:, PITCH])
    stream_y, stream_z = stream[0] - moved[:, SURGE_RATE], stream[1] - moved[:, PLUNGE_RATE]
    along = stream_y * cosine + stream_z * sine
    return along, stream_z * cosine - stream_y * sine - behind * moved[:, PITCH_RATE]


def typical_angle(moved: Array, behind: float, stream: tuple[float, float]) -> float:
    """Mean angle of attack (degrees) of the rigid chord, weighted by the square of the speed.

    Arguments as of `flow_to_chord`.
    """
    along, across = flow_to_chord(moved, behind, stream)
    pressure = along**2 + across**2
    if not pressure.any():
        return 0.0
    return math.degrees(float(np.average(np.arctan2(np.abs(across), np.abs(along)), weights=pressure)))


def sample_axis(axis: Travel, frequency: float | None, growth: float, times: NDArray[np.floating]) -> Array:
    """Plunge, pitch or surge at `times` (s) with its derivatives, shape (times, 3).

    Args:
        frequency: frequency of periodic motions, Hz.
        growth: duration of the start-up, s.
    """
    followed = _follow(axis, frequency, times)
    return waveforms.product(waveforms.start_up(times, growth), followed) if growth else followed


def _follow(axis: Travel, frequency: float | None, times: NDArray[np.floating]) -> Array:
    formula: Callable[..., Array] = getattr(waveforms, axis.kind)
    arguments = axis.in_si(frequency)
    if axis.repeats:
        arguments["frequency"] = frequency
    return formula(times, **arguments)
