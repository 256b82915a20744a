"""Lift and thrust in a free stream."""

import math

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case

Array = NDArray[np.float64]


def in_stream(case: Case, force_y: Array, force_z: Array) -> tuple[Array, Array]:
    """Lift and thrust (N) of a force: its component 90 degrees counter-clockwise from the stream, and against the
    stream.
    """
    speed = math.hypot(*case.fluid.velocity)
    stream_y, stream_z = (component / speed for component in case.fluid.velocity)
    return force_z * stream_y - force_y * stream_z, -(force_y * stream_y + force_z * stream_z)
