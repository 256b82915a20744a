"""Exact solutions with which the models are compared. Each cites its source; none shares code with the models.

A plate of chord c in a stream U. Lengths are in chords, frequencies are `k = omega c / (2 U)`, lift and thrust are over
`rho U^2 c / 2` and moments over `rho U^2 c^2 / 2`, all per unit span. Harmonic quantities are complex amplitudes of
`exp(i omega t)`.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import quad
from scipy.linalg import eigvalsh
from scipy.optimize import brentq
from scipy.special import hankel2e

Array = NDArray[np.float64]

TERMS = 64
"""Number of terms of the sine series of a plate's potential; smooth beam shapes need about a dozen."""


def theodorsen(k: float) -> complex:
    """Theodorsen's function `C(k) = H1/(H1 + i H0)` of Hankel functions of the second kind; C(0) = 1.

    Theodorsen, NACA Report 496 (1935).
    """
    if k == 0.0:
        return 1.0 + 0.0j
    one, zero = hankel2e(1, k), hankel2e(0, k)
    return complex(one / (one + 1j * zero))


def wagner(s: float) -> float:
    """Wagner's function: fraction of the steady lift at `s = 2 U t / c` half-chords after a sudden start.

    The inverse transform of Theodorsen's function, `2/pi int_0^inf Re C(k) sin(k s)/k dk` (Garrick, NACA Report 629,
    1938), integrated after subtracting its limit of 1/2 at high k.
    """
    if s == 0.0:
        return 0.5

    def rest(k: float) -> float:
        return (theodorsen(k).real - 0.5) / k

    near, _ = quad(lambda k: rest(k) * math.sin(k * s), 0.0, 1.0, limit=400, epsabs=1e-11, epsrel=1e-11)
    far, _ = quad(rest, 1.0, math.inf, weight="sin", wvar=s, limlst=200, epsabs=1e-10)
    return 0.5 + 2.0 / math.pi * (near + far)


def oscillating_loads(
    k: float, plunge: complex = 0.0, pitch: complex = 0.0, axis: float = 0.0
) -> tuple[complex, complex]:
    """Lift and nose-up moment coefficients of a plate that plunges and pitches.

    Theodorsen, NACA Report 496 (1935), Eqs XVIII and XX, with his downward plunge turned upward.

    Args:
        k: reduced frequency.
        plunge: amplitude, chords, towards positive lift.
        pitch: amplitude, rad, nose up.
        axis: pitch axis, to which the moment refers, chords behind the leading edge.
    """
    b, a, rate = 0.5, 2.0 * axis - 1.0, 2j * k
    downward = -plunge
    wash = _wash(k, plunge, pitch, axis)
    lift = b * b * (rate**2 * downward + rate * pitch - b * a * rate**2 * pitch)
    lift += 2.0 * b * theodorsen(k) * wash
    moment = (
        b * b * (b * a * rate**2 * downward - b * (0.5 - a) * rate * pitch - b * b * (0.125 + a * a) * rate**2 * pitch)
    )
    moment += 2.0 * b * b * (a + 0.5) * theodorsen(k) * wash
    return 2.0 * math.pi * lift, 2.0 * math.pi * moment


def mean_power(k: float, plunge: complex = 0.0, pitch: complex = 0.0, axis: float = 0.0) -> float:
    """Mean power required by the motion of `oscillating_loads`, over `rho U^3 c / 2`."""
    lift, moment = oscillating_loads(k, plunge, pitch, axis)
    rate = 2j * k
    return -0.5 * (lift * np.conj(rate * plunge) + moment * np.conj(rate * pitch)).real


def mean_thrust(
    k: float, plunge: complex = 0.0, pitch: complex = 0.0, axis: float = 0.0, *, suction: bool = True
) -> float:
    """Mean thrust coefficient of the motion of `oscillating_loads`.

    Garrick, NACA Report 567 (1936): the forward lean of the normal force, and the suction at the leading edge `pi rho b
    S^2` with `S = (2 C(k) Q - b dalpha/dt)/sqrt(2)`, which is omitted with `suction=False`, as for a sharp leading edge
    or a lattice without suction.
    """
    lift, _ = oscillating_loads(k, plunge, pitch, axis)
    lean = -0.5 * (lift * np.conj(pitch)).real
    if not suction:
        return lean
    strength = 2.0 * theodorsen(k) * _wash(k, plunge, pitch, axis) - 0.5 * 2j * k * pitch
    return lean + 0.5 * math.pi * abs(strength) ** 2 / 2.0


def _wash(k: float, plunge: complex, pitch: complex, axis: float) -> complex:
    """Upwash at three quarters of the chord over U."""
    return -2j * k * plunge + pitch + (0.75 - axis) * 2j * k * pitch


def plate_normal_force(alpha: float) -> float:
    """Steady normal force coefficient of a flat plate at `alpha` (rad): `2 pi sin(alpha) cos(alpha)`.

    The circulation `pi c U sin(alpha)` times the tangential speed; suction acts along the chord and does not
    contribute. Katz & Plotkin, Low-Speed Aerodynamics (2001), section 5.4.
    """
    return 2.0 * math.pi * math.sin(alpha) * math.cos(alpha)


def plate_load_ahead(x: ArrayLike) -> Array:
    """Fraction of a flat plate's steady load ahead of `x` chords.

    Integral of `dp ~ sqrt((1 - x)/x)`: `(t + sin t)/pi` with `x = (1 - cos t)/2` (Katz & Plotkin 2001, Eq. 5.72).
    """
    angle = np.arccos(1.0 - 2.0 * np.asarray(x, dtype=float))
    return (angle + np.sin(angle)) / math.pi


def parabolic_camber_lift(alpha: float, camber: float) -> float:
    """Steady lift coefficient of a parabolic camber line of height `camber` chords: `2 pi (alpha + 2 f/c)`.

    Glauert, The Elements of Aerofoil and Airscrew Theory (1926), chapter VII; `alpha` (rad) is that of the chord line.
    """
    return 2.0 * math.pi * (alpha + 2.0 * camber)


def added_mass(shapes: Sequence[Callable[[Array], Array]]) -> Array:
    """Added mass of a plate in fluid at rest, without circulation, for velocities of given shapes along the chord.

    A normal velocity v has the potential jump `c/2 sum_n B_n sin(n t)` at `x = (1 - cos t)/2`, with
    `n B_n = 4/pi int_0^pi v sin t sin(n t) dt`; heave gives `pi rho c^2/4` (Lamb, Hydrodynamics, 1932, art. 71).

    Args:
        shapes: functions of x, chords behind the leading edge.

    Returns:
        Shape (shapes, shapes): the fluid's kinetic energy per unit span is `rho c^2 v M v / 2`.
    """
    points = 8 * TERMS
    angle = (np.arange(points) + 0.5) * math.pi / points
    order = np.arange(1, TERMS + 1)
    sines = np.sin(np.outer(order, angle)) * np.sin(angle) * (math.pi / points)
    moments = np.array([sines @ shape(0.5 * (1.0 - np.cos(angle))) for shape in shapes])
    return moments / order @ moments.T / math.pi


def wet_frequencies(frequency: ArrayLike, mass: ArrayLike) -> Array:
    """Natural frequencies of mass-normalised modes with the added modal mass of a fluid.

    Args:
        frequency: in vacuo, any unit, shape (modes,).
        mass: added modal mass matrix, shape (modes, modes).

    Returns:
        The frequencies in the same unit, in increasing order.
    """
    dry = np.asarray(frequency, dtype=float)
    return np.sqrt(eigvalsh(np.diag(dry**2), np.eye(len(dry)) + np.asarray(mass)))


def cantilever_roots(count: int) -> Array:
    """The first roots of `cos(beta) cosh(beta) + 1 = 0`, bracketed and bisected.

    Blevins, Formulas for Natural Frequency and Mode Shape (1979), table 8-1.
    """
    return np.array(
        [
            brentq(lambda x: math.cos(x) + 1.0 / math.cosh(x), (k - 1) * math.pi, k * math.pi, xtol=1e-15)
            for k in range(1, count + 1)
        ]
    )


def cantilever_frequencies(count: int, chord: float, thickness: float, density: float, youngs_modulus: float) -> Array:
    """Natural frequencies (Hz) of a uniform plate clamped along one edge, as a beam; SI units.

    `f = beta^2/(2 pi c^2) sqrt(E I/m)` with `I = t^3/12` and `m = rho t` per unit width (Blevins 1979, table 8-1).
    """
    stiffness = youngs_modulus * thickness**3 / 12.0
    return cantilever_roots(count) ** 2 / (2.0 * math.pi * chord**2) * math.sqrt(stiffness / (density * thickness))


def cantilever_shape(beta: float, s: ArrayLike) -> Array:
    """Clamped-free mode of unit mean square at `s`, fractions of the length, for a root `beta` up to about 20.

    Blevins (1979), table 8-1, in the textbook's hyperbolic functions.
    """
    x = beta * np.asarray(s, dtype=float)
    sigma = (math.sinh(beta) - math.sin(beta)) / (math.cosh(beta) + math.cos(beta))
    return np.cosh(x) - np.cos(x) - sigma * (np.sinh(x) - np.sin(x))


def pair_speed(circulation: float, distance: float) -> float:
    """Speed of two opposite vortices: `Gamma/(2 pi d)` (Lamb, Hydrodynamics, 1932, art. 155)."""
    return circulation / (2.0 * math.pi * distance)


def pair_rotation(first: float, second: float, distance: float) -> float:
    """Rate of rotation (rad/s) of two vortices about their centre: `(G1 + G2)/(2 pi d^2)` (Lamb 1932, art. 155)."""
    return (first + second) / (2.0 * math.pi * distance**2)


def polygon_rotation(count: int, circulation: float, radius: float) -> float:
    """Rate of rotation (rad/s) of equal vortices at the corners of a regular polygon: `(n - 1) G/(4 pi R^2)`.

    Thomson, A Treatise on the Motion of Vortex Rings (1883), art. 53.
    """
    return (count - 1) * circulation / (4.0 * math.pi * radius**2)
