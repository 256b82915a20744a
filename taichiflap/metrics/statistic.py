"""Statistics of a metric over the beats of a run, or of several runs at once."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .uncertainty import standard_errors

SAME = 1e-6
"""Standard error, as a share of the mean, below which beats are printed as equal."""

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

    def shown(self, factor: float, digits: int = 4) -> str:
        """The mean times a factor as text, with its standard error if it has one and the beats differ."""
        known = self.error or 0.0
        error = f" ± {factor * known:.2g}" if known > SAME * abs(self.mean) else ""
        return f"{factor * self.mean:.{digits}g}{error}"


@dataclass(frozen=True)
class Statistics:
    """The `Statistic` of each of several runs.

    Attributes:
        mean, spread, error: shape (runs,); not-a-number for an error that is not known.
    """

    mean: Array
    spread: Array
    error: Array

    @classmethod
    def each(cls, values: Mapping[str, Array]) -> dict[str, "Statistics"]:
        """Statistics of several metrics by name, with one value per beat: shape (runs, beats)."""
        every = np.stack(list(values.values()))
        count = every.shape[-1]
        means = every.sum(axis=-1) / count
        spreads = np.sqrt(((every - means[..., None]) ** 2).sum(axis=-1) / count)
        return dict(zip(values, map(cls, means, spreads, standard_errors(every)), strict=True))

    def over(self, scale: Array) -> "Statistics":
        """The statistics divided by a positive number of each run."""
        return Statistics(self.mean / scale, self.spread / scale, self.error / scale)

    def of(self, run: int) -> Statistic:
        """The statistics of one run."""
        error = float(self.error[run])
        return Statistic(float(self.mean[run]), float(self.spread[run]), None if math.isnan(error) else error)
