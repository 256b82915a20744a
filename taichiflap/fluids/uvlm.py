"""Unsteady vortex lattice: loads of a lumped-vortex lattice on the deformed camber line, with a free wake.

Reade & Jankauski (2020), Eqs 28-34; `taichiflap.lattice` holds Eqs 28-31, `taichiflap.wake` Eqs 29 and 32.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import lattice, wake
from ..beam import Modes
from ..body import AXIAL, BETA, C0, C1, C2, MOMENT, NORMAL, UNSTEADY
from ..case import Case
from ..lattice import between, circulation_at
from ..runtime import Floats2, Ints2, Ints3, Singles3, Singles4, View, ti
from ..vortex import CIRCULATION, Y, Z
from ..wake import COUNT, KEEP, OLDEST, YOUNGEST

Film = ti.types.argpack(
    circulation=Floats2,
    panel_circulation=Singles3,
    pressure_jump=Singles3,
    wake_count=Ints2,
    wake=Singles4,  # (case, frame, 3, vortex), first shed first
    wake_birth=Ints3,
)

GROUPS = {"flow": lattice.Lattice, "wake": wake.Wake, "film": Film}

nodes = lattice.nodes


def allocate(cases: Sequence[Case], sections: Sequence[Modes]) -> dict[str, Any]:
    """Arrays of the lattices and wakes of a batch."""
    return {"flow": lattice.allocate(cases, sections), "wake": wake.allocate(cases)}


def film(cases: Sequence[Case], frames: int) -> Any:
    """Room for `frames` frames of the fields along the chord and of the wake."""
    count = len(cases)
    panels = max(case.uvlm.panels for case in cases)
    vortices = max(wake.ring_size(case) for case in cases)
    return Film(
        circulation=ti.ndarray(ti.f64, (count, frames)),
        panel_circulation=ti.ndarray(ti.f32, (count, frames, panels)),
        pressure_jump=ti.ndarray(ti.f32, (count, frames, panels)),
        wake_count=ti.ndarray(ti.i32, (count, frames)),
        wake=ti.ndarray(ti.f32, (count, frames, 3, vortices)),
        wake_birth=ti.ndarray(ti.i32, (count, frames, vortices)),
    )


def trim(frames: dict[str, np.ndarray], case: Case) -> dict[str, np.ndarray]:
    """One case's share of the padded frames of a batch, its wake as contiguous ragged arrays."""
    panels = {name: frames[name][:, : case.uvlm.panels] for name in ("panel_circulation", "pressure_jump")}
    return frames | panels | wake.in_order(frames)


def work(case: Case, step: int) -> float:
    """Cost of a step, in pair interactions (about a nanosecond): the wake grows until it is full."""
    panels, vortices = case.uvlm.panels, min(step + 1, wake.ring_size(case))
    return (vortices + panels) ** 2 + panels**3 / 10.0


def frame_bytes(case: Case) -> float:
    """Size of a frame's fields."""
    return 16.0 * wake.ring_size(case) + 8.0 * case.uvlm.panels


@ti.func
def load_modes(body: View, flow: View, b, rule):
    """Modal force and its response to the modal acceleration.

    Unsteady Bernoulli (Eq. 33) on every panel, with the second-order d(Gamma)/dt; the force of a panel
    `dP * span * length` (Eq. 34 prints c for the span) acts along its normal at its middle.
    """
    modes = body.modes[b]
    for column in range(modes + 1):
        running = 0.0
        for i in range(flow.panels[b]):
            circulation = flow.solution[b, column, i]
            running += circulation
            change = rule[C0] * running
            if column == 0:
                change += rule[C1] * flow.sums[b, 0, i] + rule[C2] * flow.sums[b, 1, i]
            lift = flow.slip[b, i] * circulation + change * flow.length[b, i]
            force = -flow.density[b] * flow.span[b] * lift * flow.tangent[b, Y, i]
            for j in range(modes):
                share = between(flow.shape[b, j, i], flow.shape[b, j, i + 1], 0.5) * force
                if column == 0:
                    body.load[b, j] = body.load[b, j] + share
                else:
                    body.response[b, j, column - 1] = body.response[b, j, column - 1] + rule[BETA] * share


@ti.func
def circulate(body: View, flow: View, wakes: View, b, rule):
    """Circulation, new vortex and forces with the modal rates that the step has come to."""
    total_normal = 0.0
    total_axial = 0.0
    total_moment = 0.0
    total_unsteady = 0.0
    running = 0.0
    for i in range(flow.panels[b]):
        circulation = circulation_at(body, flow, body.q, b, i)
        running += circulation
        change = rule[C0] * running + rule[C1] * flow.sums[b, 0, i] + rule[C2] * flow.sums[b, 1, i]
        flow.sums[b, 1, i] = flow.sums[b, 0, i]
        flow.sums[b, 0, i] = running
        flow.bound[b, CIRCULATION, i] = circulation
        length = flow.length[b, i]
        pressure = -flow.density[b] * (flow.slip[b, i] * circulation / length + change)
        flow.pressure[b, i] = pressure
        area = flow.span[b] * length
        normal = pressure * area * flow.tangent[b, Y, i]
        axial = -pressure * area * flow.tangent[b, Z, i]
        total_normal += normal
        total_axial += axial
        total_moment += between(flow.node[b, Y, i], flow.node[b, Y, i + 1], 0.5) * normal
        total_moment -= between(flow.node[b, Z, i], flow.node[b, Z, i + 1], 0.5) * axial
        total_unsteady -= flow.density[b] * change * area * flow.tangent[b, Y, i]
    wakes.vortex[b, CIRCULATION, wakes.ring[b, YOUNGEST]] = flow.total[b] - running
    flow.total[b] = running
    body.force[b, NORMAL] = total_normal
    body.force[b, AXIAL] = total_axial
    body.force[b, MOMENT] = total_moment
    body.force[b, UNSTEADY] = total_unsteady


@ti.func
def prepare(batch: View, b, n, rule):
    """Geometry and circulation of the coming step `n`, linear in the modal acceleration; its modal force."""
    panels = batch.flow.panels[b]
    if n > 0:
        wake.convect(batch.wake, batch.flow.bound, panels, batch.flow.stream, b, batch.body.dt[b])
    lattice.lay_panels(batch.body, batch.flow, b, n)
    lattice.shed_vortex(batch.body, batch.flow, batch.wake, b, n)
    lattice.wash_panels(batch.body, batch.flow, batch.wake, b, n)
    lattice.assemble(batch.body, batch.flow, b, n)
    lattice.solve(batch.body, batch.flow, b)
    lattice.slip_past_panels(batch.body, batch.flow, b, n)
    load_modes(batch.body, batch.flow, b, rule)


@ti.func
def settle(batch: View, b, n, rule):
    """Circulation, new vortex and forces of step `n` once its modal acceleration is known."""
    circulate(batch.body, batch.flow, batch.wake, b, rule)


@ti.func
def record(batch: View, b, frame):
    batch.film.circulation[b, frame] = batch.flow.total[b]
    for i in range(batch.flow.panels[b]):
        batch.film.panel_circulation[b, frame, i] = ti.cast(batch.flow.bound[b, CIRCULATION, i], ti.f32)
        batch.film.pressure_jump[b, frame, i] = ti.cast(batch.flow.pressure[b, i], ti.f32)
    batch.film.wake_count[b, frame] = batch.wake.ring[b, COUNT]
    for m in range(batch.wake.ring[b, COUNT]):
        place = (batch.wake.ring[b, OLDEST] + m) % batch.wake.ring[b, KEEP]
        batch.film.wake_birth[b, frame, m] = batch.wake.birth[b, place]
        for axis in range(3):
            batch.film.wake[b, frame, axis, m] = ti.cast(batch.wake.vortex[b, axis, place], ti.f32)
