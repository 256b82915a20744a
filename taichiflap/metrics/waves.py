"""Harmonics of a series, the phase of its first, and the times of stroke reversal."""

import cmath
import functools
import math

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..case.motion import Travel
from ..motion import sampling

MOMENTS = 512
"""Number of times per beat at which the motion is sampled."""
RESOLVED = 1e-12
"""Difference (beats) below which two times count as equal."""

Array = NDArray[np.float64]


def harmonics(case: Case, time: Array, values: Array, count: int) -> NDArray[np.complex128]:
    """Complex amplitudes `a_n`, n = 1 ... count, over whole beats: `values` holds `Re(a_n exp(2 pi i n f t))`.

    Args:
        values: values at `time`, along the last axis.

    Returns:
        Shape (count, ...), with the other axes of `values`.
    """
    return project(values, exponentials(case.beat, time, count)) * (2.0 / values.shape[-1])


def exponentials(beat: float, time: Array, count: int) -> tuple[Array, Array]:
    """Real and imaginary part of `exp(-2 pi i n f t)`, n = 1 ... count, each of shape (count, times)."""
    angle = 2.0 * math.pi / beat * time
    turn = np.cos(angle) - 1j * np.sin(angle)
    powers = np.empty((count, len(time)), np.complex128)
    powers[0] = turn
    for n in range(1, count):
        np.multiply(powers[n - 1], turn, out=powers[n])
    return powers.real.copy(), powers.imag.copy()


@functools.lru_cache(maxsize=32)
def exponentials_at_steps(beat: float, step: float, first: int, last: int, count: int) -> tuple[Array, Array]:
    """What `exponentials` gives at some of the steps of a march; the cases of a study have them in common."""
    return exponentials(beat, step * np.arange(first, last, dtype=np.float64), count)


def project(values: Array, turns: tuple[Array, Array]) -> NDArray[np.complex128]:
    """Sums of values, along the last axis, times what `exponentials` gives at their times: shape (count, ...)."""
    # Real and imaginary part apart: einsum's sums of real numbers are several times faster, and need no BLAS,
    # whose rounding goes by the number of its threads.
    real, imaginary = (np.einsum("...t,nt->n...", values, part) for part in turns)
    return real + 1j * imaginary


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


def phase(case: Case, last: float, force: complex) -> float | None:
    """Phase lead (degrees) of a first harmonic, up to the time `last` (s), over that of the driving motion.

    None without a driving motion, or if the harmonic is zero.
    """
    driver = _driver(case, round(last / case.beat))
    if driver is None or not force:
        return None
    return 180.0 - (180.0 - math.degrees(cmath.phase(force / driver))) % 360.0


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
