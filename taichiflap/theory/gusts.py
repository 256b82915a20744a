"""Lift of a plate in a small gust normal to the stream: Kuessner's and Sears's functions."""

import math

from scipy.integrate import quad
from scipy.special import jv

from .classical import theodorsen


def sears(k: float) -> complex:
    """Sears's function `S(k) = C(k) [J0(k) - i J1(k)] + i J1(k)`: lift in a sinusoidal gust over the quasi-steady lift.

    The lift is `2 pi w/U S(k)`, with the phase of the gust at mid-chord as reference (Sears, J. Aeronaut. Sci. 8,
    1941).
    """
    return theodorsen(k) * complex(jv(0, k), -jv(1, k)) + 1j * float(jv(1, k))


def kuessner(s: float) -> float:
    """Kuessner's function: fraction of the steady lift `2 pi w/U` at `s = 2 U t/c` after the edge meets a sharp gust.

    The inverse transform of Sears's function about the leading edge, `2/pi int_0^inf Re[S exp(-i k)] sin(k s)/k dk`
    (von Karman & Sears, J. Aeronaut. Sci. 5, 1938).
    """
    if s <= 0.0:
        return 0.0

    def rest(k: float) -> float:
        return (sears(k) * complex(math.cos(k), -math.sin(k))).real / k

    near, _ = quad(lambda k: rest(k) * math.sin(k * s), 0.0, 1.0, limit=400, epsabs=1e-11, epsrel=1e-11)
    far, _ = quad(rest, 1.0, math.inf, weight="sin", wvar=s, limlst=400, limit=400, epsabs=1e-7)
    return 2.0 / math.pi * (near + far)
