"""Deformable blade element theory: quasi-steady lift, drag and added mass of every chordwise element.

Reade & Jankauski (2020), Eqs 17-27, with the corrections that the equations below name. An element moves at
`(u_y, u_z)` relative to the free stream, so that `sin A = u_z/U` and `cos A = u_y/U` in all four quadrants
(the paper's arctangent of Eq. 18 loses two), and the force coefficients of Eqs 19-20 become polynomials:

    C_L U^2 = 2 C_Lmax u_y u_z,        C_D U^2 = C_D0 u_y^2 + C_Dmax u_z^2.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..beam import Modes
from ..body import (
    ACCEL,
    AMPLITUDE,
    AXIAL,
    BETA,
    MOMENT,
    NORMAL,
    RATE,
    UNSTEADY,
    array,
    most_modes,
    pivot_velocity,
    superpose,
    zeros,
)
from ..case import Case
from ..motion import PITCH, PITCH_ACCEL, PITCH_RATE, PLUNGE_ACCEL
from ..runtime import Floats1, Floats2, Floats3, Ints1, Singles3, View, ti

Flow = ti.types.argpack(
    elements=Ints1,
    truncated=Ints1,
    half_density_area=Floats1,  # rho/2 times the area of an element
    added_mass=Floats1,  # pi rho c/4 times the area of an element; 0 where it is left out
    area=Floats1,
    stream=Floats2,
    lift_max=Floats1,
    drag_min=Floats1,
    drag_max=Floats1,
    y=Floats2,  # chordwise positions of the midpoints
    shape=Floats3,  # mode shapes there
    r_z=Floats2,  # rigid part of u_z
    e_y=Floats2,  # elastic part of u_y
    w_rate=Floats2,  # expected elastic part of u_z
    normal=Floats2,  # force along -e_z with it ...
    slope=Floats2,  # ... and the derivative of that force with respect to u_z
    accel=Floats2,  # acceleration along e_z (Eq. 7) without the modal part
    pressure=Floats2,
    shear=Floats2,
)

Film = ti.types.argpack(pressure_jump=Singles3, shear=Singles3)


GROUPS = {"flow": Flow, "film": Film}


def allocate(cases: Sequence[Case], sections: Sequence[Modes]) -> dict[str, Any]:
    """Arrays of the elements of a batch."""
    count = len(cases)
    most = max(case.dbet.elements for case in cases)
    y = np.zeros((count, most))
    shape = np.zeros((count, most_modes(sections), most))
    for b, (case, section) in enumerate(zip(cases, sections, strict=True)):
        n = case.dbet.elements
        y[b, :n] = case.wing.chord * (np.arange(n) + 0.5) / n
        shape[b, : section.count, :n] = section.shape(y[b, :n])
    area = np.array([case.wing.chord * case.wing.span / case.dbet.elements for case in cases])
    density = np.array([case.fluid.density for case in cases])
    chord = np.array([case.wing.chord if case.dbet.added_mass else 0.0 for case in cases])
    flow = Flow(
        elements=array([case.dbet.elements for case in cases]),
        truncated=array([case.dbet.speed == "truncated" for case in cases]),
        half_density_area=array(0.5 * density * area),
        added_mass=array(math.pi * density * chord / 4.0 * area),
        area=array(area),
        stream=array([case.fluid.velocity for case in cases], float),
        lift_max=array([case.dbet.lift_max for case in cases], float),
        drag_min=array([case.dbet.drag_min for case in cases], float),
        drag_max=array([case.dbet.drag_max for case in cases], float),
        y=array(y),
        shape=array(shape),
        r_z=zeros(ti.f64, count, most),
        e_y=zeros(ti.f64, count, most),
        w_rate=zeros(ti.f64, count, most),
        normal=zeros(ti.f64, count, most),
        slope=zeros(ti.f64, count, most),
        accel=zeros(ti.f64, count, most),
        pressure=zeros(ti.f64, count, most),
        shear=zeros(ti.f64, count, most),
    )
    return {"flow": flow}


def film(cases: Sequence[Case], frames: int) -> Any:
    """Room for `frames` frames of the fields along the chord."""
    shape = (len(cases), frames, max(case.dbet.elements for case in cases))
    return Film(**{name: ti.ndarray(ti.f32, shape) for name in Film.members})


def trim(frames: dict[str, np.ndarray], case: Case) -> dict[str, np.ndarray]:
    """One case's share of the padded frames of a batch."""
    return frames | {name: frames[name][:, : case.dbet.elements] for name in Film.members}


def nodes(case: Case) -> np.ndarray:
    """Chordwise positions of the ends of the elements, m."""
    return case.wing.chord * np.arange(case.dbet.elements + 1) / case.dbet.elements


def work(case: Case) -> float:
    """Cost of a step, in pair interactions (about a nanosecond)."""
    return 50.0 * case.dbet.elements


def frame_bytes(case: Case) -> float:
    """Size of a frame's fields."""
    return 8.0 * case.dbet.elements


@ti.func
def blade_force(flow: View, b, r_y, r_z, e_y, e_z):
    """Force of an element along -e_z and -e_y and the derivative of the first with respect to `u_z`.

    Eqs 17-24 for the velocity `u = r + e`, rigid part plus elastic part. Corrected: the coefficients stay inside
    the integral (Eqs 21-22), and the axial force is `dD cos A - dL sin A` (Eq. 23 prints cos A twice). The full
    speed `|r + e|^2` is the default; the paper's drops the square of the elastic part.
    """
    normal = 0.0
    axial = 0.0
    slope = 0.0
    u_y = r_y + e_y
    u_z = r_z + e_z
    speed2 = u_y * u_y + u_z * u_z
    if speed2 > 0.0:
        speed = ti.sqrt(speed2)
        lift2 = 2.0 * flow.lift_max[b]
        across = (flow.drag_min[b] + lift2) * u_y * u_y + flow.drag_max[b] * u_z * u_z
        along = flow.drag_min[b] * u_y * u_y + (flow.drag_max[b] - lift2) * u_z * u_z
        scale = flow.half_density_area[b] / speed
        normal = scale * u_z * across
        axial = scale * u_y * along
        slope = scale * (across * u_y * u_y / speed2 + 2.0 * flow.drag_max[b] * u_z * u_z)
        if flow.truncated[b] == 1:
            kept = (r_y * r_y + r_z * r_z + 2.0 * (r_y * e_y + r_z * e_z)) / speed2
            slope = kept * slope + normal * 2.0 * (r_z - kept * u_z) / speed2
            normal *= kept
            axial *= kept
    return normal, axial, slope


@ti.func
def load_modes(body: View, flow: View, b, n, rule):
    """Modal force and its response to the modal acceleration.

    The blade forces are linearised about the expected rates (their slope is never negative: blades damp);
    the added mass (Eqs 25-27) is linear and goes whole into the response.
    """
    modes = body.modes[b]
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    heave = body.motion[b, n, PLUNGE_ACCEL] * ti.cos(body.motion[b, n, PITCH])
    theta_rate = body.motion[b, n, PITCH_RATE]
    theta_accel = body.motion[b, n, PITCH_ACCEL]
    for e in range(flow.elements[b]):
        w = superpose(flow.shape, body.q_guess, b, AMPLITUDE, e, modes)
        w_rate = superpose(flow.shape, body.q_guess, b, RATE, e, modes)
        known_rate = superpose(flow.shape, body.q_known, b, RATE, e, modes)
        flow.w_rate[b, e] = w_rate
        flow.r_z[b, e] = p_z + flow.y[b, e] * theta_rate
        flow.e_y[b, e] = -w * theta_rate
        normal, _, slope = blade_force(flow, b, p_y, flow.r_z[b, e], flow.e_y[b, e], w_rate)
        flow.normal[b, e] = normal
        flow.slope[b, e] = slope
        flow.accel[b, e] = heave + flow.y[b, e] * theta_accel - w * theta_rate * theta_rate
        force = -normal - slope * (known_rate - w_rate) - flow.added_mass[b] * flow.accel[b, e]
        inertia = flow.added_mass[b] + rule[BETA] * slope
        for j in range(modes):
            phi = flow.shape[b, j, e]
            body.load[b, j] = body.load[b, j] + phi * force
            for k in range(modes):
                body.response[b, j, k] = body.response[b, j, k] - phi * inertia * flow.shape[b, k, e]


@ti.func
def sum_forces(body: View, flow: View, b, n):
    """Forces with the modal rates and accelerations that the step has come to."""
    modes = body.modes[b]
    p_y, _ = pivot_velocity(body, flow.stream, b, n)
    total_normal = 0.0
    total_axial = 0.0
    total_moment = 0.0
    total_unsteady = 0.0
    for e in range(flow.elements[b]):
        w = superpose(flow.shape, body.q_guess, b, AMPLITUDE, e, modes)
        w_rate = superpose(flow.shape, body.q, b, RATE, e, modes)
        w_accel = superpose(flow.shape, body.q, b, ACCEL, e, modes)
        _, axial, _ = blade_force(flow, b, p_y, flow.r_z[b, e], flow.e_y[b, e], w_rate)
        unsteady = -flow.added_mass[b] * (flow.accel[b, e] + w_accel)
        normal = unsteady - flow.normal[b, e] - flow.slope[b, e] * (w_rate - flow.w_rate[b, e])
        flow.pressure[b, e] = normal / flow.area[b]
        flow.shear[b, e] = -axial / flow.area[b]
        total_normal += normal
        total_axial -= axial
        total_moment += flow.y[b, e] * normal + w * axial
        total_unsteady += unsteady
    body.force[b, NORMAL] = total_normal
    body.force[b, AXIAL] = total_axial
    body.force[b, MOMENT] = total_moment
    body.force[b, UNSTEADY] = total_unsteady


@ti.func
def prepare(batch: View, b, n, rule):
    """Modal force of the coming step `n`."""
    load_modes(batch.body, batch.flow, b, n, rule)


@ti.func
def settle(batch: View, b, n, rule):
    """Forces of step `n` once its modal acceleration is known."""
    sum_forces(batch.body, batch.flow, b, n)


@ti.func
def record(batch: View, b, frame):
    for e in range(batch.flow.elements[b]):
        batch.film.pressure_jump[b, frame, e] = ti.cast(batch.flow.pressure[b, e], ti.f32)
        batch.film.shear[b, frame, e] = ti.cast(batch.flow.shear[b, e], ti.f32)
