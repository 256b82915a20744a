"""Unsteady vortex lattice: loads of a lumped-vortex lattice on the deformed camber line, with a free wake.

Reade & Jankauski (2020), Eqs 28-34; `lattice` holds Eqs 28-31, `wake` Eqs 29 and 32.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...case.case import Case
from ...kernels.held import held
from ...kernels.runtime import View, ti
from ...march.state import AXIAL, BETA, C0, C1, C2, MOMENT, NORMAL, UNSTEADY
from ...march.stream import carry_gust
from ...structure.beam import Modes
from ...vortex.sum import CIRCULATION, Y, Z
from ..interface import Flow
from . import lattice, leading_edge, tangential, wake
from .lattice import (
    ACROSS,
    ALONG,
    DENSITY,
    FACTOR,
    LENGTH,
    PANELS,
    PRESSURE,
    RELEASED,
    SHEDDING,
    SHEDS,
    SPAN,
    SPEED,
    SUM,
    SUM_BEFORE,
    TANGENTIAL,
    TOTAL,
    WHOLE,
    between,
    circulation_at,
)  # fmt: skip
from .long_wake import LongWakes
from .stations import ACT, AHEAD, BEHIND, NODE, VORTEX, absorbs, has_edge, is_listed, sheds
from .wake import CAPACITY, COUNT, CROSSINGS, FAR_ERROR, LOST_Y, LOST_Z, OLDEST, SHED_AT, SHED_FROM, YOUNGEST


@dataclass(frozen=True)
class Uses:
    """Features of the model that a batch needs. The kernel contains only these, to compile faster."""

    suction: bool
    loads_at_vortices: bool
    single_precision: bool
    gusts: bool
    absorbing: bool
    shedding: bool
    listing: bool
    shortening: bool
    friction: bool


def uses(cases: Sequence[Case]) -> Uses:
    """Features that a batch needs."""
    return Uses(
        suction=any(has_edge(case) for case in cases),
        loads_at_vortices=any(case.uvlm.loads == "vortices" for case in cases),
        single_precision=any(case.uvlm.precision == "single" for case in cases),
        gusts=any(case.fluid.gust != "none" for case in cases),
        absorbing=any(absorbs(case) and not is_listed(case) for case in cases),
        shedding=any(sheds(case) for case in cases),
        listing=any(map(is_listed, cases)),
        shortening=any(absorbs(case) and is_listed(case) for case in cases),
        friction=any(case.fluid.viscosity for case in cases),
    )


def flow(cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
    """Lattices and wakes of a batch at rest."""
    groups = {"flow": lattice.allocate(cases, sections), "wake": wake.allocate(cases)}
    # Velocities of long wakes are computed before each step on all threads.
    long_wakes = LongWakes(cases, groups["wake"], groups["flow"], body.failed, threads)
    types = {"flow": lattice.Lattice, "wake": wake.Wake}
    used = uses(cases)
    return Flow(groups, types, prepare, settle, record, record_step, used, long_wakes, long_wakes.first)


@ti.func
def load_modes(body: View, flow: View, b, rule, used: View):
    """Modal force and its response to the modal acceleration.

    Unsteady Bernoulli (Eq. 33) with the second-order d(Gamma)/dt: `-rho (u_t Gamma + dPhi/dt dy)` along e_z, with the
    tangential velocity u_t. The jump of potential Phi is the running sum of Gamma. With `loads = "vortices"` it changes
    at the vortices, where the steady part acts; with "panels" it is uniform over each panel, and the steady part acts
    at the panel's midpoint.
    """
    modes = body.modes[b]
    for column in range(modes + 1):
        running = 0.0
        change_ahead = 0.0
        if ti.static(used.shedding):
            if flow.size[b, SHEDDING] == 1:
                running, change_ahead = leading_edge.potential(flow, b, column, rule)
        for i in range(flow.size[b, PANELS]):
            scale = -flow.scalar[b, DENSITY] * flow.panel[b, SPAN, i]
            circulation = flow.solution[b, column, i]
            running += circulation
            change = rule[C0] * running
            if column == 0:
                change += rule[C1] * flow.panel[b, SUM, i] + rule[C2] * flow.panel[b, SUM_BEFORE, i]
            along, _ = acting_tangent(flow, b, i)
            steady = flow.panel[b, TANGENTIAL, i] * circulation * along
            for j in range(modes):
                share = steady * flow.shape[b, j, ACT, i]
                share += change_ahead * flow.shape[b, j, AHEAD, i] + change * flow.shape[b, j, BEHIND, i]
                if column == 0:
                    body.load[b, j] = body.load[b, j] + scale * share
                else:
                    body.response[b, j, column - 1] = body.response[b, j, column - 1] + rule[BETA] * scale * share
            change_ahead = change
    if ti.static(used.suction):
        if flow.scalar[b, FACTOR] > 0.0:
            _, normal = tangential.suction_force(body, flow, b)
            for j in range(modes):
                body.load[b, j] = body.load[b, j] + flow.shape[b, j, NODE, 0] * normal


@ti.func
def acting_tangent(flow: View, b, i):
    """Unit tangent at the point where a panel's steady force acts."""
    along = flow.at[b, VORTEX, ALONG, i]
    across = flow.at[b, VORTEX, ACROSS, i]
    if flow.size[b, WHOLE] == 1:
        along = (flow.at[b, NODE, Y, i + 1] - flow.at[b, NODE, Y, i]) / flow.panel[b, LENGTH, i]
        across = (flow.at[b, NODE, Z, i + 1] - flow.at[b, NODE, Z, i]) / flow.panel[b, LENGTH, i]
    return along, across


@ti.func
def along_chord(body: View, flow: View, b, bound, used: View):
    """Normal and axial force and moment of leading-edge suction and friction."""
    normal, axial, moment = 0.0, 0.0, 0.0
    if ti.static(used.suction):
        if flow.scalar[b, FACTOR] > 0.0:
            axial, normal = tangential.suction_force(body, flow, b)
            moment = flow.at[b, NODE, Y, 0] * normal - flow.at[b, NODE, Z, 0] * axial
    if ti.static(used.friction):
        rubs, turns = tangential.friction(flow, b, bound)
        axial += rubs
        moment += turns
    return normal, axial, moment


@ti.func
def circulate(body: View, flow: View, wakes: View, b, rule, used: View):
    """Circulation, new vortex and forces at the step's modal rates.

    The force of a pressure dP on a piece of the camber line is `dP * span * (-dz, dy)` and its moment about the pivot
    `dP * span * d(r^2)/2`, for any shape of the piece (Eq. 34 has c instead of the span).
    """
    total_normal = 0.0
    total_axial = 0.0
    total_moment = 0.0
    total_unsteady = 0.0
    running = 0.0
    change_ahead = 0.0
    bound = 0.0
    new = 0.0
    if ti.static(used.shedding):
        if flow.size[b, SHEDDING] == 1:
            running, change_ahead, new = leading_edge.settle(body, flow, wakes, b, rule)
    for i in range(flow.size[b, PANELS]):
        scale = -flow.scalar[b, DENSITY] * flow.panel[b, SPAN, i]
        circulation = circulation_at(body, flow, body.q, b, i)
        running += circulation
        bound += circulation
        change = rule[C0] * running + rule[C1] * flow.panel[b, SUM, i] + rule[C2] * flow.panel[b, SUM_BEFORE, i]
        flow.panel[b, SUM_BEFORE, i] = flow.panel[b, SUM, i]
        flow.panel[b, SUM, i] = running
        flow.panel[b, CIRCULATION, i] = circulation
        y_0, z_0 = flow.at[b, NODE, Y, i], flow.at[b, NODE, Z, i]
        y_1, z_1 = flow.at[b, NODE, Y, i + 1], flow.at[b, NODE, Z, i + 1]
        y_step, z_step = flow.at[b, VORTEX, Y, i], flow.at[b, VORTEX, Z, i]
        y_act, z_act = y_step, z_step
        if flow.size[b, WHOLE] == 1:
            y_step, z_step = y_0, z_0
            y_act, z_act = between(y_0, y_1, 0.5), between(z_0, z_1, 0.5)
        steady = scale * flow.panel[b, TANGENTIAL, i] * circulation
        along, across = acting_tangent(flow, b, i)
        unsteady = scale * (change_ahead * (y_step - y_0) + change * (y_1 - y_step))
        normal = steady * along + unsteady
        total_normal += normal
        total_unsteady += unsteady
        total_axial -= steady * across + scale * (change_ahead * (z_step - z_0) + change * (z_1 - z_step))
        total_moment += steady * (y_act * along + z_act * across)
        inner, middle, outer = y_0 * y_0 + z_0 * z_0, y_step * y_step + z_step * z_step, y_1 * y_1 + z_1 * z_1
        total_moment += 0.5 * scale * (change_ahead * (middle - inner) + change * (outer - middle))
        flow.panel[b, PRESSURE, i] = normal / (flow.panel[b, SPAN, i] * (y_1 - y_0))
        change_ahead = change
    wakes.vortex[b, CIRCULATION, wakes.ring[b, YOUNGEST]] = flow.scalar[b, TOTAL] - bound - new
    flow.scalar[b, TOTAL] = bound
    normal, axial, moment = along_chord(body, flow, b, bound, used)
    total_normal += normal
    total_axial += axial
    total_moment += moment
    body.force[b, NORMAL] = total_normal
    body.force[b, AXIAL] = total_axial
    body.force[b, MOMENT] = total_moment
    body.force[b, UNSTEADY] = total_unsteady


def hold(batch: Any) -> tuple[Any, Any]:
    """Lattice and wake of a batch, their arrays held; call it inside `ti.static`."""
    return held(batch.flow, *lattice.HELD), held(batch.wake, *wake.HELD)


@ti.func
def prepare(batch: View, b, n, rule, used: View):
    """Geometry, circulation (linear in the modal acceleration) and modal force of step `n`."""
    flow, wakes = ti.static(hold(batch))
    advance(batch.body, flow, wakes, b, n, rule, used)


@ti.func
def advance(body: View, flow: View, wakes: View, b, n, rule, used: View):
    panels = flow.size[b, PANELS]
    if n > 0:
        dt = body.dt[b]
        wake.convect(wakes, flow.panel, panels, flow.scalar, b, n, dt, used.single_precision, used.gusts)
    if ti.static(used.gusts):
        carry_gust(flow.scalar, b, n * body.dt[b])
    lattice.place_panels(body, flow, b, n)
    lattice.reflect_crossings(body, flow, wakes, b, n)
    lattice.shed_vortex(body, flow, wakes, b, n, used)
    lattice.wake_at_panels(body, flow, wakes, b, n)
    if ti.static(used.gusts):
        lattice.gust_at_panels(body, flow, b, n)
    lattice.assemble(body, flow, b, n)
    if ti.static(used.shedding):
        if flow.size[b, SHEDDING] == 1:
            leading_edge.place(body, flow, wakes, b, n)
            leading_edge.wake_at_edge(body, flow, wakes, b, n)
            leading_edge.assemble(body, flow, b)
    lattice.solve(body, flow, b)
    if ti.static(used.shedding):
        if flow.size[b, SHEDDING] == 1:
            leading_edge.measure(body, flow, wakes, b, n)
            leading_edge.shed(body, flow, wakes, b, n)
    if flow.size[b, WHOLE] == 1:
        tangential.past_points(body, flow, b, n)
    if ti.static(used.suction or used.loads_at_vortices):
        if flow.size[b, WHOLE] == 0 or flow.scalar[b, FACTOR] > 0.0:
            tangential.expect_circulation(body, flow, wakes, b)
    if ti.static(used.loads_at_vortices):
        if flow.size[b, WHOLE] == 0:
            tangential.past_vortices(body, flow, wakes, b, n)
    if ti.static(used.suction):
        if flow.scalar[b, FACTOR] > 0.0:
            tangential.leading_edge_suction(body, flow, wakes, b, n)
    load_modes(body, flow, b, rule, used)


@ti.func
def settle(batch: View, b, n, rule, used: View):
    """Circulation, new vortices and forces of step `n` at the known modal acceleration."""
    flow, wakes = ti.static(hold(batch))
    circulate(batch.body, flow, wakes, b, rule, used)


BOUND, CROSSED, LOST, FAR, SUCTION_VELOCITY, FROM_LEADING, FROM_TRAILING, EDGE_SHEDS = range(8)
"""Columns of the stored series, in the order in which the model declares them."""


@ti.func
def record_step(batch: View, b, row):
    batch.output.series[b, row, BOUND] = batch.flow.scalar[b, TOTAL]
    batch.output.series[b, row, CROSSED] = ti.cast(batch.wake.ring[b, CROSSINGS], ti.f64)
    batch.output.series[b, row, LOST] = ti.sqrt(batch.wake.scalar[b, LOST_Y] ** 2 + batch.wake.scalar[b, LOST_Z] ** 2)
    batch.output.series[b, row, FAR] = batch.wake.scalar[b, FAR_ERROR]
    batch.output.series[b, row, SUCTION_VELOCITY] = batch.flow.scalar[b, SPEED]
    batch.output.series[b, row, FROM_LEADING] = batch.flow.scalar[b, RELEASED]
    batch.output.series[b, row, FROM_TRAILING] = -batch.flow.scalar[b, TOTAL] - batch.flow.scalar[b, RELEASED]
    batch.output.series[b, row, EDGE_SHEDS] = batch.flow.scalar[b, SHEDS]


@ti.func
def record(batch: View, b, frame):
    for i in range(batch.flow.size[b, PANELS]):
        batch.output.panel_circulation[b, frame, i] = ti.cast(batch.flow.panel[b, CIRCULATION, i], ti.f32)
        batch.output.pressure_jump[b, frame, i] = ti.cast(batch.flow.panel[b, PRESSURE, i], ti.f32)
    batch.output.wake_count[b, frame] = batch.wake.ring[b, COUNT]
    for m in range(batch.wake.ring[b, COUNT]):
        place = (batch.wake.ring[b, OLDEST] + m) % batch.wake.ring[b, CAPACITY]
        batch.output.wake_y[b, frame, m] = ti.cast(batch.wake.vortex[b, Y, place], ti.f32)
        batch.output.wake_z[b, frame, m] = ti.cast(batch.wake.vortex[b, Z, place], ti.f32)
        batch.output.wake_circulation[b, frame, m] = ti.cast(batch.wake.vortex[b, CIRCULATION, place], ti.f32)
        batch.output.wake_birth[b, frame, m] = batch.wake.origin[b, SHED_AT, place]
        batch.output.wake_edge[b, frame, m] = batch.wake.origin[b, SHED_FROM, place]
