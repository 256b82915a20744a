"""The velocity induced by point vortices: the only module that contains the kernel 1/r.

Eq. 30 of Reade & Jankauski (2020), with a Krasny core: a vortex of circulation G (positive counter-clockwise in Y-Z)
induces the velocity `G r / (2 pi (r^2 + core^2))` at distance r, normal to the line between both points. The squared
core of a pair is the sum of both vortices' squared cores, which conserves the pair's impulse.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..kernels.loops import repeated
from ..kernels.runtime import LANE, Floats3, Octet, Sixteen, View, start, tasks, ti

Y, Z, CIRCULATION, CORE2 = range(4)
"""Axes of an array of points or vortices, shape (case, axis, index): m, m, m2/s, and the squared core, m2."""

INV_2PI = 1.0 / (2.0 * math.pi)
TINY, TINY_SINGLE = 1e-300, 1e-30
"""Squared core of a bare point: avoids 0/0, so that a vortex induces no velocity on itself."""


@ti.func
def octet(x: View, b, axis, first):
    """Eight consecutive entries of a (case, axis, index) array, starting at `first`."""
    return Octet([x[b, axis, first + lane] for lane in ti.static(range(8))])


@ti.func
def sixteen(x: View, b, axis, first):
    """Sixteen consecutive entries of a (case, axis, index) array, in single precision."""
    return Sixteen([x[b, axis, first + lane] for lane in ti.static(range(16))])


@ti.func
def store_octet(x: View, b, axis, first, value):
    for lane in ti.static(range(8)):
        x[b, axis, first + lane] = value[lane]


@ti.func
def vortex_velocity(circulation, dy, dz, core2):
    """Velocity (m/s) at the offset (dy, dz) from a vortex with squared core `core2`."""
    strength = INV_2PI * circulation / (dy * dy + dz * dz + core2)
    return -dz * strength, dy * strength


@ti.func
def normal_velocity(circulation, dy, dz, t_y, t_z):
    """Velocity (m/s) along the normal (-t_z, t_y) at the offset (dy, dz) from a point vortex."""
    return circulation * INV_2PI * (dy * t_y + dz * t_z) / (dy * dy + dz * dz)


def _sum_over(lanes: Any) -> Any:
    """The sum for a vector type: one target point per lane, in its precision."""

    @ti.func
    @repeated
    def induce(y, z, core2, vortices: View, b, first, last):
        """Velocity (m/s) at points `y`, `z` of squared cores `core2` from vortices `first` to `last - 1` of case `b`.

        `vortices` has shape (case, 4, vortex); `core2` is at least that of a bare point. Targets are processed in
        vectors, and no sum is reordered, so that results depend neither on the machine's vector width nor on
        neighbouring targets.
        """
        u_y = lanes(0.0)
        u_z = lanes(0.0)
        for j in range(first, last):
            dy = y - vortices[b, Y, j]
            dz = z - vortices[b, Z, j]
            strength = vortices[b, CIRCULATION, j] / (dy * dy + dz * dz + (core2 + vortices[b, CORE2, j]))
            u_y = u_y - dz * strength
            u_z = u_z + dy * strength
        return u_y * lanes(INV_2PI), u_z * lanes(INV_2PI)

    return induce


induce = _sum_over(Octet)
induce_single = _sum_over(Sixteen)


@ti.kernel
def _induce_everywhere(points: Floats3, velocity: Floats3, vortices: Floats3, lanes: ti.i32):
    for i in range(lanes * LANE):
        if i % LANE == 0:
            lane = i // LANE
            for m in range((points.shape[2] // 8 - lane + lanes - 1) // lanes):
                first = 8 * (lane + m * lanes)
                y = octet(points, 0, Y, first)
                z = octet(points, 0, Z, first)
                u_y, u_z = induce(y, z, TINY, vortices, 0, 0, vortices.shape[2])
                store_octet(velocity, 0, Y, first, u_y)
                store_octet(velocity, 0, Z, first, u_z)


def induced_velocity(
    points: ArrayLike, vortices: ArrayLike, core: float = 0.0, threads: int | None = None
) -> NDArray[np.float64]:
    """Velocity induced by a set of vortices at a set of points, computed by the solver's own sum.

    Args:
        points: Y and Z of the points, m, shape (2, ...).
        vortices: Y, Z (m) and circulation (m2/s) of the vortices, shape (3, ...).
        core: Krasny core radius, m. With 0, a vortex induces no velocity at its own position.
        threads: number of threads; None for all. It does not affect the result.

    Returns:
        Velocity along Y and Z, m/s, in the shape of `points`.

    Raises:
        ValueError: if the first axis of `points` is not 2 long, or that of `vortices` not 3.
    """
    given, bound = np.asarray(points, dtype=np.float64), np.array(vortices, dtype=np.float64)
    for name, found, rows in (("points", given, 2), ("vortices", bound, 3)):
        if found.shape[:1] != (rows,):
            raise ValueError(f"{name} has the shape {found.shape}; give ({rows}, ...), one row per quantity")
    start()
    targets = given.reshape(1, 2, -1)
    count = targets.shape[2]
    targets = np.pad(targets, ((0, 0), (0, 0), (0, -count % 8)))
    sources = bound.reshape(1, 3, -1)
    sources = np.concatenate((sources, np.full_like(sources[:, :1], core * core)), axis=1)
    velocity = np.zeros_like(targets)
    if count and sources.size:
        _induce_everywhere(targets, velocity, sources, tasks(min(targets.shape[2] // 8, 64), threads))
    return velocity[0, :, :count].reshape(given.shape)
