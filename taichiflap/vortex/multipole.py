"""Velocity induced by many vortices: direct sums nearby, multipole expansions on a binary tree at a distance.

The vortices are ordered along a space-filling curve. A node of the tree is a section of the curve; its children are the
two halves. Outside its circle, with centre c and radius a, a node induces the complex velocity (Greengard & Rokhlin
1987, J. Comput. Phys. 73, Eq. 2.4)

    sum_j Gamma_j / (zeta - zeta_j) = sum_m M_m / (zeta - c)^(m+1),    M_m = sum_j Gamma_j (zeta_j - c)^m,

and the truncation error at order p is at most `sum_j |Gamma_j| (a/d)^p / (d - a)` at a distance d from c. A core
changes the velocity of a distant vortex by at most `|Gamma| core^2 / r^3`. The expansion of a node is used where both
errors together are within its share of the allowed error (Barnes & Hut's tree code with an error bound instead of an
opening angle).
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.arrays import zeros
from ..kernels.runtime import Floats1, Floats3, Ints1, Ints2, Octet, View, ti, view
from .sum import CIRCULATION, CORE2, INV_2PI, Y, Z, induce

ORDER = 12
LEAF = 32
"""Number of vortices in a leaf; fewer cost more in visited nodes than they save in pairs."""

C_Y, C_Z, RADIUS, CORES = range(4)
"""Columns of a node: centre, radius of the circle around its vortices (negative: empty), largest squared core."""

Tree = ti.types.argpack(
    count=Ints1,  # number of vortices of the case; 0: no tree
    leaves=Ints1,  # a power of two; node i has the children 2i and 2i + 1, and the leaves come last
    limit=Floats1,  # allowed error per unit circulation, 1/m
    order=Ints2,  # (case, rank): places of the vortices, along the curve
    source=Floats3,  # (case, 4, rank): the vortices in that order, see taichiflap.vortex
    node=Floats3,  # (case, node, 4)
    moment=Floats3,  # (case, node, 2 ORDER): real and imaginary parts of M_m
)


def allocate(cases: int, vortices: int) -> Any:
    """Empty trees for given numbers of vortices in each case."""
    leaves = _power_of_two(vortices)
    return Tree(
        count=zeros(ti.i32, cases),
        leaves=zeros(ti.i32, cases),
        limit=zeros(ti.f64, cases),
        order=zeros(ti.i32, cases, leaves * LEAF),
        source=zeros(ti.f64, cases, 4, leaves * LEAF),
        node=zeros(ti.f64, cases, 2 * leaves, 4),
        moment=zeros(ti.f64, cases, 2 * leaves, 2 * ORDER),
    )


def _power_of_two(vortices: int) -> int:
    """Number of leaves of a tree with so many vortices."""
    return 1 << max(0, math.ceil(math.log2(max(1, vortices) / LEAF)))


def sort(tree: Any, b: int, vortices: NDArray[np.float64], error: float) -> None:
    """Sort the vortices of case `b`, shape (4 or more, count), along the curve.

    Args:
        error: maximum error of a velocity, m/s, divided among vortices by |circulation|.
    """
    count = vortices.shape[1]
    order = np.argsort(_along_curve(vortices[:2]), kind="stable")
    view(tree.count)[b] = count
    view(tree.leaves)[b] = _power_of_two(count)
    view(tree.limit)[b] = 2.0 * math.pi * error / max(float(np.sum(np.abs(vortices[CIRCULATION]))), 1e-300)
    view(tree.order)[b, :count] = order
    source = view(tree.source)[b]
    source[:, :count] = vortices[: len(source), order]
    source[:, count:] = 0.0


def _along_curve(points: NDArray[np.float64]) -> NDArray[np.uint32]:
    """Rank of points along Morton's curve, which interleaves the bits of both coordinates."""
    low = points.min(axis=1, keepdims=True)
    size = max(float(np.max(points - low)), 1e-300)
    y, z = (_spread(axis) for axis in ((points - low) * (65535.0 / size)).astype(np.uint32))
    return y | (z << np.uint32(1))


def _spread(bits: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """A zero after each of the lower sixteen bits."""
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        bits = (bits | (bits << np.uint32(shift))) & np.uint32(mask)
    return bits


@ti.func
def expand(tree: View, b, i):
    """Circle and moments of node `i`."""
    first = i
    last = i + 1
    while first < tree.leaves[b]:
        first *= 2
        last *= 2
    first = (first - tree.leaves[b]) * LEAF
    last = ti.min((last - tree.leaves[b]) * LEAF, tree.count[b])
    tree.node[b, i, RADIUS] = -1.0
    if first < last:
        low_y = tree.source[b, Y, first]
        low_z = tree.source[b, Z, first]
        high_y = low_y
        high_z = low_z
        cores = 0.0
        for j in range(first, last):
            low_y = ti.min(low_y, tree.source[b, Y, j])
            low_z = ti.min(low_z, tree.source[b, Z, j])
            high_y = ti.max(high_y, tree.source[b, Y, j])
            high_z = ti.max(high_z, tree.source[b, Z, j])
            cores = ti.max(cores, tree.source[b, CORE2, j])
        c_y = 0.5 * (low_y + high_y)
        c_z = 0.5 * (low_z + high_z)
        radius2 = 0.0
        m_y = ti.Vector([0.0] * ORDER)
        m_z = ti.Vector([0.0] * ORDER)
        for j in range(first, last):
            y = tree.source[b, Y, j] - c_y
            z = tree.source[b, Z, j] - c_z
            radius2 = ti.max(radius2, y * y + z * z)
            w_y = tree.source[b, CIRCULATION, j]
            w_z = 0.0
            for m in ti.static(range(ORDER)):
                m_y[m] += w_y
                m_z[m] += w_z
                w_y, w_z = w_y * y - w_z * z, w_y * z + w_z * y
        tree.node[b, i, C_Y] = c_y
        tree.node[b, i, C_Z] = c_z
        tree.node[b, i, RADIUS] = ti.sqrt(radius2)
        tree.node[b, i, CORES] = cores
        for m in ti.static(range(ORDER)):
            tree.moment[b, i, 2 * m] = m_y[m]
            tree.moment[b, i, 2 * m + 1] = m_z[m]


@ti.func
def induce_by_tree(y, z, core2, tree: View, b):
    """Velocity (m/s) at eight points due to all vortices of the tree, within the allowed error."""
    c_y = 0.5 * (y.min() + y.max())
    c_z = 0.5 * (z.min() + z.max())
    away_y = y - c_y
    away_z = z - c_z
    reach = ti.sqrt((away_y * away_y + away_z * away_z).max())
    blurred = core2.max()
    leaves = tree.leaves[b]
    u_y = Octet(0.0)
    u_z = Octet(0.0)
    i = 1
    while i > 0:
        radius = tree.node[b, i, RADIUS]
        d_y = tree.node[b, i, C_Y] - c_y
        d_z = tree.node[b, i, C_Z] - c_z
        clear = ti.sqrt(d_y * d_y + d_z * d_z) - reach
        gap = clear - radius
        distant = False
        if gap > 0.0:
            ratio2 = (radius / clear) * (radius / clear)
            ratio6 = ratio2 * ratio2 * ratio2
            core_share = (blurred + tree.node[b, i, CORES]) / (gap * gap * gap)
            distant = ratio6 * ratio6 / gap + core_share <= tree.limit[b]
        if radius >= 0.0 and not distant and i < leaves:
            i = 2 * i
        else:
            if radius >= 0.0 and distant:
                v_y, v_z = induce_by_moments(y, z, tree, b, i)
                u_y += v_y
                u_z += v_z
            elif radius >= 0.0:
                first = (i - leaves) * LEAF
                v_y, v_z = induce(y, z, core2, tree.source, b, first, ti.min(first + LEAF, tree.count[b]))
                u_y += v_y
                u_z += v_z
            i += 1
            while i % 2 == 0:
                i = i // 2
            if i == 1:
                i = 0
    return u_y, u_z


@ti.func
def induce_by_moments(y, z, tree: View, b, i):
    """Velocity at eight distant points from the expansion of node `i`."""
    d_y = y - tree.node[b, i, C_Y]
    d_z = z - tree.node[b, i, C_Z]
    inverse = 1.0 / (d_y * d_y + d_z * d_z)
    t_y = d_y * inverse
    t_z = (tree.node[b, i, C_Z] - z) * inverse
    s_y = Octet(0.0)
    s_z = Octet(0.0)
    for k in range(ORDER):
        m = ORDER - 1 - k
        a_y = s_y + tree.moment[b, i, 2 * m]
        a_z = s_z + tree.moment[b, i, 2 * m + 1]
        s_y = a_y * t_y - a_z * t_z
        s_z = a_y * t_z + a_z * t_y
    return s_z * INV_2PI, s_y * INV_2PI


@ti.func
def octet_at(x: View, b, axis, first, count):
    """Eight consecutive entries of a (case, axis, rank) array; the last is repeated at the end."""
    return Octet([x[b, axis, ti.min(first + lane, count - 1)] for lane in ti.static(range(8))])
