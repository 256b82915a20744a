"""Orientation of pictures: the stream runs from left to right and lift points up.

Without a stream the stroke (Z) is horizontal and up is -Y, against gravity. The plane is rotated but not mirrored, so
that counter-clockwise circulation stays counter-clockwise. Data are not changed.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..case.case import Case

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Orientation:
    """A rotation of the plane: `right_y`, `right_z` are the components of the unit vector to the right on the page."""

    right_y: float = 0.0
    right_z: float = 1.0

    @classmethod
    def of(cls, case: Case) -> "Orientation":
        """Orientation of a case, along its stream if any."""
        speed = math.hypot(*case.fluid.velocity)
        return cls(*(component / speed for component in case.fluid.velocity)) if speed else cls()

    def on_page(self, y: ArrayLike, z: ArrayLike) -> Array:
        """Inertial components as components on the page, to the right and up, shape (..., 2)."""
        y, z = np.asarray(y, dtype=float), np.asarray(z, dtype=float)
        return np.stack((self.right_y * y + self.right_z * z, self.right_y * z - self.right_z * y), axis=-1)

    def off_page(self, places: ArrayLike) -> Array:
        """Components on the page, shape (..., 2), as inertial components Y and Z, shape (2, ...)."""
        right, up = np.moveaxis(np.asarray(places, dtype=float), -1, 0)
        return np.stack((self.right_y * right - self.right_z * up, self.right_z * right + self.right_y * up))
