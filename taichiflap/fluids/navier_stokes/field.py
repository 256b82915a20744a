"""A stored frame of a flow as a field in space: positions of its cells, and the flow at any points."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .grid import areas, positions, slopes
from .inverse import inverted
from .settings import settings
from .wall_motion import WallMotion

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SEAM = 8
"""Cells on either side of the seam phi = 0 that a periodic row goes on for."""


@dataclass(frozen=True)
class Field:
    """The flow on the grid about the wing.

    Attributes:
        rho, phi: coordinates of the cells' centres.
        faces: rho of the faces between rows.
        vorticity: (rho, phi), 1/s.
        coefficients: of the map in the wing's axes from the pivot, m: of zeta, 1, 1/zeta, ...
        pivot: its position Y + i Z, m.
        pitch: rad.
        chord: m.
        wall: how the wing moves through the fluid.
        stream: velocity of the free stream along Y and Z, m/s.
    """

    rho: Array
    phi: Array
    faces: Array
    vorticity: Array
    coefficients: Complex
    pivot: complex
    pitch: float
    chord: float
    wall: WallMotion
    stream: complex = 0.0
    _last: list[Any] = field(default_factory=list, compare=False, repr=False)

    @classmethod
    def of(cls, result: Any, frame: int) -> "Field":
        """A stored frame of a result, counted from 0; -1 is the last.

        Raises:
            IndexError: when there is no such frame.
        """
        case = result.case
        grid = settings(case).grid(case.wing.pivot)
        frame = range(result.frames)[frame]
        pairs = np.asarray(result.frame("map", frame))
        return cls(
            rho=0.5 * (grid.faces[1:] + grid.faces[:-1]),
            phi=grid.centres,
            faces=grid.faces,
            vorticity=np.asarray(result.frame("vorticity", frame), float),
            coefficients=pairs[:, 0] + 1j * pairs[:, 1],
            pivot=complex(result.frame("surge", frame), result.frame("plunge", frame)),
            pitch=float(result.frame("pitch", frame)),
            chord=case.wing.chord,
            wall=WallMotion.of(result, frame),
            stream=complex(*case.fluid.velocity),
        )

    def positions(self, inertial: bool = True) -> Complex:
        """Y + i Z of the cells' centres, or y + i z in the wing's axes: (rho, phi), m."""
        wing = positions(self.coefficients, self.rho, self.phi)
        return self.pivot + wing * np.exp(1j * self.pitch) if inertial else wing

    def resampled(self, y: ArrayLike, z: ArrayLike, inertial: bool = True) -> Array:
        """Vorticity at the points of a uniform grid, (len(y), len(z)), 1/s.

        It is NaN inside the section, and zero outside the grid.

        Args:
            y, z: coordinates along Y and Z, or along the wing's axes from the pivot, m.
        """
        points = np.asarray(y, float)[:, None] + 1j * np.asarray(z, float)
        if not inertial:
            points = self.pivot + points * np.exp(1j * self.pitch)
        return self.vorticity_at(np.stack((points.real, points.imag)))

    def vorticity_at(self, points: Array) -> Array:
        """Vorticity (1/s) at points Y and Z (m), (2, ...): NaN inside the section, zero outside the grid."""
        rho, place = self._located(points)
        return _outside(rho, np.where(rho > self.faces[-1], 0.0, self._sampled(self.vorticity, place)))

    def velocity_at(self, points: Array) -> Array:
        """Velocity of the fluid (m/s) along Y and Z at points Y and Z (m), (2, ...): NaN inside the section.

        Outside the grid it is that of its outermost row.
        """
        rho, place = self._located(points)
        found = self._velocity
        return np.stack([_outside(rho, self._sampled(part, place)) for part in (found.real, found.imag)])

    def streamfunction_at(self, points: Array) -> Array:
        """Streamfunction psi (m2/s) at points Y and Z (m), (2, ...): NaN inside the section.

        The velocity is (d psi/dZ, -d psi/dY), the stream included.
        """
        rho, place = self._located(points)
        wing = self._wing(points)
        found = self._sampled(0.5 * (self._psi[1:] + self._psi[:-1]), place)
        carried = (self.stream.conjugate() * (wing * np.exp(1j * self.pitch))).imag
        return _outside(rho, self.chord**2 * found + carried)

    @cached_property
    def _psi(self) -> Array:
        """Streamfunction of the motion relative to the stream on the faces, (rows + 1, phi), chords^2/s."""
        drho, count = np.diff(self.faces), len(self.phi)
        scaled = self.coefficients / self.chord
        corner = positions(scaled, self.faces, self.phi + 0.5 * (self.phi[1] - self.phi[0]))
        source = np.fft.rfft(areas(corner, drho, self.phi[1] - self.phi[0]) * self.vorticity)
        k = np.arange(source.shape[1])
        decay = np.exp(-np.outer(drho, k))
        weight = np.concatenate((drho[:, None], (1.0 - decay[:, 1:]) / k[1:]), axis=1)
        falling = np.zeros((len(drho) + 1, len(k)), complex)
        for j in range(len(drho) - 1, -1, -1):
            falling[j] = decay[j] * falling[j + 1] + weight[j] * source[j]
        place = positions(scaled, np.zeros(1), self.phi)[0]
        tangent, psi = self.wall.on(place, slopes(scaled, self.phi))
        falling[:, 0] -= falling[0, 0] + np.fft.rfft(tangent)[0]
        climbing = np.zeros_like(falling)
        climbing[0] = np.fft.rfft(psi)
        for j in range(len(drho)):
            climbing[j + 1] = decay[j] * climbing[j] + 0.5 * weight[j] * (falling[j] + falling[j + 1])
        return np.fft.irfft(climbing, count)

    @cached_property
    def _velocity(self) -> Complex:
        """Velocity Y + i Z of the fluid in the cells, (rho, phi), m/s."""
        psi = 0.5 * (self._psi[1:] + self._psi[:-1])
        along_rho = np.diff(self._psi, axis=0) / np.diff(self.faces)[:, None]
        spectrum = np.fft.rfft(psi)
        wave = 1j * np.arange(spectrum.shape[1])
        wave[-1] = 0.0
        along_phi = np.fft.irfft(wave * spectrum, len(self.phi))
        order = 1 - np.arange(len(self.coefficients))
        gradient = positions(order * self.coefficients / self.chord, self.rho, self.phi)
        wing = -1j * (along_rho + 1j * along_phi) / gradient.conj()
        return self.stream + self.chord * wing * np.exp(1j * self.pitch)

    def _wing(self, points: Array) -> Complex:
        """y + i z in the wing's axes from the pivot of points Y and Z."""
        return (points[0] + 1j * points[1] - self.pivot) * np.exp(-1j * self.pitch)

    def _located(self, points: Array) -> tuple[Array, Array]:
        """rho of points, and their fractional row and cell; the last request is cached."""
        if not self._last or self._last[0] is not points:
            zeta = inverted(self.coefficients, self._wing(points), self.chord)
            rho = np.log(np.abs(zeta))
            row = np.interp(rho, self.rho, np.arange(len(self.rho)))
            cell = (np.angle(zeta) % (2.0 * np.pi)) / (self.phi[1] - self.phi[0]) - 0.5
            self._last[:] = points, rho, np.stack((row, cell + SEAM))
        return self._last[1], self._last[2]

    @staticmethod
    def _sampled(values: Array, place: Array) -> Array:
        """Values at fractional rows and cells, by cubic splines."""
        from scipy.ndimage import map_coordinates  # noqa: PLC0415 - slow to import, and only pictures need it

        wrapped = np.concatenate((values[:, -SEAM:], values, values[:, :SEAM]), axis=1)
        found: Array = map_coordinates(wrapped, place, order=3, mode="nearest")
        return found


def _outside(rho: Array, values: Array) -> Array:
    """Values outside the section, and NaN inside."""
    return np.where(rho < 0.0, np.nan, values)
