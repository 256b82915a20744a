"""A batch of flows in motion.

Two-dimensional incompressible flow about one thin section, rigid or bending, by vorticity and streamfunction on a
conformal grid; see `docs/theory/navier_stokes.md`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...case.case import Case
from ...kernels.held import held
from ...kernels.runtime import Octet, View, ti, view
from ...march.state import BEFORE, BETA
from ...march.stream import carry_gust
from ...structure.beam import Modes
from ..interface import Flow
from .arrays import (
    CORNER_COS,
    COURANT,
    DPHI,
    FELT,
    FLUX,
    FRICTION,
    GRADIENT,
    HELD,
    INVERSE,
    LENGTH,
    NU,
    OCTETS,
    PASCAL,
    ROWS,
    RUBBED_Y,
    RUBBED_Z,
    SOURCE,
    STORED,
    UNMAPPED,
    Arrays,
)
from .batch import allocate
from .corners import place_corners, place_wall
from .factors import step_rows
from .influence import invert_influence, lane, respond
from .loads import load_modes, sum_forces
from .mapping import find_map
from .poisson import transform_inwards, transform_outwards
from .settings import settings
from .transport import size
from .wall import (
    feed_rows,
    hold_wall,
    move_wall,
    pivot,
    settle_wall,
)

PASSES = 0
"""Level of Taichi's passes: one of them takes time in the square of the kernel's length."""
FURTHEST = 0.6
"""Tip deflection, chords, that the map of a bent section is good to."""
REFRESH = 25
"""Steps after which the influence matrix of a bending section is inverted anew."""

LOST = 13
"""Bits of a stored vorticity's mantissa, of 23, that are zero: it is right within 2^-11 of itself."""
LEAST = 1e-3
"""Least vorticity that is stored, in viscosities over the chord squared."""

FRICTION_NORMAL, FRICTION_AXIAL, LARGEST_COURANT = range(3)
"""The series, as the model declares them."""


@dataclass(frozen=True)
class Uses:
    """Features of the model that some case of a batch needs; the kernel contains only these."""

    bending: bool
    gusts: bool


def flow(cases: Sequence[Case], sections: Sequence[Modes], body: Any) -> Flow:
    """A batch at its first step.

    Raises:
        ResolutionError: when the cells of a case cannot resolve its flow.
    """
    used = Uses(any(section.count for section in sections), any(case.fluid.gust != "none" for case in cases))
    groups = {"flow": allocate(cases, sections)}

    def reason(b: int, step: int) -> str:
        return unmapped(cases[b], sections[b], view(body.q)[b, BEFORE], step) if failed_map(b) else ""

    def failed_map(b: int) -> bool:
        return bool(view(groups["flow"].size)[b, UNMAPPED])

    return Flow(groups, {"flow": Arrays}, prepare, settle, record, record_step, used, passes=PASSES, reason=reason)


def unmapped(case: Case, modes: Modes, q: Any, step: int) -> str:
    """Reason why a case stopped because its section is bent too far for the map."""
    tip = abs(float(modes.shape([case.wing.chord])[:, 0] @ q[: modes.count])) / case.wing.chord
    return (
        f"the map of the bent section did not converge at step {step} (t = {step * case.step:.4g} s), with the "
        f"trailing edge {tip:.3g} chords from the chord; it is good to about {FURTHEST:g}. May help: a stiffer "
        f"wing; navier_stokes.thickness = {2.0 * settings(case).thickness:g}"
    )


@ti.func
def prepare(batch: View, b, n, rule, used: View):
    """Modal force of the coming step `n`."""
    advance(batch.body, ti.static(held(batch.flow, *HELD)), b, n, rule, used)


@ti.func
def settle(batch: View, b, n, rule, used: View):
    """Complete step `n` with the known modal acceleration."""
    complete(batch.body, ti.static(held(batch.flow, *HELD)), b, n, used)


@ti.func
def advance(body: View, flow: View, b, n, rule, used: View):
    """Advance the vorticity to step `n`, except for the wall flux due to the modal rates; load and response."""
    beta = rule[BETA]
    bends = False
    if ti.static(used.bending):
        bends = body.modes[b] > 0
    mapped = True
    if ti.static(used.bending):
        if bends and n > 0:
            mapped = find_map(body, flow, b)
            place_corners(flow, b, n, body.dt[b])
            place_wall(body, flow, b)
    if ti.static(used.gusts):
        carry_gust(flow.gust, b, n * body.dt[b])
    move_wall(body, flow, b, n, used)
    if n > 0:
        if n <= 2 or bends:
            respond(flow, b, beta)
        if n <= 2 or (bends and n % REFRESH == 0):
            invert_influence(flow, b)
        step_rows(flow, b, n, beta, bends)
    transform_inwards(flow, b, flow.size[b, ROWS], n > 0, 1 + body.modes[b], bends)
    if n > 0:
        hold_wall(body, flow, b)
    load_modes(body, flow, b, n, rule)
    if not mapped:
        body.load[b, 0] = ti.math.nan
        flow.size[b, UNMAPPED] = n


@ti.func
def complete(body: View, flow: View, b, n, used: View):
    """With the modal acceleration of step `n` known: vorticity, fluxes and forces."""
    bends = False
    if ti.static(used.bending):
        bends = body.modes[b] > 0
    tangent = settle_wall(body, flow, b, n)
    if n > 0:
        feed_rows(flow, b, bends)
        transform_inwards(flow, b, flow.size[b, FELT], False, 0, bends)
    inner = flow.spectra[b, 0, 0]
    circulation = (0.0 - tangent) - inner[0]
    v_y, v_z, _, _ = pivot(body, flow, b, n)
    transform_outwards(body, flow, b, n, v_y, v_z, circulation, bends, used)
    sum_forces(body, flow, b, n)
    if n == 0:
        # The first step finds its flux without a guess.
        for m in range(flow.size[b, OCTETS]):
            flow.line[b, FLUX, m] = Octet(0.0)


@ti.func
def record_step(batch: View, b, row):
    batch.output.series[b, row, FRICTION_NORMAL] = batch.flow.number[b, RUBBED_Z]
    batch.output.series[b, row, FRICTION_AXIAL] = batch.flow.number[b, RUBBED_Y]
    batch.output.series[b, row, LARGEST_COURANT] = batch.flow.number[b, COURANT]


@ti.func
def record(batch: View, b, frame):
    store_wall(batch.flow, batch.output, b, frame)
    store_fields(batch.flow, batch.output, b, frame, batch.body.dt[b])


@ti.func
def store_wall(flow: View, output: View, b, frame):
    """Pressure jump and friction at the pairs of opposite cells along the chord, from the leading edge."""
    points = 8 * flow.size[b, OCTETS]
    half = points // 2
    # The pressure from its gradient, by the integral of a cubic through four points, from one end of the wall's
    # circle on.
    pressure = 0.0
    weight = flow.number[b, DPHI] * flow.number[b, PASCAL]
    for i in range(points):
        flow.line[b, SOURCE, i // 8][i % 8] = pressure
        step = 13.0 * (lane(flow.line, b, GRADIENT, i) + lane(flow.line, b, GRADIENT, (i + 1) % points))
        step -= lane(flow.line, b, GRADIENT, (i + points - 1) % points) + lane(flow.line, b, GRADIENT, (i + 2) % points)
        pressure -= step * weight / 24.0
    for p in range(half):
        upper, lower = half - 1 - p, half + p
        # By the width of each side's cell over that of the straight section's: a bent section's cells lie a little
        # aside.
        width = lane(flow.line, b, CORNER_COS, lower) - lane(flow.line, b, CORNER_COS, lower - 1)
        below = lane(flow.corner_y, b, 0, lower) - lane(flow.corner_y, b, 0, lower - 1)
        above = lane(flow.corner_y, b, 0, (upper + points - 1) % points) - lane(flow.corner_y, b, 0, upper)
        jump = lane(flow.line, b, SOURCE, lower) * below - lane(flow.line, b, SOURCE, upper) * above
        rubbed = lane(flow.line, b, FRICTION, lower) - lane(flow.line, b, FRICTION, upper)
        output.pressure_jump[b, frame, p] = ti.cast(2.0 * jump / width, ti.f32)
        output.shear[b, frame, p] = ti.cast(rubbed * flow.number[b, PASCAL], ti.f32)


@ti.func
def rounded(x, least):
    """A number in single precision with the last bits of its mantissa zero, and zero below `least`: shorter when
    compressed."""
    bits = ti.bit_cast(ti.cast(x, ti.f32), ti.i32)
    found = ti.bit_cast((bits + (1 << (LOST - 1))) & (-1 << LOST), ti.f32)
    return ti.select(ti.abs(x) < least, ti.cast(0.0, ti.f32), found)


@ti.func
def store_fields(flow: View, output: View, b, frame, dt):
    """Vorticity and the map; and the Courant number."""
    octets = flow.size[b, OCTETS]
    courant = Octet(flow.number[b, COURANT])
    least = LEAST * flow.number[b, NU]
    for j in range(flow.size[b, ROWS]):
        scale = dt * flow.row[b, j, INVERSE]
        for m in range(octets):
            w = flow.vorticity[b, j, m]
            for at in ti.static(range(8)):
                output.vorticity[b, frame, j, 8 * m + at] = rounded(w[at], least)
            through = ti.max(size(flow.flux_rho[b, j, m]), size(flow.flux_rho[b, j + 1, m])) + size(
                flow.flux_phi[b, j, m]
            )
            courant = ti.max(courant, through * scale / flow.area[b, j, m])
    for at in ti.static(range(8)):
        flow.number[b, COURANT] = ti.max(flow.number[b, COURANT], courant[at])
    for n in range(flow.size[b, STORED]):
        for part in range(2):
            output.map[b, frame, n, part] = flow.coefficient[b, n, part] * flow.number[b, LENGTH]
