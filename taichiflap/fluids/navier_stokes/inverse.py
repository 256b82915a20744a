"""The inverse of a grid's map: zeta of points in the plane."""

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]

NEWTON_STEPS = 50
QUICK_STEPS = 8
"""Steps from the straight section's map; what has not converged then starts anew from the nearest of a few circles."""
CLOSE = 1e-4
"""The last of Newton's steps, as a share of |zeta|: the error that it leaves goes with its square."""
LEAST = 0.8
"""Points inside the section end on this circle: further in, the series of a bent section does not converge."""
BANDS = (LEAST, 1.4, 3.0, 6.0, np.inf)
"""|zeta| from which on fewer and fewer coefficients matter."""
NEGLIGIBLE = 1e-9
"""Coefficients that move a point by less than this, chords, do not."""
RINGS = np.exp(np.concatenate(([0.0, 0.02, 0.06], np.arange(0.15, 1.6, 0.15))))
STARTS = 256
"""Radii and angles of the points from which the stubborn start."""


def mapped(coefficients: Complex, zeta: Complex) -> tuple[Complex, Complex]:
    """F(zeta), and its derivative.

    Args:
        coefficients: of zeta, 1, 1/zeta, ...
    """
    inverse = 1.0 / zeta
    total, slope = np.zeros_like(zeta), np.zeros_like(zeta)
    for n in range(len(coefficients) - 2, -1, -1):
        slope *= inverse
        slope += n * coefficients[n + 1]
        total *= inverse
        total += coefficients[n + 1]
    total += coefficients[0] * zeta
    slope *= -inverse
    slope += coefficients[0]
    return total, slope


def inverted(coefficients: Complex, points: Complex, chord: float) -> Complex:
    """zeta of points (m), of any shape; its absolute value is below one inside the section.

    The start is the inverse of the map's first three terms, which is all that a straight section has.
    """
    flat = points.ravel()
    half = 0.5 * (flat - coefficients[1]) / coefficients[0]
    root = np.sqrt(half * half - coefficients[2] / coefficients[0])
    zeta = half + np.where((half.conj() * root).real < 0.0, -root, root)
    if np.abs(coefficients[3:]).sum() > NEGLIGIBLE * chord:
        zeta = np.where(np.abs(zeta) < 1.0, zeta / np.abs(zeta), zeta)
        astray = np.zeros(len(flat), bool)
        astray[_improve(coefficients, flat, zeta, np.arange(len(flat)), chord, QUICK_STEPS)] = True
        # A point near the wall has another zeta, inside the circle, that a start from afar may end at.
        left = np.flatnonzero(astray | (zeta.real**2 + zeta.imag**2 < 1.0))
        if len(left):
            zeta[left] = _nearest(coefficients, flat[left])
            _improve(coefficients, flat, zeta, left, chord, NEWTON_STEPS)
    return zeta.reshape(points.shape)


def _improve(
    coefficients: Complex, points: Complex, zeta: Complex, left: NDArray[np.intp], chord: float, steps: int
) -> NDArray[np.intp]:
    """Newton steps for the points `left`, in place; returns those that have not converged."""
    weight = np.abs(coefficients) / (NEGLIGIBLE * chord)
    for _ in range(steps):
        size = np.abs(zeta[left])
        on = []
        for inner, outer in itertools.pairwise(BANDS):
            some = left[(size >= inner * (1.0 - 1e-12)) & (size < outer)]
            if len(some):
                used = max(3, int(np.flatnonzero(weight > inner ** (np.arange(len(weight)) - 1.0))[-1]) + 1)
                on.append(some[_step(coefficients[:used], points, zeta, some)])
        left = np.concatenate(on)
        if not len(left):
            break
    return left


def _step(coefficients: Complex, points: Complex, zeta: Complex, some: NDArray[np.intp]) -> Any:
    """One step for the points `some`, in place; returns those that need another."""
    before = zeta[some]
    found, slope = mapped(coefficients, before)
    change = (found - points[some]) / slope
    length = np.abs(change)
    far = length > 0.3 * np.abs(before)
    change[far] *= 0.3 * np.abs(before[far]) / length[far]
    fresh = before - change
    size = np.abs(fresh)
    inside = size <= LEAST
    fresh[inside] *= LEAST / np.maximum(size[inside], 1e-300)
    zeta[some] = fresh
    return (length >= CLOSE * np.abs(before)) & ~inside


def _nearest(coefficients: Complex, points: Complex) -> Complex:
    """The nearest of a few points around the section to each of the others."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - slow to import, and only a bent section needs it

    known = np.outer(RINGS, np.exp(2j * np.pi * (np.arange(STARTS) + 0.5) / STARTS)).ravel()
    places, _ = mapped(coefficients, known)
    _, found = cKDTree(np.stack((places.real, places.imag), axis=1)).query(np.stack((points.real, points.imag), axis=1))
    return known[found]
