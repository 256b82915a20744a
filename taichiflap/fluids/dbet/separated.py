"""Separated flow: quasi-steady lift and drag of every element.

Reade & Jankauski (2020), Eqs 17-24, with the corrections named in the functions below. An element moves at `(u_t, u_n)`
along its tangent and its normal relative to the fluid, so that `sin A = u_n/U` and `cos A = u_t/U` in all four
quadrants (the arctangent of Eq. 18 covers only two), and the coefficients of Eqs 19-20 become polynomials:

    C_L U^2 = 2 C_Lmax u_t u_n,        C_D U^2 = C_D0 u_t^2 + C_Dmax u_n^2.

In the chord frame (the paper's) tangent and normal are those of the undeformed chord, e_y and e_z; in the deformed
frame those of the bent wing, of slope `s = sum_k phi'_k q_k`.
"""

from ...kernels.runtime import Octet, View, ti
from ...march.state import AMPLITUDE, COSINE, RATE, SINE, modes_of, pivot_velocity
from ...march.stream import KIND, carry_gust, gust_at_octet
from ...motion.sampling import PITCH_RATE, PLUNGE, SURGE
from ...vortex.sum import TINY
from .elements import (
    AXIAL_N,
    AXIAL_T,
    DEFORMED,
    GUST,
    GUST_BEFORE,
    GUST_BEFORE_THAT,
    GUST_Y,
    GUST_Z,
    LEAN,
    NORMAL_N,
    NORMAL_T,
    POSITION,
    SHARE,
    SHEARING,
    SLOPE,
    STRETCH,
    TRACTION,
    TRUNCATED,
    U_N,
    U_T,
    WING_Y,
    add_up,
    superpose_octet,
)

BROADSIDE = 0.1
"""Ratio of chordwise to total speed below which the rotational force changes sign smoothly between the two leading
edges, to avoid a jump at stroke reversal.
"""


@ti.func
def inverse_speed(u_t, u_n):
    """1/U of eight elements."""
    return 1.0 / ti.sqrt(u_t * u_t + u_n * u_n + TINY)


@ti.func
def normal_force(flow: View, b, u_t, u_n):
    """Force per area along -n of eight elements (Eqs 17-24; the coefficients stay inside the integral)."""
    across = flow.setting[b, NORMAL_T] * (u_t * u_t) + flow.setting[b, NORMAL_N] * (u_n * u_n)
    return u_n * (across * inverse_speed(u_t, u_n))


@ti.func
def normal_slope(flow: View, b, u_t, u_n):
    """Derivative of the normal force per area by `u_n`."""
    inverse = inverse_speed(u_t, u_n)
    broadside = flow.setting[b, NORMAL_N] * (u_n * u_n)
    across = flow.setting[b, NORMAL_T] * (u_t * u_t) + broadside
    return (across * inverse * (u_t * u_t * inverse) + 2.0 * broadside) * inverse


@ti.func
def normal_slope_along(flow: View, b, u_t, u_n):
    """Derivative of the normal force per area by `u_t`."""
    inverse = inverse_speed(u_t, u_n)
    across = flow.setting[b, NORMAL_T] * (u_t * u_t) + flow.setting[b, NORMAL_N] * (u_n * u_n)
    return u_n * inverse * (2.0 * flow.setting[b, NORMAL_T] * u_t - across * inverse * (u_t * inverse))


@ti.func
def axial_force(flow: View, b, u_t, u_n):
    """Force per area along -t: `dD cos A - dL sin A` (Eq. 23 prints cos A twice)."""
    along = flow.setting[b, AXIAL_T] * (u_t * u_t) + flow.setting[b, AXIAL_N] * (u_n * u_n)
    return u_t * (along * inverse_speed(u_t, u_n))


@ti.func
def kept_share(r_y, r_z, e_y, e_z):
    """Fraction of the squared speed `|r + e|^2` kept in the paper's Eqs 21-22, which omit the elastic `|e|^2`."""
    inverse = inverse_speed(r_y + e_y, r_z + e_z)
    return (r_y * r_y + r_z * r_z + 2.0 * (r_y * e_y + r_z * e_z)) * inverse * inverse


@ti.func
def gust_past(body: View, flow: View, b, n, block, w):
    """Set the velocity of the gust along e_y and e_z at eight elements, and its flux through them."""
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    y = flow.element[b, POSITION, block]
    place_y = body.motion[b, n, SURGE] + cosine * y - sine * w
    place_z = body.motion[b, n, PLUNGE] + sine * y + cosine * w
    along, across = gust_at_octet(flow.stream, b, place_y, place_z)
    g_y = cosine * along + sine * across
    g_z = cosine * across - sine * along
    flow.element[b, GUST_BEFORE_THAT, block] = flow.element[b, GUST_BEFORE, block]
    flow.element[b, GUST_BEFORE, block] = flow.element[b, GUST, block]
    flow.element[b, GUST, block] = flow.element[b, LEAN, block] * g_y - g_z
    flow.element[b, GUST_Y, block], flow.element[b, GUST_Z, block] = g_y, g_z


@ti.func
def rigid_velocity(flow: View, b, block, w, p_z, theta_rate, used: View):
    """u_z of eight elements without the elastic rate, and u_y without the pivot's part."""
    r_z = p_z + flow.element[b, POSITION, block] * theta_rate
    e_y = w * -theta_rate
    if ti.static(used.extended):
        if flow.stream[b, KIND] > 0.0:
            r_z = r_z - flow.element[b, GUST_Z, block]
            e_y = e_y - flow.element[b, GUST_Y, block]
    return r_z, e_y


@ti.func
def lean(body: View, flow: View, b, block, modes):
    """Slope of the bent wing at eight elements, and the stretch of its tangent."""
    slope = superpose_octet(flow.shape_slope, body.q_predicted, b, AMPLITUDE, block, modes)
    flow.element[b, LEAN, block] = slope
    flow.element[b, STRETCH, block] = 1.0 / ti.sqrt(1.0 + slope * slope)


@ti.func
def linearise(body: View, flow: View, b, n, used: View):
    """Motion of the elements and forces of separated flow at the predicted rates (Eqs 6-7, 17-27).

    Returns the means over the chord of u_n and u_t, zero where `blend` does not need them.
    """
    modes = modes_of(body, b, used.modes)
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    theta_rate = body.motion[b, n, PITCH_RATE]
    mean_n = Octet(0.0)
    mean_t = Octet(0.0)
    carry_gust(flow.stream, b, n * body.dt[b])
    for block in range((flow.elements[b] + 7) // 8):
        w = superpose_octet(flow.shape, body.q_predicted, b, AMPLITUDE, block, modes)
        w_rate = superpose_octet(flow.shape, body.q_predicted, b, RATE, block, modes)
        if ti.static(used.extended):
            flow.element[b, WING_Y, block] = p_y - w * theta_rate
            if flow.option[b, DEFORMED] == 1:
                lean(body, flow, b, block, modes)
            if flow.stream[b, KIND] > 0.0:
                gust_past(body, flow, b, n, block, w)
        r_z, e_y = rigid_velocity(flow, b, block, w, p_z, theta_rate, used)
        u_y = p_y + e_y
        u_z = r_z + w_rate
        u_t, u_n = u_y, u_z
        if ti.static(used.extended):
            if flow.option[b, DEFORMED] == 1:
                u_t = (u_y + flow.element[b, LEAN, block] * u_z) * flow.element[b, STRETCH, block]
                u_n = (u_z - flow.element[b, LEAN, block] * u_y) * flow.element[b, STRETCH, block]
        traction = normal_force(flow, b, u_t, u_n)
        slope = normal_slope(flow, b, u_t, u_n)
        if ti.static(used.extended):
            flow.element[b, SHEARING, block] = axial_force(flow, b, u_t, u_n)
            if flow.option[b, DEFORMED] == 1:
                turned = slope + flow.element[b, LEAN, block] * normal_slope_along(flow, b, u_t, u_n)
                slope = flow.element[b, STRETCH, block] * turned
        if ti.static(used.truncated):
            if flow.option[b, TRUNCATED] == 1:
                kept = kept_share(p_y, r_z, e_y, w_rate)
                inverse = inverse_speed(u_y, u_z)
                slope = kept * slope + traction * 2.0 * (r_z - kept * u_z) * inverse * inverse
                traction = kept * traction
        flow.element[b, TRACTION, block] = traction
        flow.element[b, SLOPE, block] = slope
        if ti.static(used.extended):
            flow.element[b, U_N, block], flow.element[b, U_T, block] = u_n, u_t
            mean_n += flow.element[b, SHARE, block] * u_n
            mean_t += flow.element[b, SHARE, block] * u_t
    return add_up(mean_n), add_up(mean_t)
