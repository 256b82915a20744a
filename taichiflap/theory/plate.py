"""The exact linear solution of an elastic plate, clamped at its leading edge, that heaves or flutters in a stream.

An Euler-Bernoulli beam in its Ritz approximation by polynomials, under the unsteady loads of potential flow of Wu
(Swimming of a waving plate, J. Fluid Mech. 10, 1961). With half the chord, U and rho for units and x from -1 to 1 a
plate at `h(x) exp(i k t)` turns the flow by `v = i k h + h'`; of `v = V_0/2 + sum V_n T_n(x)` the acceleration
potential above it is

    phi = A_0/2 tan(t/2) + sum A_n sin(n t),
    A_n = -V_n - i k (V_(n-1) - V_(n+1))/(2 n),    A_0 = V_1 - C(k) (V_0 + V_1)

at x = cos t, and the load `2 phi`.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray
from scipy.linalg import eigvals, solve
from scipy.optimize import brentq

from .classical import theodorsen

POINTS = 200
"""Places in t, at the middles of equal steps: for what is smooth in t their sums are exact to round-off."""
TERMS = 60
"""Terms of the series of v."""

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Heaving:
    """Response of a heaving plate, in the conventions of `taichiflap.theory`, for a heave of one chord.

    Attributes:
        tip: elastic deflection of the trailing edge over the heave.
        lift: lift coefficient.
        thrust: mean thrust coefficient, with the suction at the leading edge.
        lean: the same without it.
        power: mean coefficient of the power that the heave takes, over `rho U^3 c/2`.
    """

    tip: complex
    lift: complex
    thrust: float
    lean: float
    power: float


class ElasticPlate:
    """An elastic plate in a stream.

    Args:
        mass_ratio: mass of fluid over that of the plate, `rho c/(rho_s t)`.
        speed: `U* = U c sqrt(rho_s t/(E I))`, E I of a unit span.
        polynomials: terms of the Ritz approximation.
    """

    def __init__(self, mass_ratio: float, speed: float = 1.0, polynomials: int = 14) -> None:
        self.mass = 2.0 / mass_ratio
        self.rigidity = 4.0 * self.mass / speed**2
        shapes = [Chebyshev([1.5, 2.0, 0.5]) * Chebyshev.basis(j) for j in range(polynomials)]
        points, weights = np.polynomial.legendre.leggauss(2 * polynomials + 4)
        along = np.array([shape(points) for shape in shapes])
        bent = np.array([shape.deriv(2)(points) for shape in shapes])
        self._inertia, self._stiffness = (along * weights) @ along.T, (bent * weights) @ bent.T
        self._carried = along @ weights
        self._angle = (np.arange(POINTS) + 0.5) * np.pi / POINTS
        x = np.cos(self._angle)
        self._shape = np.array([shape(x) for shape in shapes])
        self._slope = np.array([shape.deriv()(x) for shape in shapes])
        self._tip = np.array([shape(1.0) for shape in shapes])
        order = np.arange(TERMS + 2)[:, None]
        self._cosines, self._sines = np.cos(order * self._angle), np.sin(order * self._angle)

    def _potential(self, k: float, wash: Complex) -> tuple[complex, Complex]:
        """A_0, and A_n from n = 1 on, for the downwash v at all points."""
        v = 2.0 / POINTS * self._cosines @ wash
        order = np.arange(1, TERMS + 1)
        terms = -v[1 : TERMS + 1] - 1j * k * (v[:TERMS] - v[2 : TERMS + 2]) / (2 * order)
        return complex(v[1] - theodorsen(k) * (v[0] + v[1])), terms

    def _load(self, edge: complex, terms: Complex) -> Complex:
        """The load `2 phi` times `dx/dt`, so that sums over the points are integrals up to the step."""
        sine = np.sin(self._angle)
        smooth: Complex = 2.0 * terms @ self._sines[1 : TERMS + 1] * sine
        return smooth + edge * (1.0 - np.cos(self._angle))

    def air(self, k: float) -> Complex:
        """Forces of the flow on every shape (rows) by a unit amplitude of every shape."""
        washes = 1j * k * self._shape + self._slope
        loads = np.array([self._load(*self._potential(k, wash)) for wash in washes])
        forces: Complex = self._shape @ loads.T * (np.pi / POINTS)
        return forces

    def heaving(self, k: float) -> Heaving:
        """The plate heaving at its leading edge with an amplitude of one chord (two units)."""
        still = np.full(POINTS, 2j * k)
        step = np.pi / POINTS
        push = self._shape @ self._load(*self._potential(k, still)) * step + 2.0 * k * k * self.mass * self._carried
        system = self.rigidity * self._stiffness - k * k * self.mass * self._inertia - self.air(k)
        q = solve(system, push)
        shape, slope = 2.0 + q @ self._shape, q @ self._slope
        edge, terms = self._potential(k, 1j * k * shape + slope)
        load = self._load(edge, terms)
        lean = 0.5 * float(np.real(np.sum(load * np.conj(slope)))) * step
        power = -0.5 * float(np.real(np.sum(load * np.conj(1j * k * shape)))) * step
        suction = 0.25 * np.pi * abs(edge) ** 2
        return Heaving(complex(q @ self._tip / 2.0), np.pi * (edge + terms[0]), lean + suction, lean, power)

    def neutral(self, k: float) -> Complex:
        """Rigidities, most of them complex, at which the free plate would oscillate steadily at `k`."""
        return np.asarray(eigvals(k * k * self.mass * self._inertia + self.air(k), self._stiffness), dtype=complex)


def flutter_onset(mass_ratio: float, first: float = 0.3, last: float = 3.0, count: int = 55) -> tuple[float, float]:
    """The least speed U* at which the free plate oscillates steadily, and the reduced frequency k there.

    Where, as k varies, one of the rigidities of `ElasticPlate.neutral` is real; searched between `first` and `last`.

    Raises:
        ValueError: when there is none.
    """
    plate = ElasticPlate(mass_ratio)

    def near(k: float, place: complex) -> complex:
        found = plate.neutral(k)
        return complex(found[np.argmin(np.abs(found - place))])

    onset: list[tuple[float, float]] = []
    ks = np.linspace(first, last, count)
    before = plate.neutral(ks[0])
    for low, high in itertools.pairwise(ks):
        now = plate.neutral(high)
        for root in before[before.real > 1e-3 * np.abs(before).max()]:
            end = complex(now[np.argmin(np.abs(now - root))])
            if root.imag * end.imag < 0.0:
                k = brentq(lambda k, root=root: near(k, root).imag, low, high)
                rigidity = near(k, root).real
                if rigidity > 0.0:
                    onset.append((2.0 * float(np.sqrt(plate.mass / rigidity)), float(k)))
        before = now
    if not onset:
        raise ValueError(f"no flutter at mass ratio {mass_ratio:g} for k between {first:g} and {last:g}")
    return min(onset)
