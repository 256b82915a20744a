"""Dense linear systems inside kernels: Gaussian elimination in panels of eight columns.

The matrix of a system of `n` unknowns is stored as `n` rows of ceil(n/8) octets, and its right-hand sides as octets
behind them. A panel's eight pivot rows stay in registers, so that every row below is read once instead of eight times.
"""

from .runtime import View, ti


def octets(n: int) -> int:
    """Number of octets that hold `n` columns."""
    return -(-n // 8)


@ti.func
def element(a: View, b, row, column):
    """One matrix element, read through its whole octet.

    Taichi may keep a stale value of `a[b, i, j][lane]` after a store to its octet; this avoids it.
    """
    whole = a[b, row, column // 8]
    return whole[column % 8]


@ti.func
def solve(a: View, x: View, factor: View, b, n, columns):
    """Solve system `b` with partial pivoting; the matrix is overwritten.

    `a` has shape (systems, n, octets(n) + octets(columns)), the last octets left for the right-hand sides, and `x`
    (systems, columns, n): right-hand sides, then the solutions. `factor` (systems, n) is scratch.
    """
    blocks = (n + 7) // 8
    last = blocks + (columns + 7) // 8
    for i in range(n):
        for c in range(columns):
            a[b, i, blocks + c // 8][c % 8] = x[b, c, i]
    for panel in range(blocks):
        factorise(a, factor, b, n, panel, last)
        for j in range(panel + 1, last):
            eliminate(a, factor, b, n, panel, j)
    for j in range(blocks, last):
        for m in range(blocks):
            substitute(a, b, n, blocks - 1 - m, j)
    for i in range(n):
        for c in range(columns):
            x[b, c, i] = element(a, b, i, 8 * blocks + c)


@ti.func
def factorise(a: View, factor: View, b, n, panel, last):
    """Eliminate within a panel of eight columns; `factor` stores the multiples of the pivot rows."""
    for k in range(8 * panel, ti.min(8 * panel + 8, n)):
        pivot_row = k
        largest = -1.0
        for i in range(k, n):
            size = ti.abs(element(a, b, i, k))
            if size > largest:
                largest = size
                pivot_row = i
        if pivot_row != k:
            for j in range(panel, last):
                other = a[b, pivot_row, j]
                a[b, pivot_row, j] = a[b, k, j]
                a[b, k, j] = other
            others = factor[b, pivot_row]
            factor[b, pivot_row] = factor[b, k]
            factor[b, k] = others
        pivot = a[b, k, panel]
        inverse = 1.0 / pivot[k % 8]
        for i in range(k + 1, n):
            row = a[b, i, panel]
            share = row[k % 8] * inverse
            factor[b, i][k % 8] = share
            a[b, i, panel] = row - share * pivot


@ti.func
def eliminate(a: View, factor: View, b, n, panel, j):
    """Subtract a panel's pivot rows from block `j` of the rows below, all eight at once."""
    first = 8 * panel
    for i in range(first + 1, ti.min(first + 8, n)):
        row = a[b, i, j]
        shares = factor[b, i]
        for k in range(i - first):
            row = row - shares[k] * a[b, first + k, j]
        a[b, i, j] = row
    if first + 8 < n:
        pivots = [a[b, first + k, j] for k in ti.static(range(8))]
        for i in range(first + 8, n):
            row = a[b, i, j]
            shares = factor[b, i]
            for k in ti.static(range(8)):
                row = row - shares[k] * pivots[k]
            a[b, i, j] = row


@ti.func
def substitute(a: View, b, n, panel, j):
    """Solve for a panel's unknowns in block `j` of the right-hand sides, and substitute them in the rows above."""
    first = 8 * panel
    held = ti.min(8, n - first)
    for m in range(held):
        k = first + held - 1 - m
        known = a[b, k, j] / element(a, b, k, k)
        a[b, k, j] = known
        for i in range(first, k):
            a[b, i, j] = a[b, i, j] - element(a, b, i, k) * known
    for i in range(first):
        row = a[b, i, j]
        shares = a[b, i, panel]
        for m in ti.static(range(8)):
            if 7 - m < held:
                row = row - shares[7 - m] * a[b, first + 7 - m, j]
        a[b, i, j] = row


@ti.func
def solve_few(a: View, b, n):
    """Solve system `b` of a few unknowns in place: `a` is (systems, n, n + 1), the last column the right-hand side.

    No pivoting is needed: a modal mass matrix is the identity plus added mass, damping and stiffness of the fluid.
    """
    for k in range(n):
        for i in range(n):
            if i != k:
                factor = a[b, i, k] / a[b, k, k]
                for j in range(k + 1, n + 1):
                    a[b, i, j] = a[b, i, j] - factor * a[b, k, j]
    for k in range(n):
        a[b, k, n] = a[b, k, n] / a[b, k, k]
