"""The lattice compared with Wagner's exact lift of a suddenly started plate."""

import math
from collections.abc import Sequence

import numpy as np

from .. import theory
from ..case.case import Case
from ..march.state import NORMAL
from .checks import Array, Chart, Check, Curve, Grid, History, Row, accurate, papers, plate, run

HALF_CHORDS = (1, 2, 5, 10, 20)
TRAVEL = 0.02
"""Chords travelled per step in the rows."""
PER_CENT = 100.0
RUNS: tuple[tuple[Grid, float], ...] = (
    (accurate(12), 0.04),
    (accurate(20), TRAVEL),
    (accurate(32), 0.01),
    (papers(25), 0.04),
    (papers(50), TRAVEL),
)
"""Lattices, and chords per step."""


def wagner(runs: Sequence[tuple[Grid, float]] = RUNS) -> Check:
    """Lift after a sudden start; rows of every cosine lattice at `TRAVEL`."""
    expected = np.array([theory.wagner(s) for s in HALF_CHORDS])
    histories = run([_started(grid, travel) for grid, travel in runs])
    rows, curves, followed = [], [], []
    for (grid, travel), history in zip(runs, histories, strict=True):
        lift = np.interp(HALF_CHORDS, 2.0 * travel * history.step, _share_of_steady(history))
        label = f"{grid}, U Δt/c = {travel:g}"
        style = "o-" if grid.kind == "cosine" else "s:"
        errors = PER_CENT * np.abs(lift / expected - 1.0)
        curves.append(Curve(label, np.array(HALF_CHORDS, dtype=float), errors, style))
        if grid.kind == "cosine" and travel == TRAVEL:
            rows += [Row.relative(f"s = {s}, {label}", lift[i], expected[i], 1.0) for i, s in enumerate(HALF_CHORDS)]
            places = (2.0 * travel * history.step[2:]).astype(float)
            followed.append(Curve(label, places, _share_of_steady(history)[2:], "--"))
    line = np.linspace(0.0, 21.0, 106)
    return Check(
        "wagner",
        "Wagner: lift after a sudden start",
        "The exact function is an integral of Theodorsen's (Garrick 1938); s is the distance travelled in "
        "half-chords. Angle of attack 0.1 degree. Dotted: the paper's uniform panels.",
        tuple(rows),
        (
            Chart(
                "Lift after a sudden start",
                "Distance travelled s (half-chords)",
                "Lift over steady lift (1)",
                (Curve("exact", line, np.array([theory.wagner(s) for s in line])), *followed),
            ),
            Chart(
                "Error, panels and steps refined together",
                "Distance travelled s (half-chords)",
                "Error of the lift (%)",
                tuple(curves),
                "xy",
            ),
        ),
    )


def _started(grid: Grid, travel: float) -> Case:
    steps = round((0.5 * max(HALF_CHORDS) + 0.5) / travel)
    return plate(
        f"motion.frequency={1.0 / (steps * travel)}", "time.periods=1", f"time.steps_per_period={steps}",
        "motion.pitch.mean_deg=-0.1", grid=grid,
    )  # fmt: skip


def _share_of_steady(history: History) -> Array:
    return 2.0 * history.force[:, NORMAL] / theory.plate_normal_force(math.radians(0.1))
