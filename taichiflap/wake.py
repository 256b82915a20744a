"""The free wake: a ring of point vortices per case, shed at the trailing edge and carried by the flow.

Reade & Jankauski (2020), Eqs 29 and 32 (whose wake sum runs over the wake, not over the panels). Vortices never
change strength; a full ring gives up its oldest vortex for the new one.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .body import array, zeros
from .case import Case
from .runtime import Floats1, Floats3, Ints1, Ints2, View, ti
from .vortex import CIRCULATION, Y, Z, induce, octet, squared_core, store_octet

LOCAL_SHARE = 0.25
"""Where the new vortex stands on the trailing edge's path through the fluid during the step."""
LEAST_TRAVEL = 2e-4
"""Least distance, in chords, of a new vortex behind the trailing edge: at stroke reversal the travel vanishes."""

KEEP, COUNT, OLDEST, YOUNGEST = range(4)
"""Entries of a ring: its size, how many vortices it holds, and the places of the first and last shed."""

Wake = ti.types.argpack(
    ring=Ints2,
    local=Ints1,  # 1: new vortices are placed by the trailing edge's travel; 0: at a fixed distance
    distance=Floats1,  # that distance, m, or the least travel
    core2=Floats1,
    vortex=Floats3,  # (case, 3, place): Y, Z, circulation
    velocity=Floats3,  # what carried the vortices in the last step
    birth=Ints2,  # step of shedding
    dropped=Floats1,  # circulation of the vortices given up
)


def allocate(cases: Sequence[Case]) -> Any:
    """Empty wakes of a batch."""
    keep = [ring_size(case) for case in cases]
    count, most = len(cases), -(-max(keep) // 8) * 8
    local = np.array([case.uvlm.shedding == "local" for case in cases])
    behind = np.where(local, LEAST_TRAVEL, [case.uvlm.shedding_distance for case in cases])
    chord = np.array([case.wing.chord for case in cases])
    return Wake(
        ring=array([[size, 0, 0, 0] for size in keep]),
        local=array(local),
        distance=array(behind * chord),
        core2=array([squared_core(case.uvlm.core * case.wing.chord) for case in cases]),
        vortex=zeros(ti.f64, count, 3, most),
        velocity=zeros(ti.f64, count, 2, most),
        birth=zeros(ti.i32, count, most),
        dropped=zeros(ti.f64, count),
    )


def ring_size(case: Case) -> int:
    """Number of vortices that a case's wake can hold: never more than it will shed."""
    shed = case.steps + 1
    return shed if case.uvlm.wake == "all" else min(case.uvlm.wake, shed)


@ti.func
def shed(wake: View, b, n, y, z):
    """Put a vortex of no circulation yet at (y, z), in a free place or in that of the oldest."""
    place = wake.ring[b, COUNT]
    if place < wake.ring[b, KEEP]:
        wake.ring[b, COUNT] = place + 1
    else:
        place = wake.ring[b, OLDEST]
        wake.ring[b, OLDEST] = (place + 1) % wake.ring[b, KEEP]
        wake.dropped[b] = wake.dropped[b] + wake.vortex[b, CIRCULATION, place]
    wake.ring[b, YOUNGEST] = place
    wake.vortex[b, Y, place] = y
    wake.vortex[b, Z, place] = z
    wake.vortex[b, CIRCULATION, place] = 0.0
    wake.birth[b, place] = n


@ti.func
def convect(wake: View, bound: View, panels, stream: View, b, dt):
    """Carry every wake vortex for `dt` with the velocity of all vortices and the free stream (Eq. 32)."""
    count = wake.ring[b, COUNT]
    for block in range((count + 7) // 8):
        y = octet(wake.vortex, b, Y, 8 * block)
        z = octet(wake.vortex, b, Z, 8 * block)
        w_y, w_z = induce(y, z, wake.vortex, b, count, wake.core2[b])
        b_y, b_z = induce(y, z, bound, b, panels, wake.core2[b])
        store_octet(wake.velocity, b, Y, 8 * block, w_y + b_y + stream[b, Y])
        store_octet(wake.velocity, b, Z, 8 * block, w_z + b_z + stream[b, Z])
    for axis in range(2):
        for i in range(count):
            wake.vortex[b, axis, i] = wake.vortex[b, axis, i] + dt * wake.velocity[b, axis, i]


def in_order(frames: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The wake's frames as contiguous ragged arrays: all vortices of frame 0, then of frame 1, ..."""
    filled = np.arange(frames["wake_birth"].shape[1]) < frames["wake_count"][:, None]
    return {
        "wake_birth": frames["wake_birth"][filled],
        "wake": np.moveaxis(frames["wake"], 1, 2)[filled].T,
    }
