"""Dense linear systems inside kernels: Gaussian elimination in blocks of eight columns.

The matrix of a system of `n` unknowns is stored as `n` rows of ceil(n/8) octets. Rows of one array may alias as
far as the compiler knows, so each column block is taken on its own with the pivot row's octet held in a register.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .runtime import LANE, Floats2, Floats3, Octet, Octets3, View, start, tasks, ti, view


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
def solve(a: View, x: View, factor: View, b, n, columns):
    """Solve system `b` with partial pivoting; the matrix is overwritten.

    `a` has shape (systems, n, octets) and `x` (systems, columns, n): right-hand sides, then the solutions.
    `factor` (systems, n) is scratch.
    """
    blocks = (n + 7) // 8
    for k in range(n):
        pivot_row = k
        largest = -1.0
        for i in range(k, n):
            factor[b, i] = element(a, b, i, k)
            size = ti.abs(factor[b, i])
            if size > largest:
                largest = size
                pivot_row = i
        if pivot_row != k:
            for j in range(k // 8, blocks):
                other = a[b, pivot_row, j]
                a[b, pivot_row, j] = a[b, k, j]
                a[b, k, j] = other
            for c in range(columns):
                swapped = x[b, c, pivot_row]
                x[b, c, pivot_row] = x[b, c, k]
                x[b, c, k] = swapped
        inverse = 1.0 / factor[b, pivot_row]
        factor[b, pivot_row] = factor[b, k]
        for i in range(k + 1, n):
            factor[b, i] = factor[b, i] * inverse
        for j in range(k // 8, blocks):
            pivot = a[b, k, j]
            for i in range(k + 1, n):
                a[b, i, j] = a[b, i, j] - factor[b, i] * pivot
        for c in range(columns):
            known = x[b, c, k]
            for i in range(k + 1, n):
                x[b, c, i] = x[b, c, i] - factor[b, i] * known
    for m in range(n):
        k = n - 1 - m
        for i in range(k + 1):
            factor[b, i] = element(a, b, i, k)
        for c in range(columns):
            known = x[b, c, k] / factor[b, k]
            x[b, c, k] = known
            for i in range(k):
                x[b, c, i] = x[b, c, i] - factor[b, i] * known


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
def _solve_all(a: Octets3, x: Floats3, factor: Floats2, lanes: ti.i32):
    for i in range(lanes * LANE):
        if i % LANE == 0:
            lane = i // LANE
            for m in range((a.shape[0] - lane + lanes - 1) // lanes):
                solve(a, x, factor, lane + m * lanes, x.shape[2], x.shape[1])


def solve_systems(matrix: ArrayLike, rhs: ArrayLike) -> NDArray[np.float64]:
    """Solve a batch of systems with the solver's own elimination.

    Args:
        matrix: shape (systems, n, n).
        rhs: shape (systems, n, columns).

    Returns:
        Solutions, shape (systems, n, columns).
    """
    start()
    x = np.ascontiguousarray(np.swapaxes(np.asarray(rhs, dtype=np.float64), 1, 2))
    systems, _, n = x.shape
    a = ti.ndarray(Octet, (systems, n, octets(n)))
    rows = view(a).reshape(systems, n, 8 * octets(n))
    rows[:, :, :n] = matrix
    rows[:, :, n:] = 0.0
    _solve_all(a, x, np.empty((systems, n)), tasks(systems))
    return np.swapaxes(x, 1, 2)
