"""Modal forces of the elements, and their sums: normal and axial force, and moment."""

from ...kernels.runtime import Octet, View, ti
from ...march.state import (
    ACCEL,
    AMPLITUDE,
    AXIAL,
    BETA,
    MOMENT,
    NORMAL,
    RATE,
    UNSTEADY,
    modes_of,
    pivot_velocity,
)
from ...motion.sampling import PITCH_RATE
from ..distributions import add_load, settle_amplitudes
from . import added_mass, attached, strips
from .added_mass import TERMS
from .attached import COEFFICIENTS, SEPARATED
from .elements import (
    AREA,
    ATTACHED,
    DEFORMED,
    HALF_DENSITY,
    LEAN,
    LIFTED,
    PER_AREA,
    POSITION,
    POTENTIAL,
    PRESSURE,
    SCRATCH,
    SHEAR,
    SHEARING,
    SLOPE,
    TRACTION,
    TRUNCATED,
    add_up,
    superpose_change,
    superpose_octet,
    transform,
)
from .separated import axial_force, kept_share, rigid_velocity


@ti.func
def load_modes(body: View, flow: View, b, n, rule, used: View):
    """Modal force and its response to the modal acceleration.

    Forces of separated flow are linearised about the predicted rates (with the full speed the slope is never negative,
    so that blades damp). Added mass and attached flow are linear and enter the response exactly.
    """
    modes = modes_of(body, b, used.modes)
    rigid = strips.rigid_accel(body, b, n)
    for j in range(modes):
        for k in range(j + 1):
            load = Octet(0.0)
            response = Octet(0.0)
            for block in range((flow.elements[b] + 7) // 8):
                ahead = superpose_change(flow.shape, body.q_free, body.q_predicted, b, RATE, block, modes)
                slope = flow.element[b, SLOPE, block]
                traction = flow.element[b, TRACTION, block] + slope * ahead
                if ti.static(used.extended):
                    traction += flow.element[b, LEAN, block] * flow.element[b, SHEARING, block]
                weight = flow.shape[b, j, block] * flow.element[b, AREA, block]
                load += weight * traction
                response += weight * slope * flow.shape[b, k, block]
            row = strips.MODES + j
            strip = strips.force(body, flow, b, row, rigid, modes, False)
            body.load[b, j] = strip - add_up(load)
            body.response[b, j, k] = -flow.strip[b, row, strips.MODES + k] - rule[BETA] * add_up(response)
            body.response[b, k, j] = body.response[b, j, k]
    for j in range(modes):
        if ti.static(used.extended):
            if flow.option[b, POTENTIAL] == 1:
                for m in range(TERMS):
                    work = -2.0 * flow.setting[b, HALF_DENSITY] * flow.shape_sine[b, j, m]
                    add_load(body, flow.sine, b, j, m, work, modes)
        if ti.static(used.extended):
            if flow.option[b, ATTACHED] == 1 and flow.lag[b, SEPARATED] < 1.0:
                for block in range((flow.elements[b] + 7) // 8):
                    weight = flow.shape[b, j, block] * flow.element[b, AREA, block]
                    flow.element[b, SCRATCH, block] = weight * flow.element[b, LIFTED, block]
                transform(flow, flow.loads, b, flow.work, 0, COEFFICIENTS - 1)
                for m in range(COEFFICIENTS - 1):
                    add_load(body, flow.cosine, b, j, m, 0.0 - flow.work[b, 0, m], modes)


@ti.func
def settle_flow(body: View, flow: View, b, used: View):
    """Update the coefficients and the lag states to the step's acceleration.

    Returns whether any flow is attached.
    """
    lifting = 0
    modes = modes_of(body, b, used.modes)
    if ti.static(used.extended):
        if flow.option[b, POTENTIAL] == 1:
            settle_amplitudes(body, flow.sine, b, 0, TERMS, modes)
    if ti.static(used.extended):
        if flow.option[b, ATTACHED] == 1:
            lifting = int(flow.lag[b, SEPARATED] < 1.0)
            first = 0 if lifting == 1 else COEFFICIENTS - 1
            settle_amplitudes(body, flow.cosine, b, first, COEFFICIENTS, modes)
            attached.remember(flow, b, flow.cosine[b, 0, COEFFICIENTS - 1])
    return lifting


@ti.func
def leans(flow: View, b, used: View):
    """Whether the force along the section's tangent is that of the predicted rates."""
    leaning = False
    if ti.static(used.extended):
        leaning = flow.option[b, DEFORMED] + flow.option[b, ATTACHED] > 0
    return leaning


@ti.func
def chord_drag(flow: View, b, block, w, w_rate, p_y, p_z, theta_rate, used: View):
    """Force per area along -e_y of eight elements in separated flow, in the chord frame."""
    r_z, e_y = rigid_velocity(flow, b, block, w, p_z, theta_rate, used)
    drag = axial_force(flow, b, p_y + e_y, r_z + w_rate)
    if ti.static(used.truncated):
        if flow.option[b, TRUNCATED] == 1:
            drag *= kept_share(p_y, r_z, e_y, w_rate)
    return drag


@ti.func
def sum_forces(body: View, flow: View, b, n, used: View, stored: View):
    """Forces at the step's modal rates and accelerations."""
    modes = modes_of(body, b, used.modes)
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    theta_rate = body.motion[b, n, PITCH_RATE]
    rigid = strips.rigid_accel(body, b, n)
    lifting = settle_flow(body, flow, b, used)
    total_normal = Octet(0.0)
    total_axial = Octet(0.0)
    total_moment = Octet(0.0)
    total_unsteady = Octet(0.0)
    for block in range((flow.elements[b] + 7) // 8):
        area = flow.element[b, AREA, block]
        w = superpose_octet(flow.shape, body.q_predicted, b, AMPLITUDE, block, modes)
        ahead = superpose_change(flow.shape, body.q, body.q_predicted, b, RATE, block, modes)
        normal = -1.0 * (flow.element[b, TRACTION, block] + flow.element[b, SLOPE, block] * ahead)
        strip = Octet(0.0)
        if ti.static(used.extended or stored):
            w_accel = superpose_octet(flow.shape, body.q, b, ACCEL, block, modes)
            strip = strips.pressure(flow, b, block, w, w_accel, rigid)
        if ti.static(used.extended):
            if flow.option[b, POTENTIAL] == 1:
                unsteady = -1.0 * added_mass.force(flow, b, block)
                total_unsteady += unsteady
                normal += unsteady * flow.element[b, PER_AREA, block]
            if lifting == 1:
                normal = normal - flow.element[b, LIFTED, block] * attached.operate(flow, b, block)
        drag = Octet(0.0)
        if leans(flow, b, used):
            lean = flow.element[b, LEAN, block]
            drag = flow.element[b, SHEARING, block] + lean * (normal + strip)
            normal = normal - lean * flow.element[b, SHEARING, block]
        else:
            w_rate = superpose_octet(flow.shape, body.q, b, RATE, block, modes)
            drag = chord_drag(flow, b, block, w, w_rate, p_y, p_z, theta_rate, used)
        if ti.static(stored):
            flow.element[b, PRESSURE, block] = normal + strip
            flow.element[b, SHEAR, block] = -1.0 * drag
        total_normal += area * normal
        total_axial += area * drag
        total_moment += flow.element[b, POSITION, block] * (area * normal) + w * (area * drag)
    heaved = strips.force(body, flow, b, strips.HEAVE, rigid, modes, True)
    pitched = strips.force(body, flow, b, strips.PITCH, rigid, modes, True)
    body.force[b, NORMAL] = heaved + add_up(total_normal)
    body.force[b, AXIAL] = -add_up(total_axial)
    body.force[b, MOMENT] = pitched + add_up(total_moment)
    body.force[b, UNSTEADY] = heaved + add_up(total_unsteady)
    if ti.static(used.extended):
        if lifting == 1:  # the clamped leading edge does not rotate: along e_y, through the pivot
            body.force[b, AXIAL] = body.force[b, AXIAL] - attached.suction(flow, b)
