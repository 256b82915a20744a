"""The same double loop in numba with fastmath, one thread: what a Python user would write first."""

import functools
import math
from typing import Any

import numpy as np

from .c_loop import Sum

MISSING = "numba is not installed; pip install 'taichiflap[bench]'"


@functools.cache
def load() -> Sum | None:
    """The loop; None without numba."""
    try:
        import numba  # noqa: PLC0415 - an optional peer
    except ImportError:
        return None

    # numpy's rule for a division by zero, infinity: the check for Python's rule would keep the loop from vectorising.
    def summed(y, z, out_y, out_z, source_y, source_z, circulation, core2):
        for i in range(y.size):
            u = 0.0
            v = 0.0
            for j in range(source_y.size):
                dy = y[i] - source_y[j]
                dz = z[i] - source_z[j]
                strength = circulation[j] / (dy * dy + dz * dz + core2)
                u -= dz * strength
                v += dy * strength
            out_y[i] = u / (2.0 * math.pi)
            out_z[i] = v / (2.0 * math.pi)

    loop: Any = numba.njit(summed, fastmath=True, error_model="numpy")

    def induced_velocity(points: np.ndarray, vortices: np.ndarray, core: float) -> np.ndarray:
        velocity = np.empty_like(points)
        loop(*points, *velocity, *vortices, core**2)
        return velocity

    return induced_velocity
