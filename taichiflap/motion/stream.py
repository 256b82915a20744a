"""Forces across a free stream and against it."""

import math

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case

Array = NDArray[np.float64]


def in_stream(case: Case, force_y: Array, force_z: Array) -> tuple[Array, Array]:
    """Lift and thrust of a force (N): across the free stream, a quarter turn counter-clockwise from it, and against."""
    speed = math.hypot(*case.fluid.velocity)
    stream_y, stream_z = (component / speed for component in case.fluid.velocity)
    return force_z * stream_y - force_y * stream_z, -(force_y * stream_y + force_z * stream_z)
