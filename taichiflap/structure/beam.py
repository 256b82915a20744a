"""Elastic modes of the wing section: frequencies, mass-normalised shapes, and the constants lambda and psi.

Reade & Jankauski (2020), Eqs 8 and 11-13, for an Euler-Bernoulli section clamped at its leading edge. Uniform sections
have closed forms (Blevins, Formulas for Natural Frequency and Mode Shape); for others `taichiflap.structure.ritz`
solves the eigenproblem.
"""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..case.wing import Wing
from .distribution import GAUSS_POINTS, Section, gauss

NEWTON_STEPS = 20

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Modes:
    """Modes of a section, k = 0 .. count-1, and the rigid-body constants of its mass.

    y is the distance from the pivot, which is at the leading edge for a flexible wing.

    Attributes:
        omega: natural angular frequencies, rad/s.
        damping_ratio: damping ratio of each mode.
        lam: `int phi_k dm` (Eq. 12), sqrt(kg).
        psi: `int y phi_k dm` (Eq. 13), m sqrt(kg); positive, which defines the sign of the shapes.
        mass: `int dm`, kg.
        first_moment: `int y dm`, kg m.
        second_moment: `int y^2 dm`, kg m^2.
    """

    chord: float
    omega: Array
    damping_ratio: Array
    lam: Array
    psi: Array
    mass: float
    first_moment: float
    second_moment: float
    _shape: Callable[[Array], tuple[Array, Array]]

    @property
    def count(self) -> int:
        """Number of modes."""
        return len(self.omega)

    @property
    def frequency(self) -> Array:
        """Natural frequencies, Hz."""
        return self.omega / (2.0 * math.pi)

    @property
    def shapes(self) -> Callable[[Array], tuple[Array, Array]]:
        """Shapes and slopes as functions of y/c: the same object for uniform sections that share them."""
        return self._shape

    def shape(self, y: ArrayLike) -> Array:
        """Mass-normalised mode shapes phi_k at chordwise positions `y` (m): shape (modes, len(y)), 1/sqrt(kg)."""
        return self._shape(np.asarray(y, dtype=np.float64) / self.chord)[0]

    def curves(self, y: ArrayLike) -> tuple[Array, Array]:
        """Both `shape` and `slope`."""
        shape, slope = self._shape(np.asarray(y, dtype=np.float64) / self.chord)
        return shape, slope / self.chord

    @functools.cached_property
    def peak(self) -> Array:
        """Largest magnitude of the mode shapes, shape (modes,)."""
        return np.abs(self.shape(np.linspace(0.0, self.chord, 65))).max(axis=1, initial=0.0)

    @functools.cached_property
    def tip(self) -> Array:
        """Mode shapes at the trailing edge, shape (modes,)."""
        return self.shape([self.chord])[:, 0]

    def slope(self, y: ArrayLike) -> Array:
        """Slopes d(phi_k)/dy of the mode shapes at `y` (m): shape (modes, len(y)), 1/(m sqrt(kg))."""
        return self._shape(np.asarray(y, dtype=np.float64) / self.chord)[1] / self.chord


@functools.lru_cache(maxsize=256)
def modes(wing: Wing) -> Modes:
    """Modes of a wing section."""
    damping = _each(wing.damping_ratio, wing.modes)
    offset = wing.pivot * wing.chord
    if _is_uniform(wing):
        return _uniform(wing, damping, offset)
    section = Section.of(wing)
    s, mass = section.masses(*gauss(section.breaks, [GAUSS_POINTS] * (len(section.breaks) - 1)))
    y = wing.chord * s - offset
    rigid = float(mass.sum()), float(mass @ y), float(mass @ y**2)
    if not wing.modes:
        none = np.zeros(0)
        return Modes(wing.chord, none, damping, none, none, *rigid, functools.partial(_cantilevers, none, 1.0))
    from . import ritz  # noqa: PLC0415  (SciPy is for wings that need it)

    bent = ritz.modes(section, wing.modes)
    return Modes(wing.chord, bent.omega, damping, bent.lam, bent.psi, *rigid, bent.shape)


def _is_uniform(wing: Wing) -> bool:
    material = (wing.span, wing.thickness, wing.density, wing.youngs_modulus)
    given = material if wing.mass_per_length is None else (wing.mass_per_length, wing.flexural_rigidity)
    return not wing.point_masses and not any(isinstance(value, tuple) for value in given)


def _uniform(wing: Wing, damping: Array, offset: float) -> Modes:
    """Closed forms for a uniform wing: stiffness `E h t^3 / 12` and mass per length `rho h t` of the whole span."""
    beta = np.array([cantilever_root(k) for k in range(1, wing.modes + 1)])
    mass, speed = _mass_and_speed(wing)
    centre = wing.chord / 2.0
    return Modes(
        chord=wing.chord,
        omega=speed * (beta / wing.chord) ** 2,
        damping_ratio=damping,
        lam=math.sqrt(mass) * 2.0 * np.array([_sigma(b) for b in beta]) / beta,
        psi=math.sqrt(mass) * wing.chord * 2.0 / beta**2,
        mass=mass,
        first_moment=mass * (centre - offset),
        second_moment=mass * wing.chord**2 / 3.0 - mass * offset * (wing.chord - offset),
        _shape=_uniform_shapes(wing.modes, mass),
    )


@functools.lru_cache(maxsize=256)
def _uniform_shapes(count: int, mass: float) -> Callable[[Array], tuple[Array, Array]]:
    beta = np.array([cantilever_root(k) for k in range(1, count + 1)])
    return functools.partial(_cantilevers, beta, mass)


def _mass_and_speed(wing: Wing) -> tuple[float, float]:
    """Mass (kg) of a uniform wing, and the square root of stiffness over mass per length (m^2/s; 0 if rigid)."""
    if wing.mass_per_length is not None:
        per_length, rigidity = float(wing.mass_per_length), float(wing.flexural_rigidity or 0.0)  # type: ignore[arg-type]
        return per_length * wing.chord, math.sqrt(rigidity / per_length)
    span, thickness, density, modulus = (
        float(value or 0.0)  # type: ignore[arg-type]
        for value in (wing.span, wing.thickness, wing.density, wing.youngs_modulus)
    )
    return density * thickness * span * wing.chord, thickness * math.sqrt(modulus / (12.0 * density))


def _each(value: float | tuple[float, ...], count: int) -> Array:
    return np.array(value[:count] if isinstance(value, tuple) else [value] * count)


def cantilever_root(k: int) -> float:
    """The k-th root (k = 1, 2, ...) of `cos(beta) cosh(beta) = -1`, by Newton's method on `cos + 1/cosh`."""
    beta = (k - 0.5) * math.pi
    for _ in range(NEWTON_STEPS):
        sech = 1.0 / math.cosh(beta)
        beta -= (math.cos(beta) + sech) / (-math.sin(beta) - sech * math.tanh(beta))
    return beta


def _sigma(beta: float) -> float:
    return (math.cosh(beta) + math.cos(beta)) / (math.sinh(beta) + math.sin(beta))


def _cantilevers(beta: Array, mass: float, s: Array) -> tuple[Array, Array]:
    """Mass-normalised shapes at s = y/chord, and their slopes by s: (modes, len(s)) each."""
    both = np.array([_cantilever(b, s) for b in beta]).reshape(-1, 2, s.size) / math.sqrt(mass)
    return both[:, 0], both[:, 1]


def _cantilever(beta: float, s: Array) -> tuple[Array, Array]:
    """Clamped-free shape of unit mean square at s = y/chord, and its slope.

    `cosh(beta s) - sigma sinh(beta s)` is written with decaying exponentials; evaluated directly it loses all digits
    from about the tenth mode on.
    """
    decay = math.exp(-beta)
    grown = (math.sin(beta) - math.cos(beta) - decay) / (1.0 - decay**2 + 2.0 * decay * math.sin(beta))
    sigma = _sigma(beta)
    rising, falling = grown * np.exp(beta * (s - 1.0)), 0.5 * (1.0 + sigma) * np.exp(-beta * s)
    cosine, sine = np.cos(beta * s), np.sin(beta * s)
    return rising + falling - cosine + sigma * sine, beta * (rising - falling + sine + sigma * cosine)
