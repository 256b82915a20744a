"""Deformable blade element theory: quasi-steady lift, drag and added mass of every chordwise element.

Reade & Jankauski (2020), Eqs 17-27, with the corrections that the equations below name. An element moves at
`(u_y, u_z)` relative to the free stream, so that `sin A = u_z/U` and `cos A = u_y/U` in all four quadrants
(the paper's arctangent of Eq. 18 loses two), and the force coefficients of Eqs 19-20 become polynomials:

    C_L U^2 = 2 C_Lmax u_y u_z,        C_D U^2 = C_D0 u_y^2 + C_Dmax u_z^2.
"""

import math
from collections.abc import Sequence

import numpy as np

from ...case.case import Case
from ...kernels import linear
from ...kernels.arrays import array, octet_array
from ...kernels.runtime import Floats1, Floats2, Ints1, Octet, Octets3, View, ti
from ...march.state import (
    ACCEL,
    AMPLITUDE,
    AXIAL,
    BETA,
    MOMENT,
    NORMAL,
    RATE,
    UNSTEADY,
    most_modes,
    pivot_heave,
    pivot_velocity,
)
from ...motion.sampling import PITCH_ACCEL, PITCH_RATE
from ...structure.beam import Modes
from ...structure.chordwise import Profile
from ...vortex.sum import TINY
from ..interface import Flow

POSITION, AREA, R_Z, E_Y, W_RATE, NORMAL_TRACTION, SLOPE, ACCELERATION, PRESSURE, SHEAR = range(10)
"""Rows of the elements: distance behind the pivot and area (none where a batch pads); rigid part of u_z and elastic
part of u_y; expected elastic part of u_z, with it the force per area along -e_z and its derivative by u_z; the
acceleration along e_z (Eq. 7) without the modal part; and the force per area along e_z and e_y."""

Blades = ti.types.argpack(
    elements=Ints1,
    truncated=Ints1,
    half_density=Floats1,
    added_mass=Floats1,  # pi rho c/4, per area; 0 where it is left out
    stream=Floats2,
    lift_max=Floats1,
    drag_min=Floats1,
    drag_max=Floats1,
    element=Octets3,  # (case, row, eight elements)
    shape=Octets3,  # (case, mode, eight elements): mode shapes at the midpoints
)


def flow(cases: Sequence[Case], sections: Sequence[Modes]) -> Flow:
    """The elements of a batch, at rest."""
    count = len(cases)
    most = 8 * linear.octets(max(case.dbet.elements for case in cases))
    element = np.zeros((count, 10, most))
    shape = np.zeros((count, most_modes(sections), most))
    for b, (case, section) in enumerate(zip(cases, sections, strict=True)):
        n = case.dbet.elements
        y = middles(case)
        element[b, POSITION, :n] = y
        element[b, AREA, :n] = areas(case)
        shape[b, : section.count, :n] = section.shape(y)
    density = np.array([case.fluid.density for case in cases])
    chord = np.array([case.wing.chord if case.dbet.added_mass else 0.0 for case in cases])
    blades = Blades(
        elements=array([case.dbet.elements for case in cases]),
        truncated=array([case.dbet.speed == "truncated" for case in cases]),
        half_density=array(0.5 * density),
        added_mass=array(math.pi * density * chord / 4.0),
        stream=array([case.fluid.velocity for case in cases], float),
        lift_max=array([case.dbet.lift_max for case in cases], float),
        drag_min=array([case.dbet.drag_min for case in cases], float),
        drag_max=array([case.dbet.drag_max for case in cases], float),
        element=octet_array(element),
        shape=octet_array(shape),
    )
    return Flow({"flow": blades}, {"flow": Blades}, prepare, settle, record)


def middles(case: Case) -> np.ndarray:
    """Positions of the middles of the elements along the chord, from the pivot, m."""
    count = case.dbet.elements
    return case.wing.chord * (np.arange(count) + 0.5) / count - case.wing.pivot * case.wing.chord


def areas(case: Case) -> np.ndarray:
    """Areas of the elements, m^2."""
    count = case.dbet.elements
    return case.wing.chord * Profile.of(case.wing.span).means(np.arange(count + 1) / count) / count


@ti.func
def superpose_octet(shape: View, state: View, b, row, block, count):
    """`sum_k phi_k q_k` of a row of a modal state at eight elements."""
    total = Octet(0.0)
    for k in range(count):
        total += shape[b, k, block] * state[b, row, k]
    return total


@ti.func
def normal_force(flow: View, b, u_y, u_z):
    """Force per area along -e_z of eight elements (Eqs 17-24; the coefficients stay inside the integral)."""
    across = (flow.drag_min[b] + 2.0 * flow.lift_max[b]) * u_y * u_y + flow.drag_max[b] * u_z * u_z
    return flow.half_density[b] * u_z * across / ti.sqrt(u_y * u_y + u_z * u_z + TINY)


@ti.func
def normal_slope(flow: View, b, u_y, u_z):
    """Derivative of the normal force per area by `u_z`."""
    speed2 = u_y * u_y + u_z * u_z + TINY
    across = (flow.drag_min[b] + 2.0 * flow.lift_max[b]) * u_y * u_y + flow.drag_max[b] * u_z * u_z
    change = across * u_y * u_y / speed2 + 2.0 * flow.drag_max[b] * u_z * u_z
    return flow.half_density[b] * change / ti.sqrt(speed2)


@ti.func
def axial_force(flow: View, b, u_y, u_z):
    """Force per area along -e_y: `dD cos A - dL sin A` (Eq. 23 prints cos A twice)."""
    along = flow.drag_min[b] * u_y * u_y + (flow.drag_max[b] - 2.0 * flow.lift_max[b]) * u_z * u_z
    return flow.half_density[b] * u_y * along / ti.sqrt(u_y * u_y + u_z * u_z + TINY)


@ti.func
def kept_share(r_y, r_z, e_y, e_z):
    """Share of the squared speed `|r + e|^2` that the paper's Eqs 21-22 keep: all but the elastic `|e|^2`."""
    u_y = r_y + e_y
    u_z = r_z + e_z
    return (r_y * r_y + r_z * r_z + 2.0 * (r_y * e_y + r_z * e_z)) / (u_y * u_y + u_z * u_z + TINY)


@ti.func
def linearise(body: View, flow: View, b, n):
    """Blade forces about the expected rates, and the acceleration that the added mass feels (Eqs 6-7, 17-27)."""
    modes = body.modes[b]
    heave = pivot_heave(body, b, n)
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    theta_rate = body.motion[b, n, PITCH_RATE]
    theta_accel = body.motion[b, n, PITCH_ACCEL]
    for block in range((flow.elements[b] + 7) // 8):
        y = flow.element[b, POSITION, block]
        w = superpose_octet(flow.shape, body.q_guess, b, AMPLITUDE, block, modes)
        w_rate = superpose_octet(flow.shape, body.q_guess, b, RATE, block, modes)
        r_z = p_z + y * theta_rate
        e_y = w * -theta_rate
        u_y = p_y + e_y
        u_z = r_z + w_rate
        traction = normal_force(flow, b, u_y, u_z)
        slope = normal_slope(flow, b, u_y, u_z)
        if flow.truncated[b] == 1:
            kept = kept_share(p_y, r_z, e_y, w_rate)
            slope = kept * slope + traction * 2.0 * (r_z - kept * u_z) / (u_y * u_y + u_z * u_z + TINY)
            traction = kept * traction
        flow.element[b, R_Z, block] = r_z
        flow.element[b, E_Y, block] = e_y
        flow.element[b, W_RATE, block] = w_rate
        flow.element[b, NORMAL_TRACTION, block] = traction
        flow.element[b, SLOPE, block] = slope
        flow.element[b, ACCELERATION, block] = heave + y * theta_accel - w * (theta_rate * theta_rate)


@ti.func
def load_modes(body: View, flow: View, b, rule):
    """Modal force and its response to the modal acceleration.

    The blade forces enter with their slope (never negative with the full speed: blades damp); the added mass is
    linear and goes whole into the response.
    """
    modes = body.modes[b]
    for j in range(modes):
        load = Octet(0.0)
        for block in range((flow.elements[b] + 7) // 8):
            known_rate = superpose_octet(flow.shape, body.q_known, b, RATE, block, modes)
            ahead = known_rate - flow.element[b, W_RATE, block]
            traction = flow.element[b, NORMAL_TRACTION, block] + flow.element[b, SLOPE, block] * ahead
            traction += flow.added_mass[b] * flow.element[b, ACCELERATION, block]
            load = load - flow.shape[b, j, block] * flow.element[b, AREA, block] * traction
        body.load[b, j] = load.sum()
        for k in range(modes):
            response = Octet(0.0)
            for block in range((flow.elements[b] + 7) // 8):
                inertia = flow.added_mass[b] + rule[BETA] * flow.element[b, SLOPE, block]
                weight = flow.shape[b, j, block] * flow.element[b, AREA, block]
                response = response - weight * inertia * flow.shape[b, k, block]
            body.response[b, j, k] = response.sum()


@ti.func
def sum_forces(body: View, flow: View, b, n):
    """Forces with the modal rates and accelerations that the step has come to."""
    modes = body.modes[b]
    p_y, _ = pivot_velocity(body, flow.stream, b, n)
    total_normal = Octet(0.0)
    total_axial = Octet(0.0)
    total_moment = Octet(0.0)
    total_unsteady = Octet(0.0)
    for block in range((flow.elements[b] + 7) // 8):
        y = flow.element[b, POSITION, block]
        area = flow.element[b, AREA, block]
        w = superpose_octet(flow.shape, body.q_guess, b, AMPLITUDE, block, modes)
        w_rate = superpose_octet(flow.shape, body.q, b, RATE, block, modes)
        w_accel = superpose_octet(flow.shape, body.q, b, ACCEL, block, modes)
        r_z = flow.element[b, R_Z, block]
        e_y = flow.element[b, E_Y, block]
        drag = axial_force(flow, b, p_y + e_y, r_z + w_rate)
        if flow.truncated[b] == 1:
            drag *= kept_share(p_y, r_z, e_y, w_rate)
        ahead = w_rate - flow.element[b, W_RATE, block]
        unsteady = -flow.added_mass[b] * (flow.element[b, ACCELERATION, block] + w_accel)
        blades = flow.element[b, NORMAL_TRACTION, block] + flow.element[b, SLOPE, block] * ahead
        normal = unsteady - blades
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


@ti.func
def prepare(batch: View, b, n, rule):
    """Modal force of the coming step `n`."""
    linearise(batch.body, batch.flow, b, n)
    load_modes(batch.body, batch.flow, b, rule)


@ti.func
def settle(batch: View, b, n, rule):
    """Forces of step `n` once its modal acceleration is known."""
    sum_forces(batch.body, batch.flow, b, n)


@ti.func
def record(batch: View, b, frame):
    elements = batch.flow.elements[b]
    for block in range((elements + 7) // 8):
        pressure = batch.flow.element[b, PRESSURE, block]
        shear = batch.flow.element[b, SHEAR, block]
        for lane in ti.static(range(8)):
            if 8 * block + lane < elements:
                batch.film.pressure_jump[b, frame, 8 * block + lane] = ti.cast(pressure[lane], ti.f32)
                batch.film.shear[b, frame, 8 * block + lane] = ti.cast(shear[lane], ti.f32)
