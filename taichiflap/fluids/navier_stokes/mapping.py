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
    HALF_THICKNESS,
    HILBERT,
    OCTETS,
    SERIES,
    SMOOTH,
    TERMS,
)
from .plan import POINTS

PASSES = 8
"""Passes after which the iteration is given up."""
CONVERGED = 1e-6
"""Largest change of s in a pass after which the next would change it by round-off."""
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
