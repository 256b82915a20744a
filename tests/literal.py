"""Misprints of the paper taken literally: forces are computed again from the stored motion of a run."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichiflap.case.case import Case
from taichiflap.fluids.dbet import elements
from taichiflap.metrics.beats import settled_beats
from taichiflap.metrics.waves import harmonic
from taichiflap.motion import sampling
from taichiflap.motion.sampling import PITCH, PITCH_RATE, PLUNGE_RATE
from taichiflap.results.reader import Result
from taichiflap.structure import beam
from taichiflap.structure.chordwise import Profile

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Blades:
    """Quasi-steady forces of blade elements, shape (frames,), N: `normal` along e_z, `axial` along e_y.

    `backward` is the share of time and chord with negative chordwise speed.
    """

    normal: Array
    axial: Array
    pitch: Array
    backward: float

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
    case, frames = result.case, settled_beats(result).frames
    across, along = _velocities(case, result, frames)
    angle = np.arctan(across / along) if arctangent else np.arctan2(across, along)
    if outside:
        middle = case.dbet.elements // 2
        angle = np.broadcast_to(angle[:, middle : middle + 1], angle.shape)
    sine, cosine = np.sin(angle), np.cos(angle)
    polar = case.dbet.polar
    pressure = 0.5 * case.fluid.density * (across**2 + along**2) * elements.areas(case)
    lift = pressure * polar.lift_max * np.sin(2.0 * angle)
    drag = pressure * (polar.drag_min * cosine**2 + polar.drag_max * sine**2)
    axial = drag * cosine - lift * (cosine if cosines else sine)
    normal = drag * sine + lift * cosine
    backward = float(np.mean(along < 0.0))
    return Blades(-normal.sum(axis=1), -axial.sum(axis=1), result.pitch[frames], backward)


def _velocities(case: Case, result: Result, frames: slice) -> tuple[Array, Array]:
    """`u_z` and `u_y` (Eq. 6) of every element at its middle, m/s, shape (frames, elements)."""
    y = elements.middles(case)
    moved = sampling.sample(case.motion, result.time[frames])[:, :, None]
    across = moved[:, PLUNGE_RATE] * np.cos(moved[:, PITCH]) + y * moved[:, PITCH_RATE]
    along = moved[:, PLUNGE_RATE] * np.sin(moved[:, PITCH]) + 0.0 * y
    if case.wing.modes:
        shape = beam.modes(case.wing).shape(y)
        across = across + result.q_rate[frames] @ shape
        along = along - moved[:, PITCH_RATE] * (result.q[frames] @ shape)
    return across, along


def whole_panels(result: Result) -> tuple[complex, complex]:
    """First harmonic of a UVLM run's normal force, N, with Eq. 33 as printed and as corrected.

    The potential jumps by a panel's circulation at its vortex, at a quarter, so that three quarters of the panel
    carry it; the running sum gives it to the whole panel.
    """
    case, frames = result.case, settled_beats(result).frames
    size, dt = case.wing.chord / case.uvlm.panels, case.step
    own = np.sum([result.frame("panel_circulation", int(n)) for n in range(result.frames)], axis=1, dtype=float)
    growth = np.zeros_like(own)
    growth[2:] = (1.5 * own[2:] - 2.0 * own[1:-1] + 0.5 * own[:-2]) / dt
    excess = -case.fluid.density * Profile.of(case.wing.span).mean * size * 0.25 * growth
    printed = harmonic(case, result.time[frames], result.force_normal[frames])
    return printed, printed - harmonic(case, result.time[frames], excess[frames])


def pitch_energy(case: Case) -> tuple[float, float, float]:
    """Largest value over a beat, in SI units, of the kinetic energy's T6 as printed and as meant, and of all of it.

    A rigid wing: T3, T4 and T6 of the paper's Appendix A.
    """
    section = beam.modes(case.wing)
    moved = sampling.sample(case.motion, np.linspace(0.0, case.beat, 1001))
    speed, rate = moved[:, PLUNGE_RATE], moved[:, PITCH_RATE]
    printed = speed * np.cos(moved[:, PITCH]) * section.mass * case.wing.chord / 2.0
    rest = 0.5 * section.mass * (speed**2 + rate**2 * case.wing.chord**2 / 3.0)
    sizes = (np.abs(values).max() for values in (printed, printed * rate, rest + printed * rate))
    return tuple(map(float, sizes))  # type: ignore[return-value]
