"""How the section of a stored frame moves through the fluid."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...motion.sampling import PITCH, PITCH_RATE, PLUNGE_RATE, SURGE_RATE, sample

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class WallMotion:
    """The wall's velocity; lengths in chords, in the wing's axes from the pivot.

    Attributes:
        pivot: V_O, the pivot's velocity relative to the stream, 1/s.
        rate: of the pitch angle, rad/s.
        node: places along the chord at which the deflection's rate is known.
        bending: that rate, 1/s.
    """

    pivot: complex
    rate: float
    node: Array
    bending: Array

    @classmethod
    def of(cls, result: Any, frame: int) -> "WallMotion":
        """That of a frame of a result."""
        case = result.case
        moved = sample(case.motion, np.array([float(result.frame("time", frame))]))[0]
        through = complex(moved[SURGE_RATE], moved[PLUNGE_RATE]) - complex(*case.fluid.velocity)
        node, bending = np.asarray(result.stations), np.zeros(len(result.stations))
        if case.wing.modes:
            bending = np.asarray(result.frame("q_rate", frame)) @ result.modes["shape"]
        chord = case.wing.chord
        return cls(
            pivot=through * np.exp(-1j * moved[PITCH]) / chord, rate=float(moved[PITCH_RATE]), node=node / chord,
            bending=bending / chord,
        )  # fmt: skip

    def on(self, place: Complex, slope: Complex) -> tuple[Array, Array]:
        """Tangential velocity T = Im(V conj G) (chords^2/s) and streamfunction (chords^2/s) of points of the wall.

        Args:
            place: y + i z.
            slope: G there.
        """
        y = np.clip(place.real, self.node[0], self.node[-1])
        shed = np.concatenate(([0.0], np.cumsum(0.5 * (self.bending[1:] + self.bending[:-1]) * np.diff(self.node))))
        velocity = self.pivot + 1j * self.rate * place + 1j * np.interp(y, self.node, self.bending)
        psi = self.pivot.real * place.imag - self.pivot.imag * place.real - 0.5 * self.rate * np.abs(place) ** 2
        return (velocity * slope.conj()).imag, psi - np.interp(y, self.node, shed)
