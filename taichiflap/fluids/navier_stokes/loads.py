"""Forces of the fluid on the wall, and on the modes: sums over the cells around the section.

Pressure enters by its gradient, which is the wall's flux of circulation and the wall's acceleration: summed by parts,
no transform is needed. Everything is linear in the modal rates and accelerations, so that load and response of the
modes are sums of the same kind.
"""

from ...kernels.runtime import Octet, View, ti
from ...march.state import AXIAL, BETA, MOMENT, NORMAL, RATE, UNSTEADY
from ...motion.sampling import PITCH_RATE
from .arrays import (
    ACCELERATION,
    DPHI,
    FLUX,
    FRICTION,
    GRADIENT,
    INTEGRAL,
    LINES,
    LOAD,
    MODAL_LINES,
    MOMENT_LOAD,
    NU,
    OCTETS,
    OF_MEAN,
    RESPONSE,
    RUBBED_Y,
    RUBBED_Z,
    SHAPE,
    SLOPE_Y,
    SLOPE_Z,
    STEP,
    THICKNESS,
    WALL_Y,
    WALL_Z,
)
from .wall import mean_acceleration, total


@ti.func
def load_modes(body: View, flow: View, b, n, rule):
    """Modal force without acceleration, and its response to the modal accelerations."""
    modes = body.modes[b]
    nu, dphi = flow.number[b, NU], flow.number[b, DPHI]
    spin = 2.0 * body.motion[b, n, PITCH_RATE]
    half = 0.5 * flow.row[b, 0, THICKNESS]
    factor = flow.number[b, MOMENT_LOAD] * dphi
    # At rest there is no friction, and the flux follows the acceleration itself.
    shear, through = 1.0, rule[BETA]
    if n == 0:
        shear, through = 0.0, 1.0
    for j in range(modes):
        line = LINES + MODAL_LINES * j
        load = Octet(0.0)
        for m in range(flow.size[b, OCTETS]):
            shape, integral = flow.line[b, line + SHAPE, m], flow.line[b, line + INTEGRAL, m]
            step = flow.line[b, STEP, m]
            g = flow.line[b, FLUX, m] + step
            tau = nu * (flow.vorticity[b, 0, m] + flow.response[b, 0, m] * step - spin) + half * g
            load = load + (g + flow.line[b, ACCELERATION, m]) * integral
            load = load + shear * tau * shape * flow.line[b, SLOPE_Y, m]
        body.load[b, j] = factor * total(load)
        for k in range(modes):
            by_rate, by_accel = Octet(0.0), Octet(0.0)
            other = LINES + MODAL_LINES * k
            turned = 0.0
            if n > 0:
                turned = mean_acceleration(flow, b, k)
            for m in range(flow.size[b, OCTETS]):
                shape, integral = flow.line[b, line + SHAPE, m], flow.line[b, line + INTEGRAL, m]
                slope = flow.line[b, SLOPE_Y, m]
                step = flow.line[b, other + RESPONSE, m]
                tau = (nu * flow.response[b, 0, m] + half) * step
                by_rate = by_rate + step * integral + shear * tau * shape * slope
                by_accel = by_accel + flow.line[b, other + SHAPE, m] * slope * integral
                step = turned * flow.line[b, OF_MEAN, m]
                tau = (nu * flow.response[b, 0, m] + half) * step
                by_accel = by_accel - step * integral - tau * shape * slope
            moved = factor * total(by_rate)
            body.response[b, j, k] = through * moved + factor * total(by_accel)
            if n > 0:
                body.load[b, j] = body.load[b, j] + moved * body.q_free[b, RATE, k]


@ti.func
def sum_forces(body: View, flow: View, b, n):
    """Forces on the wall: pressure by parts from its gradient, and friction."""
    nu = flow.number[b, NU]
    spin = 2.0 * body.motion[b, n, PITCH_RATE]
    half = 0.5 * flow.row[b, 0, THICKNESS]
    if n == 0:
        half = 0.0
    pressed_y, pressed_z, rubbed_y, rubbed_z = Octet(0.0), Octet(0.0), Octet(0.0), Octet(0.0)
    moment = Octet(0.0)
    for m in range(flow.size[b, OCTETS]):
        y, z = flow.line[b, WALL_Y, m], flow.line[b, WALL_Z, m]
        g_y, g_z = flow.line[b, SLOPE_Y, m], flow.line[b, SLOPE_Z, m]
        g = flow.line[b, FLUX, m]
        rise = g + flow.line[b, ACCELERATION, m]
        tau = nu * (flow.vorticity[b, 0, m] - spin) + half * g
        flow.line[b, GRADIENT, m] = rise
        flow.line[b, FRICTION, m] = tau
        pressed_y = pressed_y - rise * z
        pressed_z = pressed_z + rise * y
        rubbed_y = rubbed_y - tau * g_z
        rubbed_z = rubbed_z + tau * g_y
        moment = moment + 0.5 * rise * (y * y + z * z) + tau * (y * g_y + z * g_z)
    dphi = flow.number[b, DPHI]
    force = flow.number[b, LOAD] * dphi
    body.force[b, NORMAL] = force * (total(pressed_z) + total(rubbed_z))
    body.force[b, AXIAL] = force * (total(pressed_y) + total(rubbed_y))
    body.force[b, MOMENT] = flow.number[b, MOMENT_LOAD] * dphi * total(moment)
    body.force[b, UNSTEADY] = 0.0
    flow.number[b, RUBBED_Y] = force * total(rubbed_y)
    flow.number[b, RUBBED_Z] = force * total(rubbed_z)
