"""Tangential velocity along the wing for the loads, and leading-edge suction.

Reade & Jankauski (2020), Eq. 33, with the contribution of the bound vortices of a bent wing; all at the predicted modal
rates. Leading-edge suction follows Lan (1974).
"""

from ...kernels.runtime import Octet, View, ti
from ...march.state import AMPLITUDE, COSINE, RATE, SINE, pivot_velocity
from ...march.stream import gust_at_octet
from ...motion.sampling import PITCH_RATE, PLUNGE, SURGE
from ...vortex.sum import CIRCULATION, INV_2PI, TINY, Y, Z, induce, octet, store_octet
from .lattice import (
    ACROSS,
    ALONG,
    EDGE_FACTOR,
    FACTOR,
    FRICTION,
    LENGTH,
    NEW,
    PANELS,
    SHEDS,
    SPAN,
    SPEED,
    SUCTION,
    SUCTION_LIMIT,
    TANGENTIAL,
    TOTAL,
    WAKE,
    circulation_at,
    deflect,
)  # fmt: skip
from .leading_edge import released_at
from .stations import EDGE_SLOPE, NODE, POINT, VORTEX
from .wake import COUNT, YOUNGEST, YOUNGEST_LEADING


@ti.func
def new_circulation(body: View, flow: View, b):
    """Circulation of the new vortex at the predicted modal rates (Kelvin)."""
    new = flow.scalar[b, TOTAL]
    for i in range(flow.size[b, PANELS]):
        new -= circulation_at(body, flow, body.q_predicted, b, i)
    return new - released_at(body, flow, body.q_predicted, b)


@ti.func
def past_points(body: View, flow: View, b, n):
    """Tangential velocity `(V - Rdot) . tau` at the control points (Eq. 33), at the predicted modal rates.

    As in the paper, V includes the stream and the wake but not the bound vortices of a bent wing.
    """
    theta_rate = body.motion[b, n, PITCH_RATE]
    p_y, p_z = pivot_velocity(body, flow.scalar, b, n)
    new = new_circulation(body, flow, b)
    for i in range(flow.size[b, PANELS]):
        u_y = flow.panel[b, WAKE + Y, i] + new * flow.panel[b, NEW + Y, i] - p_y + theta_rate * flow.at[b, POINT, Z, i]
        u_z = flow.panel[b, WAKE + Z, i] + new * flow.panel[b, NEW + Z, i] - p_z - theta_rate * flow.at[b, POINT, Y, i]
        u_z -= deflect(flow, body.q_predicted, b, RATE, POINT, i, body.modes[b])
        flow.panel[b, TANGENTIAL, i] = u_y * flow.at[b, POINT, ALONG, i] + u_z * flow.at[b, POINT, ACROSS, i]


@ti.func
def expect_circulation(body: View, flow: View, wakes: View, b):
    """Set the circulation of the bound and the new vortices at the predicted modal rates."""
    for i in range(flow.size[b, PANELS]):
        flow.panel[b, CIRCULATION, i] = circulation_at(body, flow, body.q_predicted, b, i)
    wakes.vortex[b, CIRCULATION, wakes.ring[b, YOUNGEST]] = new_circulation(body, flow, b)
    if flow.scalar[b, SHEDS] > 0.0:
        wakes.vortex[b, CIRCULATION, wakes.ring[b, YOUNGEST_LEADING]] = released_at(body, flow, body.q_predicted, b)


@ti.func
def induced(flow: View, wakes: View, y, z, b):
    """Velocity at eight points (Y, Z) from the wake, a gust, and all bound vortices except one at the point itself."""
    w_y, w_z = induce(y, z, TINY, wakes.vortex, b, 0, wakes.ring[b, COUNT])
    b_y, b_z = induce(y, z, TINY, flow.panel, b, 0, flow.size[b, PANELS])
    g_y, g_z = gust_at_octet(flow.scalar, b, y, z)
    return w_y + b_y + g_y, w_z + b_z + g_z


@ti.func
def past_vortices(body: View, flow: View, wakes: View, b, n):
    """Tangential velocity at the bound vortices, including all other vortices, at the predicted modal rates.

    A vortex represents a piece of a vortex sheet. A curved sheet induces the tangential velocity `Gamma kappa/(4 pi)`
    on itself, with the curvature kappa.
    """
    theta_rate = body.motion[b, n, PITCH_RATE]
    p_y, p_z = pivot_velocity(body, flow.scalar, b, n)
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    for block in range((flow.size[b, PANELS] + 7) // 8):
        u_y, u_z = induced(flow, wakes, octet(flow.panel, b, Y, 8 * block), octet(flow.panel, b, Z, 8 * block), b)
        store_octet(flow.panel, b, TANGENTIAL + Y, 8 * block, cosine * u_y + sine * u_z)
        store_octet(flow.panel, b, TANGENTIAL + Z, 8 * block, cosine * u_z - sine * u_y)
    for i in range(flow.size[b, PANELS]):
        t_y = flow.at[b, VORTEX, ALONG, i]
        t_z = flow.at[b, VORTEX, ACROSS, i]
        u_y = flow.panel[b, TANGENTIAL + Y, i] - p_y + theta_rate * flow.at[b, VORTEX, Z, i]
        u_z = flow.panel[b, TANGENTIAL + Z, i] - p_z - theta_rate * flow.at[b, VORTEX, Y, i]
        u_z -= deflect(flow, body.q_predicted, b, RATE, VORTEX, i, body.modes[b])
        turn = t_y * flow.at[b, POINT, ACROSS, i] - t_z * flow.at[b, POINT, ALONG, i]
        bend = turn * t_y / (flow.at[b, POINT, Y, i] - flow.at[b, VORTEX, Y, i])
        flow.panel[b, TANGENTIAL, i] = u_y * t_y + u_z * t_z + 0.5 * INV_2PI * bend * flow.panel[b, CIRCULATION, i]


@ti.func
def friction(flow: View, b, bound):
    """Laminar friction of both sides: its force along e_y and its moment about the pivot.

    The mean speed of each side is the mean tangential velocity plus or minus half the mean strength of the bound sheet.
    Friction is that of a plate's boundary layer at this speed (Blasius). It acts along the chord even if the wing is
    bent, so that it does no work on the modes. Speeds are those at the predicted modal rates.

    Args:
        bound: total bound circulation, m2/s.
    """
    arc, along = 0.0, 0.0
    for i in range(flow.size[b, PANELS]):
        arc += flow.panel[b, LENGTH, i]
        along += flow.panel[b, LENGTH, i] * flow.panel[b, TANGENTIAL, i]
    stress = 0.0
    for side in ti.static((-0.5, 0.5)):
        speed = (along + side * bound) / arc
        stress += flow.scalar[b, FRICTION] * ti.sqrt(ti.abs(speed)) * speed
    force, moment = 0.0, 0.0
    for i in range(flow.size[b, PANELS]):
        share = stress * flow.panel[b, SPAN, i] * flow.panel[b, LENGTH, i]
        force += share
        moment -= share * flow.at[b, VORTEX, Z, i]
    return force, moment


@ti.func
def leading_edge_suction(body: View, flow: View, wakes: View, b, n):
    """Leading-edge suction along the tangent, from the predicted flow through the lattice there.

    Lan (1974): the lattice satisfies no penetration only at its control points, and the flow through the leading edge
    is proportional to the strength of the singularity there.
    """
    slope = deflect(flow, body.q_predicted, b, AMPLITUDE, EDGE_SLOPE, 0, body.modes[b])
    stretch = ti.sqrt(1.0 + slope * slope)
    theta_rate = body.motion[b, n, PITCH_RATE]
    p_y, p_z = pivot_velocity(body, flow.scalar, b, n)
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    y, z = flow.at[b, NODE, Y, 0], flow.at[b, NODE, Z, 0]
    edge_y = body.motion[b, n, SURGE] + cosine * y - sine * z
    edge_z = body.motion[b, n, PLUNGE] + sine * y + cosine * z
    v_y, v_z = induced(flow, wakes, Octet(edge_y), Octet(edge_z), b)
    u_y = cosine * v_y[0] + sine * v_z[0] - p_y + theta_rate * z
    u_z = cosine * v_z[0] - sine * v_y[0] - p_z - theta_rate * y
    u_z -= deflect(flow, body.q_predicted, b, RATE, NODE, 0, body.modes[b])
    through = (u_z - slope * u_y) / stretch
    if flow.scalar[b, SHEDS] > 0.0:
        # Set exactly to the limit, which the shed vortex enforces.
        at_limit = flow.scalar[b, EDGE_FACTOR] * flow.scalar[b, SUCTION_LIMIT]
        flow.scalar[b, SUCTION] = flow.scalar[b, FACTOR] * at_limit * at_limit
    else:
        flow.scalar[b, SUCTION] = flow.scalar[b, FACTOR] * stretch * through * through
        flow.scalar[b, SPEED] = through * ti.sqrt(stretch) / flow.scalar[b, EDGE_FACTOR]


@ti.func
def suction_force(body: View, flow: View, b):
    """The suction along e_y and e_z: it pulls the leading edge forward along its tangent."""
    slope = deflect(flow, body.q_predicted, b, AMPLITUDE, EDGE_SLOPE, 0, body.modes[b])
    forward = flow.scalar[b, SUCTION] / ti.sqrt(1.0 + slope * slope)
    return -forward, -forward * slope
