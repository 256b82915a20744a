"""Geometric angle of attack and speeds of a rigid section, from its prescribed motion."""

import numpy as np
from numpy.typing import NDArray

from .sampling import PITCH, PITCH_RATE, PLUNGE_RATE, SURGE_RATE

Array = NDArray[np.float64]

SLOW = 0.05
"""Share of the largest speed below which a direction of motion, and so an angle of attack, says nothing."""


def angle_of_attack(stream: tuple[float, float], moved: Array) -> Array:
    """Angle (rad) between the chord and the pivot's motion through the fluid, from 0, leading edge first, to pi.

    In hover, without surge, it is a right angle less the size of the pitch. A right angle where the pivot rests.

    Args:
        stream: velocity of the free stream along Y and Z, m/s.
        moved: motion as `sampling.sample` returns it.
    """
    along_y, along_z = _through_the_fluid(stream, moved)
    speed = np.hypot(along_y, along_z)
    ahead = -(along_y * np.cos(moved[:, PITCH]) + along_z * np.sin(moved[:, PITCH]))
    return np.arccos(np.clip(np.divide(ahead, speed, out=np.zeros_like(speed), where=speed > 0.0), -1.0, 1.0))


def tells(stream: tuple[float, float], moved: Array) -> NDArray[np.bool_]:
    """Where the pivot is fast enough for its direction, and so its angle of attack, to say something."""
    speed = np.hypot(*_through_the_fluid(stream, moved))
    return np.asarray(speed > SLOW * speed.max(initial=0.0))


def speeds(stream: tuple[float, float], behind: float, moved: Array) -> tuple[Array, Array]:
    """Speeds (m/s) through the fluid of the pivot, and of a place on the rigid chord.

    Args:
        behind: distance of the place behind the pivot, m.
        stream, moved: as of `angle_of_attack`.
    """
    along_y, along_z = _through_the_fluid(stream, moved)
    turning = behind * moved[:, PITCH_RATE]
    there_y = along_y - turning * np.sin(moved[:, PITCH])
    there_z = along_z + turning * np.cos(moved[:, PITCH])
    return np.hypot(along_y, along_z), np.hypot(there_y, there_z)


def _through_the_fluid(stream: tuple[float, float], moved: Array) -> tuple[Array, Array]:
    return moved[:, SURGE_RATE] - stream[0], moved[:, PLUNGE_RATE] - stream[1]
