"""The body-fitted grid about a section: rows from the wall outwards, cells around it, and constants on them.

The outside of the section is the image of |zeta| > 1 under y + i z = F(zeta) = r zeta + sum_n a_n zeta^-n; with
zeta = e^(rho + i phi) the grid is rectangular in (rho, phi). Lengths are in chords. A rigid section is an ellipse of
the wing's chord and of `thickness`, whose map is Joukowski's: r = (1/2 + b)/2 and a_1 = (1/2 - b)/2 with b =
thickness/2.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .plan import Plan

Array = NDArray[np.float64]

GROWTH = 1.06
"""Ratio of the thicknesses of neighbouring rows near the wall; further out cells are square in (rho, phi)."""
OPEN = 0.4, 0.1
"""Over which last part of rho the convection turns from implicit to explicit: the outermost rows let vorticity out."""
HIGHER = 0.1, 0.4
"""rho between which implicit convection turns from second order to third: near the wall the Courant number is too
large."""
NEGLIGIBLE = 1e-9
"""Share of a wall flux of vorticity beyond which no row feels it within a step."""


@dataclass(frozen=True)
class Grid:
    """Rows and cells.

    Attributes:
        points: cells around the section.
        drho: thickness of the rows in rho = ln |zeta|.
        half: half of the section's thickness, chords.
        pivot: distance of the pivot behind the leading edge, chords.
        implicit: rho up to which convection is implicit, and from which on it is explicit.
    """

    points: int
    drho: Array
    half: float
    pivot: float = 0.0
    implicit: tuple[float, float] | None = None

    @classmethod
    def stretched(cls, points: int, first: float, last: float, half: float, pivot: float = 0.0) -> "Grid":
        """Rows from the wall on, the first of thickness `first` in rho, out to rho = `last`; an even number."""
        widest = 2.0 * math.pi / points
        rows = [first]
        while sum(rows) < last or len(rows) % 2:
            rows.append(min(rows[-1] * GROWTH, widest))
        thickness = np.array(rows)
        thickness.setflags(write=False)
        return cls(points, thickness, half, pivot)

    def blended(self, first: float, last: float) -> "Grid":
        """The same grid with convection that is implicit up to rho = `first` and explicit from `last` on."""
        return replace(self, implicit=(first, last))

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.drho)

    @cached_property
    def alike(self) -> int:
        """First of the outer rows, which are all of one thickness."""
        return int(np.flatnonzero(self.drho == self.drho[-1])[0])

    @property
    def dphi(self) -> float:
        """Angle of a cell."""
        return 2.0 * math.pi / self.points

    @cached_property
    def plan(self) -> Plan:
        """Plan of the transform of a row."""
        return Plan(self.points)

    @cached_property
    def faces(self) -> Array:
        """rho of the faces between rows, from the wall on: rows + 1."""
        return np.concatenate(([0.0], np.cumsum(self.drho)))

    @property
    def centres(self) -> Array:
        """Angles of the cells' centres."""
        return self.dphi * (np.arange(self.points, dtype=np.float64) + 0.5)

    @property
    def corners(self) -> Array:
        """Angles of the cells' far corners."""
        return self.dphi * (np.arange(self.points, dtype=np.float64) + 1.0)

    @property
    def coefficients(self) -> NDArray[np.complex128]:
        """Map of the straight section: r, a_0 and a_1, from the pivot."""
        return np.array([0.5 * (0.5 + self.half), 0.5 - self.pivot, 0.5 * (0.5 - self.half)], complex)

    @cached_property
    def corner(self) -> NDArray[np.complex128]:
        """Positions of the cells' corners on the straight section's grid, (rows + 1, points)."""
        return positions(self.coefficients, self.faces, self.corners)

    @cached_property
    def area(self) -> Array:
        """J: areas of the straight section's cells over drho dphi, (rows, points)."""
        return areas(self.corner, self.drho, self.dphi)

    @property
    def radius(self) -> float:
        """Radius of the outer edge, chords."""
        return float(self.coefficients[0].real * math.exp(self.faces[-1]))

    @cached_property
    def blend(self) -> tuple[Array, Array]:
        """Share of implicit convection at the faces, rows + 1, and in the rows."""
        first, last = self.implicit or (self.faces[-1] - OPEN[0], self.faces[-1] - OPEN[1])
        shares = []
        for rho in (self.faces, 0.5 * (self.faces[1:] + self.faces[:-1])):
            shares.append(smooth((last - rho) / (last - first)))
        shares[0][self.near :] = 0.0
        return shares[0], shares[1]

    @property
    def higher(self) -> tuple[Array, Array]:
        """Share of the higher order of implicit convection at the rows' lower faces and in the rows."""
        lower, middle = self.faces[:-1], 0.5 * (self.faces[1:] + self.faces[:-1])
        return tuple(smooth((rho - HIGHER[0]) / (HIGHER[1] - HIGHER[0])) for rho in (lower, middle))  # type: ignore[return-value]

    @cached_property
    def near(self) -> int:
        """Rows whose convection is implicit."""
        last = self.implicit[1] if self.implicit else self.faces[-1] - OPEN[1]
        return min(self.rows - 3, int(np.count_nonzero(self.faces < last)) + 1)

    @cached_property
    def diffusion(self) -> tuple[Array, Array]:
        """Diffusion over viscosity through the upper and the lower face of each row."""
        drho = self.drho
        upper = 1.0 / (drho * 0.5 * (drho + np.append(drho[1:], drho[-1])))
        lower = np.append(0.0, 1.0 / (drho[1:] * 0.5 * (drho[1:] + drho[:-1])))
        return upper, lower

    def reach(self, spread: float) -> int:
        """Number of rows that the wall flux affects within a step, even; `spread` is viscosity times the step."""
        response = wall_response(self.area, self.drho, self.diffusion, spread, self.rows)
        total = response * self.area * self.drho[:, None]
        felt = np.flatnonzero((total > NEGLIGIBLE * total.sum(axis=0)).any(axis=1))
        rows = min(self.rows, int(felt[-1]) + 3)
        return rows - rows % 2


def smooth(x: Array) -> Array:
    """From 0 below 0 to 1 above 1, with one continuous derivative."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def positions(coefficients: NDArray[np.complex128], rho: Array, phi: Array) -> NDArray[np.complex128]:
    """F on the circles `rho` at the angles `phi`, (rho, phi).

    Args:
        coefficients: r, then a_0, a_1, ...
    """
    zeta = np.exp(rho[:, None] + 1j * phi)
    total = np.zeros_like(zeta)
    for a in coefficients[:0:-1]:
        total = total / zeta + a
    return coefficients[0] * zeta + total


def slopes(coefficients: NDArray[np.complex128], phi: Array) -> NDArray[np.complex128]:
    """G = dF/dchi on the wall at the angles `phi`."""
    order = np.arange(len(coefficients) - 1)
    return coefficients[0] * np.exp(1j * phi) - np.exp(-1j * np.outer(phi, order)) @ (order * coefficients[1:])


def areas(corner: NDArray[np.complex128], drho: Array, dphi: float) -> Array:
    """Areas of the quadrilaterals between the corners over drho dphi."""
    before = np.roll(corner, 1, axis=1)
    rising, falling = corner[1:] - before[:-1], corner[:-1] - before[1:]
    return 0.5 * (rising.conj() * falling).imag / (drho[:, None] * dphi)


def wall_response(area: Array, drho: Array, diffusion: tuple[Array, Array], spread: float, rows: int) -> Array:
    """Vorticity in the first `rows` rows per wall flux of circulation (over dphi) and step, (rows, points).

    The columns' implicit diffusion, closed behind the last row, so that nothing is lost.
    """
    upper, lower = spread * diffusion[0][:rows], spread * diffusion[1][:rows]
    upper = np.append(upper[:-1], 0.0)
    factor = np.zeros((rows, area.shape[1]))
    response = np.zeros_like(factor)
    for j in range(rows):
        before = factor[j - 1] if j else 0.0
        pivot = 1.0 / (area[j] + upper[j] + lower[j] - lower[j] * before)
        factor[j] = upper[j] * pivot
        response[j] = (lower[j] * response[j - 1] if j else 1.0 / drho[0]) * pivot
    for j in range(rows - 2, -1, -1):
        response[j] += factor[j] * response[j + 1]
    return response
