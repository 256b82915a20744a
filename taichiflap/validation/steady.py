"""The lattice compared with exact theory of steady flow past flat and cambered plates, and of a plate accelerated from
rest.
"""

import math
from collections.abc import Sequence

import numpy as np

from .. import fluids, theory
from ..fluids.uvlm import stations
from ..kernels.runtime import view
from ..march.march import March
from ..march.state import MOMENT, NORMAL, RUNAWAY
from ..motion.sampling import PITCH_RATE, PLUNGE_RATE
from .checks import Array, Chart, Check, Curve, Grid, Row, accurate, papers, plate

GRIDS = (accurate(10), accurate(20), accurate(40), papers(12), papers(25), papers(50), papers(100))
SETTLED = ("motion.frequency=1e-9", "time.periods=1", "time.steps_per_period=4")
"""Chords per step: after one step the starting vortex is far away."""
LEAST_SHARE = 1e-20
"""Scale of the mode that represents the camber: so small that no fluid force deforms it."""
PER_CENT = 100.0


def steady(grids: Sequence[Grid] = GRIDS, alpha_deg: float = 5.0) -> Check:
    """Steady normal force of a flat plate, and its distribution along the chord."""
    exact = theory.plate_normal_force(math.radians(alpha_deg))
    forces, places, curves = [], [], []
    worst: dict[str, list[tuple[int, float]]] = {}
    for grid in grids:
        march = March([plate(*SETTLED, f"motion.pitch.mean_deg={-alpha_deg}", grid=grid)], fluids.load("uvlm"))
        frames = march.advance(march.steps + 1)[0]
        force, node = frames["force"][-1], fluids.load("uvlm").nodes(march.cases[0])
        ahead = np.cumsum(frames["pressure_jump"][-1] * np.diff(node)) / force[NORMAL]
        expected = theory.plate_load_ahead(node[1:])
        i = int(np.argmax(np.abs(ahead - expected)))
        off = PER_CENT * float(ahead[i] - expected[i])
        worst.setdefault(grid.kind, []).append((grid.panels, abs(off)))
        forces.append(Row.relative(f"normal force, 5 deg, {grid}", 2.0 * force[NORMAL], exact, 1e-6))
        if grid == accurate():
            share = f"load ahead of x/c = {node[i + 1]:.3g}, the worst of {grid}"
            places.append(Row(share, ahead[i], float(expected[i]), off, 0.2, "% of load"))
            centre = force[MOMENT] / force[NORMAL]
            shift = PER_CENT * (centre - 0.25)
            places.append(Row(f"centre of pressure, {grid}, chords", centre, 0.25, shift, 1e-6, "% of chord"))
        if grid in (accurate(), papers()):
            curves.append(Curve(str(grid), node[1:], PER_CENT * ahead, "o" if grid == accurate() else "."))
    line = np.linspace(0.0, 1.0, 400)
    return Check(
        "steady",
        "Steady lift of a flat plate and its centre of pressure",
        "The exact normal force, once the starting vortex is far away, is 2π sin α cos α (Katz & Plotkin 2001, "
        "section 5.4). It is reached with any number of panels. Cosine panels (Lan 1974) also have the exact centre "
        "of pressure. On the paper's uniform panels the force acts at the middle of a panel and the vortex at its "
        "quarter, so that the centre of pressure is a quarter panel too far aft.",
        (*forces, *places),
        (
            Chart(
                "Load ahead of a point",
                "Distance behind the leading edge (chords)",
                "Load ahead (% of all)",
                (Curve("exact", line, PER_CENT * theory.plate_load_ahead(line)), *curves),
            ),
            Chart("Error against panels", "Panels", "Error of the load ahead (% of load)", _by_kind(worst), "xy"),
        ),
    )


def _by_kind(errors: dict[str, list[tuple[int, float]]]) -> tuple[Curve, ...]:
    """A curve for each kind of lattice from pairs of panels and error."""
    styles = {"cosine": "o-", "uniform": "s:"}
    curves = []
    for kind, pairs in errors.items():
        panels, values = np.array(pairs, dtype=float).T
        curves.append(Curve(f"{kind} panels", panels, values, styles[kind]))
    return tuple(curves)


def camber(grids: Sequence[Grid] = GRIDS, height: float = 0.01, alpha: float = 0.02) -> Check:
    """Steady lift of a plate with parabolic camber, held by a mode that does not deform."""
    reference = theory.parabolic_camber_lift(alpha, height)
    rows = []
    errors: dict[str, list[tuple[int, float]]] = {}
    for grid in grids:
        lift = bent_lift(grid, height, alpha)
        errors.setdefault(grid.kind, []).append((grid.panels, PER_CENT * abs(lift / reference - 1.0)))
        if grid.kind == "cosine":
            rows.append(Row.relative(f"f/c = {height:g}, α = {alpha:g} rad, {grid}", lift, reference, 0.1))
    pure = theory.parabolic_camber_lift(0.0, height)
    flat = bent_lift(accurate(), height, 0.0)
    rows.append(Row.relative(f"f/c = {height:g}, α = 0, {accurate()}", flat, pure, 0.1))
    return Check(
        "camber",
        "Parabolic camber: 2π (α + 2 f/c)",
        "Glauert (1926). The parabola is the shape of the lattice's only mode, which has no stiffness, no damping "
        "and a negligible force, so that it keeps its amplitude. Cosine panels lie on the curve; their difference is "
        "of the order of α², which the theory neglects. Uniform panels are straight, have the slope of their middle "
        "and their control points at three quarters, which is an error of first order in their length.",
        tuple(rows),
        (Chart("Error against panels", "Panels", "Error of the lift (%)", _by_kind(errors), "xy"),),
    )


def bent_lift(grid: Grid, height: float, alpha: float) -> float:
    """Steady lift coefficient of a plate bent to a parabola of `height` chords at `alpha` (rad)."""
    case = plate(*SETTLED, "wing.modes=1", f"motion.pitch.mean_deg={-math.degrees(alpha)}", grid=grid)
    march = March([case], fluids.load("uvlm"))
    flow = march.groups["flow"]
    scale = 4.0 * height * LEAST_SHARE
    tables = stations.tables(case, lambda y: scale * (y * (1.0 - y))[None], lambda y: scale * (1.0 - 2.0 * y)[None])
    view(flow.shape)[0, :, :, : grid.panels + 1] = tables
    view(march.body.constant)[...] = 0.0
    view(march.body.constant)[:, RUNAWAY] = np.inf
    view(march.body.q)[0, 0, 0] = 1.0 / LEAST_SHARE
    return 2.0 * float(march.advance(march.steps + 1)[0]["force"][-1, NORMAL])


def added_mass(grids: Sequence[Grid] = GRIDS) -> Check:
    """Force and moment of a plate accelerated from rest in still fluid, before it sheds noticeable vorticity."""
    mass = theory.added_mass([np.ones_like, lambda x: x])
    expected = np.array([mass[0, 0], mass[0, 1], mass[0, 1], mass[1, 1]])
    names = ("heave: force", "heave: moment", "pitch: force", "pitch: moment")
    rows = []
    worst: dict[str, list[tuple[int, float]]] = {}
    for grid in grids:
        pushed = _pushed_mass(grid)
        worst.setdefault(grid.kind, []).append((grid.panels, PER_CENT * np.abs(pushed / expected - 1.0).max()))
        if grid == accurate():
            rows = [Row.relative(f"{name}, {grid}", pushed[i], expected[i], 0.3) for i, name in enumerate(names)]
    return Check(
        "added-mass",
        "Added mass of a plate in heave and pitch",
        "π/4, π/8, π/8 and 9π/128 of ρ c² (force and moment about the leading edge over acceleration, lengths in "
        "chords; Lamb 1932, art. 71). The plate is accelerated from rest for one step of 1e-4 of a period in fluid "
        "at rest. The shed vortex stays at the trailing edge, so that wing and wake together have no circulation. "
        "Its distance of 2e-4 chords, the minimum of the shedding rule, causes the remaining error. The added mass "
        "of the blade elements is a formula, which the wet frequency below tests.",
        tuple(rows),
        (Chart("Error against panels", "Panels", "Largest error of the four (%)", _by_kind(worst), "xy"),),
    )


def _pushed_mass(grid: Grid) -> Array:
    """Normal force and moment over acceleration: heave's two, then pitch's two (about the leading edge)."""
    found = []
    for drive, rate in (("plunge.amplitude=1e-3", PLUNGE_RATE), ("pitch.amplitude_deg=0.01", PITCH_RATE)):
        name = drive.split(".")[0]
        case = plate(
            "fluid.velocity=[0.0, 0.0]", f"motion.{drive}", f"motion.{name}.phase_deg=90.0", "time.periods=1",
            "time.steps_per_period=10000", grid=grid,
        )  # fmt: skip
        march = March([case], fluids.load("uvlm"))
        force = march.advance(2)[0]["force"][1]
        found += [-force[column] * case.step / march.motion[0, 1, rate] for column in (NORMAL, MOMENT)]
    return np.array(found)
