"""The vortex lattice on the deformed camber line: its panels, and the circulation that lets no fluid through.

Reade & Jankauski (2020), Eqs 28-31. On the wing all is in wing axes (e_y, e_z); the bound vortices and the control
points, which meet the wake, are also kept in Y, Z. With the wing and the wake in place the circulation is linear
in the wing's velocity, hence in the modal acceleration: one elimination gives it for no acceleration (column 0)
and for a unit rate of every mode (columns 1 to K).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import linear, wake
from .beam import Modes
from .body import AMPLITUDE, RATE, array, most_modes, pivot_velocity, superpose, zeros
from .case import Case
from .motion import PITCH, PITCH_RATE, PLUNGE
from .runtime import Floats1, Floats2, Floats3, Ints1, Octet, Octets3, View, ti
from .vortex import INV_2PI, Y, Z, induce, octet, store_octet
from .wake import COUNT, YOUNGEST

TO_VORTEX, TO_POINT = 0.25, 0.75
"""Bound vortex and control point along a panel (Table 4)."""

Lattice = ti.types.argpack(
    panels=Ints1,
    density=Floats1,
    span=Floats1,
    stream=Floats2,
    shape=Floats3,  # mode shapes at the nodes
    node=Floats3,  # nodes in wing axes, and the rate of their deflection without acceleration
    tangent=Floats3,  # panel's unit tangent t in wing axes; its normal is (-t_z, t_y)
    length=Floats2,
    vortex=Floats3,  # bound vortices and control points in wing axes ...
    point=Floats3,
    bound=Floats3,  # ... and in Y, Z, the vortices with their circulation
    control=Floats3,
    wash=Floats3,  # velocity of the wake at the control points, in wing axes
    new=Floats3,  # and of a new vortex of unit circulation
    slip=Floats2,  # tangential velocity of the fluid past the panel, as expected
    sums=Floats3,  # circulation ahead of and on each panel, one step earlier and two
    total=Floats1,  # bound circulation, one step earlier
    pressure=Floats2,
    matrix=Octets3,
    solution=Floats3,  # (case, 1 + modes, panel): circulation without acceleration, and for a unit rate of each mode
    factor=Floats2,
)


def allocate(cases: Sequence[Case], sections: Sequence[Modes]) -> Any:
    """Arrays of the lattices of a batch."""
    count = len(cases)
    most = -(-max(case.uvlm.panels for case in cases) // 8) * 8
    modes = most_modes(sections)
    node = np.zeros((count, 3, most + 1))
    shape = np.zeros((count, modes, most + 1))
    for b, (case, section) in enumerate(zip(cases, sections, strict=True)):
        y = nodes(case)
        node[b, Y, : len(y)] = y
        shape[b, : section.count, : len(y)] = section.shape(y)
    return Lattice(
        panels=array([case.uvlm.panels for case in cases]),
        density=array([case.fluid.density for case in cases], float),
        span=array([case.wing.span for case in cases], float),
        stream=array([case.fluid.velocity for case in cases], float),
        shape=array(shape),
        node=array(node),
        tangent=zeros(ti.f64, count, 2, most),
        length=zeros(ti.f64, count, most),
        vortex=zeros(ti.f64, count, 2, most),
        point=zeros(ti.f64, count, 2, most),
        bound=zeros(ti.f64, count, 3, most),
        control=zeros(ti.f64, count, 2, most),
        wash=zeros(ti.f64, count, 2, most),
        new=zeros(ti.f64, count, 2, most),
        slip=zeros(ti.f64, count, most),
        sums=zeros(ti.f64, count, 2, most),
        total=zeros(ti.f64, count),
        pressure=zeros(ti.f64, count, most),
        matrix=zeros(Octet, count, most, most // 8),
        solution=zeros(ti.f64, count, modes + 1, most),
        factor=zeros(ti.f64, count, most),
    )


def nodes(case: Case) -> np.ndarray:
    """Chordwise positions of the ends of the panels, m."""
    return case.wing.chord * np.arange(case.uvlm.panels + 1) / case.uvlm.panels


@ti.func
def between(left, right, share):
    return left + share * (right - left)


@ti.func
def lay_panels(body: View, flow: View, b, n):
    """Panels, bound vortices and control points of the wing as it is expected to deform."""
    cosine = ti.cos(body.motion[b, n, PITCH])
    sine = ti.sin(body.motion[b, n, PITCH])
    pivot = body.motion[b, n, PLUNGE]
    for i in range(flow.panels[b] + 1):
        flow.node[b, Z, i] = superpose(flow.shape, body.q_guess, b, AMPLITUDE, i, body.modes[b])
        flow.node[b, 2, i] = superpose(flow.shape, body.q_known, b, RATE, i, body.modes[b])
    for i in range(flow.panels[b]):
        dy = flow.node[b, Y, i + 1] - flow.node[b, Y, i]
        dz = flow.node[b, Z, i + 1] - flow.node[b, Z, i]
        length = ti.sqrt(dy * dy + dz * dz)
        flow.length[b, i] = length
        flow.tangent[b, Y, i] = dy / length
        flow.tangent[b, Z, i] = dz / length
        for axis in range(2):
            left = flow.node[b, axis, i]
            right = flow.node[b, axis, i + 1]
            flow.vortex[b, axis, i] = between(left, right, TO_VORTEX)
            flow.point[b, axis, i] = between(left, right, TO_POINT)
        flow.bound[b, Y, i] = cosine * flow.vortex[b, Y, i] - sine * flow.vortex[b, Z, i]
        flow.bound[b, Z, i] = pivot + sine * flow.vortex[b, Y, i] + cosine * flow.vortex[b, Z, i]
        flow.control[b, Y, i] = cosine * flow.point[b, Y, i] - sine * flow.point[b, Z, i]
        flow.control[b, Z, i] = pivot + sine * flow.point[b, Y, i] + cosine * flow.point[b, Z, i]


@ti.func
def shed_vortex(body: View, flow: View, wakes: View, b, n):
    """Place this step's wake vortex behind the trailing edge and note what a unit of it does to the panels.

    Fixed rule: a distance along the last panel. Local rule: a share of the trailing edge's path relative to the
    flow that carried the youngest vortex; never ahead of the edge, never closer than the least travel.
    """
    edge = flow.panels[b]
    cosine = ti.cos(body.motion[b, n, PITCH])
    sine = ti.sin(body.motion[b, n, PITCH])
    t_y = flow.tangent[b, Y, edge - 1]
    t_z = flow.tangent[b, Z, edge - 1]
    along = wakes.distance[b]
    across = 0.0
    if wakes.local[b] == 1:
        p_y, p_z = pivot_velocity(body, flow.stream, b, n)
        theta_rate = body.motion[b, n, PITCH_RATE]
        u_y = theta_rate * flow.node[b, Z, edge] - p_y
        u_z = -p_z - theta_rate * flow.node[b, Y, edge] - flow.node[b, 2, edge]
        if n > 0:
            youngest = wakes.ring[b, YOUNGEST]
            w_y = wakes.velocity[b, Y, youngest] - flow.stream[b, Y]
            w_z = wakes.velocity[b, Z, youngest] - flow.stream[b, Z]
            u_y += cosine * w_y + sine * w_z
            u_z += cosine * w_z - sine * w_y
        share = wake.LOCAL_SHARE * body.dt[b]
        along = ti.max(share * (u_y * t_y + u_z * t_z), along)
        across = share * (u_z * t_y - u_y * t_z)
    y = flow.node[b, Y, edge] + along * t_y - across * t_z
    z = flow.node[b, Z, edge] + along * t_z + across * t_y
    for i in range(flow.panels[b]):
        dy = flow.point[b, Y, i] - y
        dz = flow.point[b, Z, i] - z
        strength = INV_2PI / (dy * dy + dz * dz + wakes.core2[b])
        flow.new[b, Y, i] = -dz * strength
        flow.new[b, Z, i] = dy * strength
    pivot = body.motion[b, n, PLUNGE]
    wake.shed(wakes, b, n, cosine * y - sine * z, pivot + sine * y + cosine * z)


@ti.func
def wash_panels(body: View, flow: View, wakes: View, b, n):
    """Velocity of the wake at the control points, along e_y and e_z."""
    cosine = ti.cos(body.motion[b, n, PITCH])
    sine = ti.sin(body.motion[b, n, PITCH])
    for block in range((flow.panels[b] + 7) // 8):
        y = octet(flow.control, b, Y, 8 * block)
        z = octet(flow.control, b, Z, 8 * block)
        u_y, u_z = induce(y, z, wakes.vortex, b, wakes.ring[b, COUNT], wakes.core2[b])
        store_octet(flow.wash, b, Y, 8 * block, cosine * u_y + sine * u_z)
        store_octet(flow.wash, b, Z, 8 * block, cosine * u_z - sine * u_y)


@ti.func
def assemble(body: View, flow: View, b, n):
    """No penetration at every control point (Eqs 28, 31), the new vortex eliminated by Kelvin's theorem.

    `sum_j Gamma_j + Gamma_new = total` (the corrected last row of Eq. 31: all bound circulation of the step
    before), so that column j holds vortex j less the new one.
    """
    modes = body.modes[b]
    theta_rate = body.motion[b, n, PITCH_RATE]
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    for i in range(flow.panels[b]):
        t_y = flow.tangent[b, Y, i]
        t_z = flow.tangent[b, Z, i]
        new = flow.new[b, Z, i] * t_y - flow.new[b, Y, i] * t_z
        for block in range((flow.panels[b] + 7) // 8):
            dy = flow.point[b, Y, i] - octet(flow.vortex, b, Y, 8 * block)
            dz = flow.point[b, Z, i] - octet(flow.vortex, b, Z, 8 * block)
            flow.matrix[b, i, block] = INV_2PI * (dy * t_y + dz * t_z) / (dy * dy + dz * dz) - new
        u_y = p_y - theta_rate * flow.point[b, Z, i] - flow.wash[b, Y, i]
        u_z = p_z + theta_rate * flow.point[b, Y, i] - flow.wash[b, Z, i]
        u_z += between(flow.node[b, 2, i], flow.node[b, 2, i + 1], TO_POINT)
        flow.solution[b, 0, i] = u_z * t_y - u_y * t_z - new * flow.total[b]
        for k in range(modes):
            flow.solution[b, k + 1, i] = between(flow.shape[b, k, i], flow.shape[b, k, i + 1], TO_POINT) * t_y


@ti.func
def solve(body: View, flow: View, b):
    """Circulations for no modal acceleration and for a unit rate of every mode."""
    linear.solve(flow.matrix, flow.solution, flow.factor, b, flow.panels[b], body.modes[b] + 1)


@ti.func
def circulation_at(body: View, flow: View, state: View, b, i):
    """Circulation of panel `i` at the modal rates of a state."""
    circulation = flow.solution[b, 0, i]
    for k in range(body.modes[b]):
        circulation += flow.solution[b, k + 1, i] * (state[b, RATE, k] - body.q_known[b, RATE, k])
    return circulation


@ti.func
def slip_past_panels(body: View, flow: View, b, n):
    """Tangential velocity `(V - Rdot) . tau` at the control points (Eq. 33), at the expected modal rates."""
    modes = body.modes[b]
    theta_rate = body.motion[b, n, PITCH_RATE]
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    new = flow.total[b]
    for i in range(flow.panels[b]):
        new -= circulation_at(body, flow, body.q_guess, b, i)
    for i in range(flow.panels[b]):
        left = superpose(flow.shape, body.q_guess, b, RATE, i, modes)
        right = superpose(flow.shape, body.q_guess, b, RATE, i + 1, modes)
        u_y = flow.wash[b, Y, i] + new * flow.new[b, Y, i] - p_y + theta_rate * flow.point[b, Z, i]
        u_z = flow.wash[b, Z, i] + new * flow.new[b, Z, i] - p_z - theta_rate * flow.point[b, Y, i]
        u_z -= between(left, right, TO_POINT)
        flow.slip[b, i] = u_y * flow.tangent[b, Y, i] + u_z * flow.tangent[b, Z, i]
