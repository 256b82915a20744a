"""Motion of the section of a stored frame through the fluid."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...case.case import Case
from ...motion.gust import gust_velocity
from ...motion.sampling import PITCH, PITCH_RATE, PLUNGE, PLUNGE_RATE, SURGE, SURGE_RATE, sample

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
        gust: its velocity (1/s) at points y + i z, in the wing's axes; None without one.
    """

    pivot: complex
    rate: float
    node: Array
    bending: Array
    gust: Callable[[Complex], Complex] | None = None

    @classmethod
    def of(cls, result: Any, frame: int) -> "WallMotion":
        """The wall motion of a frame of a result."""
        case = result.case
        moved = sample(case.motion, np.array([float(result.frame("time", frame))]))[0]
        through = complex(moved[SURGE_RATE], moved[PLUNGE_RATE]) - complex(*case.fluid.velocity)
        node, bending = np.asarray(result.stations), np.zeros(len(result.stations))
        if case.wing.modes:
            bending = np.asarray(result.frame("q_rate", frame)) @ result.modes["shape"]
        chord = case.wing.chord
        return cls(
            pivot=through * np.exp(-1j * moved[PITCH]) / chord, rate=float(moved[PITCH_RATE]), node=node / chord,
            bending=bending / chord, gust=_gust(case, float(result.frame("time", frame)), moved),
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
        psi = psi - np.interp(y, self.node, shed)
        if self.gust is not None:
            blown = self.gust(place)
            velocity = velocity - blown
            ahead = 0.5 * (blown[1:] + blown[:-1]).conj() * np.diff(place)
            psi = psi - np.concatenate(([0.0], np.cumsum(ahead.imag)))
        return (velocity * slope.conj()).imag, psi


def _gust(case: Case, time: float, moved: Array) -> Callable[[Complex], Complex] | None:
    """Velocity of the gust at the wing at a time (s) of its motion."""
    if case.fluid.gust == "none":
        return None
    turn, pivot = np.exp(1j * moved[PITCH]), complex(moved[SURGE], moved[PLUNGE])

    def blow(place: Complex) -> Complex:
        points = pivot + case.wing.chord * place * turn
        along_y, along_z = gust_velocity(case.fluid, time, points.real, points.imag)
        found: Complex = (along_y + 1j * along_z) / (turn * case.wing.chord)
        return found

    return blow
