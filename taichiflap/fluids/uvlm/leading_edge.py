"""A leading edge that sheds: a second vortex sheet whose strength limits the leading-edge suction.

The flow around the edge is measured by the suction velocity `A = w sqrt(s)/(2 N)`, m/s: w is the normal flow through
the lattice at the edge, N the number of panels and s the stretch `sqrt(1 + slope^2)` of the camber line. On a steady
flat plate A is `U sin(alpha)`; near the edge `gamma -> 2 A sqrt(c/x)`, and the suction per unit span is `pi rho c A^2`.
`A/U` is the leading-edge suction parameter of Ramesh, Gopalarathnam, Granlund, Ol & Edwards (2014),
J. Fluid Mech. 751, whose criterion is used: |A| does not exceed a limit.

A unit vortex at the edge is an additional right-hand side of the lattice's elimination. The A of all columns gives the
strength required by the limit, which is linear in the modal acceleration: `g = g_0 + sum_k g_k (rate_k - known
rate_k)`. The new vortex is then included in every column, so that loads and coupling need no special treatment.
"""

from ...kernels.runtime import Octet, View, ti
from ...march.state import AMPLITUDE, C0, C1, C2, COSINE, RATE, SINE
from ...motion.sampling import PLUNGE, SURGE
from ...vortex.sum import CIRCULATION, CORE2, TINY, Y, Z, induce, normal_velocity, vortex_velocity
from . import wake
from .lattice import (
    ACROSS,
    ALONG,
    BASE,
    EDGE_FACTOR,
    LEADING_Y,
    LEADING_Z,
    NEW,
    NEW_LEADING,
    NEW_Y,
    NEW_Z,
    PANELS,
    RELEASED,
    RELEASED_BEFORE,
    SHEDS,
    SPEED,
    STRENGTH,
    SUCTION_LIMIT,
    TOTAL,
    WAKE_Y,
    WAKE_Z,
    deflect,
    velocity_past,
)  # fmt: skip
from .stations import EDGE_SLOPE, NODE, POINT, VORTEX
from .wake import ALONG_PATH, COUNT, DISTANCE, LEADING, VELOCITY, YOUNGEST, YOUNGEST_LEADING


@ti.func
def tangent(body: View, flow: View, b):
    """Unit tangent of the camber line at the leading edge, and its stretch."""
    slope = deflect(flow, body.q_predicted, b, AMPLITUDE, EDGE_SLOPE, 0, body.modes[b])
    stretch = ti.sqrt(1.0 + slope * slope)
    return 1.0 / stretch, slope / stretch, stretch


@ti.func
def place(body: View, flow: View, wakes: View, b, n):
    """Position of a new vortex of the leading edge, and the velocity it induces per unit at the panels.

    Mirror image of the trailing edge's rule: at a share of the edge's path relative to the flow that carried the last
    vortex, if the previous step shed one, or else relative to the wake's velocity at the edge; never behind the edge.
    """
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    t_y, t_z, _ = tangent(body, flow, b)
    u_y, u_z = velocity_past(body, flow, b, n, 0)
    w_y, w_z = flow.scalar[b, WAKE_Y], flow.scalar[b, WAKE_Z]
    if flow.scalar[b, SHEDS] > 0.0:
        youngest = wakes.ring[b, YOUNGEST_LEADING]
        w_y = wakes.vortex[b, VELOCITY + Y, youngest] - flow.scalar[b, Y]
        w_z = wakes.vortex[b, VELOCITY + Z, youngest] - flow.scalar[b, Z]
    u_y += cosine * w_y + sine * w_z
    u_z += cosine * w_z - sine * w_y
    share = wakes.scalar[b, ALONG_PATH] * body.dt[b]
    along = ti.min(share * (u_y * t_y + u_z * t_z), -wakes.scalar[b, DISTANCE])
    across = share * (u_z * t_y - u_y * t_z)
    y = flow.at[b, NODE, Y, 0] + along * t_y - across * t_z
    z = flow.at[b, NODE, Z, 0] + along * t_z + across * t_y
    flow.scalar[b, LEADING_Y] = y
    flow.scalar[b, LEADING_Z] = z
    core2 = wake.core2_at_birth(wakes, b)
    for i in range(flow.size[b, PANELS]):
        u_y, u_z = vortex_velocity(1.0, flow.at[b, POINT, Y, i] - y, flow.at[b, POINT, Z, i] - z, core2)
        flow.panel[b, NEW_LEADING + Y, i] = u_y
        flow.panel[b, NEW_LEADING + Z, i] = u_z


@ti.func
def wake_at_edge(body: View, flow: View, wakes: View, b, n):
    """Velocity of the wake at the leading edge, along Y and Z."""
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    y, z = flow.at[b, NODE, Y, 0], flow.at[b, NODE, Z, 0]
    at_y = body.motion[b, n, SURGE] + cosine * y - sine * z
    at_z = body.motion[b, n, PLUNGE] + sine * y + cosine * z
    u_y, u_z = induce(Octet(at_y), Octet(at_z), TINY, wakes.vortex, b, 0, wakes.ring[b, COUNT])
    flow.scalar[b, WAKE_Y] = u_y[0]
    flow.scalar[b, WAKE_Z] = u_z[0]


@ti.func
def assemble(body: View, flow: View, b):
    """Right-hand side of a unit vortex at the leading edge; the trailing edge's vortex compensates it (Kelvin)."""
    for i in range(flow.size[b, PANELS]):
        u_y = flow.panel[b, NEW + Y, i] - flow.panel[b, NEW_LEADING + Y, i]
        u_z = flow.panel[b, NEW + Z, i] - flow.panel[b, NEW_LEADING + Z, i]
        flow.solution[b, body.modes[b] + 1, i] = u_z * flow.at[b, POINT, ALONG, i] - u_y * flow.at[b, POINT, ACROSS, i]


@ti.func
def measure(body: View, flow: View, wakes: View, b, n):
    """A of every column of the solution; the last is that of a unit vortex at the leading edge."""
    modes = body.modes[b]
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    t_y, t_z, stretch = tangent(body, flow, b)
    scale = ti.sqrt(stretch) / flow.scalar[b, EDGE_FACTOR]
    y, z = flow.at[b, NODE, Y, 0], flow.at[b, NODE, Z, 0]
    core2 = wakes.vortex[b, CORE2, wakes.ring[b, YOUNGEST]]
    u_y, u_z = vortex_velocity(1.0, y - flow.scalar[b, NEW_Y], z - flow.scalar[b, NEW_Z], core2)
    new = u_z * t_y - u_y * t_z
    core2 = wake.core2_at_birth(wakes, b)
    u_y, u_z = vortex_velocity(1.0, y - flow.scalar[b, LEADING_Y], z - flow.scalar[b, LEADING_Z], core2)
    leading = u_z * t_y - u_y * t_z
    for column in range(modes + 2):
        through = 0.0
        bound = 0.0
        for i in range(flow.size[b, PANELS]):
            dy, dz = y - flow.at[b, VORTEX, Y, i], z - flow.at[b, VORTEX, Z, i]
            circulation = flow.solution[b, column, i]
            through += normal_velocity(circulation, dy, dz, t_y, t_z)
            bound += circulation
        if column == 0:
            w_y, w_z = flow.scalar[b, WAKE_Y], flow.scalar[b, WAKE_Z]
            u_y, u_z = velocity_past(body, flow, b, n, 0)
            u_y += cosine * w_y + sine * w_z
            u_z += cosine * w_z - sine * w_y
            through += new * (flow.scalar[b, TOTAL] - bound) + u_z * t_y - u_y * t_z
        elif column <= modes:
            through -= new * bound + flow.shape[b, column - 1, NODE, 0] * t_y
        else:
            through += leading - new * (bound + 1.0)
        flow.edge[b, BASE, column] = scale * through


@ti.func
def at_rates(body: View, flow: View, state: View, b, row):
    """A row of `edge` at the modal rates of a state."""
    value = flow.edge[b, row, 0]
    for k in range(body.modes[b]):
        value += flow.edge[b, row, k + 1] * (state[b, RATE, k] - body.q_free[b, RATE, k])
    return value


@ti.func
def released_at(body: View, flow: View, state: View, b):
    """Circulation of the leading edge's new vortex at the modal rates of a state; zero if none is shed."""
    released = 0.0
    if flow.scalar[b, SHEDS] > 0.0:
        released = at_rates(body, flow, state, b, STRENGTH)
    return released


@ti.func
def shed(body: View, flow: View, wakes: View, b, n):
    """Shed a vortex if the predicted A exceeds its limit, with the strength that keeps A at the limit.

    The decision uses the predicted modal rates, the strength the actual ones.
    """
    modes = body.modes[b]
    limit = flow.scalar[b, SUCTION_LIMIT]
    expected = at_rates(body, flow, body.q_predicted, b, BASE)
    flow.scalar[b, SHEDS] = 0.0
    if ti.abs(expected) > limit or limit == 0.0:
        flow.scalar[b, SHEDS] = 1.0
        target = limit
        if expected < 0.0:
            target = 0.0 - limit
        for column in range(modes + 1):
            strength = (target - flow.edge[b, BASE, column]) / flow.edge[b, BASE, modes + 1]
            target = 0.0
            flow.edge[b, STRENGTH, column] = strength
            for i in range(flow.size[b, PANELS]):
                flow.solution[b, column, i] = flow.solution[b, column, i] + strength * flow.solution[b, modes + 1, i]
        cosine = body.motion[b, n, COSINE]
        sine = body.motion[b, n, SINE]
        y, z = flow.scalar[b, LEADING_Y], flow.scalar[b, LEADING_Z]
        at_y = body.motion[b, n, SURGE] + cosine * y - sine * z
        at_z = body.motion[b, n, PLUNGE] + sine * y + cosine * z
        wake.shed(wakes, b, n, LEADING, at_y, at_z)


@ti.func
def potential(flow: View, b, column, rule):
    """Jump of potential at the leading edge (its total shed circulation) and its rate, for a column of the solution."""
    jump = 0.0
    if flow.scalar[b, SHEDS] > 0.0:
        jump = flow.edge[b, STRENGTH, column]
    past = 0.0
    if column == 0:
        jump += flow.scalar[b, RELEASED]
        past = rule[C1] * flow.scalar[b, RELEASED] + rule[C2] * flow.scalar[b, RELEASED_BEFORE]
    return jump, rule[C0] * jump + past


@ti.func
def settle(body: View, flow: View, wakes: View, b, rule):
    """Set the strength of the new vortex at the actual rates.

    Returns:
        Jump of potential at the leading edge, m2/s, its rate, and that strength.
    """
    released = released_at(body, flow, body.q, b)
    flow.scalar[b, SPEED] = at_rates(body, flow, body.q, b, BASE) + flow.edge[b, BASE, body.modes[b] + 1] * released
    before = flow.scalar[b, RELEASED]
    jump = before + released
    rate = rule[C0] * jump + rule[C1] * before + rule[C2] * flow.scalar[b, RELEASED_BEFORE]
    flow.scalar[b, RELEASED_BEFORE] = before
    flow.scalar[b, RELEASED] = jump
    if flow.scalar[b, SHEDS] > 0.0:
        wakes.vortex[b, CIRCULATION, wakes.ring[b, YOUNGEST_LEADING]] = released
    return jump, rate, released
