"""Convection and diffusion of vorticity: one implicit step by alternating directions.

    d(J w)/dt + d_rho(w Q_rho) + d_phi(w Q_phi) = nu (w_rhorho + w_phiphi)

in delta form, `w^{n+1} = w^n + x`, with BDF2 in time. Q are the fluxes of the fluid through the cells' faces,
relative to the faces. In all but the outermost rows convection is implicit with extrapolated fluxes. The increments
feel central differences of second order; being skew-symmetric these leave the pivots J + diffusion alone, so that
they never vanish. The known vorticity feels differences of third order, upwind, away from the wall and as far as the
Courant number allows: what they add to the second fades where the fluid crosses about a cell in a step. In the
outermost rows convection is explicit, upwind of fifth order.
"""

from ...kernels.runtime import Octet, View, ti
from .arrays import (
    DPHI,
    FLUX,
    HIGHER_FACE,
    HIGHER_ROW,
    INVERSE,
    LOWER,
    LOWER_FACE,
    NEAR,
    NU,
    OCTETS,
    ROWS,
    SHARE_ROW,
    SHARE_UPPER,
    THICKNESS,
    UPPER_FACE,
)

DISSIPATION = 0.1
"""Cap of the coefficient of what is added to second order, a share of the cell over the step."""


@ti.func
def size(q):
    """Absolute value of an octet."""
    return ti.max(q, Octet(0.0) - q)


@ti.func
def after(c, n, s: View):
    """The octet `s` elements further, `n` being the next."""
    return Octet([c[(at + s) % 8] if ti.static(at + s < 8) else n[(at + s) % 8] for at in ti.static(range(8))])


@ti.func
def before(p, c, s: View):
    """The octet `s` elements back, `p` being the one before."""
    return Octet([c[(at - s) % 8] if ti.static(at - s >= 0) else p[(at - s) % 8] for at in ti.static(range(8))])


@ti.func
def upwind_phi(flow: View, b, j, m, octets):
    """Explicit flux of vorticity through the far faces of an octet of cells."""
    w = ti.static(flow.vorticity)
    p = w[b, j, (m + octets - 1) % octets]
    c = w[b, j, m]
    n = w[b, j, (m + 1) % octets]
    w1, w2, w3, v1, v2 = after(c, n, 1), after(c, n, 2), after(c, n, 3), before(p, c, 1), before(p, c, 2)
    q = flow.flux_phi[b, j, m]
    sixth = 37.0 * (c + w1) - 8.0 * (v1 + w2) + (v2 + w3)
    fifth = (w3 - v2) - 5.0 * (w2 - v1) + 10.0 * (w1 - c)
    return (q * sixth - size(q) * fifth) * (1.0 / 60.0)


@ti.func
def third_order(q, most, inverse):
    """Correction from second to third order: the fraction of a flux for the central part, and for the third difference.

    The one fades and the other is cut off where `most`, a share of the cell over the step, is reached; `inverse` is
    one over it.
    """
    part = size(q) * (1.0 / 12.0)
    return q * (1.0 / 12.0) * ti.max(1.0 - part * inverse, 0.0), ti.min(part, most)


@ti.func
def central(q, higher, most, inverse, v1, c, w1, w2):
    """Implicit scheme's flux of the known vorticity between c and w1; v1 and w2 are the next cells on either side."""
    more, damping = third_order(q, most, inverse)
    return 0.5 * q * (c + w1) + (higher * more) * ((c + w1) - (v1 + w2)) + damping * ((w2 - v1) - 3.0 * (w1 - c))


@ti.func
def upwind_rho(flow: View, b, j, m, rows):
    """Explicit flux through face `j`, between rows j - 1 and j."""
    w = ti.static(flow.vorticity)
    f = Octet(0.0)
    if j > 0:
        q = flow.flux_rho[b, j, m]
        a = w[b, j - 1, m]
        if j == rows:
            f = ti.max(q, 0.0) * a
        elif j == 1 or j == rows - 1:
            f = 0.5 * q * (a + w[b, j, m])
        elif j == 2 or j == rows - 2:
            c, a2, c2 = w[b, j, m], w[b, j - 2, m], w[b, j + 1, m]
            f = (q * (7.0 * (a + c) - (a2 + c2)) + size(q) * ((c2 - a2) - 3.0 * (c - a))) * (1.0 / 12.0)
        else:
            c, a2, c2, a3, c3 = w[b, j, m], w[b, j - 2, m], w[b, j + 1, m], w[b, j - 3, m], w[b, j + 2, m]
            sixth = 37.0 * (a + c) - 8.0 * (a2 + c2) + (a3 + c3)
            f = (q * sixth - size(q) * ((c3 - a3) - 5.0 * (c2 - a2) + 10.0 * (c - a))) * (1.0 / 60.0)
    return f


@ti.func
def assemble(flow: View, b, n, beta, bends, first, last):  # noqa: PLR0915 - one loop nest
    """Right-hand side of the step in rows `first` to `last` - 1, in `change`; from the wall outwards."""
    rows, octets, near = flow.size[b, ROWS], flow.size[b, OCTETS], flow.size[b, NEAR]
    spread = flow.number[b, NU] * beta
    dphi = flow.number[b, DPHI]
    around = spread / (dphi * dphi)
    # BDF2 of J w, and second-order extrapolation of explicit convection; first order at the first step.
    kept, now, then = 1.0 / 3.0, 2.0, -1.0
    if n == 1:
        kept, now, then = 0.0, 1.0, 0.0
    for j in range(first, last):
        thickness, inverse = flow.row[b, j, THICKNESS], flow.row[b, j, INVERSE]
        upper, lower = spread * flow.row[b, j, UPPER_FACE], spread * flow.row[b, j, LOWER_FACE]
        share, share_up = flow.row[b, j, SHARE_ROW], flow.row[b, j, SHARE_UPPER]
        up1, up2, down1 = ti.min(j + 1, rows - 1), ti.min(j + 2, rows - 1), ti.max(j - 1, 0)
        outer = 1.0
        if j == rows - 1:
            outer = 0.0
        explicit, implicit, inside = share < 1.0 or share_up < 1.0, j < near, j + 1 < near
        # Most of a cell over the step that damping takes, of this row's sides and of its upper face, whose row is next.
        cap = DISSIPATION * dphi / beta
        most, most_up = cap * thickness, cap * flow.row[b, up1, THICKNESS]
        higher, higher_up = flow.row[b, j, HIGHER_ROW], flow.row[b, up1, HIGHER_FACE]
        p, c = flow.vorticity[b, j, octets - 1], flow.vorticity[b, j, 0]
        last_far, last_near = Octet(0.0), Octet(0.0)
        if explicit:
            last_far = (1.0 - share) * upwind_phi(flow, b, j, octets - 1, octets)
        if implicit:
            pp = flow.vorticity[b, j, octets - 2]
            area = flow.area[b, j, octets - 1]
            last_near = share * central(
                flow.ahead_phi[b, j, octets - 1], higher, most * area, 1.0 / (most * area),
                before(pp, p, 1), p, after(p, c, 1), after(p, c, 2),
            )  # fmt: skip
        for m in range(octets):
            right = flow.vorticity[b, j, (m + 1) % octets]
            v1, w1 = before(p, c, 1), after(c, right, 1)
            area = flow.area[b, j, m]
            above, below = flow.vorticity[b, up1, m], flow.vorticity[b, down1, m]
            x = kept * flow.change[b, j, m] + around * (v1 + w1 - 2.0 * c)
            x = x + upper * (outer * above - c) - lower * (c - below)
            if bends:
                x = x + (flow.content[b, j, m] - area * c)
            if explicit:
                f = (1.0 - share) * upwind_phi(flow, b, j, m, octets)
                carried = flow.line[b, LOWER, m] + before(last_far, f, 1) - f
                last_far = f
                f = (1.0 - share_up) * upwind_rho(flow, b, j + 1, m, rows)
                flow.line[b, LOWER, m] = f
                carried = (carried - f) * inverse
                x = x + beta * (now * carried + then * flow.convection[b, j, m])
                flow.convection[b, j, m] = carried
            if implicit:
                over = Octet(1.0) / area
                f = share * central(
                    flow.ahead_phi[b, j, m], higher, most * area, (1.0 / most) * over, v1, c, w1, after(c, right, 2)
                )
                carried = before(last_near, f, 1) - f + flow.line[b, LOWER + 1, m]
                last_near = f
                if inside:
                    q = flow.ahead_rho[b, j + 1, m]
                    f = share_up * 0.5 * q * (c + above)
                    if j > 0:
                        f = share_up * central(
                            q, higher_up, most_up * area, (1.0 / most_up) * over, below, c, above,
                            flow.vorticity[b, up2, m],
                        )  # fmt: skip
                    carried = carried - f
                    flow.line[b, LOWER + 1, m] = f
                x = x + (beta * inverse) * carried
            if j == 0:
                x = x + (beta / thickness) * flow.line[b, FLUX, m]
            flow.change[b, j, m] = x
            p = c
            c = right
