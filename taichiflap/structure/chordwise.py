"""A property along the chord: a constant, or a piecewise linear table over s = y/chord."""

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Profile:
    """A continuous, piecewise linear function of s from 0, the leading edge, to 1.

    Attributes:
        s: breakpoints, increasing from 0 to 1.
        values: values at the breakpoints.
    """

    s: Array
    values: Array

    @classmethod
    def of(cls, given: float | Sequence[Sequence[float]]) -> "Profile":
        """Make it from a number or a table [[s, value], ...], as in a case file."""
        return _profile(given) if isinstance(given, int | float | tuple) else cls._of(given)

    @classmethod
    def _of(cls, given: float | Sequence[Sequence[float]]) -> "Profile":
        table = [(0.0, given), (1.0, given)] if isinstance(given, int | float) else given
        s, values = np.array(table, dtype=np.float64).T
        return cls(s, values)

    def __call__(self, s: Array) -> Array:
        """Values at `s`, of the same shape."""
        return np.asarray(np.interp(s, self.s, self.values))

    @functools.cached_property
    def mean(self) -> float:
        """Mean over the chord."""
        return float(self.means(np.array([0.0, 1.0]))[0])

    def means(self, edges: Array) -> Array:
        """Exact means over the intervals between `edges` (increasing, in [0, 1]): one fewer than edges."""
        if np.all(self.values == self.values[0]):
            return np.full(len(edges) - 1, self.values[0])
        area = np.concatenate(([0.0], np.cumsum(np.diff(self.s) * 0.5 * (self.values[1:] + self.values[:-1]))))
        left = np.searchsorted(self.s, edges, side="right") - 1
        to_edge = area[left] + (edges - self.s[left]) * 0.5 * (self.values[left] + self(edges))
        return np.diff(to_edge) / np.diff(edges)


@functools.lru_cache(maxsize=64)
def _profile(given: float | tuple[tuple[float, float], ...]) -> Profile:
    """That of a number or tuple, which cases of a study and parts of a case share."""
    return Profile._of(given)
