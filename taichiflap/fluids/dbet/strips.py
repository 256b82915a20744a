"""Added mass of strips: every element accelerates the fluid of a circle about its chord (the paper's Eqs 25-27).

The load per area is proportional to the acceleration of Eq. 7, `heave + y th'' - w th'^2 + sum_k phi_k q_k''`: a sum of
few shapes along the chord, namely one, y and the mode shapes. The resultants are the product of a mass matrix with the
coefficients of these shapes.
"""

import numpy as np

from ...kernels.runtime import View, ti
from ...march.state import ACCEL, AMPLITUDE, pivot_heave
from ...motion.sampling import PITCH_ACCEL, PITCH_RATE
from .elements import POSITION, STRIP

HEAVE, PITCH, MODES = range(3)
"""Rows and columns of the mass matrix: of the shapes one and y, and from MODES on of the modes."""


def masses(y: np.ndarray, area: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Mass matrix of strips with a unit mass per area, shape (2 + modes, 2 + modes).

    Args:
        y, area: positions and areas of the elements.
        shape: mode shapes there, shape (modes, elements).
    """
    shapes = np.vstack((np.ones_like(y), y, shape))
    found: np.ndarray = (shapes[:, None] * shapes * area).sum(axis=2)
    return found


@ti.func
def rigid_accel(body: View, b, n):
    """Acceleration of a wing that keeps its deflection: coefficients of one, y and -w."""
    theta_rate = body.motion[b, n, PITCH_RATE]
    return ti.Vector([pivot_heave(body, b, n), body.motion[b, n, PITCH_ACCEL], theta_rate * theta_rate])


@ti.func
def pressure(flow: View, b, block, w, w_accel, rigid):
    """Force per area along n of eight strips."""
    accel = rigid[0] + flow.element[b, POSITION, block] * rigid[1] - w * rigid[2] + w_accel
    return -flow.setting[b, STRIP] * accel


@ti.func
def force(body: View, flow: View, b, row, rigid, modes, settled: View):
    """Resultant of the strips on a shape; without the modal acceleration until it is `settled`."""
    total = flow.strip[b, row, HEAVE] * rigid[0] + flow.strip[b, row, PITCH] * rigid[1]
    for k in range(modes):
        share = -rigid[2] * body.q_predicted[b, AMPLITUDE, k]
        if ti.static(settled):
            share += body.q[b, ACCEL, k]
        total += flow.strip[b, row, MODES + k] * share
    return -total
