"""The streamfunction of the vorticity in an unbounded fluid, one wavenumber at a time.

With `u = (psi_z, -psi_y)` in the wing's axes, `psi_rhorho + psi_phiphi = -J w` on any grid of this kind. For each
wavenumber k, `A = psi' + k psi` obeys `A' - k A = -(J w)_k` and is integrated inwards from A = 0, which is what free
space outside asks for; then `psi' = A - k psi` is integrated outwards from the wall. Both integrals are exact for a
source that is constant in each row, with `E = e^(-k drho)`:

    A_j = E A_{j+1} + (1 - E)/k (J w)_k,        psi_{j+1} = E psi_j + (1 - E)/(2k) (A_j + A_{j+1}).
"""

from ...kernels.runtime import Octet, View, ti
from ...motion.sampling import PITCH_RATE
from . import fourier, gust
from .arrays import (
    ALIKE,
    BASE,
    CORNER_COS,
    CORNER_SIN,
    DECAYED,
    GROWN,
    HALF,
    INVERSE_K,
    IS_ZERO,
    LINES,
    MODAL,
    MODAL_LINES,
    NEAR,
    OCTETS,
    ROWS,
    SCALE,
    SOURCE,
    SOURCES,
    STREAM_LINES,
    STREAMS,
    TANGENT,
    THICKNESS,
    WALL_SPECTRA,
)
from .factors import substitute
from .plan import SLOTS
from .transport import before


@ti.func
def decay_across(flow: View, b, j, s):
    """E of a row at a slot's wavenumbers."""
    return flow.decay[b, ti.min(j, flow.size[b, ALIKE]), s]


@ti.func
def weight(flow: View, b, j, s, decay):
    """(1 - E)/k of a row, drho for k = 0."""
    q = (1.0 - decay) * flow.slot[b, INVERSE_K, s]
    if s == 0:
        q = q + flow.row[b, j, THICKNESS] * flow.slot[b, IS_ZERO, 0]
    return q


@ti.func
def transform_inwards(flow: View, b, rows, stepping, walls, bends):
    """A of the inner `rows` rows, from the outermost inwards; and the spectra of `walls` pairs of wall lines.

    Args:
        stepping: whether the step's factor along rho is still to be substituted back.
        walls: the first pair are the wall's tangential velocity and streamfunction; one more for every mode.
    """
    octets, base = flow.size[b, OCTETS], flow.size[b, BASE]
    scale = flow.number[b, SCALE]
    pairs = rows // 2
    for pair in range(pairs + walls):
        j = rows - 2 - 2 * pair
        i0, i1 = SOURCE, SOURCE + 1
        o0, o1 = base + SOURCES, base + SOURCES + 1
        if pair < pairs:
            for back in range(2):
                r = j + 1 - back
                if stepping:
                    substitute(flow, b, r, SOURCE + 1 - back, scale, bends)
                else:
                    for m in range(octets):
                        flow.line[b, SOURCE + 1 - back, m] = flow.area[b, r, m] * flow.vorticity[b, r, m] * scale
        else:
            wall = pair - pairs
            o0 = base + WALL_SPECTRA + 2 * wall
            o1 = o0 + 1
            i0, i1 = TANGENT, TANGENT + 1
            if wall > 0:
                i0 = LINES + MODAL_LINES * (wall - 1) + MODAL
                i1 = i0 + 1
        fourier.forward(flow.line, flow.spectra, flow.work, flow.root, flow.twiddle, flow.plan, b, 0, i0, i1, o0, o1)
        if pair < pairs:
            for s in range(flow.plan[b, 0, SLOTS]):
                for back in range(2):
                    r = j + 1 - back
                    e = decay_across(flow, b, r, s)
                    q = weight(flow, b, r, s, e)
                    for part in ti.static(range(2)):
                        flow.spectra[b, r, 2 * s + part] = (
                            e * flow.spectra[b, r + 1, 2 * s + part] + q * flow.spectra[b, o0 + 1 - back, 2 * s + part]
                        )


@ti.func
def climb(flow: View, b, j, below, above, circulation):
    """The streamfunction's spectrum at face j + 1 from that at face j; `circulation` is added to A of k = 0."""
    for s in range(flow.plan[b, 0, SLOTS]):
        e = decay_across(flow, b, j, s)
        q = 0.5 * weight(flow, b, j, s, e)
        for part in ti.static(range(2)):
            i = 2 * s + part
            flow.spectra[b, above, i] = e * flow.spectra[b, below, i] + q * (
                flow.spectra[b, j, i] + flow.spectra[b, j + 1, i]
            )
    more = flow.row[b, j, THICKNESS] * circulation
    flow.spectra[b, above, 0] = flow.spectra[b, above, 0] + more * flow.slot[b, IS_ZERO, 0]


@ti.func
def transform_outwards(body: View, flow: View, b, n, v_y, v_z, circulation, bends, used: View):
    """Streamfunction at the corners, from the wall's out, and from it the fluxes through the faces, relative to them.

    The faces move with the wing, at the pivot's velocity (v_y, v_z) and the pitch rate, and as the section bends; a
    gust goes through them too.
    """
    octets, near, base = flow.size[b, OCTETS], flow.size[b, NEAR], flow.size[b, BASE]
    streams = base + STREAMS
    spin = 0.5 * body.motion[b, n, PITCH_RATE]
    lead, s_y, s_z = gust.front(body, flow, b, n)
    for pair in range((flow.size[b, ROWS] + 2) // 2):
        j = 2 * pair
        if j > 0:
            climb(flow, b, j - 1, streams + (j - 1) % 4, streams + j % 4, circulation)
        climb(flow, b, j, streams + j % 4, streams + (j + 1) % 4, circulation)
        i0 = streams + j % 4
        o0 = STREAM_LINES + j % 4
        fourier.inverse(
            flow.spectra, flow.line, flow.work, flow.root, flow.twiddle, flow.slot, flow.plan,
            b, 0, HALF, i0, i0 + 1, o0, o0 + 1,
        )  # fmt: skip
        for face in range(j, j + 2):
            here, below = STREAM_LINES + face % 4, STREAM_LINES + (face + 3) % 4
            if ti.static(used.gusts):
                if gust.blows(flow, b):
                    gust.blow_on_corners(flow, b, face, here, lead, s_y, s_z)
            y, z = corner(flow, b, face, octets - 1, bends)
            last = flow.line[b, here, octets - 1] - (v_y * z - v_z * y - spin * (y * y + z * z))
            last_y, last_z = y, z
            for m in range(octets):
                y, z = corner(flow, b, face, m, bends)
                psi = flow.line[b, here, m] - (v_y * z - v_z * y - spin * (y * y + z * z))
                flow.line[b, here, m] = psi
                q = psi - before(last, psi, 1)
                if bends:
                    q = q - swept_along(flow, b, face, m, octets, last_y, last_z)
                    last_y, last_z = y, z
                last = psi
                if face <= near:
                    ahead = q
                    if n > 0:
                        ahead = 2.0 * q - flow.flux_rho[b, face, m]
                    flow.ahead_rho[b, face, m] = ahead
                flow.flux_rho[b, face, m] = q
                if face > 0:
                    p = flow.line[b, below, m] - psi
                    if bends:
                        p = p + swept_across(flow, b, face, m)
                    if face <= near:
                        ahead = p
                        if n > 0:
                            ahead = 2.0 * p - flow.flux_phi[b, face - 1, m]
                        flow.ahead_phi[b, face - 1, m] = ahead
                    flow.flux_phi[b, face - 1, m] = p


@ti.func
def corner(flow: View, b, face, m, bends):
    """Corners of an octet of cells; those of a straight section are worked out, which is faster than to read them."""
    y, z = Octet(0.0), Octet(0.0)
    if bends:
        y, z = flow.corner_y[b, face, m], flow.corner_z[b, face, m]
    else:
        out, inwards = flow.row[b, face, GROWN], flow.row[b, face, DECAYED]
        lead, third = out * flow.coefficient[b, 0, 0], inwards * flow.coefficient[b, 2, 0]
        y = (lead + third) * flow.line[b, CORNER_COS, m] + flow.coefficient[b, 1, 0]
        z = (lead - third) * flow.line[b, CORNER_SIN, m]
    return y, z


@ti.func
def swept_along(flow: View, b, face, m, octets, last_y, last_z):
    """Rate at which the faces between rows sweep area due to bending; `last` are the corners of the previous octet."""
    back = (m + octets - 1) % octets
    y, z = flow.corner_y[b, face, m], flow.corner_z[b, face, m]
    u, v = flow.rate_y[b, face, m], flow.rate_z[b, face, m]
    mean_y = 0.5 * (u + before(flow.rate_y[b, face, back], u, 1))
    mean_z = 0.5 * (v + before(flow.rate_z[b, face, back], v, 1))
    return mean_y * (z - before(last_z, z, 1)) - mean_z * (y - before(last_y, y, 1))


@ti.func
def swept_across(flow: View, b, face, m):
    """Rate at which the faces between the cells of the row below `face` sweep area while the section bends."""
    mean_y = 0.5 * (flow.rate_y[b, face, m] + flow.rate_y[b, face - 1, m])
    mean_z = 0.5 * (flow.rate_z[b, face, m] + flow.rate_z[b, face - 1, m])
    dy = flow.corner_y[b, face, m] - flow.corner_y[b, face - 1, m]
    dz = flow.corner_z[b, face, m] - flow.corner_z[b, face - 1, m]
    return mean_y * dz - mean_z * dy
