"""Elastic modes of the wing section: frequencies, mass-normalised shapes, and the constants lambda and psi.

Reade & Jankauski (2020), Eqs 8 and 11-13, for a uniform section clamped at its leading edge; the closed forms
are the textbook ones of an Euler-Bernoulli cantilever (Blevins, Formulas for Natural Frequency and Mode Shape).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .sections.wing import Wing

NEWTON_STEPS = 20


@dataclass(frozen=True)
class Modes:
    """Modes of a section, k = 0 .. count-1, and the rigid-body constants of its mass.

    Attributes:
        omega: natural angular frequencies, rad/s.
        damping_ratio: damping ratio of each mode.
        lam: `int phi_k dm` (Eq. 12), sqrt(kg).
        psi: `int y phi_k dm` (Eq. 13), m sqrt(kg).
        mass: `int dm`, kg.
        first_moment: `int y dm`, kg m.
        second_moment: `int y^2 dm`, kg m^2.
    """

    chord: float
    omega: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    lam: NDArray[np.float64]
    psi: NDArray[np.float64]
    mass: float
    first_moment: float
    second_moment: float
    _beta: NDArray[np.float64]

    @property
    def count(self) -> int:
        """Number of modes."""
        return len(self.omega)

    @property
    def frequency(self) -> NDArray[np.float64]:
        """Natural frequencies, Hz."""
        return self.omega / (2.0 * math.pi)

    def shape(self, y: ArrayLike) -> NDArray[np.float64]:
        """Mass-normalised mode shapes phi_k at chordwise positions `y` (m): shape (modes, len(y)), 1/sqrt(kg)."""
        s = np.asarray(y, dtype=np.float64) / self.chord
        return np.array([_cantilever(beta, s)[0] for beta in self._beta]).reshape(-1, s.size) / math.sqrt(self.mass)

    def slope(self, y: ArrayLike) -> NDArray[np.float64]:
        """Slopes d(phi_k)/dy of the mode shapes at `y` (m): shape (modes, len(y)), 1/(m sqrt(kg))."""
        s = np.asarray(y, dtype=np.float64) / self.chord
        slopes = np.array([_cantilever(beta, s)[1] for beta in self._beta]).reshape(-1, s.size)
        return slopes / (self.chord * math.sqrt(self.mass))


def modes(wing: Wing) -> Modes:
    """Modes of a wing section.

    The bending stiffness is that of the section's span: `E h t^3 / 12` over a mass of `rho h t` a metre of chord.
    """
    beta = np.array([cantilever_root(k) for k in range(1, wing.modes + 1)])
    mass = wing.density * wing.thickness * wing.span * wing.chord
    speed = wing.thickness * math.sqrt(wing.youngs_modulus / (12.0 * wing.density))
    return Modes(
        chord=wing.chord,
        omega=speed * (beta / wing.chord) ** 2,
        damping_ratio=_each(wing.damping_ratio, wing.modes),
        lam=math.sqrt(mass) * 2.0 * np.array([_sigma(b) for b in beta]) / beta,
        psi=math.sqrt(mass) * wing.chord * 2.0 / beta**2,
        mass=mass,
        first_moment=mass * wing.chord / 2.0,
        second_moment=mass * wing.chord**2 / 3.0,
        _beta=beta,
    )


def _each(value: float | tuple[float, ...], count: int) -> NDArray[np.float64]:
    return np.array(value[:count] if isinstance(value, tuple) else [value] * count, dtype=np.float64)


def cantilever_root(k: int) -> float:
    """The k-th root (k = 1, 2, ...) of `cos(beta) cosh(beta) = -1`, by Newton's method on `cos + 1/cosh`."""
    beta = (k - 0.5) * math.pi
    for _ in range(NEWTON_STEPS):
        sech = 1.0 / math.cosh(beta)
        beta -= (math.cos(beta) + sech) / (-math.sin(beta) - sech * math.tanh(beta))
    return beta


def _sigma(beta: float) -> float:
    return (math.cosh(beta) + math.cos(beta)) / (math.sinh(beta) + math.sin(beta))


def _cantilever(beta: float, s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Clamped-free shape of unit mean square at s = y/chord, and its slope.

    `cosh(beta s) - sigma sinh(beta s)` is written in decaying exponentials: as it stands it loses all digits
    from about the tenth mode on.
    """
    decay = math.exp(-beta)
    grown = (math.sin(beta) - math.cos(beta) - decay) / (1.0 - decay**2 + 2.0 * decay * math.sin(beta))
    sigma = _sigma(beta)
    rising, falling = grown * np.exp(beta * (s - 1.0)), 0.5 * (1.0 + sigma) * np.exp(-beta * s)
    cosine, sine = np.cos(beta * s), np.sin(beta * s)
    return rising + falling - cosine + sigma * sine, beta * (rising - falling + sine + sigma * cosine)
