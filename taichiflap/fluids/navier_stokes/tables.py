"""Data of a case's flow before the first step: numbers, tables, and the state at rest."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ...case.case import Case
from ...motion import sampling
from ...motion.gust import gust_velocity
from ...motion.sampling import (
    PITCH,
    PITCH_ACCEL,
    PITCH_RATE,
    PLUNGE,
    PLUNGE_ACCEL,
    PLUNGE_RATE,
    SURGE,
    SURGE_ACCEL,
    SURGE_RATE,
)
from ...structure.beam import Modes
from . import MODEL, arrays, mapping
from .arrays import LINES, MODAL_LINES
from .grid import Grid, positions, slopes
from .plan import Plan
from .settings import Settings, checked

MAP_POINTS = ((0.04, 2048), (0.0, 4096))
"""Points of a bending section's map from a thickness in chords on."""
ROUND_OFF = 1e-14
LONGEST_SERIES = 128
"""A mode's series ends when it is as good as this, or so long."""
SPARE = 4
"""Rows behind the last: transforms take two at a time, systems eight."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Given:
    """A case and its derived data."""

    case: Case
    modes: Modes
    settings: Settings
    grid: Grid

    @classmethod
    def of(cls, case: Case, modes: Modes) -> "Given":
        """The derived data of a case."""
        found = checked(case)
        return cls(case, modes, found, found.grid(case.wing.pivot))

    @property
    def plans(self) -> list[Plan]:
        """Plans of the flow's transforms and of the map's."""
        return [self.grid.plan, Plan(map_points(self.settings.thickness))] if self.modes.count else [self.grid.plan]

    def sizes(self) -> list[int]:
        """Row of `size`."""
        grid = self.grid
        felt = grid.reach(self.viscosity * self.case.step)
        terms, count = (grid.points // 2, self.series().shape[1]) if self.modes.count else (0, 0)
        return [
            grid.rows,
            grid.points // 8,
            grid.near,
            felt,
            grid.rows + SPARE,
            terms,
            count,
            self.stored,
            grid.alike,
            0,
        ]

    @property
    def viscosity(self) -> float:
        """Viscosity, chords^2/s."""
        return float(self.case.fluid.viscosity or 0.0) / self.case.wing.chord**2

    @property
    def stored(self) -> int:
        """Coefficients of the map that are stored."""
        return len(np.asarray(MODEL.axes(self.case)["exponent"].values))

    def numbers(self) -> list[float]:
        """Row of `number`."""
        case, chord = self.case, self.case.wing.chord
        load = case.fluid.density * chord**3 * float(case.wing.span)  # type: ignore[arg-type]
        grid = self.grid
        pascal = case.fluid.density * chord**2
        return [
            self.viscosity, grid.dphi, 1.0 / grid.points, chord, load, load * chord, grid.half, *case.fluid.velocity,
            pascal,
        ]  # fmt: skip

    def rows(self) -> Array:
        """Constants of the rows, (rows + SPARE, COLUMNS)."""
        grid = self.grid
        made = np.zeros((grid.rows + SPARE, arrays.COLUMNS))
        made[:, arrays.THICKNESS] = 1.0
        inside = made[: grid.rows]
        inside[:, arrays.THICKNESS] = grid.drho
        inside[:, arrays.UPPER_FACE], inside[:, arrays.LOWER_FACE] = grid.diffusion
        inside[:, arrays.INVERSE] = 1.0 / (grid.drho * grid.dphi)
        face, row = grid.blend
        inside[:, arrays.SHARE_FACE], inside[:, arrays.SHARE_UPPER], inside[:, arrays.SHARE_ROW] = (
            face[:-1],
            face[1:],
            row,
        )
        inside[:, arrays.HIGHER_FACE], inside[:, arrays.HIGHER_ROW] = grid.higher
        made[: grid.rows + 1, arrays.GROWN] = np.exp(grid.faces)
        made[: grid.rows + 1, arrays.DECAYED] = np.exp(-grid.faces)
        return made

    def factors(self, slots: int) -> Array:
        """Rows of `slot`, (FACTORS, slots, 8)."""
        made = np.zeros((arrays.FACTORS, slots, 8))
        plan = self.grid.plan
        wave = np.abs(plan.wavenumber).astype(float)
        shift = np.exp(1j * plan.wavenumber * np.pi / plan.points)
        shift[plan.index == plan.points // 2] = 0.0
        flow = made[:, : plan.slots]
        flow[arrays.WAVE] = wave
        flow[arrays.INVERSE_K] = np.where(wave == 0.0, 0.0, 1.0 / np.maximum(wave, 1.0))
        flow[arrays.IS_ZERO] = wave == 0.0
        flow[arrays.HALF], flow[arrays.HALF + 1] = shift.real, shift.imag
        if self.modes.count:
            contour = self.plans[1]
            k, points = contour.wavenumber, contour.points
            of_map = made[:, : contour.slots]
            of_map[arrays.HILBERT + 1] = np.where(2 * np.abs(k) < points, -np.sign(k), 0.0) / points
            of_map[arrays.SMOOTH] = (np.abs(k) < points // 3) / points
        return made

    def series(self) -> Array:
        """Chebyshev series along the chord of the modes over the chord, and of their integrals in chords; room for
        one more."""
        chord, count = self.case.wing.chord, self.modes.count
        pivot = self.case.wing.pivot
        assert not pivot
        degree = 16
        while True:
            x = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
            shape = self.modes.shape(0.5 * chord * (1.0 + x)) / chord
            found = chebyshev.chebfit(x, shape.T, degree)
            tail = np.abs(found[-degree // 8 :]).max()
            if tail < ROUND_OFF * np.abs(found).max() or degree >= LONGEST_SERIES:
                break
            degree *= 2
        integral = 0.5 * chebyshev.chebint(found, lbnd=-1)
        made = np.zeros((2 * count + 1, degree + 2))
        made[:count, :-1] = found.T
        made[count : 2 * count] = integral.T
        return made

    def map_places(self) -> NDArray[np.int32]:
        """Positions of wavenumbers 0, 1, ... in a spectrum of the contour, counted from one; negative for -k."""
        wave = self.plans[1].wavenumber
        made = np.zeros(self.grid.points // 2 + 1, np.int32)
        for (slot, lane), k in np.ndenumerate(wave):
            if abs(k) < len(made) and not made[abs(k)]:
                made[abs(k)] = (8 * slot + lane + 1) * (1 if k >= 0 else -1)
        return made

    def contour(self) -> Array:
        """Lines of the straight section's contour, (CONTOUR_LINES, points of the map): s = phi."""
        phi = 2.0 * np.pi * np.arange(self.plans[1].points) / self.plans[1].points
        made = np.zeros((mapping.CONTOUR_LINES, len(phi)))
        for line in (mapping.NOW, mapping.EARLIER, mapping.CIRCLE):
            made[line], made[line + 1] = np.cos(phi), np.sin(phi)
        return made

    def decay(self) -> Array:
        """e^(-k drho) of the rows that differ, (rows, slots, 8)."""
        grid = self.grid
        return np.exp(-np.abs(grid.plan.wavenumber) * grid.drho[: grid.alike + 1, None, None])

    def equations(self) -> NDArray[np.int32]:
        """Row of `equation`: positions of each wavenumber's parts in a spectrum, followed by the wavenumbers."""
        index, points = self.grid.plan.index, self.grid.points
        made = np.zeros((2, points), np.int32)
        c = 2
        seen: set[int] = {0, points // 2}
        for (slot, lane), k in np.ndenumerate(index):
            if min(k, points - k) not in seen:
                seen.add(int(min(k, points - k)))
                made[0, c], made[0, c + 1] = 16 * slot + lane, 16 * slot + 8 + lane
                made[1, c : c + 2] = k
                c += 2
        assert c == points
        return made.reshape(-1)

    def lines(self) -> Array:
        """Lines of the straight section at its start, (LINES + MODAL_LINES modes, points)."""
        grid = self.grid
        wall = positions(grid.coefficients, np.zeros(1), grid.centres)[0]
        slope = slopes(grid.coefficients, grid.centres)
        made = np.zeros((LINES + MODAL_LINES * self.modes.count, grid.points))
        made[arrays.WALL_Y], made[arrays.WALL_Z] = wall.real, wall.imag
        made[arrays.SLOPE_Y], made[arrays.SLOPE_Z] = slope.real, slope.imag
        made[arrays.CORNER_COS], made[arrays.CORNER_SIN] = np.cos(grid.corners), np.sin(grid.corners)
        made[arrays.CENTRE_COS], made[arrays.CENTRE_SIN] = np.cos(grid.centres), np.sin(grid.centres)
        _, gain = self._start()
        made[arrays.STEP] = self._flux(wall, slope, *gain)
        series = self.series() if self.modes.count else np.zeros((0, 1))
        x = np.clip(2.0 * (wall.real + self.case.wing.pivot) - 1.0, -1.0, 1.0)
        for k in range(self.modes.count):
            shape, integral = (chebyshev.chebval(x, series[row]) for row in (k, self.modes.count + k))
            made[LINES + MODAL_LINES * k + arrays.SHAPE] = shape
            made[LINES + MODAL_LINES * k + arrays.INTEGRAL] = integral
            made[LINES + MODAL_LINES * k + arrays.RESPONSE] = sheet(shape * slope.real, -integral)
        return made

    def _start(self) -> tuple[tuple[complex, float], tuple[complex, float]]:
        """Velocity of the pivot in the wing's axes, relative to the stream, and pitch rate at the start;
        accelerations."""
        moved = sampling.sample(self.case.motion, np.zeros(1))[0]
        turned = np.exp(-1j * moved[PITCH]) / self.case.wing.chord
        stream_y, stream_z = self.case.fluid.velocity
        velocity = complex(moved[SURGE_RATE] - stream_y, moved[PLUNGE_RATE] - stream_z) * turned
        gain = complex(moved[SURGE_ACCEL], moved[PLUNGE_ACCEL]) * turned
        return (velocity, float(moved[PITCH_RATE])), (gain, float(moved[PITCH_ACCEL]))

    def _flux(
        self, wall: Any, slope: Any, velocity: complex, rate: float, depth: float = 0.0, wind: Any = 0.0
    ) -> Array:
        """Vortex sheet over dphi on an impulsively started wall.

        Args:
            depth: of the row that it is spread over.
            wind: velocity of a gust on the wall.
        """
        tangent = ((velocity + 1j * rate * wall - wind) * slope.conj()).imag
        stream = velocity.real * wall.imag - velocity.imag * wall.real - 0.5 * rate * np.abs(wall) ** 2
        return sheet(tangent, stream - along_wall((wind * slope.conj()).real), depth)

    def _gust(self, wall: Any) -> Any:
        """Velocity of the gust on the wall at the start, in the wing's axes, chords/s."""
        moved, chord = sampling.sample(self.case.motion, np.zeros(1))[0], self.case.wing.chord
        turned = np.exp(1j * moved[PITCH])
        place = complex(moved[SURGE], moved[PLUNGE]) + chord * wall * turned
        along_y, along_z = gust_velocity(self.case.fluid, 0.0, place.real, place.imag)
        return (along_y + 1j * along_z) / turned / chord

    def vorticity(self) -> Array:
        """Vorticity of the first row after an impulsive start: the vortex sheet, spread over the row."""
        grid = self.grid
        wall = positions(grid.coefficients, np.zeros(1), grid.centres)[0]
        moving, _ = self._start()
        slope = slopes(grid.coefficients, grid.centres)
        spread = self._flux(wall, slope, *moving, grid.drho[0], self._gust(wall))
        return spread / grid.drho[0] / grid.area[0]


def map_points(thickness: float) -> int:
    """Points of the map of a bending section."""
    return next(points for least, points in MAP_POINTS if thickness >= least)


def along_wall(rise: Array) -> Array:
    """Integral over phi of a derivative, up to a constant."""
    k = np.arange(len(rise) // 2 + 1)
    found = np.fft.rfft(rise) / (1j * np.maximum(k, 1))
    found[[0, -1]] = 0.0
    return np.fft.irfft(found, len(rise))


def sheet(tangent: Array, stream: Array, depth: float = 0.0) -> Array:
    """Vortex sheet over dphi that gives no slip for a wall's Im(V conj G) and streamfunction.

    Args:
        depth: thickness in rho of the row over which it is spread; 0 on the wall itself.
    """
    k = np.arange(len(tangent) // 2 + 1)
    asked = k * np.fft.rfft(stream) - np.fft.rfft(tangent)
    asked[-1] = 0.0
    if depth:
        asked[1:] *= k[1:] * depth / -np.expm1(-k[1:] * depth)
    return np.fft.irfft(asked, len(tangent))
