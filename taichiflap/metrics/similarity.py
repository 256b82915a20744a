"""Dimensionless numbers of a case's motion, its speeds, and its angle of attack.

All refer to the prescribed motion over the last beat, or over the whole run for a non-periodic motion. The reference
speed U is that of `march.reference`: the stream's, or in hover the root-mean-square speed of mid-chord.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np

from ..case.case import Case
from ..case.fluid import Fluid
from ..case.motion import Motion
from ..march.reference import MOMENTS, Reference, reduced_frequency, reynolds
from ..motion import attack, sampling


@dataclass(frozen=True)
class Similarity:
    """Similarity numbers of a case.

    Attributes:
        reynolds: U c / nu; None without `fluid.viscosity`.
        reduced_frequency: pi f c / U; None for a non-periodic motion or a wing at rest.
        pivot_speed: mean speed of the pivot along its path, without the stream, m/s; for a plunge, 2 f times the stroke
            from end to end.
        wing_tip_speed: mean speed of the wing tip, the pivot's speed times span over radius, m/s; None without a radius
            (`motion.measured`).
        angle_of_attack_mean, angle_of_attack_rms: mean and root mean square of the geometric angle of attack, between 0
            and 180 deg, while the pivot moves at more than 5 % of its maximum speed; None if it is at rest.
    """

    reynolds: float | None
    reduced_frequency: float | None
    pivot_speed: float
    wing_tip_speed: float | None
    angle_of_attack_mean: float | None
    angle_of_attack_rms: float | None

    @classmethod
    def of(cls, case: Case, scale: Reference | None = None) -> "Similarity":
        """Similarity numbers of a case; `scale` are its reference values, if they are known."""
        pivot, mean, rms = _moved(case.motion, case.fluid, case.duration, case.beat)
        return cls(
            reynolds=reynolds(case, scale),
            reduced_frequency=reduced_frequency(case, scale),
            pivot_speed=pivot,
            wing_tip_speed=_at_the_tip(case, pivot),
            angle_of_attack_mean=mean,
            angle_of_attack_rms=rms,
        )


@functools.lru_cache(maxsize=256)
def _moved(motion: Motion, fluid: Fluid, duration: float, beat: float) -> tuple[float, float | None, float | None]:
    """Mean speed of the pivot, m/s, and mean and root mean square of its angle of attack, degrees."""
    times = max(0.0, duration - beat) + min(beat, duration) * (np.arange(MOMENTS) + 0.5) / MOMENTS
    moved = sampling.sample(motion, times)
    speed = float(np.hypot(moved[:, sampling.PLUNGE_RATE], moved[:, sampling.SURGE_RATE]).mean())
    tells = attack.tells(fluid.velocity, moved)
    if not tells.any():
        return speed, None, None
    angles = np.degrees(attack.angle_of_attack(fluid.velocity, moved)[tells])
    return speed, float(angles.mean()), math.sqrt(np.mean(angles**2))


def _at_the_tip(case: Case, speed: float) -> float | None:
    measured = case.motion.measured
    return speed * case.wing.widest / measured.from_hinge(case.wing.widest) if measured else None
