"""Added mass of potential flow about the chord, for any normal velocity along it.

A flux v(y) through the chord gives the jump of potential `-2 b sum_m S_m[v]/m sin(m theta)` with the sine coefficients
`S_m[v] = 2/pi int_0^pi v sin(theta) sin(m theta) dtheta` (Lamb, Hydrodynamics, 1932, art. 71; b = c/2), and the rate of
the flux, taken at fixed points of the wing, the load

    dF = -rho pi b^2 sum_m S_m[h^1/2 v'] S_m[h^1/2 ...]/m

of a wing of span h(y): a symmetric form, so that energy is conserved over a cycle of motion. In the wing's rotating
axes it is exact at any amplitude. The paper's strips use the inertial acceleration (Eqs 25-27), which does not conserve
energy when the wing pitches and heaves.
"""

import functools

import numpy as np

from ...case.case import Case
from ...kernels.runtime import Octet, View, ti
from ...march.state import AMPLITUDE, BETA, C0, C1, C2, RATE, modes_of, pivot_advance, pivot_heave, pivot_velocity
from ...march.stream import KIND
from ...motion.sampling import PITCH_ACCEL, PITCH_RATE
from . import elements
from .elements import (
    DEFORMED,
    GUST,
    GUST_BEFORE,
    GUST_BEFORE_THAT,
    LEAN,
    POSITION,
    SCRATCH,
    WING_Y,
    superpose_octet,
    transform,
)

TERMS = 12
"""Number of terms of the series, which gives five digits for four modes of a beam."""


@functools.lru_cache(maxsize=16)
def sines(count: int) -> np.ndarray:
    """`2/pi int_e sin(theta) sin(m theta) dtheta` over each of so many elements, (TERMS, count): exact integrals."""
    angle, order = elements.angles(count), np.arange(1, TERMS + 1)[:, None]
    below = np.sin((order - 1) * angle) / (2 * np.maximum(order - 1, 1))
    below[0] = angle / 2
    return 2.0 / np.pi * np.diff(below - np.sin((order + 1) * angle) / (2 * (order + 1)))


def table(case: Case) -> np.ndarray:
    """The sine coefficients weighted by `sqrt(pi b^2 h/m)`: kinetic energy of the fluid is `rho/2 sum_m (table_m .
    v)^2`.
    """
    order = np.arange(1, TERMS + 1)[:, None]
    return sines(case.dbet.elements) * np.sqrt(np.pi * (case.wing.chord / 2.0) ** 2 / order * elements.spans(case))


@ti.func
def flux_rates(body: View, flow: View, b, n, rule, used: View):
    """Sine coefficients of the rate of the flux `u_z - s u_y` at fixed points of the wing, and for every mode."""
    modes = modes_of(body, b, used.modes)
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    theta_rate = body.motion[b, n, PITCH_RATE]
    theta_accel = body.motion[b, n, PITCH_ACCEL]
    accel_y = pivot_advance(body, b, n) + theta_rate * p_z
    accel_z = pivot_heave(body, b, n) - theta_rate * p_y
    for block in range((flow.elements[b] + 7) // 8):
        rate = accel_z + flow.element[b, POSITION, block] * theta_accel
        if ti.static(used.extended):
            if flow.option[b, DEFORMED] == 1:
                w = superpose_octet(flow.shape, body.q_predicted, b, AMPLITUDE, block, modes)
                lean_rate = superpose_octet(flow.shape_slope, body.q_free, b, RATE, block, modes)
                rate = rate - lean_rate * flow.element[b, WING_Y, block]
                w_rate = superpose_octet(flow.shape, body.q_predicted, b, RATE, block, modes)
                turned = accel_y - w_rate * theta_rate - w * theta_accel
                rate = rate - flow.element[b, LEAN, block] * turned
        if flow.stream[b, KIND] > 0.0:
            rate += rule[C0] * flow.element[b, GUST, block] + rule[C1] * flow.element[b, GUST_BEFORE, block]
            rate += rule[C2] * flow.element[b, GUST_BEFORE_THAT, block]
        flow.element[b, SCRATCH, block] = rate
    transform(flow, flow.sines, b, flow.sine, 0, TERMS)
    for k in range(modes):
        for m in range(TERMS):
            flow.sine[b, k + 1, m] = flow.shape_sine[b, k, m]
        if ti.static(used.extended):
            if flow.option[b, DEFORMED] == 1:
                for block in range((flow.elements[b] + 7) // 8):
                    u_y = flow.element[b, WING_Y, block]
                    rate = flow.shape[b, k, block] - rule[BETA] * u_y * flow.shape_slope[b, k, block]
                    flow.element[b, SCRATCH, block] = rate
                transform(flow, flow.sines, b, flow.sine, k + 1, TERMS)


@ti.func
def force(flow: View, b, block):
    """Force along -n of eight elements for the coefficients in the last column of `sine`."""
    total = Octet(0.0)
    for m in range(TERMS):
        total += flow.sines[b, m, block] * flow.sine[b, 0, m]
    return total * (2.0 * flow.setting[b, elements.HALF_DENSITY])
