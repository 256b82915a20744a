"""Published forces of pitch-up ramps: mean and seven cosines of the coefficients over time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ramp:
    """Cosine series of lift and drag coefficient: `C(t) = sum_n a_n cos(n pi (t - first) / (last - first))`.

    Attributes:
        first, last: times between which it holds, chords over the stream's speed.
        count: number of evenly spaced times at which a series is fitted.
        cosines: amplitudes by coefficient, `C_L` and `C_D`; the first is the mean.
    """

    first: float
    last: float
    count: int
    cosines: Mapping[str, tuple[float, ...]]

    @property
    def times(self) -> Array:
        """Times at which a series is fitted."""
        return np.linspace(self.first, self.last, self.count)

    def published(self, name: str, times: ArrayLike) -> Array:
        """The published coefficient at some times."""
        return self._waves(times, len(self.cosines[name])) @ np.array(self.cosines[name])

    def filtered(self, name: str, times: Array, values: Array) -> Array:
        """A computed coefficient as far as the published series resolves it, at `times` of this ramp."""
        waves = self._waves(self.times, len(self.cosines[name]))
        return waves @ np.linalg.lstsq(waves, np.interp(self.times, times, values), rcond=None)[0]

    def _waves(self, times: ArrayLike, count: int) -> Array:
        share = (np.asarray(times, dtype=float) - self.first) / (self.last - self.first)
        return np.cos(np.pi * np.multiply.outer(share, np.arange(count)))


RAMPS = {
    25: Ramp(
        1.2, 7, 30,
        {
            "C_L": (1.086, 0.988, -0.372, -0.380, -0.030, -0.165, -0.102, 0.033),
            "C_D": (0.246, 0.089, -0.260, -0.132, 0.018, 0.033, -0.009, -0.014),
        },
    ),
    45: Ramp(
        1.1, 4.8, 38,
        {
            "C_L": (2.899, 1.625, 0.564, 0.250, 0.190, -0.214, -0.410, -0.329),
            "C_D": (2.265, 0.144, -0.296, -0.424, -0.186, -0.302, -0.357, -0.204),
        },
    ),
    90: Ramp(
        1.1, 4.8, 38,
        {
            "C_L": (2.536, 0.984, -1.230, -0.114, -0.148, -0.025, -0.060, 0.033),
            "C_D": (2.698, -1.661, -0.922, 0.240, -0.139, 0.069, -0.099, 0.095),
        },
    ),
}  # fmt: skip
"""By angle, deg: 25 as measured in water, 45 and 90 as computed by J. D. Eldredge; all as Ramesh et al. (J. Fluid Mech.
751, 2014) compare with."""
