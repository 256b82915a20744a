"""Where a map puts the grid of a bent section: the cells' corners and their rates, and the points of the wall."""

from ...kernels.runtime import Octet, View, ti
from .arrays import (
    CENTRE_COS,
    CENTRE_SIN,
    CORNER_COS,
    CORNER_SIN,
    DECAYED,
    GROWN,
    INTEGRAL,
    INVERSE,
    LINES,
    MODAL_LINES,
    OCTETS,
    ROWS,
    SHAPE,
    SLOPE_Y,
    SLOPE_Z,
    TERMS,
    WALL_Y,
    WALL_Z,
)
from .mapping import series
from .transport import before

SMALLEST = 1e-14
"""Terms of the map below this, chords, are left out where they are."""


@ti.func
def place_corners(flow: View, b, n, dt):
    """Corners of the cells by Horner's rule, their velocities, and the areas of the cells."""
    octets, rows = flow.size[b, OCTETS], flow.size[b, ROWS]
    last = flow.size[b, TERMS] - 1
    r_y, r_z = flow.coefficient[b, 0, 0], flow.coefficient[b, 0, 1]
    for j in range(rows + 1):
        out, inwards = flow.row[b, j, GROWN], flow.row[b, j, DECAYED]
        power = ti.pow(inwards, 1.0 * last)
        for _ in range(last):
            size = ti.abs(flow.coefficient[b, last + 1, 0]) + ti.abs(flow.coefficient[b, last + 1, 1])
            if size * power < SMALLEST:
                last -= 1
                power *= out
        for pair in range(octets // 2):
            ca, sa = flow.line[b, CORNER_COS, 2 * pair], flow.line[b, CORNER_SIN, 2 * pair]
            cb, sb = flow.line[b, CORNER_COS, 2 * pair + 1], flow.line[b, CORNER_SIN, 2 * pair + 1]
            pa, qa, pb, qb = ca * inwards, sa * inwards, cb * inwards, sb * inwards
            a_y, a_z = flow.coefficient[b, last + 1, 0], flow.coefficient[b, last + 1, 1]
            ya, za, yb, zb = Octet(a_y), Octet(a_z), Octet(a_y), Octet(a_z)
            for back in range(last):
                a_y, a_z = flow.coefficient[b, last - back, 0], flow.coefficient[b, last - back, 1]
                ta, tb = ya * pa + za * qa + a_y, yb * pb + zb * qb + a_y
                za, zb = za * pa - ya * qa + a_z, zb * pb - yb * qb + a_z
                ya, yb = ta, tb
            move_corner(flow, b, j, 2 * pair, n, dt, ya + out * (r_y * ca - r_z * sa), za + out * (r_y * sa + r_z * ca))
            move_corner(
                flow, b, j, 2 * pair + 1, n, dt, yb + out * (r_y * cb - r_z * sb), zb + out * (r_y * sb + r_z * cb)
            )
        if j > 0:
            measure_row(flow, b, j - 1)


@ti.func
def move_corner(flow: View, b, j, m, n, dt, y, z):
    """New position of a corner, and its velocity by BDF2."""
    dy, dz = y - flow.corner_y[b, j, m], z - flow.corner_z[b, j, m]
    now, then = 1.5 / dt, 0.5 / dt
    if n == 1:
        now, then = 1.0 / dt, 0.0
    flow.rate_y[b, j, m] = now * dy - then * flow.moved_y[b, j, m]
    flow.rate_z[b, j, m] = now * dz - then * flow.moved_z[b, j, m]
    flow.moved_y[b, j, m] = dy
    flow.moved_z[b, j, m] = dz
    flow.corner_y[b, j, m] = y
    flow.corner_z[b, j, m] = z


@ti.func
def measure_row(flow: View, b, j):
    """J of a row's cells: the quadrilaterals between the corners, over drho dphi."""
    octets = flow.size[b, OCTETS]
    scale = 0.5 * flow.row[b, j, INVERSE]
    py, pz = flow.corner_y[b, j, octets - 1], flow.corner_z[b, j, octets - 1]
    qy, qz = flow.corner_y[b, j + 1, octets - 1], flow.corner_z[b, j + 1, octets - 1]
    for m in range(octets):
        y, z = flow.corner_y[b, j, m], flow.corner_z[b, j, m]
        u, v = flow.corner_y[b, j + 1, m], flow.corner_z[b, j + 1, m]
        rising_y, rising_z = u - before(py, y, 1), v - before(pz, z, 1)
        falling_y, falling_z = y - before(qy, u, 1), z - before(qz, v, 1)
        flow.area[b, j, m] = scale * (rising_y * falling_z - rising_z * falling_y)
        py, pz, qy, qz = y, z, u, v


@ti.func
def place_wall(body: View, flow: View, b):
    """Position and slope of the map on the wall at the cells' centres, and the modes and their integrals there."""
    last = flow.size[b, TERMS] - 1
    r_y, r_z = flow.coefficient[b, 0, 0], flow.coefficient[b, 0, 1]
    modes = body.modes[b]
    for m in range(flow.size[b, OCTETS]):
        c, s = flow.line[b, CENTRE_COS, m], flow.line[b, CENTRE_SIN, m]
        y, z, g, h = Octet(0.0), Octet(0.0), Octet(0.0), Octet(0.0)
        for back in range(last + 1):
            n = last - back
            a_y, a_z = flow.coefficient[b, n + 1, 0], flow.coefficient[b, n + 1, 1]
            t, u = y * c + z * s + a_y, g * c + h * s + n * a_y
            z, h = z * c - y * s + a_z, h * c - g * s + n * a_z
            y, g = t, u
        lead_y, lead_z = r_y * c - r_z * s, r_y * s + r_z * c
        y = y + lead_y
        flow.line[b, WALL_Y, m] = y
        flow.line[b, WALL_Z, m] = z + lead_z
        flow.line[b, SLOPE_Y, m] = lead_y - g
        flow.line[b, SLOPE_Z, m] = lead_z - h
        x = ti.min(ti.max(2.0 * y - 1.0, -1.0), 1.0)
        for k in range(modes):
            shape, _ = series(flow, b, k, x)
            integral, _ = series(flow, b, modes + k, x)
            flow.line[b, LINES + MODAL_LINES * k + SHAPE, m] = shape
            flow.line[b, LINES + MODAL_LINES * k + INTEGRAL, m] = integral
