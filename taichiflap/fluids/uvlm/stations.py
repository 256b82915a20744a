"""Chordwise positions of panel ends, bound vortices and control points, and the modes there.

- Uniform: equal, straight panels between points of the camber line, the bound vortex at 1/4 of each and the control
  point at 3/4 (Reade & Jankauski 2020, Table 4).
- Cosine: Lan's quasi-vortex lattice (J. Aircraft 11, 1974). With `y = c/2 (1 - cos a)` panels end at `a = i pi/N`, the
  vortices are at the midpoints in `a`, the control points at the ends, the last at the trailing edge. All lie on the
  camber line itself, so that sums over them are quadratures of spectral accuracy.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from ...case.case import Case
from ...structure.chordwise import Profile

Array = NDArray[np.float64]
Sampler = Callable[[Array], Array]
"""Values of every mode at positions along the chord, shape (modes, positions)."""

TO_VORTEX, TO_POINT = 0.25, 0.75
"""Position of the bound vortex and the control point on a uniform panel."""
SHARE = {"uniform": 0.25, "cosine": 0.30}
"""Position of a new vortex on the trailing edge's path through the fluid during a step, by the local rule."""

BLASIUS = 0.664
"""Mean friction of one side of a plate with a laminar boundary layer, in `rho U^2 Re^-1/2`."""

NODE, VORTEX, POINT, ACT, AHEAD, BEHIND, VORTEX_SLOPE, POINT_SLOPE, EDGE_SLOPE = range(9)
"""Tables of a mode, one value per node or panel: its values at the nodes, the vortices, the control points and the
points of action of the steady force; its integrals over the panel ahead of and behind the step of potential; its slopes
at the vortices, at the points, and (one value) at the leading edge."""
TABLES = 9

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class Stations:
    """Positions along the chord, from the pivot, m: ends of the panels, and a vortex and a control point on each."""

    node: Array
    vortex: Array
    point: Array


def stations(case: Case) -> Stations:
    """Positions of a case's lattice."""
    panels, chord = case.uvlm.panels, case.wing.chord
    number, ahead = np.arange(panels + 1), case.wing.pivot * chord
    if case.uvlm.spacing == "cosine":
        node = chord * np.sin(0.5 * pi * number / panels) ** 2 - ahead
        return Stations(node, chord * np.sin(0.5 * pi * (number[1:] - 0.5) / panels) ** 2 - ahead, node[1:])
    node = chord * number / panels - ahead
    side = np.diff(node)
    return Stations(node, node[:-1] + TO_VORTEX * side, node[:-1] + TO_POINT * side)


def tables(case: Case, shape: Sampler, slope: Sampler) -> Array:
    """The tables of every mode, shape (modes, TABLES, panels + 1), padded with zeros.

    Args:
        case: the case.
        shape: the modes (`Modes.shape`).
        slope: their slopes (`Modes.slope`).
    """
    at = stations(case)
    side = np.diff(at.node)
    node = shape(at.node)
    middle = 0.5 * (node[:, :-1] + node[:, 1:])
    if case.uvlm.spacing == "cosine":
        vortex, point = shape(at.vortex), shape(at.point)
        slopes = slope(at.vortex), slope(at.point), slope(at.node[:1])
        step = at.vortex
        whole = _integral(shape, at.node[:-1], at.node[1:])
        ahead = _integral(shape, at.node[:-1], step)
    else:
        straight = np.diff(node, axis=1) / side
        vortex, point = (node[:, :-1] + share * np.diff(node, axis=1) for share in (TO_VORTEX, TO_POINT))
        slopes = straight, straight, straight[:, :1]
        whole = middle * side
        ahead = TO_VORTEX * side * 0.5 * (node[:, :-1] + vortex)
    act = vortex
    if case.uvlm.loads == "panels":
        act, ahead, whole = middle, 0.0 * ahead, middle * side
    made = np.zeros((len(node), TABLES, len(at.node)))
    for table, values in enumerate((node, vortex, point, act, ahead, whole - ahead, *slopes)):
        made[:, table, : values.shape[1]] = values
    return made


def _integral(shape: Sampler, left: Array, right: Array) -> Array:
    """Integrals of the modes from `left` to `right` by Gauss's rule, shape (modes, len(left))."""
    half = 0.5 * (right - left)
    places = 0.5 * (left + right) + half * _GAUSS[:, None]
    return np.einsum("g,kgi->ki", _WEIGHTS, shape(places.ravel()).reshape(-1, *places.shape)) * half


def edge_factor(case: Case) -> float:
    """Flow through the leading edge of the lattice of a flat plate in a unit normal stream.

    It measures the singularity there (Lan 1974): 2 N for cosine spacing; for uniform panels, whose through-flow is the
    rational function `prod (x - point)/(x - vortex)`, its value one quarter panel ahead of the first vortex.
    """
    n = case.uvlm.panels
    if case.uvlm.spacing == "cosine":
        return 2.0 * n
    return float(np.prod((np.arange(n) + TO_POINT) / (np.arange(n) + TO_VORTEX)))


def suction_factor(case: Case) -> float:
    """Ratio of the leading-edge suction to the square of the through-flow there, N s2/m2.

    With `gamma = C / sqrt(x)` near the edge the suction is `pi rho C^2 / 4` a unit span; a flat plate in a unit normal
    stream has `C^2 = 4 c` and the through-flow of `edge_factor`.
    """
    span = Profile.of(case.wing.span).values[0]
    return float(pi * case.fluid.density * case.wing.chord * span / edge_factor(case) ** 2)


def friction_factor(case: Case) -> float:
    """Laminar friction of one side of a plate per area and speed to the power 1.5 (Blasius 1908)."""
    return BLASIUS * case.fluid.density * float(np.sqrt((case.fluid.viscosity or 0.0) / case.wing.chord))


def ring_size(case: Case) -> int:
    """Capacity of a case's wake, at most the number of vortices it sheds."""
    shed = shed_a_step(case) * (case.steps + 1)
    return shed if case.uvlm.wake == "all" else min(case.uvlm.wake, shed)


def sheds(case: Case) -> bool:
    """Whether a case's leading edge may shed."""
    return case.uvlm.leading_edge == "sheds"


def has_edge(case: Case) -> bool:
    """Whether a case computes the flow around its leading edge."""
    return case.uvlm.suction or sheds(case)


def shed_a_step(case: Case) -> int:
    """Maximum number of vortices shed per step: one, or one from each edge."""
    return 2 if sheds(case) else 1


def absorbs(case: Case) -> bool:
    """Whether a case's wake can get full and then absorbs vortices."""
    return case.uvlm.old_wake == "absorb" and ring_size(case) < shed_a_step(case) * (case.steps + 1)


def is_listed(case: Case) -> bool:
    """Whether a case's wake is a list instead of a ring, see `taichiflap.fluids.uvlm.merging`."""
    return sheds(case) or case.uvlm.merge_error > 0.0
