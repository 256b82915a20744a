"""Dimensionless numbers of a case, which decide which model is suitable."""

import math
from dataclasses import dataclass

import numpy as np

from ..case.case import Case
from ..march.reference import reduced_frequency, reynolds
from ..motion import sampling
from ..motion.sampling import PITCH, PITCH_RATE, PLUNGE, PLUNGE_RATE, SURGE_RATE
from ..structure import beam

MOMENTS = 512
"""Number of times per beat at which the motion is sampled."""
SMALLEST = 1e-3
"""Reduced frequencies and strokes below this count as equal."""


@dataclass(frozen=True)
class Regime:
    """Dimensionless numbers of a case.

    Attributes:
        hovers: whether there is no free stream.
        bends: whether the wing has modes.
        reduced_frequency: pi f c / U, see `taichiflap.march.reference`; 0 for a non-periodic motion.
        stroke: extent of the plunge, chords.
        angle: mean angle of attack at mid-chord, weighted by the square of the speed, degrees.
        reynolds: U c / nu; None without a viscosity.
        frequency_ratio: flapping over first natural frequency; 0 for a rigid wing.
    """

    hovers: bool
    bends: bool
    reduced_frequency: float
    stroke: float
    angle: float
    reynolds: float | None
    frequency_ratio: float

    @classmethod
    def of(cls, case: Case) -> "Regime":
        """The regime of a case, from its motion in the last beat."""
        chord = case.wing.chord
        moved = sampling.sample(case.motion, np.linspace(case.duration - case.beat, case.duration, MOMENTS))
        cosine, sine = np.cos(moved[:, PITCH]), np.sin(moved[:, PITCH])
        past_y = case.fluid.velocity[0] - moved[:, SURGE_RATE]
        past_z = case.fluid.velocity[1] - moved[:, PLUNGE_RATE]
        along = past_y * cosine + past_z * sine
        across = past_z * cosine - past_y * sine - (0.5 - case.wing.pivot) * chord * moved[:, PITCH_RATE]
        squared = along**2 + across**2
        angles = np.degrees(np.arctan2(np.abs(across), np.abs(along)))
        frequency = case.motion.frequency or 0.0
        first = beam.modes(case.wing).frequency[:1]
        return cls(
            hovers=not case.fluid.streams,
            bends=bool(first.size),
            reduced_frequency=reduced_frequency(case) or 0.0,
            stroke=float(np.ptp(moved[:, PLUNGE])) / chord,
            angle=float(np.average(angles, weights=squared)) if squared.any() else 0.0,
            reynolds=reynolds(case),
            frequency_ratio=frequency / float(first[0]) if first.size and frequency else 0.0,
        )

    def distance(self, other: "Regime") -> float:
        """Distance between two regimes; infinite between hover and stream, and between rigid and flexible wings."""
        alike = self.hovers == other.hovers and self.bends == other.bends
        return self.difference(other) if alike else math.inf

    def difference(self, other: "Regime") -> float:
        """Difference between the numbers of two regimes of any kind.

        A difference of 1 corresponds to a factor of e in reduced frequency or stroke, 30 deg in angle of attack, a
        factor of ten in Reynolds number, or 0.3 in frequency ratio.
        """
        parts = [
            _logarithm(self.reduced_frequency, other.reduced_frequency),
            _logarithm(self.stroke, other.stroke),
            (self.angle - other.angle) / 30.0,
            (self.frequency_ratio - other.frequency_ratio) / 0.3,
        ]
        if self.reynolds and other.reynolds:
            parts.append(math.log10(self.reynolds / other.reynolds))
        return math.hypot(*parts)


def _logarithm(one: float, other: float) -> float:
    return math.log(max(one, SMALLEST) / max(other, SMALLEST))
