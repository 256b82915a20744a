"""The two factors of an implicit step, along phi and along rho: tridiagonal systems solved by elimination.

Being skew-symmetric, convection leaves the pivots J + diffusion alone, so that they never vanish.
"""

from ...kernels.runtime import Octet, View, ti
from .arrays import (
    CARRY,
    DPHI,
    LOWER,
    LOWER_FACE,
    NEAR,
    NU,
    OCTETS,
    ROWS,
    SHARE_FACE,
    SHARE_ROW,
    SHARE_UPPER,
    THICKNESS,
    UPPER_FACE,
)
from .fourier import transpose
from .transport import assemble


@ti.func
def step_rows(flow: View, b, n, beta, bends):
    """Right-hand side and both factors of the step, but for the substitution back from the outer row.

    Eight rows at a time, while they are in the cache.
    """
    rows = flow.size[b, ROWS]
    for m in range(flow.size[b, OCTETS]):
        flow.line[b, LOWER, m] = Octet(0.0)
        flow.line[b, LOWER + 1, m] = Octet(0.0)
        flow.line[b, CARRY, m] = Octet(0.0)
        flow.factor_rho[b, 0, m] = Octet(0.0)
    for group in range((rows + 7) // 8):
        first = 8 * group
        last = ti.min(first + 8, rows)
        assemble(flow, b, n, beta, bends, first, last)
        if first < flow.size[b, NEAR]:
            solve_phi(flow, b, beta, first)
        eliminate_rho(flow, b, beta, first, last)


@ti.func
def gather(a: View, strip: View, b, k: View, j, octets):
    """Eight rows, transposed: element i of each in one octet of strip `k`."""
    for m in range(octets):
        x = transpose([a[b, j + r, m] for r in ti.static(range(8))])
        for at in ti.static(range(8)):
            strip[b, k, 8 * m + at] = x[at]


@ti.func
def solve_phi(flow: View, b, beta, j):  # noqa: PLR0915 - one loop nest
    """The factor along phi, (J - nu beta d_phiphi + convection) x = d, in eight rows from `j` on; leaves J x.

    Cyclic tridiagonal systems, by elimination with Sherman and Morrison's correction. Only near rows change.
    """
    octets, near = flow.size[b, OCTETS], flow.size[b, NEAR]
    count = 8 * octets
    dphi = flow.number[b, DPHI]
    around = flow.number[b, NU] * beta / (dphi * dphi)
    strip = ti.static(flow.strip)
    gather(flow.change, strip, b, 0, j, octets)
    gather(flow.area, strip, b, 1, j, octets)
    gather(flow.ahead_phi, strip, b, 2, j, octets)
    h = Octet(
        [
            flow.row[b, j + r, SHARE_ROW] * (0.5 * beta / dphi) / flow.row[b, j + r, THICKNESS]
            for r in ti.static(range(8))
        ]
    )
    last_q = strip[b, 2, count - 1]
    q = strip[b, 2, 0]
    corner = Octet(0.0) - (around + h * last_q)
    pivot = strip[b, 1, 0] + 2.0 * around
    gamma = Octet(0.0) - pivot
    x = Octet(1.0) / (pivot - gamma)
    c = (around - h * q) * x
    z = gamma * x
    v = strip[b, 0, 0] * x
    strip[b, 0, 0] = v
    strip[b, 2, 0] = c
    strip[b, 3, 0] = z
    for i in range(1, count - 1):
        next_q = strip[b, 2, i]
        lower = around + h * q
        x = Octet(1.0) / (strip[b, 1, i] + 2.0 * around - lower * c)
        c = (around - h * next_q) * x
        v = (strip[b, 0, i] + lower * v) * x
        z = lower * z * x
        strip[b, 0, i] = v
        strip[b, 2, i] = c
        strip[b, 3, i] = z
        q = next_q
    lower, upper = around + h * q, around - h * last_q
    ratio = corner / gamma
    x = Octet(1.0) / (strip[b, 1, count - 1] + 2.0 * around + upper * ratio - lower * c)
    v = (strip[b, 0, count - 1] + lower * v) * x
    z = (lower * z - upper) * x
    strip[b, 0, count - 1] = v
    strip[b, 3, count - 1] = z
    last_v = v
    last_z = z
    for back in range(count - 1):
        i = count - 2 - back
        c = strip[b, 2, i]
        v = strip[b, 0, i] + c * v
        z = strip[b, 3, i] + c * z
        strip[b, 0, i] = v
        strip[b, 3, i] = z
    share = (v + ratio * last_v) / (1.0 + z + ratio * last_z)
    for m in range(octets):
        y = transpose(
            [
                (strip[b, 0, 8 * m + at] - share * strip[b, 3, 8 * m + at]) * strip[b, 1, 8 * m + at]
                for at in ti.static(range(8))
            ]
        )
        for r in ti.static(range(8)):
            if j + r < near:
                flow.change[b, j + r, m] = y[r]


@ti.func
def eliminate_rho(flow: View, b, beta, first, last):
    """Elimination of the factor along rho in rows `first` to `last` - 1, from the wall outwards; `substitute` goes
    back."""
    octets, near = flow.size[b, OCTETS], flow.size[b, NEAR]
    spread = flow.number[b, NU] * beta
    half = 0.5 * beta / flow.number[b, DPHI]
    for j in range(first, last):
        upper, lower = spread * flow.row[b, j, UPPER_FACE], spread * flow.row[b, j, LOWER_FACE]
        jl = ti.max(j - 1, 0)
        above, below = 0.0, 0.0
        if j < near:
            above = half / flow.row[b, j, THICKNESS] * flow.row[b, j, SHARE_UPPER]
        if j > 0 and j < near:
            below = half / flow.row[b, j, THICKNESS] * flow.row[b, j, SHARE_FACE]
        for m in range(octets):
            u = Octet(upper)
            low = Octet(lower)
            if j < near:
                u = u - above * flow.ahead_rho[b, j + 1, m]
                low = low + below * flow.ahead_rho[b, j, m]
            x = Octet(1.0) / (flow.area[b, j, m] + (upper + lower) - low * flow.factor_rho[b, jl, m])
            flow.factor_rho[b, j, m] = u * x
            flow.change[b, j, m] = (flow.change[b, j, m] + low * flow.change[b, jl, m]) * x


@ti.func
def substitute(flow: View, b, j, out, scale, bends):
    """Vorticity of row `j` at the end of the step, and J w times `scale` in a line; from the outer row inwards."""
    for m in range(flow.size[b, OCTETS]):
        x = flow.change[b, j, m] + flow.factor_rho[b, j, m] * flow.line[b, CARRY, m]
        flow.line[b, CARRY, m] = x
        w = flow.vorticity[b, j, m] + x
        flow.vorticity[b, j, m] = w
        content = flow.area[b, j, m] * w
        if bends:
            flow.change[b, j, m] = content - flow.content[b, j, m]
            flow.content[b, j, m] = content
        else:
            flow.change[b, j, m] = flow.area[b, j, m] * x
        flow.line[b, out, m] = content * scale
