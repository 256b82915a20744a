"""Modes of a section of any mass and stiffness, by Ritz's method with the curvature as the unknown.

On each piece of the chord between two breaks the curvature is a Legendre series; integrated twice from the clamp it
gives the deflection, which is then continuous with its slope whatever the series. The stiffness matrix has blocks for
each piece alone, and where the section vanishes towards the tip nothing is singular. Convergence is exponential in the
number of terms.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import cholesky, eigh, solve_triangular

from .distribution import Array, Section, gauss

TERMS = 6
TERMS_A_CHORD = 56
"""Terms of a piece: a few, and more in proportion to its length (twenty modes have nine waves along the chord)."""

SPARE_POINTS = 4
"""Gauss points of a piece beyond its terms: exact up to the powers that tables multiply up to."""


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
    """The `count` lowest modes of a section that is clamped at s = 0.

    `K a = omega^2 M a` is solved from its other end, `M a = omega^-2 K a`: the lowest modes are then the largest
    eigenvalues, which round-off leaves alone.
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
    # The eigenvectors are normal in mass only to the round-off of the first mode; here every mode to its own.
    gram = cholesky((shapes * mass) @ shapes.T, lower=True)
    turn = solve_triangular(gram, np.eye(count), lower=True)
    turn *= np.sign(turn @ shapes @ (mass * places))[:, None]
    coefficients, shapes = turn @ coefficients, turn @ shapes
    return Bent(1.0 / np.sqrt(values[::-1]), shapes @ mass, chord * (shapes @ (mass * places)), breaks, coefficients)


def terms(breaks: Array) -> list[int]:
    """Number of terms of each piece."""
    return [TERMS + math.ceil(TERMS_A_CHORD * length) for length in np.diff(breaks)]


def curvature(breaks: Array, s: Array) -> Array:
    """The unknowns' shares of the second derivative by s, at s: (unknowns, len(s))."""
    rows = []
    for left, right, count in zip(breaks[:-1], breaks[1:], terms(breaks), strict=True):
        x = 2.0 * (s - left) / (right - left) - 1.0
        rows.append(np.where(np.abs(x) <= 1.0, legendre.legval(x, np.eye(count)), 0.0))
    return np.concatenate(rows)


def deflection(breaks: Array, s: Array) -> tuple[Array, Array]:
    """The unknowns' shares of the deflection at s, and of its slope by s: (unknowns, len(s)) each.

    Behind its piece a share goes on straight.
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
