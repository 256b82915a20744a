"""The blade elements: their positions, the rows of their arrays, and sums over them."""

import numpy as np

from ...case.case import Case
from ...kernels.runtime import Octet, View, ti
from ...structure.chordwise import Profile

POSITION, AREA, PER_AREA, SHARE, LEAN, STRETCH, U_N, U_T = range(8)
"""First rows of the elements: distance behind the pivot, area, its inverse, and one over their number (the last three 0
in the padding of a batch); slope s of the bent wing, and `1/sqrt(1 + s^2)`; predicted velocities along its normal and
tangent."""
TRACTION, SLOPE, SHEARING, LIFTED, PRESSURE, SHEAR, SCRATCH = range(8, 15)
"""Next rows: at the predicted rates the force per area along -n, its derivative by the elastic rate, and the force
along -t; force per area of attached flow per unit K v; force per area along e_z and e_y; and scratch for the
transforms.
"""
WING_Y, GUST_Y, GUST_Z, GUST, GUST_BEFORE, GUST_BEFORE_THAT = range(15, 21)
"""Last rows: velocity along e_y without the gust; the gust's along e_y and e_z; and its flux through the wing, now and
at the two previous steps.
"""
ROWS = 21
ABREAST = 7
"""Number of independent sums that a transform takes at once."""

HALF_DENSITY, STRIP, NORMAL_T, NORMAL_N, AXIAL_T, AXIAL_N = range(6)
ROTATION, SUCTION, STALL, STALLED, FRICTION, CHORD = range(6, 12)
"""Settings: rho/2; `pi rho c/4` per area for strips, else 0; rho/2 times the coefficients of u_t^2 and u_n^2 in the
forces along -n and -t, see `separated`; `pi/4 rho c` times the factor of rotation; `pi rho` times the suction's share
and the wing's area; angles (rad); `1.328 rho sqrt(nu/c)`; chord (m)."""

TRUNCATED, DEFORMED, POTENTIAL, ATTACHED = range(4)
"""Options of a case, 0 or 1."""


def middles(case: Case) -> np.ndarray:
    """Midpoints of the elements along the chord, from the pivot, m."""
    count = case.dbet.elements
    return case.wing.chord * (np.arange(count) + 0.5) / count - case.wing.pivot * case.wing.chord


def spans(case: Case) -> np.ndarray:
    """Mean spans of the elements, m."""
    count = case.dbet.elements
    return Profile.of(case.wing.span).means(np.arange(count + 1) / count)


def areas(case: Case) -> np.ndarray:
    """Areas of the elements, m^2."""
    return case.wing.chord * spans(case) / case.dbet.elements


def angles(count: int) -> np.ndarray:
    """Angles of the ends of so many elements: `x/c = (1 - cos theta)/2`, from 0 at the leading edge to pi."""
    return np.arccos(1.0 - 2.0 * np.arange(count + 1) / count)


@ti.func
def add_up(octet):
    """Sum of eight numbers, two halves at a time."""
    four = ti.Vector([octet[i] + octet[i + 4] for i in ti.static(range(4))])
    two = ti.Vector([four[i] + four[i + 2] for i in ti.static(range(2))])
    return two[0] + two[1]


@ti.func
def superpose_octet(shape: View, state: View, b, row, block, count):
    """`sum_k phi_k q_k` of a row of a modal state at eight elements."""
    total = Octet(0.0)
    for k in range(count):
        total += shape[b, k, block] * state[b, row, k]
    return total


@ti.func
def superpose_change(shape: View, state: View, before: View, b, row, block, count):
    """`sum_k phi_k (q_k - q'_k)` of a row of two modal states at eight elements."""
    total = Octet(0.0)
    for k in range(count):
        total += shape[b, k, block] * (state[b, row, k] - before[b, row, k])
    return total


@ti.func
def transform(flow: View, table: View, b, result: View, column, terms: View):
    """Sums over the elements of the scratch row times each term of a table."""
    for group in ti.static(range(0, terms, ABREAST)):
        totals = [Octet(0.0) for _ in ti.static(range(min(ABREAST, terms - group)))]
        for block in range((flow.elements[b] + 7) // 8):
            values = flow.element[b, SCRATCH, block]
            for i in ti.static(range(min(ABREAST, terms - group))):
                totals[i] += table[b, group + i, block] * values
        for i in ti.static(range(min(ABREAST, terms - group))):
            result[b, column, group + i] = add_up(totals[i])


@ti.func
def weigh(flow: View, table: View, b, term):
    """Sum over the elements of the scratch row times one term of a table, as of `transform`."""
    total = Octet(0.0)
    for block in range((flow.elements[b] + 7) // 8):
        total += table[b, term, block] * flow.element[b, SCRATCH, block]
    return add_up(total)
