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
from ...vortex.sum import TINY
from ..distributions import add_load, settle_amplitudes
from . import added_mass, attached
from .added_mass import TERMS
from .attached import COEFFICIENTS, SEPARATED
from .elements import (
    AREA,
    ATTACHED,
    DEFORMED,
    E_Y,
    FLUX_RATE,
    HALF_DENSITY,
    LEAN,
    LIFTED,
    POSITION,
    POTENTIAL,
    PRESSURE,
    R_Z,
    SCRATCH,
    SHEAR,
    SHEARING,
    SLOPE,
    STRIP,
    SUCTION,
    TRACTION,
    TRUNCATED,
    W_RATE,
    superpose_octet,
    transform,
)
from .separated import axial_force, kept_share


@ti.func
def load_modes(body: View, flow: View, b, rule, used: View):
    """Modal force and its response to the modal acceleration.

    Forces of separated flow are linearised about the predicted rates (with the full speed the slope is never negative,
    so that blades damp). Added mass and attached flow are linear and enter the response exactly.
    """
    modes = modes_of(body, b, used.modes)
    for j in range(modes):
        load = Octet(0.0)
        for block in range((flow.elements[b] + 7) // 8):
            known_rate = superpose_octet(flow.shape, body.q_free, b, RATE, block, modes)
            ahead = known_rate - flow.element[b, W_RATE, block]
            traction = flow.element[b, TRACTION, block] + flow.element[b, SLOPE, block] * ahead
            traction += flow.setting[b, STRIP] * flow.element[b, FLUX_RATE, block]
            if ti.static(used.extended):
                traction += flow.element[b, LEAN, block] * flow.element[b, SHEARING, block]
            load = load - flow.shape[b, j, block] * flow.element[b, AREA, block] * traction
        body.load[b, j] = load.sum()
        for k in range(modes):
            response = Octet(0.0)
            for block in range((flow.elements[b] + 7) // 8):
                inertia = flow.setting[b, STRIP] + rule[BETA] * flow.element[b, SLOPE, block]
                weight = flow.shape[b, j, block] * flow.element[b, AREA, block]
                response = response - weight * inertia * flow.shape[b, k, block]
            body.response[b, j, k] = response.sum()
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
def sum_forces(body: View, flow: View, b, n, used: View):
    """Forces at the step's modal rates and accelerations."""
    modes = modes_of(body, b, used.modes)
    p_y, _ = pivot_velocity(body, flow.stream, b, n)
    lifting = settle_flow(body, flow, b, used)
    total_normal = Octet(0.0)
    total_axial = Octet(0.0)
    total_moment = Octet(0.0)
    total_unsteady = Octet(0.0)
    for block in range((flow.elements[b] + 7) // 8):
        y = flow.element[b, POSITION, block]
        area = flow.element[b, AREA, block]
        w = superpose_octet(flow.shape, body.q_predicted, b, AMPLITUDE, block, modes)
        w_rate = superpose_octet(flow.shape, body.q, b, RATE, block, modes)
        w_accel = superpose_octet(flow.shape, body.q, b, ACCEL, block, modes)
        r_z = flow.element[b, R_Z, block]
        e_y = flow.element[b, E_Y, block]
        drag = axial_force(flow, b, p_y + e_y, r_z + w_rate)
        if flow.option[b, TRUNCATED] == 1:
            drag *= kept_share(p_y, r_z, e_y, w_rate)
        ahead = w_rate - flow.element[b, W_RATE, block]
        unsteady = -flow.setting[b, STRIP] * (flow.element[b, FLUX_RATE, block] + w_accel)
        blades = flow.element[b, TRACTION, block] + flow.element[b, SLOPE, block] * ahead
        if ti.static(used.extended):
            if flow.option[b, POTENTIAL] == 1:
                unsteady = added_mass.force(flow, b, block) / (-1.0 * (area + TINY))
        if ti.static(used.extended):
            if lifting == 1:
                blades += flow.element[b, LIFTED, block] * attached.operate(flow, b, block)
        normal = unsteady - blades
        if ti.static(used.extended):
            if flow.option[b, DEFORMED] + flow.option[b, ATTACHED] > 0:
                lean = flow.element[b, LEAN, block]
                shearing = flow.element[b, SHEARING, block]
                drag = shearing + lean * normal
                normal = normal - lean * shearing
        flow.element[b, PRESSURE, block] = normal
        flow.element[b, SHEAR, block] = -1.0 * drag
        total_normal += area * normal
        total_axial = total_axial - area * drag
        total_moment += area * (y * normal + w * drag)
        total_unsteady += area * unsteady
    body.force[b, NORMAL] = total_normal.sum()
    body.force[b, AXIAL] = total_axial.sum()
    body.force[b, MOMENT] = total_moment.sum()
    body.force[b, UNSTEADY] = total_unsteady.sum()
    if ti.static(used.extended):
        if lifting == 1:  # the clamped leading edge does not rotate: along e_y, through the pivot
            around = flow.cosine[b, 0, 0]
            suction = (1.0 - flow.lag[b, SEPARATED]) * flow.setting[b, SUCTION] * around * around
            body.force[b, AXIAL] = body.force[b, AXIAL] - suction
