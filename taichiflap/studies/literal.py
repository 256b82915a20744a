"""Misprints of the paper taken at their word on the stored motion of a run: forces change, the wing does not."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import beam, motion
from ..case import Case
from ..metrics import settled_beats
from ..motion import PITCH, PITCH_RATE, PLUNGE_RATE
from ..results import Result

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Blades:
    """Quasi-steady forces of blade elements, shape (frames,), N: `normal` along e_z, `axial` along e_y."""

    normal: Array
    axial: Array
    pitch: Array

    @property
    def vertical(self) -> float:
        """Mean vertical force of both, N."""
        return float(np.mean(self.normal * np.sin(self.pitch) - self.axial * np.cos(self.pitch)))

    @property
    def vertical_normal(self) -> float:
        """Mean vertical force of the normal force alone, N."""
        return float(np.mean(self.normal * np.sin(self.pitch)))


def blades(result: Result, *, arctangent: bool = False, cosines: bool = False, outside: bool = False) -> Blades:
    """Quasi-steady forces (Eqs 17-24) over the settled beats of a DBET run, without added mass.

    Args:
        arctangent: the angle of Eq. 18 as an arctangent, within 90 degrees of zero.
        cosines: the axial force with the two cosines that Eq. 23 prints.
        outside: the coefficients of Eqs 21-22, and the angle of Eqs 23-24, at the middle of the chord for all elements.
    """
    case, frames = result.case, np.concatenate(list(settled_beats(result.case, result.time)))
    across, along = _velocities(case, result, frames)
    angle = np.arctan(across / along) if arctangent else np.arctan2(across, along)
    if outside:
        middle = case.dbet.elements // 2
        angle = np.broadcast_to(angle[:, middle : middle + 1], angle.shape)
    sine, cosine = np.sin(angle), np.cos(angle)
    model = case.dbet
    pressure = 0.5 * case.fluid.density * (across**2 + along**2) * case.wing.chord * case.wing.span / model.elements
    lift = pressure * model.lift_max * np.sin(2.0 * angle)
    drag = pressure * (model.drag_min * cosine**2 + model.drag_max * sine**2)
    axial = drag * cosine - lift * (cosine if cosines else sine)
    normal = drag * sine + lift * cosine
    return Blades(-normal.sum(axis=1), -axial.sum(axis=1), result.pitch[frames])


def _velocities(case: Case, result: Result, frames: NDArray[np.intp]) -> tuple[Array, Array]:
    """`u_z` and `u_y` (Eq. 6) of every element at its middle, m/s, shape (frames, elements)."""
    y = case.wing.chord * (np.arange(case.dbet.elements) + 0.5) / case.dbet.elements
    moved = motion.sample(case.motion, result.time[frames])[:, :, None]
    across = moved[:, PLUNGE_RATE] * np.cos(moved[:, PITCH]) + y * moved[:, PITCH_RATE]
    along = moved[:, PLUNGE_RATE] * np.sin(moved[:, PITCH]) + 0.0 * y
    if case.wing.modes:
        shape = beam.modes(case.wing).shape(y)
        across = across + result.q_rate[frames] @ shape
        along = along - moved[:, PITCH_RATE] * (result.q[frames] @ shape)
    return across, along


def convection(result: Result) -> tuple[float, float]:
    """Root mean square of the wake vortices' velocity in the last frame (m/s), and of its error.

    The error is that of a wake sum (Eq. 32) which runs to the number of panels, as printed, over the youngest
    vortices, and not to the number of wake vortices.
    """
    last, count = result.frames - 1, result.case.uvlm.panels
    wake = result.wake(last)
    places = wake["y"].astype(float) + 1j * wake["z"].astype(float)
    nodes = result.frame("node_position", last).astype(float) @ np.array([1.0, 1j])
    bound = 0.75 * nodes[:-1] + 0.25 * nodes[1:]
    induced = _induced(places, places, wake["circulation"])
    kept = np.arange(len(places)) >= len(places) - count
    whole = induced.sum(axis=1) + _induced(places, bound, result.frame("panel_circulation", last)).sum(axis=1)
    lost = induced[:, ~kept].sum(axis=1)
    return float(np.sqrt(np.mean(abs(whole) ** 2))), float(np.sqrt(np.mean(abs(lost) ** 2)))


def _induced(targets: NDArray[np.complex128], sources: NDArray[np.complex128], circulation: Array) -> Array:
    """Complex conjugate velocity (m/s) at each target by each source (Eq. 30), none of a vortex on itself."""
    apart = targets[:, None] - sources
    itself = apart == 0.0
    return np.where(itself, 0.0, circulation.astype(float) / (2j * np.pi * np.where(itself, 1.0, apart)))
