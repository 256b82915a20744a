"""A stored frame of a flow as a field in space: where its cells are, and its vorticity on a plain grid."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .settings import settings

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

NEWTON_STEPS = 50
CLOSE = 1e-10
"""Error of an inverted map, chords."""


@dataclass(frozen=True)
class Field:
    """Vorticity on the grid about the wing.

    Attributes:
        rho, phi: coordinates of the cells' centres.
        faces: rho of the faces between rows.
        vorticity: (rho, phi), 1/s.
        coefficients: of the map in the wing's axes from the pivot, m: of zeta, 1, 1/zeta, ...
        pivot: its position Y + i Z, m.
        pitch: rad.
        chord: m.
    """

    rho: Array
    phi: Array
    faces: Array
    vorticity: Array
    coefficients: Complex
    pivot: complex
    pitch: float
    chord: float

    @classmethod
    def of(cls, result: Any, frame: int) -> "Field":
        """A stored frame of a result, counted from 0; -1 is the last.

        Raises:
            IndexError: when there is no such frame.
        """
        case = result.case
        grid = settings(case).grid(case.wing.pivot)
        frame = range(len(result.vorticity))[frame]
        step = int(case.step_of(frame))
        pairs = np.asarray(result.map[frame])
        return cls(
            rho=0.5 * (grid.faces[1:] + grid.faces[:-1]),
            phi=grid.centres,
            faces=grid.faces,
            vorticity=np.asarray(result.vorticity[frame], float),
            coefficients=pairs[:, 0] + 1j * pairs[:, 1],
            pivot=complex(result.surge[step], result.plunge[step]),
            pitch=float(result.pitch[step]),
            chord=case.wing.chord,
        )

    def positions(self, inertial: bool = True) -> Complex:
        """Y + i Z of the cells' centres, or y + i z in the wing's axes: (rho, phi), m."""
        wing, _ = self._mapped(np.exp(self.rho[:, None] + 1j * self.phi))
        return self.pivot + wing * np.exp(1j * self.pitch) if inertial else wing

    def resampled(self, y: ArrayLike, z: ArrayLike, inertial: bool = True) -> Array:
        """Vorticity at the points of a plain grid, (len(y), len(z)), 1/s.

        It is NaN inside the section, and zero outside the grid.

        Args:
            y, z: coordinates along Y and Z, or along the wing's axes from the pivot, m.
        """
        points = np.asarray(y, float)[:, None] + 1j * np.asarray(z, float)
        if inertial:
            points = (points - self.pivot) * np.exp(-1j * self.pitch)
        zeta = self._inverted(points)
        rho, phi = np.log(np.abs(zeta)), np.angle(zeta) % (2.0 * np.pi)
        row = np.clip(np.searchsorted(self.rho, rho) - 1, 0, len(self.rho) - 2)
        share = np.clip((rho - self.rho[row]) / (self.rho[row + 1] - self.rho[row]), 0.0, 1.0)
        cell = phi / (self.phi[1] - self.phi[0]) - 0.5
        left = np.floor(cell).astype(int)
        aside = cell - left
        count = len(self.phi)
        below, above = (
            (1.0 - aside) * self.vorticity[r, left % count] + aside * self.vorticity[r, (left + 1) % count]
            for r in (row, row + 1)
        )
        found = np.where(rho > self.faces[-1], 0.0, (1.0 - share) * below + share * above)
        return np.where(rho < 0.0, np.nan, found)

    def _mapped(self, zeta: Complex) -> tuple[Complex, Complex]:
        """F(zeta), and its derivative."""
        total, slope = np.zeros_like(zeta), np.zeros_like(zeta)
        for n in range(len(self.coefficients) - 2, -1, -1):
            slope = slope / zeta + n * self.coefficients[n + 1]
            total = total / zeta + self.coefficients[n + 1]
        return total + self.coefficients[0] * zeta, self.coefficients[0] - slope / zeta

    def _inverted(self, points: Complex) -> Complex:
        """zeta of points, by Newton's method from the nearest cell; of length below one inside the section."""
        from scipy.spatial import cKDTree  # noqa: PLC0415 - slow to import, and only a resampled field needs it

        known = np.exp(self.rho[:, None] + 1j * self.phi).ravel()
        wing, _ = self._mapped(known)
        tree = cKDTree(np.stack((wing.real, wing.imag), axis=1))
        _, nearest = tree.query(np.stack((points.real.ravel(), points.imag.ravel()), axis=1))
        zeta = known[nearest].reshape(points.shape)
        for _ in range(NEWTON_STEPS):
            found, slope = self._mapped(zeta)
            step = (found - points) / slope
            # Not far inside, where the series of a bent section does not converge.
            step *= np.minimum(1.0, 0.3 * np.abs(zeta) / np.maximum(np.abs(step), 1e-300))
            zeta = zeta - step
            zeta = np.where(np.abs(zeta) < 0.8, zeta / np.abs(zeta) * 0.8, zeta)
            if np.all((np.abs(step) * np.abs(slope) < CLOSE * self.chord) | (np.abs(zeta) <= 0.8 + 1e-12)):
                break
        return zeta
