"""Dense linear systems inside kernels: Gaussian elimination in panels of eight columns.

The matrix of a system of `n` unknowns is stored as `n` rows of ceil(n/8) octets, and its right-hand sides as octets
behind them. A panel's pivot rows stay in registers, four at a time, so that every row below is read twice instead of
eight times.
"""

from .held import HeldArray
from .runtime import View, ti


def octets(n: int) -> int:
    """Number of octets that hold `n` columns."""
    return -(-n // 8)


@ti.func
def solve(a: View, x: View, factor: View, b, n, columns):
    """Solve system `b` with partial pivoting; the matrix is overwritten.

    `a` has shape (systems, rows, octets(n) + octets(columns)), with rows at least `n` and a multiple of eight; its last
    octets are left for the right-hand sides. `x` (systems, columns, n): right-hand sides, then the solutions. `factor`
    (systems, rows) is scratch.
    """
    solve_held(ti.static(HeldArray.of(a)), x, ti.static(HeldArray.of(factor)), b, n, columns)


@ti.func
def solve_held(a: View, x: View, factor: View, b, n, columns):
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
            solution = a[b, i, blocks + c // 8]
            x[b, c, i] = solution[c % 8]


@ti.func
def factorise(a: View, factor: View, b, n, panel, last):
    """Eliminate within a panel of eight columns; `factor` stores the multiples of the pivot rows.

    While a column is subtracted from the next, the largest entry of the next is found. Lanes known only at run time are
    read from memory: a lane of an octet in registers would take the octet through memory.
    """
    first = 8 * panel
    largest, pivot_row = -1.0, first
    for i in range(first, n):
        size = ti.abs(a[b, i, panel][0])
        if size > largest:
            largest, pivot_row = size, i
    for k in range(first, ti.min(first + 8, n)):
        if pivot_row != k:
            for j in range(panel, last):
                other = a[b, pivot_row, j]
                a[b, pivot_row, j] = a[b, k, j]
                a[b, k, j] = other
            others = factor[b, pivot_row]
            factor[b, pivot_row] = factor[b, k]
            factor[b, k] = others
        lane, following = k - first, (k + 1 - first) % 8
        pivot = a[b, k, panel]
        inverse, ahead = 1.0 / pivot[lane], pivot[following]
        largest, pivot_row = -1.0, k + 1
        for i in range(k + 1, n):
            share = a[b, i, panel][lane] * inverse
            size = ti.abs(a[b, i, panel][following] - share * ahead)
            factor[b, i][lane] = share
            a[b, i, panel] = a[b, i, panel] - share * pivot
            if size > largest:
                largest, pivot_row = size, i


@ti.func
def eliminate(a: View, factor: View, b, n, panel, j):
    """Subtract a panel's pivot rows from block `j` of the rows below.

    They are subtracted four at a time, which is as many octets as fit into the registers of AVX2. Rows from `n` on hold
    no equations, and what becomes of them is not read.
    """
    first = 8 * panel
    pivots = [a[b, first + k, j] for k in ti.static(range(8))]
    for i in ti.static(range(1, 8)):
        shares = factor[b, first + i]
        for k in ti.static(range(i)):
            pivots[i] = pivots[i] - shares[k] * pivots[k]
        a[b, first + i, j] = pivots[i]
    for half in ti.static(range(2)):
        for i in range(first + 8, n):
            row = a[b, i, j]
            shares = factor[b, i]
            for k in ti.static(range(4 * half, 4 * half + 4)):
                row = row - shares[k] * pivots[k]
            a[b, i, j] = row


@ti.func
def substitute(a: View, b, n, panel, j):
    """Solve for a panel's unknowns in block `j` of the right-hand sides, and substitute them in the rows above."""
    first = 8 * panel
    held = ti.min(8, n - first)
    for m in range(held):
        k = first + held - 1 - m
        known = a[b, k, j] / a[b, k, panel][k - first]
        a[b, k, j] = known
        for i in range(first, k):
            a[b, i, j] = a[b, i, j] - a[b, i, panel][k - first] * known
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
