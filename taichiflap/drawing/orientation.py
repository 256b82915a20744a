"""Orientation of pictures: the stream runs from left to right and lift points up.

Without a stream the stroke (Z) is horizontal and up is -Y, against gravity. The plane is rotated but not mirrored, so
that counter-clockwise circulation stays counter-clockwise. Data are not changed.
"""

import math
from dataclasses import dataclass
from typing import Any

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


INERTIAL, WING = FRAMES = ("inertial", "wing")
"""Frames of reference that a picture can be drawn in."""


@dataclass(frozen=True)
class Standpoint:
    """View of a picture: its vertical direction, and the point (Y and Z, m) at its origin."""

    orientation: Orientation = Orientation()
    y: float = 0.0
    z: float = 0.0

    @classmethod
    def of(cls, result: Any, index: int, frame: str = INERTIAL) -> "Standpoint":
        """The one for a frame of a result.

        Args:
            frame: of reference: `inertial`, or `wing`, in which the pivot stands still and the undeformed chord lies
                across, leading edge on the left.
        """
        if frame == INERTIAL:
            return cls(Orientation.of(result.case))
        pitch = float(result.frame("pitch", index))
        surge = float(result.frame("surge", index)) if "surge" in result.variables else 0.0
        return cls(Orientation(math.cos(pitch), math.sin(pitch)), surge, float(result.frame("plunge", index)))

    def vectors(self, y: ArrayLike, z: ArrayLike) -> Array:
        """Inertial components as components on the page, shape (..., 2)."""
        return self.orientation.on_page(y, z)

    def places(self, y: ArrayLike, z: ArrayLike) -> Array:
        """Points Y and Z as points of the page, shape (..., 2)."""
        return self.orientation.on_page(np.asarray(y, dtype=float) - self.y, np.asarray(z, dtype=float) - self.z)

    def points(self, places: ArrayLike) -> Array:
        """Points of the page, shape (..., 2), as Y and Z, shape (2, ...)."""
        found = self.orientation.off_page(places)
        found[0] += self.y
        found[1] += self.z
        return found
