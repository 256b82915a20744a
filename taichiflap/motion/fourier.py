"""The harmonics nearest to the points of a period: measured motion without its noise."""

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = tuple[tuple[float, float], ...]
BLIND = 1e3
"""Condition number beyond which the points leave a gap that the harmonics could do anything in."""


@dataclass(frozen=True)
class Series:
    """A mean and harmonics.

    Attributes:
        mean: in the unit of the points.
        terms: (n, amplitude_n, phase_n) of `amplitude_n sin(2 pi n t + phase_n)`, t in periods and phases in radians.
        residual: root mean square of the distance of the points from it.
        blind: whether a gap between the points is too long for so many harmonics.
    """

    mean: float
    terms: tuple[tuple[int, float, float], ...]
    residual: float
    blind: bool


def most(points: Points) -> int:
    """How many harmonics so many points tell of."""
    return (len(points) - 1) // 2


@functools.lru_cache(maxsize=64)
def series(points: Points, smooth: int | None, tolerance: float | None = None) -> Series:
    """The series of least squares of a number of harmonics, or of the fewest that come near enough.

    Args:
        points: (time, value), the time in periods; of one beat or of several.
        smooth: their number, or None.
        tolerance: largest residual, in the place of a number; when none is near enough, the series of all that the
            points tell of.
    """
    if smooth is not None:
        return _fit(points, smooth)
    found = (_fit(points, n) for n in range(1, most(points) + 1))
    return next((one for one in found if one.residual <= (tolerance or 0.0)), _fit(points, most(points)))


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
