"""Fourier transforms along the angle, of real rows in pairs, eight points at a time.

A row of N = 8 M points lies in M octets: point n = 8 n1 + n2 is lane n2 of octet n1. Two real rows are transformed as
the real and imaginary part of one complex row: a DFT of M over n1, lane by lane (Stockham's, radices 8, 4, 3 and 2),
the two rows separated, a twiddle, an 8 x 8 transpose and a DFT of 8 over n2. Of the wavenumbers k = k1 + M k2 only
those with k1 = 0 .. M/2 are kept: with k2 = 0 .. 7 that is every wavenumber of a real row, k or N - k. A row's
spectrum is `slots` pairs of octets, real and imaginary: slot 8 g + k2 holds k1 = 8 g .. 8 g + 7, and if M/2 is a
multiple of 8 one more slot holds k1 = M/2, its lanes k2.

What a length needs is a `taichiflap.fluids.navier_stokes.plan.Plan`; kernels find it in arrays, so that one kernel
serves all lengths.
"""

import numpy as np

from ...kernels.runtime import Octet, View, ti
from .plan import GROUPS, PASSES, POINTS, RADIX, SLOTS, TAIL

DIAGONAL = float(np.sqrt(0.5))
HEIGHT = float(np.sqrt(0.75))


@ti.func
def exchange(rows: View, s: View):
    """Eight octets with the off-diagonal squares of `s` by `s` elements exchanged, of each square of twice that."""
    return [
        Octet([rows[i ^ ((i ^ at) & s)][at ^ ((i ^ at) & s)] for at in ti.static(range(8))])
        for i in ti.static(range(8))
    ]


@ti.func
def transpose(rows: View):
    """Transpose of eight octets, in three steps of which each takes an octet from two: one instruction a register."""
    # Loaded whole, not element by element.
    whole = [rows[at] for at in ti.static(range(8))]
    halves = exchange(whole, 4)
    pairs = exchange(halves, 2)
    return exchange(pairs, 1)


@ti.func
def dft4(xr: View, xi: View, sign: View):
    """DFT of four; `sign` is 1 for e^-i and -1 for e^+i."""
    sr, si = xr[0] + xr[2], xi[0] + xi[2]
    tr, t_i = xr[0] - xr[2], xi[0] - xi[2]
    ur, ui = xr[1] + xr[3], xi[1] + xi[3]
    vr, vi = (xr[1] - xr[3]) * ti.static(float(sign)), (xi[1] - xi[3]) * ti.static(float(sign))
    return [sr + ur, tr + vi, sr - ur, tr - vi], [si + ui, t_i - vr, si - ui, t_i + vr]


@ti.func
def dft8(xr: View, xi: View, sign: View):
    """DFT of eight."""
    er, ei = dft4([xr[0], xr[2], xr[4], xr[6]], [xi[0], xi[2], xi[4], xi[6]], sign)
    jr, ji = dft4([xr[1], xr[3], xr[5], xr[7]], [xi[1], xi[3], xi[5], xi[7]], sign)
    s = ti.static(float(sign))
    # Times the powers of the eighth root.
    p1r, p1i = DIAGONAL * (jr[1] + s * ji[1]), DIAGONAL * (ji[1] - s * jr[1])
    p2r, p2i = s * ji[2], (0.0 - s) * jr[2]
    p3r, p3i = DIAGONAL * (s * ji[3] - jr[3]), DIAGONAL * ((0.0 - s) * jr[3] - ji[3])
    pr, pi = [jr[0], p1r, p2r, p3r], [ji[0], p1i, p2i, p3i]
    upper = [er[k] + pr[k] for k in ti.static(range(4))], [ei[k] + pi[k] for k in ti.static(range(4))]
    lower = [er[k] - pr[k] for k in ti.static(range(4))], [ei[k] - pi[k] for k in ti.static(range(4))]
    return upper[0] + lower[0], upper[1] + lower[1]


@ti.func
def stockham(work: View, root: View, plan: View, b, p, sign: View):  # noqa: PLR0915 - one loop nest
    """DFT of M octets, real at 2 m and imaginary at 2 m + 1 of `work[b, 0]`; it ends in `work[b, passes % 2]`."""
    count = plan[b, p, POINTS]
    s = 1
    for t in range(plan[b, p, PASSES]):
        radix = plan[b, p, RADIX + t]
        count = count // radix
        src = t % 2
        dst = 1 - src
        hop = 2 * s * count
        step = 2 * s
        for m in range(count):
            w1r = root[b, p, m * s, 0]
            w1i = ti.static(float(sign)) * root[b, p, m * s, 1]
            if radix == 4:
                w2r = w1r * w1r - w1i * w1i
                w2i = 2.0 * w1r * w1i
                w3r = w1r * w2r - w1i * w2i
                w3i = w1r * w2i + w1i * w2r
                for q in range(s):
                    i = 2 * (q + s * m)
                    xr = [work[b, src, i + hop * k] for k in ti.static(range(4))]
                    xi = [work[b, src, i + hop * k + 1] for k in ti.static(range(4))]
                    yr, yi = dft4(xr, xi, sign)
                    o = 2 * (q + 4 * s * m)
                    work[b, dst, o] = yr[0]
                    work[b, dst, o + 1] = yi[0]
                    work[b, dst, o + step] = yr[1] * w1r - yi[1] * w1i
                    work[b, dst, o + step + 1] = yr[1] * w1i + yi[1] * w1r
                    work[b, dst, o + 2 * step] = yr[2] * w2r - yi[2] * w2i
                    work[b, dst, o + 2 * step + 1] = yr[2] * w2i + yi[2] * w2r
                    work[b, dst, o + 3 * step] = yr[3] * w3r - yi[3] * w3i
                    work[b, dst, o + 3 * step + 1] = yr[3] * w3i + yi[3] * w3r
            elif radix == 8:
                for q in range(s):
                    xr = [work[b, src, 2 * q + hop * k] for k in ti.static(range(8))]
                    xi = [work[b, src, 2 * q + hop * k + 1] for k in ti.static(range(8))]
                    yr, yi = dft8(xr, xi, sign)
                    for k in ti.static(range(8)):
                        work[b, dst, 2 * q + step * k] = yr[k]
                        work[b, dst, 2 * q + step * k + 1] = yi[k]
            elif radix == 3:
                w2r = w1r * w1r - w1i * w1i
                w2i = 2.0 * w1r * w1i
                for q in range(s):
                    i = 2 * (q + s * m)
                    xr = [work[b, src, i + hop * k] for k in ti.static(range(3))]
                    xi = [work[b, src, i + hop * k + 1] for k in ti.static(range(3))]
                    ur, ui = xr[1] + xr[2], xi[1] + xi[2]
                    vr = (xr[1] - xr[2]) * ti.static(HEIGHT * sign)
                    vi = (xi[1] - xi[2]) * ti.static(HEIGHT * sign)
                    tr, t_i = xr[0] - 0.5 * ur, xi[0] - 0.5 * ui
                    o = 2 * (q + 3 * s * m)
                    work[b, dst, o] = xr[0] + ur
                    work[b, dst, o + 1] = xi[0] + ui
                    y1r, y1i, y2r, y2i = tr + vi, t_i - vr, tr - vi, t_i + vr
                    work[b, dst, o + step] = y1r * w1r - y1i * w1i
                    work[b, dst, o + step + 1] = y1r * w1i + y1i * w1r
                    work[b, dst, o + 2 * step] = y2r * w2r - y2i * w2i
                    work[b, dst, o + 2 * step + 1] = y2r * w2i + y2i * w2r
            else:
                for q in range(s):
                    i = 2 * (q + s * m)
                    ar, ai = work[b, src, i], work[b, src, i + 1]
                    br, bi = work[b, src, i + hop], work[b, src, i + hop + 1]
                    o = 2 * (q + 2 * s * m)
                    work[b, dst, o] = ar + br
                    work[b, dst, o + 1] = ai + bi
                    vr, vi = ar - br, ai - bi
                    work[b, dst, o + step] = vr * w1r - vi * w1i
                    work[b, dst, o + step + 1] = vr * w1i + vi * w1r
        s *= radix


@ti.func
def separate(work: View, twiddle: View, b, p, src, k1, points, c):
    """Row `c`, 0 or 1, of a transformed pair at k1, twiddled."""
    i = 2 * k1
    m = 2 * ((points - k1) % points)
    ar, ai = work[b, src, i], work[b, src, i + 1]
    br, bi = work[b, src, m], work[b, src, m + 1]
    xr = 0.5 * (ar + br)
    xi = 0.5 * (ai - bi)
    if c == 1:
        xr = 0.5 * (ai + bi)
        xi = 0.5 * (br - ar)
    wr, wi = twiddle[b, p, k1, 0], twiddle[b, p, k1, 1]
    return xr * wr - xi * wi, xr * wi + xi * wr


@ti.func
def forward(rows: View, spectra: View, work: View, root: View, twiddle: View, plan: View, b, p, i0, i1, o0, o1):
    """Spectra `o0`, `o1` of rows `i0`, `i1`: unnormalised, as `numpy.fft.rfft`."""
    points = plan[b, p, POINTS]
    for m in range(points):
        work[b, 0, 2 * m] = rows[b, i0, m]
        work[b, 0, 2 * m + 1] = rows[b, i1, m]
    stockham(work, root, plan, b, p, 1)
    src = plan[b, p, PASSES] % 2
    for c in range(2):
        out = o0 + c * (o1 - o0)
        for g in range(plan[b, p, GROUPS]):
            x = [separate(work, twiddle, b, p, src, 8 * g + at, points, c) for at in ti.static(range(8))]
            xr = transpose([x[at][0] for at in ti.static(range(8))])
            xi = transpose([x[at][1] for at in ti.static(range(8))])
            yr, yi = dft8(xr, xi, 1)
            for k in ti.static(range(8)):
                spectra[b, out, 16 * g + 2 * k] = yr[k]
                spectra[b, out, 16 * g + 2 * k + 1] = yi[k]
        if plan[b, p, TAIL] == 1:
            ar, ai = separate(work, twiddle, b, p, src, points // 2, points, c)
            yr, yi = lanes_dft(ar, ai, 1)
            spectra[b, out, 2 * plan[b, p, SLOTS] - 2] = yr
            spectra[b, out, 2 * plan[b, p, SLOTS] - 1] = yi


@ti.func
def lanes_dft(xr, xi, sign: View):
    """DFT of the eight lanes of one octet."""
    yr = Octet(0.0)
    yi = Octet(0.0)
    for at in ti.static(range(8)):
        cosine = Octet([ti.static(float(np.cos(np.pi * at * k / 4))) for k in ti.static(range(8))])
        sine = Octet([ti.static(float(sign * np.sin(np.pi * at * k / 4))) for k in ti.static(range(8))])
        yr = yr + (xr[at] * cosine + xi[at] * sine)
        yi = yi + (xi[at] * cosine - xr[at] * sine)
    return yr, yi


@ti.func
def join(work: View, twiddle: View, b, p, k1, points, xr, xi, c):
    """Put row `c` of a pair back at k1 and, conjugate, at M - k1."""
    wr, wi = twiddle[b, p, k1, 0], twiddle[b, p, k1, 1]
    yr = xr * wr + xi * wi
    yi = xi * wr - xr * wi
    i = 2 * k1
    m = 2 * ((points - k1) % points)
    if c == 0:
        if 2 * k1 <= points:
            work[b, 0, i] = yr
            work[b, 0, i + 1] = yi
        if k1 > 0 and 2 * k1 < points:
            work[b, 0, m] = yr
            work[b, 0, m + 1] = Octet(0.0) - yi
    else:
        pr, pi = work[b, 0, i], work[b, 0, i + 1]
        if 2 * k1 <= points:
            work[b, 0, i] = pr - yi
            work[b, 0, i + 1] = pi + yr
        if k1 > 0 and 2 * k1 < points:
            work[b, 0, m] = pr + yi
            work[b, 0, m + 1] = yr - pi


@ti.func
def scaled(spectra: View, factor: View, b, row, f, s):
    """Slot `s` of a spectrum times the complex factors in rows `f` and `f + 1` of `factor`."""
    r, i = spectra[b, row, 2 * s], spectra[b, row, 2 * s + 1]
    fr, fi = factor[b, f, s], factor[b, f + 1, s]
    return r * fr - i * fi, r * fi + i * fr


@ti.func
def inverse(
    spectra: View, rows: View, work: View, root: View, twiddle: View, factor: View, plan: View,
    b, p, f, i0, i1, o0, o1,
):  # fmt: skip
    """Rows `o0`, `o1`: the sums over k of spectra `i0`, `i1` times a factor times e^(i k phi), not divided by N."""
    points = plan[b, p, POINTS]
    for c in range(2):
        row = i0 + c * (i1 - i0)
        for g in range(plan[b, p, GROUPS]):
            x = [scaled(spectra, factor, b, row, f, 8 * g + at) for at in ti.static(range(8))]
            yr, yi = dft8([x[at][0] for at in ti.static(range(8))], [x[at][1] for at in ti.static(range(8))], -1)
            tr = transpose(yr)
            t_i = transpose(yi)
            for at in ti.static(range(8)):
                join(work, twiddle, b, p, 8 * g + at, points, tr[at], t_i[at], c)
        if plan[b, p, TAIL] == 1:
            xr, xi = scaled(spectra, factor, b, row, f, plan[b, p, SLOTS] - 1)
            yr, yi = lanes_dft(xr, xi, -1)
            half = points // 2
            # k1 = M/2 mirrors itself: real for a real row.
            real = yr * twiddle[b, p, half, 0] + yi * twiddle[b, p, half, 1]
            if c == 0:
                work[b, 0, points] = real
                work[b, 0, points + 1] = Octet(0.0)
            else:
                work[b, 0, points + 1] = real
    stockham(work, root, plan, b, p, -1)
    src = plan[b, p, PASSES] % 2
    for m in range(points):
        rows[b, o0, m] = work[b, src, 2 * m]
        rows[b, o1, m] = work[b, src, 2 * m + 1]
