"""The free wake: point vortices in a ring buffer, shed from the edges of the wing and convected by the flow.

Reade & Jankauski (2020), Eqs 29 and 32 (whose wake sum should run over the wake instead of the panels). The strength of
a vortex changes only by merging and absorption (`merging`).
"""

import math
from collections.abc import Sequence
from typing import Any

from ...case.case import Case
from ...kernels.arrays import array, zeros
from ...kernels.runtime import Floats2, Floats3, Ints2, Ints3, Singles3, View, ti
from ...march.stream import EDGE, KIND, gust_at
from ...vortex.sum import (
    CIRCULATION,
    CORE2,
    TINY,
    TINY_SINGLE,
    Sixteen,
    Y,
    Z,
    induce,
    induce_single,
    octet,
    sixteen,
    store_octet,
)
from .stations import SHARE, ring_size, shed_a_step

LEAST_TRAVEL = 2e-4
"""Minimum distance, in chords, of a new vortex behind the trailing edge; the travel vanishes at stroke reversal."""

TRAILING, LEADING = range(2)
"""Edge from which a vortex was shed."""

MERGE_FROM = 1.5
"""Minimum distance from mid-chord, in chords, at which vortices may merge."""

CAPACITY, COUNT, OLDEST, YOUNGEST, CARRIED, CROSSINGS, YOUNGEST_LEADING = range(7)
"""Entries of a ring: capacity, number of vortices, indices of the oldest vortex and of the youngest from the trailing
edge, step for which velocities are computed already, number of wake-wing crossings, and index of the youngest vortex
from the leading edge.
"""

LOST_Y, LOST_Z, DROPPED, FAR_ERROR = range(4)
"""First columns of `scalar`: velocity lost at the wing by dropping and absorption, along Y and Z, m/s; circulation of
the dropped vortices, m2/s; and largest error of a far sum, m/s.
"""
(ALONG_PATH, DISTANCE, AB2, CORE, GROWTH, ABSORBS, ABSORB_BEYOND, DECAY, REFLECTS, SINGLE, SHED_A_STEP, MERGES,
 MERGE_BEYOND, SPREAD) = range(4, 18)  # fmt: skip
"""Next columns, the settings: position of new vortices on the trailing edge's path (0: at a fixed distance); that
distance, or the minimum distance, m; weight of the velocity change in convection (Adams-Bashforth: 1/2; Euler: 0); full
core, m; core growth per distance moved (0: full at once); 1 if a full ring absorbs, 0 if it drops; distance from the
wing within which absorption is avoided, m; decay of the lost velocity per step; 1 if crossing vortices are reflected; 1
for pair sums in single precision; maximum number of vortices shed per step; allowed velocity change of merging, m/s (0:
no merging), and minimum distance from mid-chord for merging, m; increase of the squared core by viscosity per step, m2.
"""
HEIGHT, VELOCITY, BEFORE, ROWS = 4, 5, 7, 9
"""Rows of `vortex` after those of `taichiflap.vortex`: height above the wing, m (0: beyond the edges); first rows of
the velocities, now and one step earlier, m/s; and the number of rows.
"""
SHED_AT, SHED_FROM = range(2)
"""Rows of `origin`: step of shedding, and edge, TRAILING or LEADING."""

Wake = ti.types.argpack(
    ring=Ints2,  # (case, column), and the others: see the names of the columns and rows
    scalar=Floats2,
    vortex=Floats3,  # (case, row, index)
    origin=Ints3,
    single=Singles3,  # (case, 4, index): bound vortices and then the wake's, for sums in single precision
)

HELD = ("vortex",), ("origin",)
"""Arrays whose shapes the kernel reads once, see `taichiflap.kernels.held`."""


def allocate(cases: Sequence[Case]) -> Any:
    """Empty wakes of a batch."""
    keep = [ring_size(case) for case in cases]
    single = any(case.uvlm.precision == "single" for case in cases)
    panels = max(case.uvlm.panels for case in cases)
    # Sums process eight or sixteen entries at a time.
    count, most = len(cases), 16 * -(-max(keep) // 16)
    return Wake(
        ring=array([[size, 0, 0, 0, 0, 0, 0] for size in keep]),
        scalar=array([[0.0] * ALONG_PATH + _settings(case) for case in cases]),
        vortex=zeros(ti.f64, count, ROWS, most),
        origin=zeros(ti.i32, count, 2, most),
        single=zeros(ti.f32, count, 4, most + panels if single else 1),
    )


def _settings(case: Case) -> list[float]:
    chord, uvlm = case.wing.chord, case.uvlm
    local = uvlm.shedding == "local"
    return [
        SHARE[uvlm.spacing] if local else 0.0,
        chord * (LEAST_TRAVEL if local else uvlm.shedding_distance),
        0.5 if uvlm.convection == "second_order" else 0.0,
        uvlm.core * chord,
        uvlm.core_growth,
        float(uvlm.old_wake == "absorb"),
        uvlm.absorb_beyond * chord,
        math.exp(-case.step / case.beat),
        float(uvlm.crossing == "reflect"),
        float(uvlm.precision == "single"),
        float(shed_a_step(case)),
        uvlm.merge_error * case.reference_speed if uvlm.merge_error else 0.0,
        MERGE_FROM * chord,
        4.0 * (case.fluid.viscosity or 0.0) * case.step,
    ]


@ti.func
def shed(wake: View, b, n, edge, y, z):
    """Add a vortex at (y, z), with zero circulation so far, at a free index or in place of the oldest."""
    place = wake.ring[b, COUNT]
    if place < wake.ring[b, CAPACITY]:
        wake.ring[b, COUNT] = place + 1
    else:
        place = wake.ring[b, OLDEST]
        wake.ring[b, OLDEST] = (place + 1) % wake.ring[b, CAPACITY]
        wake.scalar[b, DROPPED] = wake.scalar[b, DROPPED] + wake.vortex[b, CIRCULATION, place]
    if edge == LEADING:
        wake.ring[b, YOUNGEST_LEADING] = place
    else:
        wake.ring[b, YOUNGEST] = place
    wake.vortex[b, Y, place] = y
    wake.vortex[b, Z, place] = z
    wake.vortex[b, CIRCULATION, place] = 0.0
    wake.vortex[b, CORE2, place] = 0.0
    wake.vortex[b, HEIGHT, place] = 0.0
    grow_core(wake, b, place, 0.0, 0.0)
    wake.origin[b, SHED_AT, place] = n
    wake.origin[b, SHED_FROM, place] = edge


@ti.func
def core2_at_birth(wake: View, b):
    """Initial squared core of a vortex, m2."""
    core = wake.scalar[b, CORE]
    if wake.scalar[b, GROWTH] > 0.0:
        core = 0.0
    return core * core


@ti.func
def move(wake: View, b, source, to):
    """Move a vortex from one index to another."""
    for row in range(ROWS):
        wake.vortex[b, row, to] = wake.vortex[b, row, source]
    wake.origin[b, SHED_AT, to] = wake.origin[b, SHED_AT, source]
    wake.origin[b, SHED_FROM, to] = wake.origin[b, SHED_FROM, source]
    if wake.ring[b, YOUNGEST] == source:
        wake.ring[b, YOUNGEST] = to
    if wake.ring[b, YOUNGEST_LEADING] == source:
        wake.ring[b, YOUNGEST_LEADING] = to


@ti.func
def carry(wake: View, bound: View, panels, stream: View, b, first):
    """Velocity of eight wake vortices, starting at index `first`, due to all vortices and the free stream (Eq. 32)."""
    y = octet(wake.vortex, b, Y, first)
    z = octet(wake.vortex, b, Z, first)
    core2 = octet(wake.vortex, b, CORE2, first) + TINY
    w_y, w_z = induce(y, z, core2, wake.vortex, b, 0, wake.ring[b, COUNT])
    b_y, b_z = induce(y, z, core2, bound, b, 0, panels)
    store_octet(wake.vortex, b, VELOCITY + Y, first, w_y + b_y + stream[b, Y])
    store_octet(wake.vortex, b, VELOCITY + Z, first, w_z + b_z + stream[b, Z])


@ti.func
def narrow(wake: View, bound: View, panels, b):
    """Copy the bound and wake vortices to single precision."""
    for row in range(CORE2 + 1):
        for i in range(panels):
            wake.single[b, row, i] = ti.cast(bound[b, row, i], ti.f32)
        for i in range(wake.ring[b, COUNT]):
            wake.single[b, row, panels + i] = ti.cast(wake.vortex[b, row, i], ti.f32)


@ti.func
def carry_single(wake: View, panels, stream: View, b, first):
    """As `carry`, for sixteen wake vortices in single precision."""
    y = sixteen(wake.single, b, Y, panels + first)
    z = sixteen(wake.single, b, Z, panels + first)
    core2 = sixteen(wake.single, b, CORE2, panels + first) + Sixteen(TINY_SINGLE)
    u_y, u_z = induce_single(y, z, core2, wake.single, b, 0, panels + wake.ring[b, COUNT])
    for lane in ti.static(range(16)):
        wake.vortex[b, VELOCITY + Y, first + lane] = ti.cast(u_y[lane], ti.f64) + stream[b, Y]
        wake.vortex[b, VELOCITY + Z, first + lane] = ti.cast(u_z[lane], ti.f64) + stream[b, Z]


@ti.func
def carry_all(wake: View, bound: View, panels, stream: View, b, single: View):
    """Velocity of all wake vortices; the kernel contains sums in single precision only if a case needs them."""
    count = wake.ring[b, COUNT]
    if wake.scalar[b, SINGLE] > 0.0:
        if ti.static(single):
            narrow(wake, bound, panels, b)
            for block in range((count + 15) // 16):
                carry_single(wake, panels, stream, b, 16 * block)
    else:
        for block in range((count + 7) // 8):
            carry(wake, bound, panels, stream, b, 8 * block)


@ti.func
def convect(wake: View, bound: View, panels, stream: View, b, n, dt, single: View, gusts: View):
    """Convect every wake vortex from step `n - 1` to `n`.

    A new vortex has no previous velocity, so its first step is an Euler step.
    """
    count = wake.ring[b, COUNT]
    if wake.ring[b, CARRIED] != n:
        carry_all(wake, bound, panels, stream, b, single)
    if ti.static(gusts):
        if stream[b, KIND] > 0.0:
            for i in range(count):
                g_y, g_z = gust_at(stream, b, wake.vortex[b, Y, i], wake.vortex[b, Z, i], stream[b, EDGE])
                wake.vortex[b, VELOCITY + Y, i] = wake.vortex[b, VELOCITY + Y, i] + g_y
                wake.vortex[b, VELOCITY + Z, i] = wake.vortex[b, VELOCITY + Z, i] + g_z
    for i in range(count):
        moved2 = 0.0
        for axis in range(2):
            now = wake.vortex[b, VELOCITY + axis, i]
            change = 0.0
            if wake.origin[b, SHED_AT, i] < n - 1:
                change = wake.scalar[b, AB2] * (now - wake.vortex[b, BEFORE + axis, i])
            wake.vortex[b, BEFORE + axis, i] = now
            step = dt * (now + change)
            moved2 += step * step
            wake.vortex[b, axis, i] = wake.vortex[b, axis, i] + step
        grow_core(wake, b, i, ti.sqrt(moved2), wake.scalar[b, SPREAD])


@ti.func
def grow_core(wake: View, b, i, moved, spread):
    """Let the core of a vortex grow with the distance moved, up to its full size, and by viscosity.

    A full core next to the edge would smear the Kutta condition. Viscosity adds `4 nu dt` to the squared core per step
    (Lamb-Oseen), even beyond the full size.
    """
    full = wake.scalar[b, CORE]
    gain = wake.scalar[b, GROWTH]
    core2 = wake.vortex[b, CORE2, i] + spread
    if core2 < full * full or spread == 0.0:
        core = full
        if gain > 0.0:
            core = ti.min(full, ti.sqrt(core2) + gain * moved)
        core2 = core * core
    wake.vortex[b, CORE2, i] = core2
