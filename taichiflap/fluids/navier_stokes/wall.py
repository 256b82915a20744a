"""The wall: its motion, and the flux of vorticity that satisfies the no-slip condition.

The flux of circulation `g` (over dphi and time) that the wall feeds into the first row is found implicitly: the factor
along rho answers a change dg column by column with `w += response dg`, the slip is then linear in dg, and the influence
matrix of it is inverted once for a rigid section, and now and then for a bending one. The mean of g follows from a
pressure of one value: mean(g) = -mean(Im(a conj G)).

Everything is linear in the modal rates and accelerations: dg has a part for the motion that is known and one for each
mode.
"""

from ...kernels.runtime import Octet, View, ti
from ...march.state import ACCEL, COSINE, RATE, SINE
from ...motion.sampling import (
    PITCH_ACCEL,
    PITCH_RATE,
    PLUNGE_ACCEL,
    PLUNGE_RATE,
    SURGE_ACCEL,
    SURGE_RATE,
)
from . import gust
from .arrays import (
    ACCELERATION,
    BASE,
    FELT,
    FLUX,
    INTEGRAL,
    IS_ZERO,
    LENGTH,
    LINES,
    MODAL,
    MODAL_LINES,
    MODAL_STREAM,
    OCTETS,
    OF_MEAN,
    RESPONSE,
    SCALE,
    SHAPE,
    SLOPE_Y,
    SLOPE_Z,
    STEP,
    STREAM_Y,
    STREAM_Z,
    STREAMS,
    TANGENT,
    WALL_SPECTRA,
    WALL_STREAM,
    WALL_Y,
    WALL_Z,
    WAVE,
)
from .influence import oppose_slip
from .plan import SLOTS


@ti.func
def total(x):
    """Sum of the lanes."""
    return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]))


@ti.func
def pivot(body: View, flow: View, b, n):
    """Velocity of the pivot relative to the stream, and its acceleration, along e_y and e_z, in chords."""
    cosine, sine = body.motion[b, n, COSINE], body.motion[b, n, SINE]
    unit = 1.0 / flow.number[b, LENGTH]
    along_y = (body.motion[b, n, SURGE_RATE] - flow.number[b, STREAM_Y]) * unit
    along_z = (body.motion[b, n, PLUNGE_RATE] - flow.number[b, STREAM_Z]) * unit
    gain_y, gain_z = body.motion[b, n, SURGE_ACCEL] * unit, body.motion[b, n, PLUNGE_ACCEL] * unit
    return (
        along_z * sine + along_y * cosine,
        along_z * cosine - along_y * sine,
        gain_z * sine + gain_y * cosine,
        gain_z * cosine - gain_y * sine,
    )


@ti.func
def move_wall(body: View, flow: View, b, n, used: View):
    """Tangential velocity, streamfunction and acceleration of the wall without modal motion, and those of each mode."""
    v_y, v_z, a_y, a_z = pivot(body, flow, b, n)
    rate, gain = body.motion[b, n, PITCH_RATE], body.motion[b, n, PITCH_ACCEL]
    scale = flow.number[b, SCALE]
    lead, s_y, s_z = gust.front(body, flow, b, n)
    for m in range(flow.size[b, OCTETS]):
        y, z = flow.line[b, WALL_Y, m], flow.line[b, WALL_Z, m]
        g_y, g_z = flow.line[b, SLOPE_Y, m], flow.line[b, SLOPE_Z, m]
        bending = Octet(0.0)
        for k in range(body.modes[b]):
            line = LINES + MODAL_LINES * k
            shape = flow.line[b, line + SHAPE, m]
            bending = bending + body.q_predicted[b, RATE, k] * shape
            flow.line[b, line + MODAL, m] = shape * g_y * scale
            flow.line[b, line + MODAL_STREAM, m] = flow.line[b, line + INTEGRAL, m] * (0.0 - scale)
        flow.line[b, TANGENT, m] = ((v_z + rate * y) * g_y - (v_y - rate * z) * g_z) * scale
        flow.line[b, WALL_STREAM, m] = (v_y * z - v_z * y - (0.5 * rate) * (y * y + z * z)) * scale
        # Coriolis' acceleration of the bending points along the chord.
        along = a_y - gain * z - (rate * rate) * y - (2.0 * rate) * bending
        across = a_z + gain * y - (rate * rate) * z
        flow.line[b, ACCELERATION, m] = across * g_y - along * g_z
        if ti.static(used.gusts):
            if gust.blows(flow, b):
                gust.blow_on_wall(flow, b, m, lead, s_y, s_z, v_y - rate * z, v_z + rate * y + bending)


@ti.func
def hold_wall(body: View, flow: View, b):
    """Changes of the wall flux due to the motion without modes, and per unit rate of each mode."""
    base, octets = flow.size[b, BASE], flow.size[b, OCTETS]
    walls = base + WALL_SPECTRA
    defect = walls + 2 * body.modes[b] + 2
    flow.spectra[b, walls + 1, 0] = flow.spectra[b, walls + 1, 0] * (1.0 - flow.slot[b, IS_ZERO, 0])
    mean = Octet(0.0)
    for m in range(octets):
        mean = mean - (flow.line[b, ACCELERATION, m] + flow.line[b, FLUX, m])
    for m in range(octets):
        # The influence matrix's first equation is the mean.
        for lane_ in ti.static(range(8)):
            whole = flow.influence[b, 8 * m + lane_, octets]
            flow.line[b, OF_MEAN, m][lane_] = whole[0]
    for wall in range(body.modes[b] + 1):
        out, asked = STEP, total(mean) * flow.number[b, SCALE]
        if wall > 0:
            out, asked = LINES + MODAL_LINES * (wall - 1) + RESPONSE, 0.0
        for s in range(flow.plan[b, 0, SLOTS]):
            wave = flow.slot[b, WAVE, s]
            for part in ti.static(range(2)):
                i = 2 * s + part
                x = wave * flow.spectra[b, walls + 2 * wall + 1, i] - flow.spectra[b, walls + 2 * wall, i]
                if wall == 0:
                    x = x - flow.spectra[b, 0, i]
                flow.spectra[b, defect, i] = x
        oppose_slip(flow, b, defect, asked, out)


@ti.func
def mean_acceleration(flow: View, b, k):
    """Mean of Im(a conj G) for a unit acceleration of mode `k`; the mean of g has the opposite sign."""
    line = LINES + MODAL_LINES * k + MODAL
    mean = Octet(0.0)
    for m in range(flow.size[b, OCTETS]):
        mean = mean + flow.line[b, line, m]
    return total(mean)


@ti.func
def settle_wall(body: View, flow: View, b, n):
    """At the known modal rates: the wall flux, its effect on the near rows, and the streamfunction on the wall.

    Returns:
        The mean of Im(V conj G).
    """
    octets, modes = flow.size[b, OCTETS], body.modes[b]
    turned = 0.0
    if n > 0:
        for k in range(modes):
            turned += body.q[b, ACCEL, k] * mean_acceleration(flow, b, k)
    for m in range(octets):
        step, tangent = flow.line[b, STEP, m], flow.line[b, TANGENT, m]
        for k in range(modes):
            line = LINES + MODAL_LINES * k
            moved = body.q[b, RATE, k]
            tangent = tangent + moved * flow.line[b, line + MODAL, m]
            if n == 0:
                moved = body.q[b, ACCEL, k]
            step = step + moved * flow.line[b, line + RESPONSE, m]
            gain = body.q[b, ACCEL, k] * flow.line[b, line + SHAPE, m] * flow.line[b, SLOPE_Y, m]
            flow.line[b, ACCELERATION, m] = flow.line[b, ACCELERATION, m] + gain
        step = step - turned * flow.line[b, OF_MEAN, m]
        flow.line[b, STEP, m] = step
        flow.line[b, TANGENT, m] = tangent
        flow.line[b, FLUX, m] = flow.line[b, FLUX, m] + step
    mean = Octet(0.0)
    for m in range(octets):
        mean = mean + flow.line[b, TANGENT, m]
    walls, streams = flow.size[b, BASE] + WALL_SPECTRA, flow.size[b, BASE] + STREAMS
    for i in range(2 * flow.plan[b, 0, SLOTS]):
        stream = flow.spectra[b, walls + 1, i]
        for k in range(modes):
            stream = stream + body.q[b, RATE, k] * flow.spectra[b, walls + 2 * k + 3, i]
        flow.spectra[b, streams, i] = stream
    flow.spectra[b, streams, 0] = flow.spectra[b, streams, 0] * (1.0 - flow.slot[b, IS_ZERO, 0])
    return total(mean)


@ti.func
def feed_rows(flow: View, b, bends):
    """Add the effect of the change of the wall flux to the near rows."""
    for j in range(flow.size[b, FELT]):
        for m in range(flow.size[b, OCTETS]):
            more = flow.response[b, j, m] * flow.line[b, STEP, m]
            flow.vorticity[b, j, m] = flow.vorticity[b, j, m] + more
            more = flow.area[b, j, m] * more
            flow.change[b, j, m] = flow.change[b, j, m] + more
            if bends:
                flow.content[b, j, m] = flow.content[b, j, m] + more
