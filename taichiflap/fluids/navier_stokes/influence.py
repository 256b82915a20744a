"""Effect of the wall's flux of vorticity on the slip at the wall: the influence matrix, and its inverse."""

from ...kernels import linear
from ...kernels.runtime import Octet, View, ti
from .arrays import (
    CORNER_COS,
    CORNER_SIN,
    EQUATION,
    FELT,
    INVERSE_K,
    LOWER_FACE,
    NU,
    OCTETS,
    SCALE,
    THICKNESS,
    UPPER_FACE,
)
from .fourier import transpose
from .poisson import decay_across


@ti.func
def respond(flow: View, b, beta):
    """Response of the vorticity in the near rows to the wall flux: `grid.wall_response`, for the current cells."""
    felt, octets = flow.size[b, FELT], flow.size[b, OCTETS]
    spread = flow.number[b, NU] * beta
    source = beta / flow.row[b, 0, THICKNESS]
    for j in range(felt):
        upper, lower = spread * flow.row[b, j, UPPER_FACE], spread * flow.row[b, j, LOWER_FACE]
        if j == felt - 1:
            upper = 0.0
        jl = ti.max(j - 1, 0)
        for m in range(octets):
            factor, known = Octet(0.0), Octet(source)
            if j > 0:
                factor = flow.felt[b, jl, m]
                known = lower * flow.response[b, jl, m]
            x = Octet(1.0) / (flow.area[b, j, m] + (upper + lower) - lower * factor)
            flow.felt[b, j, m] = upper * x
            flow.response[b, j, m] = known * x
    for back in range(felt - 1):
        j = felt - 2 - back
        for m in range(octets):
            flow.response[b, j, m] = flow.response[b, j, m] + flow.felt[b, j, m] * flow.response[b, j + 1, m]


@ti.func
def lane(a: View, b, line, i):
    """Element `i` of a line."""
    whole = a[b, line, i // 8]
    return whole[i % 8]


@ti.func
def turn(flow: View, b, i, points):
    """Cosine and sine of 2 pi i / points."""
    corner = (i + points - 1) % points
    return lane(flow.line, b, CORNER_COS, corner), lane(flow.line, b, CORNER_SIN, corner)


@ti.func
def invert_influence(flow: View, b):
    """Influence matrix of the wall flux on the slip, followed by the rows of its inverse."""
    octets = flow.size[b, OCTETS]
    points = 8 * octets
    scale = flow.number[b, SCALE]
    matrix = ti.static(flow.influence)
    for m in range(octets):
        for c in range(points):
            matrix[b, c, m] = Octet(0.0)
            matrix[b, c, octets + m] = Octet(0.0)
        matrix[b, 0, m] = Octet(scale)
        matrix[b, 1, m] = scale * Octet([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    for c in range(points):
        matrix[b, c, octets + c // 8][c % 8] = 1.0
    for half in range(1, points // 2):
        c = 2 * half
        place = flow.equation[b, c]
        s, lane_ = place // 16, place % 8
        over = flow.slot[b, INVERSE_K, s]
        depth = 1.0
        for j in range(flow.size[b, FELT]):
            decay = decay_across(flow, b, j, s)
            weight = depth * (1.0 - decay[lane_]) * over[lane_]
            depth *= decay[lane_]
            for m in range(octets):
                matrix[b, c, m] = matrix[b, c, m] + weight * (flow.response[b, j, m] * flow.area[b, j, m])
        wave = flow.equation[b, points + c]
        cosine = Octet(0.0)
        sine = Octet(0.0)
        for at in ti.static(range(8)):
            x, y = turn(flow, b, wave * at % points, points)
            cosine[at] = x
            sine[at] = y
        step_c, step_s = turn(flow, b, wave * 8 % points, points)
        for m in range(octets):
            v = matrix[b, c, m] * scale
            matrix[b, c, m] = v * cosine
            matrix[b, c + 1, m] = (0.0 - v) * sine
            turned = cosine * step_c - sine * step_s
            sine = sine * step_c + cosine * step_s
            cosine = turned
    for panel in range(octets):
        linear.factorise(matrix, flow.pivots, b, points, panel, 2 * octets)
        for j in range(panel + 1, 2 * octets):
            linear.eliminate(matrix, flow.pivots, b, points, panel, j)
    for j in range(octets, 2 * octets):
        for m in range(octets):
            linear.substitute(matrix, b, points, octets - 1 - m, j)


@ti.func
def oppose_slip(flow: View, b, defect, mean, out):
    """Change of the wall flux that removes a slip, with a given mean; stored in line `out`."""
    octets = flow.size[b, OCTETS]
    points = 8 * octets
    for c in range(points):
        value = 0.0
        if c == 0:
            value = mean
        elif c > 1:
            place = flow.equation[b, c]
            whole = flow.spectra[b, defect, place // 8]
            value = whole[place % 8]
        flow.line[b, EQUATION, c // 8][c % 8] = value
    for group in range(octets):
        sums = [Octet(0.0) for _ in ti.static(range(8))]
        for m in range(octets):
            known = flow.line[b, EQUATION, m]
            for at in ti.static(range(8)):
                sums[at] = sums[at] + flow.influence[b, 8 * group + at, octets + m] * known
        t = transpose(sums)
        flow.line[b, out, group] = ((t[0] + t[1]) + (t[2] + t[3])) + ((t[4] + t[5]) + (t[6] + t[7]))
