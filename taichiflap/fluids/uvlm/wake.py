"""The free wake: a ring of point vortices per case, shed at the edges of the wing and carried by the flow.

Reade & Jankauski (2020), Eqs 29 and 32 (whose wake sum runs over the wake, not over the panels). Vortices never
change strength, unless two are merged or a full ring absorbs one (`merging`) instead of giving up its oldest for the
new one.
"""

import math
from collections.abc import Sequence
from typing import Any

from ...case.case import Case
from ...kernels.arrays import array, zeros
from ...kernels.runtime import Floats2, Floats3, Ints2, Singles3, View, ti
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
"""Least distance, in chords, of a new vortex behind the trailing edge: at stroke reversal the travel vanishes."""

TRAILING, LEADING = range(2)
"""The edge that a vortex was shed from."""

MERGE_FROM = 1.5
"""Distance, in chords, from the middle of the wing within which no vortices are merged."""

CAPACITY, COUNT, OLDEST, YOUNGEST, CARRIED, CROSSINGS, YOUNGEST_LEADING = range(7)
"""Entries of a ring: its size, how many vortices it holds, the places of the first shed and of the last from the
trailing edge, the step for which the velocities are known beforehand, how often a vortex has come upon the wing, and
the place of the last shed from the leading edge."""

(ALONG_PATH, DISTANCE, AB2, CORE, GROWTH, ABSORBS, ABSORB_BEYOND, DECAY, REFLECTS, SINGLE, SHED_A_STEP, MERGES,
 MERGE_BEYOND, SPREAD) = range(14)  # fmt: skip
"""Settings of a wake: where new vortices stand on the trailing edge's path during a step (0: at a fixed distance);
that distance, m, or the least travel; how much of the change of a velocity since the last step is added to it
(Adams-Bashforth: 1/2; Euler: 0); full core, m; what a core gains per distance moved (0: full from the start);
whether a full ring absorbs (1) or drops (0); how near to the wing that is avoided, m; what is left after a step of what
was lost; whether the wing keeps vortices on their side (1); whether pairs are summed in single precision (1); how many
vortices are shed in a step at most; velocity that merging two may change at the wing, m/s (0: none are merged), and how
near to its middle none are, m; what viscosity adds to a squared core in a step, m2."""
DROPPED, FAR_ERROR = 2, 3
"""Columns of the tally, after the velocity at the wing of what was dropped or absorbed, m/s, along Y and Z: circulation
of the vortices given up, m2/s, and the largest error found in a far sum, m/s."""
HEIGHT = 4
"""Row of a wake's vortices after those of `taichiflap.vortex`."""
BEFORE = 2
"""First row of the velocities one step earlier."""

Wake = ti.types.argpack(
    ring=Ints2,
    setting=Floats2,  # (case, 14), see the names of its columns
    vortex=Floats3,  # (case, 5, place), see taichiflap.vortex; and how far above the wing it stands, m (0: beside it)
    velocity=Floats3,  # (case, 4, place): that of the vortices now, and that with which they moved last
    single=Singles3,  # (case, 4, index): bound vortices and then the wake's, where pairs are summed in single precision
    birth=Ints2,  # step of shedding
    edge=Ints2,  # TRAILING or LEADING
    tally=Floats2,
)


def allocate(cases: Sequence[Case]) -> Any:
    """Empty wakes of a batch."""
    keep = [ring_size(case) for case in cases]
    single = any(case.uvlm.precision == "single" for case in cases)
    panels = max(case.uvlm.panels for case in cases)
    # Sums fill eight places at a time, or sixteen.
    count, most = len(cases), 16 * -(-max(keep) // 16)
    return Wake(
        ring=array([[size, 0, 0, 0, 0, 0, 0] for size in keep]),
        setting=array([_settings(case) for case in cases]),
        vortex=zeros(ti.f64, count, 5, most),
        velocity=zeros(ti.f64, count, 4, most),
        single=zeros(ti.f32, count, 4, most + panels if single else 1),
        birth=zeros(ti.i32, count, most),
        edge=zeros(ti.i32, count, most),
        tally=zeros(ti.f64, count, 4),
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
    """Put a vortex of no circulation yet at (y, z), in a free place or in that of the oldest."""
    place = wake.ring[b, COUNT]
    if place < wake.ring[b, CAPACITY]:
        wake.ring[b, COUNT] = place + 1
    else:
        place = wake.ring[b, OLDEST]
        wake.ring[b, OLDEST] = (place + 1) % wake.ring[b, CAPACITY]
        wake.tally[b, DROPPED] = wake.tally[b, DROPPED] + wake.vortex[b, CIRCULATION, place]
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
    wake.birth[b, place] = n
    wake.edge[b, place] = edge


@ti.func
def core2_at_birth(wake: View, b):
    """Squared core of a vortex that has not moved yet, m2."""
    core = wake.setting[b, CORE]
    if wake.setting[b, GROWTH] > 0.0:
        core = 0.0
    return core * core


@ti.func
def move(wake: View, b, source, to):
    """Put the vortex at one place at another."""
    for row in range(HEIGHT + 1):
        wake.vortex[b, row, to] = wake.vortex[b, row, source]
    for row in range(4):
        wake.velocity[b, row, to] = wake.velocity[b, row, source]
    wake.birth[b, to] = wake.birth[b, source]
    wake.edge[b, to] = wake.edge[b, source]
    if wake.ring[b, YOUNGEST] == source:
        wake.ring[b, YOUNGEST] = to
    if wake.ring[b, YOUNGEST_LEADING] == source:
        wake.ring[b, YOUNGEST_LEADING] = to


@ti.func
def carry(wake: View, bound: View, panels, stream: View, b, first):
    """Velocity of eight wake vortices from place `first` on, from all vortices and the free stream (Eq. 32)."""
    y = octet(wake.vortex, b, Y, first)
    z = octet(wake.vortex, b, Z, first)
    core2 = octet(wake.vortex, b, CORE2, first) + TINY
    w_y, w_z = induce(y, z, core2, wake.vortex, b, 0, wake.ring[b, COUNT])
    b_y, b_z = induce(y, z, core2, bound, b, 0, panels)
    store_octet(wake.velocity, b, Y, first, w_y + b_y + stream[b, Y])
    store_octet(wake.velocity, b, Z, first, w_z + b_z + stream[b, Z])


@ti.func
def narrow(wake: View, bound: View, panels, b):
    """Copy the bound vortices and the wake's to where they are summed in single precision."""
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
        wake.velocity[b, Y, first + lane] = ti.cast(u_y[lane], ti.f64) + stream[b, Y]
        wake.velocity[b, Z, first + lane] = ti.cast(u_z[lane], ti.f64) + stream[b, Z]


@ti.func
def carry_all(wake: View, bound: View, panels, stream: View, b, single: View):
    """Velocity of all wake vortices; the kernel holds the sums in single precision only where a case wants them."""
    count = wake.ring[b, COUNT]
    if wake.setting[b, SINGLE] > 0.0:
        if ti.static(single):
            narrow(wake, bound, panels, b)
            for block in range((count + 15) // 16):
                carry_single(wake, panels, stream, b, 16 * block)
    else:
        for block in range((count + 7) // 8):
            carry(wake, bound, panels, stream, b, 8 * block)


@ti.func
def convect(wake: View, bound: View, panels, stream: View, gust: View, b, n, dt, single: View):
    """Carry every wake vortex from step `n - 1` to `n`.

    A vortex just shed has no velocity of an earlier step: it takes Euler's step, once.
    """
    count = wake.ring[b, COUNT]
    if wake.ring[b, CARRIED] != n:
        carry_all(wake, bound, panels, stream, b, single)
    if gust[b, KIND] > 0.0:
        for i in range(count):
            g_y, g_z = gust_at(gust, b, wake.vortex[b, Y, i], wake.vortex[b, Z, i], gust[b, EDGE])
            wake.velocity[b, Y, i] = wake.velocity[b, Y, i] + g_y
            wake.velocity[b, Z, i] = wake.velocity[b, Z, i] + g_z
    for i in range(count):
        moved2 = 0.0
        for axis in range(2):
            now = wake.velocity[b, axis, i]
            change = 0.0
            if wake.birth[b, i] < n - 1:
                change = wake.setting[b, AB2] * (now - wake.velocity[b, BEFORE + axis, i])
            wake.velocity[b, BEFORE + axis, i] = now
            step = dt * (now + change)
            moved2 += step * step
            wake.vortex[b, axis, i] = wake.vortex[b, axis, i] + step
        grow_core(wake, b, i, ti.sqrt(moved2), wake.setting[b, SPREAD])


@ti.func
def grow_core(wake: View, b, i, moved, spread):
    """Let the core of a vortex that has moved by a distance grow, up to its full size, and viscosity spread it.

    A full core beside the edge would blur the Kutta condition there. Viscosity adds `4 nu dt` to the squared core in a
    step (Lamb and Oseen), beyond its full size too.
    """
    full = wake.setting[b, CORE]
    gain = wake.setting[b, GROWTH]
    core2 = wake.vortex[b, CORE2, i] + spread
    if core2 < full * full or spread == 0.0:
        core = full
        if gain > 0.0:
            core = ti.min(full, ti.sqrt(core2) + gain * moved)
        core2 = core * core
    wake.vortex[b, CORE2, i] = core2
