"""Long wakes: the velocities of their vortices are computed before a step on all threads.

A march gives each case one thread, which suits short wakes and sweeps. The pair sums of a long wake use all threads
and, if the case allows an error, the tree of `taichiflap.vortex.multipole`. Use of the tree depends only on the case,
so that results are bit-identical in any batch.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...kernels.arrays import array
from ...kernels.linear import octets
from ...kernels.runtime import LANE, Floats2, Floats3, Ints1, Ints2, View, available_threads, tasks, ti, view
from ...motion.sampling import typical_speed
from ...vortex import multipole
from ...vortex.multipole import Tree, expand, induce_by_tree, octet_at
from ...vortex.sum import CORE2, TINY, Y, Z, induce
from .lattice import PANELS
from .stations import ring_size, shed_a_step
from .wake import CARRIED, COUNT, FAR_ERROR, SINGLE, VELOCITY, Wake, carry, carry_single, narrow

WIDE = 3000
"""Minimum number of vortices for which one case's sums use all threads, since they then cost more than two kernel
launches.
"""
FAR = 3500
"""Minimum number of vortices for which the tree is faster than the pair sums, see the benchmarks."""
TASKS = 64


class LongWakes:
    """The long wakes of a batch: `long_wakes(n)` computes their velocities for step `n`.

    Attributes:
        first: first step for which this is faster.
    """

    def __init__(self, cases: Sequence[Case], wakes: Any, flow: Any, failed: Any, threads: int | None) -> None:
        self._cases = list(cases)
        self._wakes, self._flow, self._failed = wakes, flow, failed
        self._lanes = tasks(TASKS, threads)
        workers = min(threads or available_threads(), available_threads())
        alone = len(self._cases) < workers
        self._least = np.array([_long(case, alone) for case in cases])
        self._ends = np.array([case.steps for case in cases])
        self.first = int(min(least // shed_a_step(case) for case, least in zip(cases, self._least, strict=True)))
        self._error = [case.uvlm.far_error and case.uvlm.far_error * typical_speed_of(case) for case in cases]
        self._single = any(case.uvlm.precision == "single" for case in cases)
        self._tree: Any = None

    def __call__(self, n: int) -> None:
        """Compute the velocities of the wakes that are long at step `n`."""
        if self._tree is None:
            self._tree = multipole.allocate(len(self._cases), self._room())
            self._ready = array([0] * len(self._cases))
        counts = view(self._wakes.ring)[:, COUNT]
        view(self._ready)[...] = ready = (counts >= self._least) & (n <= self._ends) & (view(self._failed) < 0)
        for b in np.flatnonzero(ready & np.array([error > 0.0 for error in self._error])):
            multipole.sort(self._tree, int(b), view(self._wakes.vortex)[b, : CORE2 + 1, : counts[b]], self._error[b])
        if any(self._error):
            _expand_all(self._tree, int(view(self._tree.leaves).max()), len(self._cases), self._lanes)
        blocks = octets(int(counts.max()))
        flow = self._flow
        if self._single:
            _narrow_all(self._wakes, self._ready, flow.panel, flow.size)
        _carry_all(self._wakes, self._tree, self._ready, flow.panel, flow.size, flow.scalar, n, blocks, self._lanes)

    def _room(self) -> int:
        return max([ring_size(case) for case in self._cases if case.uvlm.far_error], default=0)


def _long(case: Case, alone: bool) -> int:
    """Number of vortices from which a case's wake counts as long; more than it ever holds if never."""
    least = FAR if case.uvlm.far_error else WIDE
    may = alone or case.uvlm.far_error > 0.0
    return least if may and ring_size(case) >= least else shed_a_step(case) * (case.steps + 1)


def typical_speed_of(case: Case) -> float:
    """Reference speed (m/s) of `uvlm.far_error`: that of the trailing edge over the whole run."""
    times = case.step * np.arange(case.steps + 1, dtype=np.float64)
    behind = (1.0 - case.wing.pivot) * case.wing.chord
    return typical_speed(case.motion, behind, case.fluid.velocity, times)


@ti.kernel
def _expand_all(tree: Tree, leaves: ti.i32, cases: ti.i32, lanes: ti.i32):
    for i in range(lanes * LANE):
        if i % LANE == 0:
            lane = i // LANE
            for m in range((cases * (2 * leaves - 1) - lane + lanes - 1) // lanes):
                b = (lane + m * lanes) // (2 * leaves - 1)
                place = 1 + (lane + m * lanes) % (2 * leaves - 1)
                if place < 2 * tree.leaves[b]:
                    expand(tree, b, place)


@ti.kernel
def _narrow_all(wakes: Wake, ready: Ints1, bound: Floats3, size: Ints2):
    ti.loop_config(serialize=True)
    for b in range(ready.shape[0]):
        if ready[b] == 1 and wakes.scalar[b, SINGLE] > 0.0:
            narrow(wakes, bound, size[b, PANELS], b)


@ti.kernel
def _carry_all(
    wakes: Wake,
    tree: Tree,
    ready: Ints1,
    bound: Floats3,
    size: Ints2,
    stream: Floats2,
    n: ti.i32,
    blocks: ti.i32,
    lanes: ti.i32,
):
    for i in range(lanes * LANE):
        if i % LANE == 0:
            lane = i // LANE
            for m in range((ready.shape[0] * blocks - lane + lanes - 1) // lanes):
                b = (lane + m * lanes) // blocks
                block = (lane + m * lanes) % blocks
                if ready[b] == 1 and 8 * block < wakes.ring[b, COUNT]:
                    if wakes.scalar[b, SINGLE] > 0.0:
                        if block % 2 == 0:
                            carry_single(wakes, size[b, PANELS], stream, b, 8 * block)
                    elif tree.count[b] == 0:
                        carry(wakes, bound, size[b, PANELS], stream, b, 8 * block)
                    else:
                        carry_by_tree(wakes, tree, bound, size[b, PANELS], stream, b, 8 * block)
                        if block == n % ((wakes.ring[b, COUNT] + 7) // 8):
                            compare(wakes, tree, b, 8 * block)
                    if block == 0:
                        wakes.ring[b, CARRIED] = n


@ti.func
def carry_by_tree(wakes: View, tree: View, bound: View, panels, stream: View, b, first):
    """As `wake.carry`, for eight neighbouring vortices on the tree's curve."""
    count = tree.count[b]
    y = octet_at(tree.source, b, Y, first, count)
    z = octet_at(tree.source, b, Z, first, count)
    core2 = octet_at(tree.source, b, CORE2, first, count) + TINY
    w_y, w_z = induce_by_tree(y, z, core2, tree, b)
    b_y, b_z = induce(y, z, core2, bound, b, 0, panels)
    u_y = w_y + b_y + stream[b, Y]
    u_z = w_z + b_z + stream[b, Z]
    for lane in ti.static(range(8)):
        if first + lane < count:
            place = tree.order[b, first + lane]
            wakes.vortex[b, VELOCITY + Y, place] = u_y[lane]
            wakes.vortex[b, VELOCITY + Z, place] = u_z[lane]


@ti.func
def compare(wakes: View, tree: View, b, first):
    """Store the difference between the tree and the direct sum, for eight vortices per step."""
    count = tree.count[b]
    y = octet_at(tree.source, b, Y, first, count)
    z = octet_at(tree.source, b, Z, first, count)
    core2 = octet_at(tree.source, b, CORE2, first, count) + TINY
    t_y, t_z = induce_by_tree(y, z, core2, tree, b)
    p_y, p_z = induce(y, z, core2, tree.source, b, 0, count)
    error2 = (t_y - p_y) * (t_y - p_y) + (t_z - p_z) * (t_z - p_z)
    wakes.scalar[b, FAR_ERROR] = ti.max(wakes.scalar[b, FAR_ERROR], ti.sqrt(error2.max()))
