"""Modes of a section with any distribution of mass and stiffness, by the Ritz method with the curvature as unknown.

On each piece of the chord between two breaks the curvature is a Legendre series; integrated twice from the clamp it
gives the deflection, which is continuous with its slope. The stiffness matrix is block diagonal, and sections that
vanish at the tip cause no singularity. Convergence is exponential in the number of terms.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import cholesky, eigh, solve_triangular

from .distribution import Array, Section, gauss

TERMS = 6
TERMS_A_CHORD = 56
"""Terms per piece: a minimum, plus a number proportional to its length (mode 20 has nine waves along the chord)."""

SPARE_POINTS = 4
"""Gauss points per piece in addition to its terms; exact for products of all tables."""


@dataclass(frozen=True)
class Bent:
    """Frequencies (rad/s), lambda, psi and mass-normalised shapes of a section; see `beam.Modes`."""

    omega: Array
    lam: Array
    psi: Array
    breaks: Array
    coefficients: Array

    def shape(self, s: Array) -> tuple[Array, Array]:
        """Shapes at s = y/chord and their slopes by s: (modes, len(s)), 1/sqrt(kg)."""
        moved, turned = deflection(self.breaks, s)
        return self.coefficients @ moved, self.coefficients @ turned


def modes(section: Section, count: int) -> Bent:
    """The `count` lowest modes of a section clamped at s = 0.

    `K a = omega^2 M a` is solved as `M a = omega^-2 K a`: the lowest modes are then the largest eigenvalues, which are
    insensitive to round-off.
    """
    assert section.flexural_rigidity is not None
    breaks, chord = section.breaks, section.chord
    s, weights = gauss(breaks, [count + SPARE_POINTS for count in terms(breaks)])
    bent = curvature(breaks, s)
    stiffness = (bent * (weights * section.flexural_rigidity(s) / chord**3)) @ bent.T
    places, mass = section.masses(s, weights)
    moved, _ = deflection(breaks, places)
    factor = cholesky(stiffness, lower=True)
    turned = solve_triangular(factor, moved, lower=True)
    last = len(stiffness) - 1
    values, vectors = eigh((turned * mass) @ turned.T, subset_by_index=(last - count + 1, last))
    coefficients = solve_triangular(factor, vectors[:, ::-1], lower=True, trans="T").T
    shapes = coefficients @ moved
    # Normalise every mode again, since the eigenvectors are normalised only to the round-off of the first mode.
    gram = cholesky((shapes * mass) @ shapes.T, lower=True)
    turn = solve_triangular(gram, np.eye(count), lower=True)
    turn *= np.sign(turn @ shapes @ (mass * places))[:, None]
    coefficients, shapes = turn @ coefficients, turn @ shapes
    return Bent(1.0 / np.sqrt(values[::-1]), shapes @ mass, chord * (shapes @ (mass * places)), breaks, coefficients)


def terms(breaks: Array) -> list[int]:
    """Number of terms of each piece."""
    return [TERMS + math.ceil(TERMS_A_CHORD * length) for length in np.diff(breaks)]


def curvature(breaks: Array, s: Array) -> Array:
    """Second derivative of each unknown's shape at s: (unknowns, len(s))."""
    rows = []
    for left, right, count in zip(breaks[:-1], breaks[1:], terms(breaks), strict=True):
        x = 2.0 * (s - left) / (right - left) - 1.0
        rows.append(np.where(np.abs(x) <= 1.0, legendre.legval(x, np.eye(count)), 0.0))
    return np.concatenate(rows)


def deflection(breaks: Array, s: Array) -> tuple[Array, Array]:
    """Deflection of each unknown's shape at s, and its slope by s: (unknowns, len(s)) each.

    Beyond its piece a shape continues as a straight line.
    """
    shares, slopes = [], []
    for left, right, count in zip(breaks[:-1], breaks[1:], terms(breaks), strict=True):
        half = 0.5 * (right - left)
        x = np.clip((s - left) / half - 1.0, -1.0, 1.0)
        once = legendre.legint(np.eye(count), lbnd=-1)
        slope = half * legendre.legval(x, once)
        twice = legendre.legint(once, lbnd=-1)
        shares.append(half**2 * legendre.legval(x, twice) + slope * np.maximum(s - right, 0.0))
        slopes.append(slope)
    return np.concatenate(shares), np.concatenate(slopes)
