"""The gust in the free stream, on the wall and in the cells.

The fluid's velocity is that of the stream, of the gust and of a disturbance u'; the gust is carried along unchanged
(`taichiflap.motion.gust`), and its own vorticity does not change that of the disturbance ("field velocity": Singh &
Baeder, J. Aircraft 34, 1997). What is left is a wall that moves with `V - u_gust` in a fluid whose vorticity the gust
carries along too. The gust is the streamfunction `psi = w H(x)`, H being the integral of its shape over the distance x
behind its front, so that the fluxes through a cell's faces add to nothing.
"""

import math

from ...kernels.runtime import Octet, View, ti
from ...march.state import COSINE, SINE
from ...march.stream import ALONG_Y, ALONG_Z, EDGE, FRONT, KIND, LENGTH, NONE, SHARP_EDGED, SINUSOIDAL, SPEED
from ...motion.sampling import PLUNGE, SURGE
from . import arrays
from .arrays import ACCELERATION, OCTETS, SCALE, SLOPE_Y, SLOPE_Z, TANGENT, WALL_STREAM, WALL_Y, WALL_Z

PIECES = 20
"""Of the chord; over one of them a sharp edge is drawn out."""


@ti.func
def blows(flow: View, b):
    """Whether there is a gust."""
    return flow.gust[b, KIND] > NONE


@ti.func
def front(body: View, flow: View, b, n):
    """Distance of the front ahead of the pivot, m, and direction of the stream along e_y and e_z."""
    cosine, sine = body.motion[b, n, COSINE], body.motion[b, n, SINE]
    along_y, along_z = flow.gust[b, ALONG_Y], flow.gust[b, ALONG_Z]
    lead = flow.gust[b, FRONT] - along_y * body.motion[b, n, SURGE] - along_z * body.motion[b, n, PLUNGE]
    return lead, along_y * cosine + along_z * sine, along_z * cosine - along_y * sine


@ti.func
def shape(gust: View, b, behind):
    """Fraction of the gust's velocity at a distance (m) behind its front; its integral from there, and its slope."""
    length = gust[b, LENGTH]
    x = ti.max(behind, 0.0)
    share, integral, slope = 0.0, 0.0, 0.0
    if gust[b, KIND] == SHARP_EDGED:
        edge = gust[b, EDGE]
        x = ti.min(ti.max(behind / edge + 0.5, 0.0), 1.0)
        share = x * x * (3.0 - 2.0 * x)
        integral = edge * x * x * x * (1.0 - 0.5 * x) + ti.max(behind - 0.5 * edge, 0.0)
        slope = 6.0 * x * (1.0 - x) / edge
    elif gust[b, KIND] == SINUSOIDAL:
        wave = 2.0 * math.pi / length
        share = ti.sin(wave * x)
        integral = (1.0 - ti.cos(wave * x)) / wave
        if behind > 0.0:
            slope = wave * ti.cos(wave * x)
    else:
        x = ti.min(x, length)
        wave = 2.0 * math.pi / length
        share = 0.5 - 0.5 * ti.cos(wave * x)
        integral = 0.5 * x - 0.5 / wave * ti.sin(wave * x)
        slope = 0.5 * wave * ti.sin(wave * x)
    return share, integral, slope


@ti.func
def shape_at(flow: View, b, lead, s_y, s_z, y, z):
    """`shape` at eight points (chords) in the wing's axes."""
    share, integral, slope = Octet(0.0), Octet(0.0), Octet(0.0)
    behind = lead - flow.number[b, arrays.LENGTH] * (s_y * y + s_z * z)
    for lane in ti.static(range(8)):
        one, two, three = shape(flow.gust, b, behind[lane])
        share[lane] = one
        integral[lane] = two
        slope[lane] = three
    return share, integral, slope


@ti.func
def blow_on_wall(flow: View, b, m, lead, s_y, s_z, v_y, v_z):
    """Subtract the gust from the wall's velocity, streamfunction and acceleration, which are those of the wing alone.

    The acceleration is that of the wall in the fluid without the gust, `a - omega_gust z x u'`: so the pressure has one
    value.

    Args:
        m: the octet of points.
        v_y, v_z: velocity of the wall relative to the stream, along e_y and e_z.
    """
    scale, unit = flow.number[b, SCALE], 1.0 / flow.number[b, arrays.LENGTH]
    speed = flow.gust[b, SPEED]
    g_y, g_z = flow.line[b, SLOPE_Y, m], flow.line[b, SLOPE_Z, m]
    share, integral, slope = shape_at(flow, b, lead, s_y, s_z, flow.line[b, WALL_Y, m], flow.line[b, WALL_Z, m])
    across = (speed * unit) * share
    flow.line[b, TANGENT, m] = flow.line[b, TANGENT, m] - scale * across * (g_y * s_y + g_z * s_z)
    flow.line[b, WALL_STREAM, m] = flow.line[b, WALL_STREAM, m] - (speed * unit * unit * scale) * integral
    # The gust's vorticity is the other way round: its share rises behind the front, against the stream.
    spin = speed * slope
    turned = (v_y + s_z * across) * g_y + (v_z - s_y * across) * g_z
    flow.line[b, ACCELERATION, m] = flow.line[b, ACCELERATION, m] + spin * turned


@ti.func
def blow_on_corners(flow: View, b, face, line, lead, s_y, s_z):
    """Add the gust's streamfunction to that at the corners of a face, in a line."""
    unit = 1.0 / flow.number[b, arrays.LENGTH]
    for m in range(flow.size[b, OCTETS]):
        y, z = flow.corner_y[b, face, m], flow.corner_z[b, face, m]
        _, integral, _ = shape_at(flow, b, lead, s_y, s_z, y, z)
        flow.line[b, line, m] = flow.line[b, line, m] + (flow.gust[b, SPEED] * unit * unit) * integral
