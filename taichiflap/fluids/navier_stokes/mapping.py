"""The conformal map of the exterior of a bent section, computed in each step, and the resulting grid.

The contour is y + i z = (1 + cos s)/2 + i (W + b sin s), an ellipse sheared along the wing's normal by its deflection
W. The angles s(phi) that the points of the unit circle correspond to are found by Wegmann's iteration (Numer. Math.
30, 1978), a Riemann-Hilbert problem in each pass that the conjugate function solves; it starts from an extrapolation
in time and converges quadratically. The coefficients of the map are the contour's Fourier coefficients by phi.
"""

from ...kernels.runtime import Octet, View, ti
from ...march.state import AMPLITUDE
from . import fourier
from .arrays import (
    CENTRE_COS,
    CENTRE_SIN,
    CORNER_COS,
    CORNER_SIN,
    DECAYED,
    GROWN,
    HALF_THICKNESS,
    HILBERT,
    INTEGRAL,
    INVERSE,
    LINES,
    MODAL_LINES,
    OCTETS,
    ROWS,
    SERIES,
    SHAPE,
    SLOPE_Y,
    SLOPE_Z,
    SMOOTH,
    TERMS,
    WALL_Y,
    WALL_Z,
)
from .fourier import POINTS
from .transport import before

PASSES = 8
"""Passes after which the iteration is given up."""
CONVERGED = 1e-6
"""Largest change of s in a pass after which the next would change it by round-off."""
SMALLEST = 1e-14
"""Terms of the map below this, chords, are left out where they are."""

NOW, EARLIER, CIRCLE, POINT, TANGENT, DATA, SPECTRUM, GROWTH, CONTOUR_LINES = 0, 2, 4, 6, 8, 10, 12, 14, 15
"""Lines of `contour`, pairs but for the last: e^(i s) now and a step earlier, e^(i phi), the contour and its
derivative by s, what is transformed, its spectrum; and the conjugate function of the tangent's angle."""


@ti.func
def series(flow: View, b, row, x):
    """Sum of a Chebyshev series at eight x, and its derivative."""
    count = flow.size[b, SERIES]
    twice = x + x
    b1, b2, u1, u2 = Octet(0.0), Octet(0.0), Octet(0.0), Octet(0.0)
    for back in range(count - 1):
        n = count - 1 - back
        c = flow.series[b, row, n]
        b0 = twice * b1 - b2 + c
        u0 = twice * u1 - u2 + n * c
        b2, b1, u2, u1 = b1, b0, u1, u0
    return x * b1 - b2 + flow.series[b, row, 0], u1


@ti.func
def superpose_series(body: View, flow: View, b):
    """Series of the deflection, behind those of the modes and of their integrals."""
    modes = body.modes[b]
    for n in range(flow.size[b, SERIES]):
        w = 0.0
        for k in range(modes):
            w += body.q_predicted[b, AMPLITUDE, k] * flow.series[b, k, n]
        flow.series[b, 2 * modes, n] = w


@ti.func
def trace(flow: View, b, m, deflection):
    """The contour and its derivative by s at an octet of points."""
    cosine, sine = flow.contour[b, NOW, m], flow.contour[b, NOW + 1, m]
    half = flow.number[b, HALF_THICKNESS]
    w, slope = series(flow, b, deflection, cosine)
    flow.contour[b, POINT, m] = 0.5 + 0.5 * cosine
    flow.contour[b, POINT + 1, m] = w + half * sine
    flow.contour[b, TANGENT, m] = sine * -0.5
    flow.contour[b, TANGENT + 1, m] = half * cosine - sine * slope


@ti.func
def tangent_angle(flow: View, b, m):
    """Angle of the tangent minus phi; it stays near pi/2, so that no branch is crossed."""
    c, s = flow.contour[b, CIRCLE, m], flow.contour[b, CIRCLE + 1, m]
    dy, dz = flow.contour[b, TANGENT, m], flow.contour[b, TANGENT + 1, m]
    real, imaginary = dy * c + dz * s, dz * c - dy * s
    angle = Octet(0.0)
    for at in ti.static(range(8)):
        angle[at] = ti.static(float(3.141592653589793 / 2)) + ti.atan2(0.0 - real[at], imaginary[at])
    return angle


@ti.func
def turned(flow: View, b, m):
    """e^(-i beta) / e of an octet, beta the tangent's angle less phi: (real, imaginary)."""
    dy, dz = flow.contour[b, TANGENT, m], flow.contour[b, TANGENT + 1, m]
    inverse = Octet(1.0) / ti.sqrt(dy * dy + dz * dz)
    return dy * inverse, dz * inverse * -1.0


@ti.func
def exponential(x):
    """e^x lane by lane."""
    y = Octet(0.0)
    for at in ti.static(range(8)):
        y[at] = ti.exp(x[at])
    return y


@ti.func
def rotate(flow: View, b, m, angle):
    """Turn e^(i s) of an octet by a small angle; returns the largest."""
    a2 = angle * angle
    c = 1.0 - a2 * (1.0 / 2) * (
        1.0 - a2 * (1.0 / 12) * (1.0 - a2 * (1.0 / 30) * (1.0 - a2 * (1.0 / 56) * (1.0 - a2 * (1.0 / 90))))
    )
    s = angle * (
        1.0
        - a2
        * (1.0 / 6)
        * (1.0 - a2 * (1.0 / 20) * (1.0 - a2 * (1.0 / 42) * (1.0 - a2 * (1.0 / 72) * (1.0 - a2 * (1.0 / 110)))))
    )
    x, y = flow.contour[b, NOW, m], flow.contour[b, NOW + 1, m]
    store(flow, b, m, x * c - y * s, x * s + y * c)
    largest = 0.0
    for at in ti.static(range(8)):
        largest = ti.max(largest, ti.abs(angle[at]))
    return largest


@ti.func
def store(flow: View, b, m, x, y):
    """Store e^(i s), normalised to length one."""
    inverse = Octet(1.0) / ti.sqrt(x * x + y * y)
    flow.contour[b, NOW, m] = x * inverse
    flow.contour[b, NOW + 1, m] = y * inverse


@ti.func
def find_map(body: View, flow: View, b):  # noqa: PLR0915 - one loop nest
    """Coefficients of the map of the section at the predicted deflection; returns whether the iteration converged."""
    octets = flow.plan[b, 1, POINTS]
    points = 8 * octets
    deflection = 2 * body.modes[b]
    superpose_series(body, flow, b)
    for m in range(octets):
        x, y = flow.contour[b, NOW, m], flow.contour[b, NOW + 1, m]
        u, v = flow.contour[b, EARLIER, m], flow.contour[b, EARLIER + 1, m]
        flow.contour[b, EARLIER, m] = x
        flow.contour[b, EARLIER + 1, m] = y
        # s goes on as it went: e^(i s) squared over the earlier.
        c, s = x * u + y * v, y * u - x * v
        store(flow, b, m, x * c - y * s, x * s + y * c)
    converged, finished = False, False
    for _ in range(PASSES + 1):
        if not finished:
            for m in range(octets):
                trace(flow, b, m, deflection)
            if converged:
                finished = True
            middle, cotangent, offset, largest = 0.0, 0.0, 0.0, 0.0
            for stage in range(3):
                if not finished or stage == 0:
                    mean = 0.0
                    for m in range(octets):
                        data, other = Octet(0.0), Octet(0.0)
                        if finished:
                            data, other = flow.contour[b, POINT, m], flow.contour[b, POINT + 1, m]
                        elif stage == 0:
                            data = tangent_angle(flow, b, m) * -1.0
                        elif stage == 1:
                            tau = flow.contour[b, GROWTH, m]
                            y, z = flow.contour[b, POINT, m], flow.contour[b, POINT + 1, m]
                            real, imaginary = turned(flow, b, m)
                            # e^(-i beta) g / e is g over the tangent's direction.
                            data = exponential(tau) * (y * imaginary + z * real)
                        else:
                            data = correction(flow, b, m, cotangent * offset)
                        flow.contour[b, DATA, m] = data
                        flow.contour[b, DATA + 1, m] = other
                        for at in ti.static(range(8)):
                            mean += data[at]
                    mean /= points
                    if stage == 0:
                        middle = 0.0 - mean
                        cotangent = ti.cos(middle) / ti.sin(middle)
                    elif stage == 1:
                        offset = mean
                    factor = HILBERT
                    if stage == 2:
                        factor = SMOOTH
                    fourier.forward(
                        flow.contour, flow.contour, flow.work, flow.root, flow.twiddle, flow.plan,
                        b, 1, DATA, DATA + 1, SPECTRUM, SPECTRUM + 1,
                    )  # fmt: skip
                    if not finished:
                        fourier.inverse(
                            flow.contour, flow.contour, flow.work, flow.root, flow.twiddle, flow.slot, flow.plan,
                            b, 1, factor, SPECTRUM, SPECTRUM + 1, DATA, DATA + 1,
                        )  # fmt: skip
                        for m in range(octets):
                            if stage == 0:
                                flow.contour[b, GROWTH, m] = flow.contour[b, DATA, m]
                            elif stage == 2:
                                largest = ti.max(largest, rotate(flow, b, m, flow.contour[b, DATA, m]))
            if not finished:
                converged = largest < CONVERGED
    read_coefficients(flow, b)
    return finished


@ti.func
def correction(flow: View, b, m, shift):
    """Change of s in a pass at an octet of points."""
    real, imaginary = turned(flow, b, m)
    decay = exponential(flow.contour[b, GROWTH, m] * -1.0)
    # F = f e^-T e, and (F - g) over the derivative: f e^-tau less g over the tangent's direction, over its length.
    y, z = flow.contour[b, POINT, m], flow.contour[b, POINT + 1, m]
    dy, dz = flow.contour[b, TANGENT, m], flow.contour[b, TANGENT + 1, m]
    along = y * real - z * imaginary
    return ((flow.contour[b, DATA, m] - shift) * decay - along) / ti.sqrt(dy * dy + dz * dz)


@ti.func
def read_coefficients(flow: View, b):
    """r and a_n from the spectra of the contour's two coordinates."""
    scale = 1.0 / (8 * flow.plan[b, 1, POINTS])
    start = 16 * flow.size[b, OCTETS]
    for n in range(-1, flow.size[b, TERMS]):
        place = flow.equation[b, start + ti.abs(n)]
        sign = 1.0
        if place < 0:
            sign = -1.0
        at = ti.abs(place) - 1
        row, lane = 2 * (at // 8), at % 8
        xr, xi = flow.contour[b, SPECTRUM, row], flow.contour[b, SPECTRUM, row + 1]
        zr, zi = flow.contour[b, SPECTRUM + 1, row], flow.contour[b, SPECTRUM + 1, row + 1]
        if n < 0:
            flow.coefficient[b, 0, 0] = (xr[lane] - sign * zi[lane]) * scale
            flow.coefficient[b, 0, 1] = (sign * xi[lane] + zr[lane]) * scale
        else:
            flow.coefficient[b, n + 1, 0] = (xr[lane] + sign * zi[lane]) * scale
            flow.coefficient[b, n + 1, 1] = (zr[lane] - sign * xi[lane]) * scale


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
