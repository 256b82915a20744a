"""A gust in the free stream: a velocity normal to the stream, carried along unchanged.

Frozen gusts of Kuessner (1936), Sears (1941) and of aircraft certification ("one minus cosine"). The front reaches the
origin of the plane at `fluid.gust_arrival`; the velocity ahead of it is zero.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..case.fluid import Fluid

Array = NDArray[np.float64]


def gust_velocity(fluid: Fluid, time: float, y: ArrayLike, z: ArrayLike) -> Array:
    """Velocity (m/s) of the gust along Y and Z at points (m) of the plane, shape (2, *points).

    Positive `gust_velocity` is 90 degrees counter-clockwise from the stream: along +Z in a stream along +Y.
    """
    y, z = np.asarray(y, dtype=float), np.asarray(z, dtype=float)
    speed = math.hypot(*fluid.velocity)
    if fluid.gust == "none" or not speed:
        return np.zeros((2, *np.broadcast_shapes(y.shape, z.shape)))
    along_y, along_z = np.array(fluid.velocity) / speed
    behind = speed * (time - fluid.gust_arrival) - along_y * y - along_z * z
    if fluid.gust == "sharp_edged":
        share = np.heaviside(behind, 0.5)
    else:
        angle = 2.0 * math.pi * behind / (fluid.gust_length or 1.0)
        sine = fluid.gust == "sinusoidal"
        share = np.sin(angle) if sine else 0.5 * (1.0 - np.cos(angle)) * (angle < 2.0 * math.pi)
        share = share * (behind > 0.0)
    across = fluid.gust_velocity * share
    return np.stack((-along_z * across, along_y * across))
