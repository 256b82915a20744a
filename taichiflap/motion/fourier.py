"""Least-squares harmonics of periodic points: measured motion without its noise."""

import bisect
import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = tuple[tuple[float, float], ...]
BLIND = 1e3
"""Condition number above which a gap between the points leaves the harmonics undetermined."""


@dataclass(frozen=True)
class Series:
    """A mean and harmonics.

    Attributes:
        mean: in the unit of the points.
        terms: (n, amplitude_n, phase_n) of `amplitude_n sin(2 pi n t + phase_n)`, t in periods and phases in radians.
        residual: root-mean-square distance of the points from the series.
        blind: whether a gap between the points is too long for the number of harmonics.
    """

    mean: float
    terms: tuple[tuple[int, float, float], ...]
    residual: float
    blind: bool


def most(points: Points) -> int:
    """Maximum number of harmonics for a number of points."""
    return (len(points) - 1) // 2


@functools.lru_cache(maxsize=64)
def series(points: Points, smooth: int | None, tolerance: float | None = None) -> Series:
    """Least-squares series with a given number of harmonics, or with the fewest that meet a tolerance.

    Args:
        points: (time, value) of one or several beats, time in periods.
        smooth: number of harmonics, or None.
        tolerance: maximum residual, used instead of a number. If no series meets it, the maximum number of harmonics is
            used.
    """
    if smooth is not None:
        return _fit(points, smooth)

    def meets(harmonics: int) -> bool:
        return _fit(points, harmonics).residual <= (tolerance or 0.0)

    # More harmonics never fit worse: double their number until they meet the tolerance, then halve the interval.
    enough, limit = 1, most(points)
    while enough < limit and not meets(enough):
        enough = min(2 * enough, limit)
    if enough >= limit and not meets(limit):
        return _fit(points, limit)
    least = enough // 2 + 1
    return _fit(points, least + bisect.bisect_left(range(least, enough), True, key=meets))


@functools.lru_cache(maxsize=256)
def _fit(points: Points, harmonics: int) -> Series:
    times, values = np.array(points).T
    orders = np.arange(1, harmonics + 1)
    angles = 2.0 * math.pi * np.multiply.outer(times, orders)
    columns: NDArray[np.float64] = np.hstack([np.ones((len(times), 1)), np.cos(angles), np.sin(angles)])
    found, _, _, singular = np.linalg.lstsq(columns, values, rcond=None)
    even, odd = found[1 : harmonics + 1], found[harmonics + 1 :]
    terms = tuple(
        (int(n), math.hypot(a, b), math.atan2(a, b))
        for n, a, b in zip(orders, even.tolist(), odd.tolist(), strict=True)
    )
    residual = math.sqrt(np.mean((columns @ found - values) ** 2))
    return Series(float(found[0]), terms, residual, bool(singular[0] > BLIND * singular[-1]))
