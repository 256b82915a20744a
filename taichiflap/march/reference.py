"""Reference speed and area of a case, for coefficients, Reynolds number and reduced frequency.

The reference speed is that of the free stream. In hover it is the root-mean-square speed of mid-chord over a beat, or
over the whole run for a non-periodic motion. The area is chord times mean span.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np

from ..case.case import Case
from ..case.motion import Motion
from ..motion.sampling import typical_speed
from ..structure.chordwise import Profile

MOMENTS = 512
"""Number of times at which the speed is sampled."""


@dataclass(frozen=True)
class Reference:
    """Reference values of forces and power.

    Attributes:
        speed: m/s.
        area: m2.
        density: density of the fluid, kg/m3.
        stream: whether the speed is that of a free stream.
    """

    speed: float
    area: float
    density: float
    stream: bool

    @property
    def force(self) -> float:
        """Reference force `rho U^2 S / 2`, N."""
        return 0.5 * self.density * self.speed**2 * self.area

    @property
    def power(self) -> float:
        """Reference power `rho U^3 S / 2`, W."""
        return self.force * self.speed


def reference(case: Case) -> Reference:
    """Reference speed and area of a case."""
    stream = case.fluid.streams
    speed = math.hypot(*case.fluid.velocity) if stream else speed_of_middle(case)
    return Reference(speed, case.wing.chord * Profile.of(case.wing.span).mean, case.fluid.density, stream)


def reynolds(case: Case, scale: Reference | None = None) -> float | None:
    """Reynolds number U c / nu of a case; None without `fluid.viscosity`.

    Args:
        scale: its reference values, if they are known.
    """
    viscosity = case.fluid.viscosity
    return (scale or reference(case)).speed * case.wing.chord / viscosity if viscosity else None


def reduced_frequency(case: Case, scale: Reference | None = None) -> float | None:
    """Reduced frequency pi f c / U of a case; None for a non-periodic motion or a wing at rest.

    Args:
        scale: its reference values, if they are known.
    """
    frequency, speed = case.motion.frequency, (scale or reference(case)).speed
    return math.pi * frequency * case.wing.chord / speed if frequency and case.periodic and speed else None


def speed_of_middle(case: Case) -> float:
    """Root-mean-square speed (m/s) of mid-chord through the fluid, over the last beat."""
    behind = (0.5 - case.wing.pivot) * case.wing.chord
    return _speed(case.motion, behind, case.fluid.velocity, case.duration, case.beat)


@functools.lru_cache(maxsize=256)
def _speed(motion: Motion, behind: float, stream: tuple[float, float], duration: float, beat: float) -> float:
    times = max(0.0, duration - beat) + min(beat, duration) * (np.arange(MOMENTS) + 0.5) / MOMENTS
    return typical_speed(motion, behind, stream, times)
