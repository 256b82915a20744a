"""The lattice against exact theory of steady flow past a plate, flat or bent, and of a plate pushed from rest."""

import math
from collections.abc import Sequence

import numpy as np

from .. import fluids, spacing, theory
from ..body import MOMENT, NORMAL
from ..march import March
from ..motion import PITCH_RATE, PLUNGE_RATE
from ..runtime import view
from .checks import Array, Chart, Check, Curve, Row, plate

PANELS = 50
SETTLED = ("motion.frequency=1e-9", "time.periods=1", "time.steps_per_period=4")
"""Steps of a quarter of 1e9 chords: after one of them the starting vortex is out of reach."""
LEAST_SHARE = 1e-20
"""Scale of the mode that holds a bent shape: so small that no force of the fluid moves it."""
PER_CENT = 100.0


def steady(panels: Sequence[int] = (10, 25, 50, 100), alpha_deg: float = 5.0) -> Check:
    """Steady normal force of a flat plate, and where along the chord it acts."""
    exact = theory.plate_normal_force(math.radians(alpha_deg))
    forces, places, curves, centres, worst = [], [], [], [], []
    for count in panels:
        march = March([plate(*SETTLED, f"motion.pitch.mean_deg={-alpha_deg}", panels=count)], fluids.load("uvlm"))
        frames = march.advance(march.steps + 1)[0]
        force, load = frames["force"][-1], frames["pressure_jump"][-1].astype(float)
        edges = np.arange(1, count + 1) / count
        ahead, expected = np.cumsum(load) / load.sum(), theory.plate_load_ahead(edges)
        worst.append(float(np.abs(ahead - expected).max()))
        centres.append(abs(force[MOMENT] / force[NORMAL] - 0.25))
        forces.append(Row.relative(f"normal force, 5 deg, {count} panels", 2.0 * force[NORMAL], exact, 1e-6))
        if count == PANELS:
            i = int(np.argmax(np.abs(ahead - expected)))
            difference = PER_CENT * (ahead[i] - expected[i])
            share = f"load ahead of x/c = {edges[i]:g}, the worst of {count} panels"
            places.append(Row(share, ahead[i], float(expected[i]), difference, 3.0, "% of load"))
            centre = force[MOMENT] / force[NORMAL]
            off = PER_CENT * (centre - 0.25)
            places.append(Row(f"centre of pressure, {count} panels, chords", centre, 0.25, off, 1.0, "% of chord"))
        if count in (panels[0], PANELS):
            style = "o" if count == panels[0] else "."
            curves.append(Curve(f"{count} panels", edges, PER_CENT * ahead, style))
    line = np.linspace(0.0, 1.0, 400)
    counts = np.array(panels, dtype=float)
    return Check(
        "steady",
        "Steady lift of a flat plate and its place",
        "Normal force 2π sin α cos α (Katz & Plotkin 2001, section 5.4), once the starting vortex is far away. The "
        "lattice has it exactly with any number of panels. It applies a panel's force at the panel's middle and its "
        "circulation at the quarter, so the load sits a quarter panel too far aft.",
        (*forces, *places),
        (
            Chart(
                "Load ahead of a point",
                "Distance behind the leading edge (chords)",
                "Load ahead (% of all)",
                (Curve("exact", line, PER_CENT * theory.plate_load_ahead(line)), *curves),
            ),
            Chart(
                "Error against panels",
                "Panels",
                "Largest error (%)",
                (
                    Curve("load ahead, % of load", counts, PER_CENT * np.array(worst), "o-"),
                    Curve("centre of pressure, % of chord", counts, PER_CENT * np.array(centres), "s-"),
                ),
                "xy",
            ),
        ),
    )


def camber(panels: Sequence[int] = (10, 25, 50, 100), height: float = 0.01, alpha: float = 0.02) -> Check:
    """Steady lift of a plate that a mode without give holds bent to a parabola."""
    exact = theory.parabolic_camber_lift(alpha, height)
    errors = []
    rows = []
    for count in panels:
        lift = bent_lift(count, height, alpha)
        errors.append(PER_CENT * abs(lift / exact - 1.0))
        if count >= PANELS:
            rows.append(Row.relative(f"f/c = {height:g}, α = {alpha:g} rad, {count} panels", lift, exact, 3.0))
    flat = bent_lift(PANELS, height, 0.0)
    pure = theory.parabolic_camber_lift(0.0, height)
    rows.append(Row.relative(f"f/c = {height:g}, α = 0, {PANELS} panels", flat, pure, 3.0))
    return Check(
        "camber",
        "Parabolic camber: 2π (α + 2 f/c)",
        "Glauert (1926). The lattice takes the parabola as the shape of its one mode, which is given no stiffness, no "
        "damping and a force so small that it stays as it was put. Straight panels have their slope in the middle and "
        "meet the flow at three quarters: an error of the first order in their length.",
        tuple(rows),
        (
            Chart(
                "Error against panels",
                "Panels",
                "Error of the lift (%)",
                (Curve(f"f/c = {height:g}, α = {alpha:g} rad", np.array(panels, dtype=float), np.array(errors), "o-"),),
                "xy",
            ),
        ),
    )


def bent_lift(panels: int, height: float, alpha: float, spacing_of: str = "uniform") -> float:
    """Steady lift coefficient of a plate bent to a parabola of `height` chords at `alpha` (rad)."""
    case = plate(
        *SETTLED, "wing.modes=1", f"motion.pitch.mean_deg={-math.degrees(alpha)}", panels=panels, spacing=spacing_of
    )
    march = March([case], fluids.load("uvlm"))
    bent = spacing.tables(
        case,
        lambda y: (4.0 * height * y * (1.0 - y) * LEAST_SHARE)[None, :],
        lambda y: (4.0 * height * (1.0 - 2.0 * y) * LEAST_SHARE)[None, :],
    )
    view(march.groups["flow"].shape)[0, :, :, : panels + 1] = bent
    view(march.body.constant)[...] = 0.0
    view(march.body.q)[0, 0, 0] = 1.0 / LEAST_SHARE
    return 2.0 * float(march.advance(march.steps + 1)[0]["force"][-1, NORMAL])


def added_mass(panels: Sequence[int] = (12, 25, 50, 100)) -> Check:
    """Force and moment of a plate pushed from rest in still fluid, before it sheds anything to speak of."""
    mass = theory.added_mass([np.ones_like, lambda x: x])
    pushed = np.array([_pushed_mass(count) for count in panels])
    names = ("heave: force", "heave: moment", "pitch: force", "pitch: moment")
    expected = np.array([mass[0, 0], mass[0, 1], mass[0, 1], mass[1, 1]])
    at = list(panels).index(PANELS)
    rows = [Row.relative(f"{name}, {PANELS} panels", pushed[at, i], expected[i], 1.0) for i, name in enumerate(names)]
    curves = tuple(
        Curve(name, np.array(panels, dtype=float), PER_CENT * np.abs(pushed[:, i] / expected[i] - 1.0), style)
        for i, (name, style) in enumerate(zip(names, ("o-", "s-", "^--", "v-"), strict=True))
    )
    return Check(
        "added-mass",
        "Added mass of a plate in heave and pitch",
        "π/4, π/8, π/8 and 9π/128 of ρ c² (force and moment about the leading edge over acceleration, lengths in "
        "chords; Lamb 1932). The plate is pushed from rest for one step of 1e-4 of a period, in fluid without a "
        "stream, so that what it sheds stands at its trailing edge. The solver has no option to shed nothing; this is "
        "its limit at t = 0+.",
        tuple(rows),
        (Chart("Error against panels", "Panels", "Error (%)", curves, "xy"),),
    )


def _pushed_mass(panels: int) -> Array:
    """Normal force and moment over acceleration: heave's two, then pitch's two (about the leading edge)."""
    found = []
    for drive, rate in (("plunge.amplitude=1e-3", PLUNGE_RATE), ("pitch.amplitude_deg=0.01", PITCH_RATE)):
        name = drive.split(".")[0]
        case = plate(
            "fluid.velocity=[0.0, 0.0]", f"motion.{drive}", f"motion.{name}.phase_deg=90.0", "time.periods=1",
            "time.steps_per_period=10000", panels=panels,
        )  # fmt: skip
        march = March([case], fluids.load("uvlm"))
        force = march.advance(2)[0]["force"][1]
        found += [-force[column] * case.step / march.motion[0, 1, rate] for column in (NORMAL, MOMENT)]
    return np.array(found)
