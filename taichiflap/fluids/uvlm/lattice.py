"""The vortex lattice on the deformed camber line: panels, and the circulation that satisfies no penetration.

Reade & Jankauski (2020), Eqs 28-31; `taichiflap.fluids.uvlm.stations` defines the positions along the chord. The wing
uses wing axes (e_y, e_z); bound vortices and control points are also stored in Y, Z, for the wake. At given positions
of wing and wake the circulation is linear in the wing's velocity and hence in the modal acceleration. One elimination
gives it without acceleration (column 0) and for a unit rate of every mode (columns 1 to K).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...kernels import linear
from ...kernels.arrays import array, zeros
from ...kernels.runtime import Floats2, Floats3, Floats4, Ints2, Octet, Octets2, Octets3, View, ti
from ...march.state import AMPLITUDE, COSINE, RATE, SINE, most_modes, pivot_velocity
from ...march.stream import FRONT, KIND, gust_at, stream_rows
from ...motion.sampling import PITCH_RATE, PLUNGE, SURGE
from ...structure.beam import Modes
from ...structure.chordwise import Profile
from ...vortex.sum import CORE2, TINY, Y, Z, induce, normal_velocity, octet, store_octet, vortex_velocity
from . import merging, wake
from . import stations as spacing
from .stations import NODE, POINT, POINT_SLOPE, TABLES, VORTEX, VORTEX_SLOPE
from .wake import ALONG_PATH, COUNT, CROSSINGS, DISTANCE, HEIGHT, REFLECTS, TRAILING, VELOCITY, YOUNGEST

ALONG, ACROSS = 2, 3
"""Rows of `at` after Y and Z, of the tables VORTEX and POINT: unit tangent t of the camber line; its normal is
(-t_z, t_y).
"""
RISE = 2
"""The same of the table NODE: rate of the deflection without modal acceleration, m/s."""
PANELS, WHOLE, SHEDDING = range(3)
"""Columns of `size`: number of panels; 1 if the pressure is uniform over panels (`loads = "panels"`); 1 if the leading
edge may shed.
"""
DENSITY, FACTOR, EDGE_FACTOR, SUCTION_LIMIT, FRICTION = range(FRONT + 1, FRONT + 6)
"""Columns of `scalar` after those of `taichiflap.march.stream`, constants: density, kg/m3; suction over the square of
the through-flow at the leading edge, N s2/m2 (`stations.suction_factor`; 0: none); `stations.edge_factor`; limit of the
suction velocity, m/s; friction of a side per area and speed to the power 1.5 (0: none).
"""
(TOTAL, SUCTION, SPEED, SHEDS, RELEASED, RELEASED_BEFORE, WAKE_Y, WAKE_Z, NEW_Y, NEW_Z, LEADING_Y,
 LEADING_Z) = range(FRONT + 6, FRONT + 18)  # fmt: skip
"""Last columns of `scalar`, the state: bound circulation one step earlier, m2/s; predicted suction, N; suction velocity
at the leading edge, m/s, see `leading_edge`; 1 while that edge sheds; circulation that it has shed, now and one step
earlier, m2/s; velocity of the wake there, along Y and Z, m/s; positions of the step's new vortices from the trailing
and the leading edge, in wing axes, m.
"""
CONTROL = 4
"""Rows of `panel`: the bound vortices in Y, Z, as in `taichiflap.vortex`; and from here on the control points there."""
LENGTH, SPAN, PRESSURE, SUM, SUM_BEFORE = range(6, 11)
"""Next rows: length and mean span, m; force per area along e_z, Pa; running sum of circulation, one and two steps
earlier, m2/s.
"""
WAKE, TANGENTIAL, NEW, NEW_LEADING = 11, 13, 15, 17
"""First of two rows each, velocities at the control points, m/s: of the wake, in wing axes; tangential velocity of the
fluid, predicted (the second row is scratch); of a new vortex of unit circulation at the trailing edge, and of one at
the leading edge (only in a batch that sheds there).
"""
BASE, STRENGTH = range(2)
"""Rows of `edge`, one value per column of the solution: A without the leading edge's new vortex, and the strength of
that vortex.
"""

Lattice = ti.types.argpack(
    size=Ints2,  # (case, column), and the next two: see the names of the columns and rows
    scalar=Floats2,
    panel=Floats3,  # (case, row, panel)
    at=Floats4,  # (case, NODE, VORTEX or POINT, row, node or panel): positions in wing axes, m
    shape=Floats4,  # (case, mode, table, node or panel), see taichiflap.fluids.uvlm.stations
    matrix=Octets3,  # also the right-hand sides before the solution
    solution=Floats3,  # (case, 1 + modes, panel): circulation without acceleration, and for a unit rate of each mode;
    # followed by that of a unit vortex at the leading edge
    edge=Floats3,
    factor=Octets2,
)

HELD = ("panel",), ("at",), ("shape",), ("matrix",), ("solution",), ("factor",)
"""Arrays whose shapes the kernel reads once, see `taichiflap.kernels.held`."""


def allocate(cases: Sequence[Case], sections: Sequence[Modes]) -> Any:
    """Arrays of the lattices of a batch."""
    count = len(cases)
    most = 8 * linear.octets(max(case.uvlm.panels for case in cases))
    modes = most_modes(sections)
    sheds = [case.uvlm.leading_edge == "sheds" for case in cases]
    size, scalar = np.zeros((count, 3), dtype=int), np.zeros((count, LEADING_Z + 1))
    panel = np.zeros((count, NEW_LEADING + 2 * any(sheds), most))
    place, shape = np.zeros((count, 3, 4, most + 1)), np.zeros((count, modes, TABLES, most + 1))
    scalar[:, :DENSITY] = stream_rows(cases, [case.uvlm.panels for case in cases])
    columns = modes + 1 + any(sheds)
    for b, (case, section) in enumerate(zip(cases, sections, strict=True)):
        at, panels = spacing.stations(case), case.uvlm.panels
        place[b, NODE, Y, : panels + 1] = at.node
        place[b, [VORTEX, POINT], Y, :panels] = at.vortex, at.point
        shape[b, : section.count, :, : panels + 1] = spacing.tables(case, section.shape, section.slope)
        panel[b, SPAN, :panels] = Profile.of(case.wing.span).means(at.node / case.wing.chord + case.wing.pivot)
        size[b] = panels, case.uvlm.loads == "panels", sheds[b]
        factor = spacing.suction_factor(case) if case.uvlm.suction or sheds[b] else 0.0
        limit = case.uvlm.suction_limit * case.reference_speed if sheds[b] else 0.0
        of_edge = factor, spacing.edge_factor(case), limit, spacing.friction_factor(case)
        scalar[b, DENSITY : FRICTION + 1] = case.fluid.density, *of_edge
    return Lattice(
        size=array(size),
        scalar=array(scalar),
        panel=array(panel),
        at=array(place),
        shape=array(shape),
        matrix=zeros(Octet, count, most, most // 8 + linear.octets(columns)),
        solution=zeros(ti.f64, count, columns, most),
        edge=zeros(ti.f64, count, 2, columns),
        factor=zeros(Octet, count, most),
    )


@ti.func
def between(left, right, share):
    return left + share * (right - left)


@ti.func
def deflect(flow: View, state: View, b, row, table, i, modes):
    """`sum_k phi_k q_k` of a row of a modal state, with modes from a table: W (Eq. 8), its rate or its slope."""
    total = 0.0
    for k in range(modes):
        total += flow.shape[b, k, table, i] * state[b, row, k]
    return total


@ti.func
def place_panels(body: View, flow: View, b, n):
    """Panels, bound vortices and control points at the predicted deformation."""
    modes = body.modes[b]
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    o_y, o_z = body.motion[b, n, SURGE], body.motion[b, n, PLUNGE]
    for i in range(flow.size[b, PANELS] + 1):
        flow.at[b, NODE, Z, i] = deflect(flow, body.q_predicted, b, AMPLITUDE, NODE, i, modes)
        flow.at[b, NODE, RISE, i] = deflect(flow, body.q_free, b, RATE, NODE, i, modes)
    for i in range(flow.size[b, PANELS]):
        dy = flow.at[b, NODE, Y, i + 1] - flow.at[b, NODE, Y, i]
        dz = flow.at[b, NODE, Z, i + 1] - flow.at[b, NODE, Z, i]
        flow.panel[b, LENGTH, i] = ti.sqrt(dy * dy + dz * dz)
        put(flow, VORTEX, deflect(flow, body.q_predicted, b, AMPLITUDE, VORTEX, i, modes),
            deflect(flow, body.q_predicted, b, AMPLITUDE, VORTEX_SLOPE, i, modes), b, i)  # fmt: skip
        put(flow, POINT, deflect(flow, body.q_predicted, b, AMPLITUDE, POINT, i, modes),
            deflect(flow, body.q_predicted, b, AMPLITUDE, POINT_SLOPE, i, modes), b, i)  # fmt: skip
        flow.panel[b, Y, i] = o_y + cosine * flow.at[b, VORTEX, Y, i] - sine * flow.at[b, VORTEX, Z, i]
        flow.panel[b, Z, i] = o_z + sine * flow.at[b, VORTEX, Y, i] + cosine * flow.at[b, VORTEX, Z, i]
        flow.panel[b, CONTROL + Y, i] = o_y + cosine * flow.at[b, POINT, Y, i] - sine * flow.at[b, POINT, Z, i]
        flow.panel[b, CONTROL + Z, i] = o_z + sine * flow.at[b, POINT, Y, i] + cosine * flow.at[b, POINT, Z, i]


@ti.func
def put(flow: View, table, deflection, slope, b, i):
    """Deflection of a vortex or a point, and the tangent of the camber line there."""
    stretch = 1.0 / ti.sqrt(1.0 + slope * slope)
    flow.at[b, table, Z, i] = deflection
    flow.at[b, table, ALONG, i] = stretch
    flow.at[b, table, ACROSS, i] = slope * stretch


@ti.func
def reflect_crossings(body: View, flow: View, wakes: View, b, n):
    """Count the wake vortices that the wing has crossed since the last step, and reflect them to their side of it.

    A vortex that was above the wing and is now below is moved to the same distance above it, and vice versa.
    """
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    o_y, o_z = body.motion[b, n, SURGE], body.motion[b, n, PLUNGE]
    last = flow.size[b, PANELS]
    for m in range(wakes.ring[b, COUNT]):
        d_y, d_z = wakes.vortex[b, Y, m] - o_y, wakes.vortex[b, Z, m] - o_z
        y = cosine * d_y + sine * d_z
        gap = 0.0
        if flow.at[b, NODE, Y, 0] < y < flow.at[b, NODE, Y, last]:
            low, high = 0, last
            while high - low > 1:
                half = (low + high) // 2
                if flow.at[b, NODE, Y, half] <= y:
                    low = half
                else:
                    high = half
            share = (y - flow.at[b, NODE, Y, low]) / (flow.at[b, NODE, Y, high] - flow.at[b, NODE, Y, low])
            gap = cosine * d_z - sine * d_y - between(flow.at[b, NODE, Z, low], flow.at[b, NODE, Z, high], share)
        if gap * wakes.vortex[b, HEIGHT, m] < 0.0:
            wakes.ring[b, CROSSINGS] = wakes.ring[b, CROSSINGS] + 1
            if wakes.scalar[b, REFLECTS] > 0.0:
                wakes.vortex[b, Y, m] = wakes.vortex[b, Y, m] + 2.0 * gap * sine
                wakes.vortex[b, Z, m] = wakes.vortex[b, Z, m] - 2.0 * gap * cosine
                gap = -gap
        wakes.vortex[b, HEIGHT, m] = gap


@ti.func
def velocity_past(body: View, flow: View, b, n, i):
    """Velocity (m/s) of the stream relative to node `i`, without modal acceleration, along e_y and e_z."""
    p_y, p_z = pivot_velocity(body, flow.scalar, b, n)
    theta_rate = body.motion[b, n, PITCH_RATE]
    return (
        theta_rate * flow.at[b, NODE, Z, i] - p_y,
        -p_z - theta_rate * flow.at[b, NODE, Y, i] - flow.at[b, NODE, RISE, i],
    )


@ti.func
def shed_vortex(body: View, flow: View, wakes: View, b, n, used: View):
    """Place this step's wake vortex behind the trailing edge, and store the velocity it induces per unit at the panels.

    Fixed rule: at a distance along the tangent. Local rule: at a share of the trailing edge's path relative to the flow
        that carried the youngest vortex, but at least the minimum distance behind the edge.
    """
    edge = flow.size[b, PANELS]
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    t_y = flow.at[b, POINT, ALONG, edge - 1]
    t_z = flow.at[b, POINT, ACROSS, edge - 1]
    along = wakes.scalar[b, DISTANCE]
    across = 0.0
    if wakes.scalar[b, ALONG_PATH] > 0.0:
        u_y, u_z = velocity_past(body, flow, b, n, edge)
        if n > 0:
            youngest = wakes.ring[b, YOUNGEST]
            w_y = wakes.vortex[b, VELOCITY + Y, youngest] - flow.scalar[b, Y]
            w_z = wakes.vortex[b, VELOCITY + Z, youngest] - flow.scalar[b, Z]
            u_y += cosine * w_y + sine * w_z
            u_z += cosine * w_z - sine * w_y
        share = wakes.scalar[b, ALONG_PATH] * body.dt[b]
        along = ti.max(share * (u_y * t_y + u_z * t_z), along)
        across = share * (u_z * t_y - u_y * t_z)
    y = flow.at[b, NODE, Y, edge] + along * t_y - across * t_z
    z = flow.at[b, NODE, Z, edge] + along * t_z + across * t_y
    o_y, o_z = body.motion[b, n, SURGE], body.motion[b, n, PLUNGE]
    middle = flow.size[b, PANELS] // 2
    merging.make_room(wakes, b, n, flow.panel[b, Y, middle], flow.panel[b, Z, middle], used)
    wake.shed(wakes, b, n, TRAILING, o_y + cosine * y - sine * z, o_z + sine * y + cosine * z)
    flow.scalar[b, NEW_Y] = y
    flow.scalar[b, NEW_Z] = z
    core2 = wakes.vortex[b, CORE2, wakes.ring[b, YOUNGEST]]
    for i in range(flow.size[b, PANELS]):
        flow.panel[b, NEW + Y, i], flow.panel[b, NEW + Z, i] = vortex_velocity(
            1.0, flow.at[b, POINT, Y, i] - y, flow.at[b, POINT, Z, i] - z, core2
        )


@ti.func
def wake_at_panels(body: View, flow: View, wakes: View, b, n):
    """Velocity of the wake at the control points, along e_y and e_z."""
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    for block in range((flow.size[b, PANELS] + 7) // 8):
        y = octet(flow.panel, b, CONTROL + Y, 8 * block)
        z = octet(flow.panel, b, CONTROL + Z, 8 * block)
        u_y, u_z = induce(y, z, TINY, wakes.vortex, b, 0, wakes.ring[b, COUNT])
        store_octet(flow.panel, b, WAKE + Y, 8 * block, cosine * u_y + sine * u_z)
        store_octet(flow.panel, b, WAKE + Z, 8 * block, cosine * u_z - sine * u_y)


@ti.func
def gust_at_panels(body: View, flow: View, b, n):
    """Add the velocity of a gust at the control points to that of the wake."""
    if flow.scalar[b, KIND] > 0.0:
        cosine = body.motion[b, n, COSINE]
        sine = body.motion[b, n, SINE]
        last = flow.size[b, PANELS] - 1
        for i in range(last + 1):
            # A sharp gust edge is averaged over the cell between two vortices.
            cell = 2.0 * (flow.at[b, POINT, Y, i] - flow.at[b, VORTEX, Y, i])
            if i < last:
                cell = flow.at[b, VORTEX, Y, i + 1] - flow.at[b, VORTEX, Y, i]
            g_y, g_z = gust_at(flow.scalar, b, flow.panel[b, CONTROL + Y, i], flow.panel[b, CONTROL + Z, i], cell)
            flow.panel[b, WAKE + Y, i] = flow.panel[b, WAKE + Y, i] + cosine * g_y + sine * g_z
            flow.panel[b, WAKE + Z, i] = flow.panel[b, WAKE + Z, i] + cosine * g_z - sine * g_y


@ti.func
def vortices(flow: View, b, axis, first):
    """A row of eight bound vortices in wing axes."""
    return Octet([flow.at[b, VORTEX, axis, first + lane] for lane in ti.static(range(8))])


@ti.func
def new_at(flow: View, b, i, t_y, t_z):
    """Velocity along the normal of panel `i` due to a unit of the new vortex."""
    return flow.panel[b, NEW + Z, i] * t_y - flow.panel[b, NEW + Y, i] * t_z


@ti.func
def assemble(body: View, flow: View, b, n):
    """No penetration at every control point (Eqs 28, 31), with the new vortex eliminated by Kelvin's theorem.

    `sum_j Gamma_j + Gamma_new = total` (the corrected last row of Eq. 31: all bound circulation of the step before), so
    that column j is the effect of vortex j minus that of the new vortex.
    """
    modes = body.modes[b]
    theta_rate = body.motion[b, n, PITCH_RATE]
    p_y, p_z = pivot_velocity(body, flow.scalar, b, n)
    for block in range((flow.size[b, PANELS] + 7) // 8):
        y, z = vortices(flow, b, Y, 8 * block), vortices(flow, b, Z, 8 * block)
        for i in range(flow.size[b, PANELS]):
            t_y, t_z = flow.at[b, POINT, ALONG, i], flow.at[b, POINT, ACROSS, i]
            past = normal_velocity(1.0, flow.at[b, POINT, Y, i] - y, flow.at[b, POINT, Z, i] - z, t_y, t_z)
            flow.matrix[b, i, block] = past - new_at(flow, b, i, t_y, t_z)
    for i in range(flow.size[b, PANELS]):
        t_y, t_z = flow.at[b, POINT, ALONG, i], flow.at[b, POINT, ACROSS, i]
        u_y = p_y - theta_rate * flow.at[b, POINT, Z, i] - flow.panel[b, WAKE + Y, i]
        u_z = p_z + theta_rate * flow.at[b, POINT, Y, i] - flow.panel[b, WAKE + Z, i]
        u_z += deflect(flow, body.q_free, b, RATE, POINT, i, modes)
        flow.solution[b, 0, i] = u_z * t_y - u_y * t_z - new_at(flow, b, i, t_y, t_z) * flow.scalar[b, TOTAL]
        for k in range(modes):
            flow.solution[b, k + 1, i] = flow.shape[b, k, POINT, i] * t_y


@ti.func
def solve(body: View, flow: View, b):
    """Circulations without modal acceleration, for a unit rate of every mode, and for a unit vortex at the leading
    edge.
    """
    columns = body.modes[b] + 1 + flow.size[b, SHEDDING]
    linear.solve(flow.matrix, flow.solution, flow.factor, b, flow.size[b, PANELS], columns)


@ti.func
def circulation_at(body: View, flow: View, state: View, b, i):
    """Circulation of panel `i` at the modal rates of a state."""
    circulation = flow.solution[b, 0, i]
    for k in range(body.modes[b]):
        circulation += flow.solution[b, k + 1, i] * (state[b, RATE, k] - body.q_free[b, RATE, k])
    return circulation
