"""Dense linear systems inside kernels: Gaussian elimination in blocks of eight columns.

A system of `n` unknowns with `r` right-hand sides is stored as `n` rows of octets: ceil(n/8) octets of matrix,
then ceil(r/8) of right-hand sides, which the solution replaces. Rows of one array may alias as far as
the compiler knows, so each column block is taken on its own with the pivot row's octet held in a register.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .runtime import LANE, Floats2, Octet, Octets3, View, start, tasks, ti, view


def octets(n: int) -> int:
    """Number of octets that hold `n` columns."""
    return -(-n // 8)


@ti.func
def element(a: View, b, row, column):
    """One matrix element, by way of its whole octet.

    Taichi may keep an element read as `a[b, i, j][lane]` across a store to its octet; this it does not.
    """
    whole = a[b, row, column // 8]
    return whole[column % 8]


@ti.func
def solve(a: View, factor: View, b, n, width):
    """Solve system `b` in place, with partial pivoting.

    `a` has shape (systems, n, width) of octets; `factor` (systems, n) is scratch.
    """
    for k in range(n):
        block = k // 8
        pivot_row = k
        largest = -1.0
        for i in range(k, n):
            factor[b, i] = element(a, b, i, k)
            size = ti.abs(factor[b, i])
            if size > largest:
                largest = size
                pivot_row = i
        if pivot_row != k:
            for j in range(block, width):
                other = a[b, pivot_row, j]
                a[b, pivot_row, j] = a[b, k, j]
                a[b, k, j] = other
        inverse = 1.0 / factor[b, pivot_row]
        factor[b, pivot_row] = factor[b, k]
        for i in range(k + 1, n):
            factor[b, i] = factor[b, i] * inverse
        for j in range(block, width):
            pivot = a[b, k, j]
            for i in range(k + 1, n):
                a[b, i, j] = a[b, i, j] - factor[b, i] * pivot
    for j in range((n + 7) // 8, width):
        for m in range(n):
            k = n - 1 - m
            x = a[b, k, j] / element(a, b, k, k)
            a[b, k, j] = x
            for i in range(k):
                a[b, i, j] = a[b, i, j] - element(a, b, i, k) * x


@ti.func
def solve_few(a: View, b, n):
    """Solve system `b` of a few unknowns in place: `a` is (systems, n, n + 1), the last column the right-hand side.

    Without pivoting: a modal mass matrix is the identity plus the fluid's added mass, damping and stiffness.
    """
    for k in range(n):
        for i in range(n):
            if i != k:
                factor = a[b, i, k] / a[b, k, k]
                for j in range(k + 1, n + 1):
                    a[b, i, j] = a[b, i, j] - factor * a[b, k, j]
    for k in range(n):
        a[b, k, n] = a[b, k, n] / a[b, k, k]


@ti.kernel
def _solve_all(a: Octets3, factor: Floats2, n: ti.i32, lanes: ti.i32):
    for i in range(lanes * LANE):
        if i % LANE == 0:
            lane = i // LANE
            for m in range((a.shape[0] - lane + lanes - 1) // lanes):
                solve(a, factor, lane + m * lanes, n, a.shape[2])


def solve_systems(matrix: ArrayLike, rhs: ArrayLike) -> NDArray[np.float64]:
    """Solve a batch of systems with the solver's own elimination.

    Args:
        matrix: shape (systems, n, n).
        rhs: shape (systems, n, r).

    Returns:
        Solutions, shape (systems, n, r).
    """
    start()
    matrix = np.asarray(matrix, dtype=np.float64)
    rhs = np.asarray(rhs, dtype=np.float64)
    systems, n, r = rhs.shape
    width = octets(n) + octets(r)
    rows = np.zeros((systems, n, 8 * width))
    rows[:, :, :n] = matrix
    rows[:, :, 8 * octets(n) : 8 * octets(n) + r] = rhs
    a = ti.ndarray(Octet, (systems, n, width))
    view(a)[...] = rows.reshape(systems, n, width, 8)
    _solve_all(a, np.empty((systems, n)), n, tasks(systems))
    solved = view(a).reshape(systems, n, 8 * width)
    return solved[:, :, 8 * octets(n) : 8 * octets(n) + r]
