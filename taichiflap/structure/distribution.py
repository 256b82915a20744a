"""Distribution of a wing's mass and bending stiffness along the chord."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..case.wing import Wing
from .chordwise import Profile

GAUSS_POINTS = 6
"""Gauss points per piece for integrals of mass; exact for products of all tables."""

Array = NDArray[np.float64]
Function = Callable[[Array], Array]


@dataclass(frozen=True)
class Section:
    """Distributions over s = y/chord.

    Attributes:
        chord: m.
        breaks: breakpoints of the distributions, from 0 to 1, including the positions of point masses.
        mass_per_length: mass of the whole span per length of chord, kg/m.
        flexural_rigidity: bending stiffness `E h t^3 / 12` of the whole span, N m^2; None if only the mass is given.
        point_masses: s and mass (kg) of each, shape (masses, 2).
    """

    chord: float
    breaks: Array
    mass_per_length: Function
    flexural_rigidity: Function | None
    point_masses: Array

    @classmethod
    def of(cls, wing: Wing) -> "Section":
        """Section of a wing, from its material or from measured distributions."""
        given = {
            name: Profile.of(value)
            for name in ("span", "thickness", "density", "youngs_modulus", "mass_per_length", "flexural_rigidity")
            if (value := getattr(wing, name)) is not None
        }
        if "mass_per_length" in given:
            mass: Function = given["mass_per_length"]
            rigidity: Function | None = given.get("flexural_rigidity")
        else:
            span, thickness = given["span"], given["thickness"]
            mass = _product(span, thickness, given["density"])
            modulus = given.get("youngs_modulus")
            rigidity = modulus and _product(Profile.of(1.0 / 12.0), span, thickness, thickness, thickness, modulus)
        points = np.array(wing.point_masses).reshape(-1, 2)
        corners = [profile.s for profile in given.values()]
        return cls(wing.chord, np.unique(np.concatenate([*corners, points[:, 0]])), mass, rigidity, points)

    def masses(self, s: Array, weights: Array) -> tuple[Array, Array]:
        """Equivalent point masses: positions (s) and masses (kg) for a quadrature rule `s`, `weights` on [0, 1]."""
        spread = self.chord * weights * self.mass_per_length(s)
        return np.concatenate((s, self.point_masses[:, 0])), np.concatenate((spread, self.point_masses[:, 1]))


def gauss(breaks: Array, points: Sequence[int]) -> tuple[Array, Array]:
    """Gauss rule on every piece between `breaks`, with the given number of points: positions and weights."""
    places, weights = [], []
    for left, right, count in zip(breaks[:-1], breaks[1:], points, strict=True):
        x, w = np.polynomial.legendre.leggauss(count)
        half = 0.5 * (right - left)
        places.append(left + half * (x + 1.0))
        weights.append(half * w)
    return np.concatenate(places), np.concatenate(weights)


def _product(*profiles: Profile) -> Function:
    return lambda s: np.prod([profile(s) for profile in profiles], axis=0)
