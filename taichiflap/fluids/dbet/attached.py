"""Attached flow: unsteady thin-aerofoil theory on the bent section, including the wake's memory.

A velocity v(y) along the normal of the section, `v = v_0 + sum_m v_m cos(m theta)`, has the steady load (Glauert 1926)

    K v = 2/pi [v_0 L - sum_m v_m T_m],    L = (theta + sin theta)',  T_m = (int sin(m theta) sin(theta) dtheta)',

in means over the elements, normalised so that the mean of K 1 is one. The wake acts through the value w of v at three
quarters of the chord (for any camber: the mean of v weighted by the mirrored load of a plate). The deficiency of the
plate's load is `-sum_m X_m`, with

    X_m <- X_m exp(-B_m s) + A_m exp(-B_m s/2) (w - w_before),    s = 2 U dt/c,

which is Wagner's function as a sum of four exponentials. The force per area along -n is `pi rho |u_t| (K v - g sum X)`,
g = K 1; the leading-edge suction is `pi rho (v_0 - sum X)^2` per area (von Karman & Burgers 1935).
"""

import functools

import numpy as np

from ...kernels.runtime import Octet, View, ti
from ...march.state import BETA, RATE, modes_of
from ...vortex.sum import TINY
from . import added_mass, elements
from .added_mass import TERMS
from .elements import SCRATCH, STRETCH, U_N, superpose_change, transform, weigh

LAG_AMPLITUDE = 0.026452, 0.134339, 0.259403, 0.079806
LAG_EXPONENT = 0.008958, 0.062834, 0.219862, 0.719731
"""A_m and B_m, fitted to Wagner's function: the error is below 6e-4, and below 2.1e-3 in Theodorsen's C(k). Half of the
load is immediate: the A_m add up to 1/2.
"""

WASH_BEFORE, SEPARATED, ADVANCE, KEPT, GAINED = 4, 5, 6, 7, 11
"""Columns of `lag` after the four states X_m: w one step earlier, the share of separated flow, s, and from KEPT and
GAINED on the step's factors of the states and of the change of w.
"""
LAGS = 15
"""Number of columns of `lag`."""
COEFFICIENTS = TERMS + 2
"""Rows of `cosine`, the cosine coefficients from v_0 on, and w."""


@functools.lru_cache(maxsize=16)
def cosines(count: int) -> np.ndarray:
    """What makes of v on so many elements the cosine coefficients and w, shape (TERMS + 2, count)."""
    angle, order = elements.angles(count), np.arange(1, TERMS + 1)[:, None]
    table = 2.0 / np.pi * np.diff(np.sin(order * angle)) / order
    mirrored = plate_load(count)[::-1] / count
    return np.vstack((np.diff(angle) / np.pi, table, mirrored))


@functools.lru_cache(maxsize=16)
def loads(count: int) -> np.ndarray:
    """What makes of the cosine coefficients K v on so many elements, shape (TERMS + 1, count)."""
    return np.vstack((plate_load(count), -0.5 * count * added_mass.sines(count)))


def plate_load(count: int) -> np.ndarray:
    """g = K 1 on so many elements: mean one, its centre at a quarter of the chord."""
    angle = elements.angles(count)
    return np.diff(angle + np.sin(angle)) * count / np.pi


@ti.func
def separate(flow: View, b, mean_n, mean_t):
    """Fraction of separated flow from the mean angle of attack, with a smooth transition between the two stall angles.

    Flow from the trailing edge is fully separated.
    """
    speed = ti.sqrt(mean_n * mean_n + mean_t * mean_t + TINY)
    angle = ti.asin(ti.min(ti.abs(mean_n) / speed, 1.0))
    first, last = flow.setting[b, elements.STALL], flow.setting[b, elements.STALLED]
    place = ti.min(ti.max((angle - first) / (last - first), 0.0), 1.0)
    share = place * place * (3.0 - 2.0 * place)
    if mean_t > 0.0:
        share = 1.0
    return share


@ti.func
def lag(flow: View, b):
    """lambda and kappa, which give the next deficiency `-sum X_m = (lambda - 1) w + kappa`."""
    kept, known = 1.0, 0.0
    for m in ti.static(range(4)):
        decay = ti.exp(-0.5 * LAG_EXPONENT[m] * flow.lag[b, ADVANCE])
        whole, half = decay * decay, LAG_AMPLITUDE[m] * decay
        flow.lag[b, KEPT + m], flow.lag[b, GAINED + m] = whole, half
        kept -= half
        known += half * flow.lag[b, WASH_BEFORE] - flow.lag[b, m] * whole
    return kept, known


@ti.func
def remember(flow: View, b, wash):
    """Advance the lag states to the step's w."""
    for m in ti.static(range(4)):
        change = flow.lag[b, GAINED + m] * (wash - flow.lag[b, WASH_BEFORE])
        flow.lag[b, m] = flow.lag[b, m] * flow.lag[b, KEPT + m] + change
    flow.lag[b, WASH_BEFORE] = wash


@ti.func
def lift(body: View, flow: View, b, rule, used: View):
    """Cosine coefficients of v without modal acceleration (column 0) and for a unit acceleration of every mode.

    The zeroth includes the deficiency; it is then the velocity around the leading edge. Of separated flow only the
    last, w, is needed.
    """
    kept, remembered = lag(flow, b)
    modes = modes_of(body, b, used.modes)
    for column in range(modes + 1):
        for block in range((flow.elements[b] + 7) // 8):
            velocity = flow.element[b, U_N, block]
            if column == 0:
                ahead = superpose_change(flow.shape, body.q_free, body.q_predicted, b, RATE, block, modes)
                velocity += flow.element[b, STRETCH, block] * ahead
            else:
                velocity = rule[BETA] * flow.element[b, STRETCH, block] * flow.shape[b, column - 1, block]
            flow.element[b, SCRATCH, block] = velocity
        if flow.lag[b, SEPARATED] < 1.0:
            transform(flow, flow.cosines, b, flow.cosine, column, COEFFICIENTS)
            lagging = (kept - 1.0) * flow.cosine[b, column, COEFFICIENTS - 1]
            if column == 0:
                lagging += remembered
            flow.cosine[b, column, 0] = flow.cosine[b, column, 0] + lagging
        else:
            flow.cosine[b, column, COEFFICIENTS - 1] = weigh(flow, flow.cosines, b, COEFFICIENTS - 1)


@ti.func
def operate(flow: View, b, block):
    """`K v + g D` of eight elements for the coefficients in column 0."""
    total = Octet(0.0)
    for m in range(COEFFICIENTS - 1):
        total += flow.loads[b, m, block] * flow.cosine[b, 0, m]
    return total


@ti.func
def suction(flow: View, b):
    """Force of the leading edge along -e_y."""
    around = flow.cosine[b, 0, 0]
    return (1.0 - flow.lag[b, SEPARATED]) * flow.setting[b, elements.SUCTION] * around * around
