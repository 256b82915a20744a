"""Orders of convergence in time step, panels, elements and modes."""

import itertools

import numpy as np

from ..case.case import Case
from ..march.state import NORMAL
from ..structure import beam
from .checks import Chart, Check, Curve, Row, accurate, observed_order, papers, run
from .oscillation import exact, loads, oscillating
from .structure import hawkmoth

PER_CENT = 100.0
K = 1.0
"""Reduced frequency at which the lattice is refined."""
ENOUGH_MODES = 10

Study = tuple[Row, Chart]


def convergence() -> Check:
    """Orders of convergence, each with its curve."""
    studies = (panels(), lattice_steps(), blade_steps(), elements(), modes())
    return Check(
        "convergence",
        "Orders of convergence",
        "Panels and steps refined together, compared with Theodorsen at k = 1 (plunge). Steps alone compared with "
        "twice as many, with 12 uniform panels (cosine panels need steps to match: a step much shorter than the last "
        "panel has no benefit). DBET on the paper's flapping wing compared with 8 times the steps, 256 elements and "
        "10 modes. Expected orders: first for the lattice (lumped vortices, one shed per step), second for the march "
        "and for blades at midpoints, and fourth for modes, whose contribution to the tip deflection decreases at "
        "least as 1/β⁴.",
        tuple(row for row, _ in studies),
        tuple(chart for _, chart in studies),
    )


def _study(
    title: str, x_label: str, y_label: str, label: str, counts: list[int], errors: list[float], order: float
) -> Study:
    measured = observed_order([1.0 / n for n in counts], errors)
    chart = Chart(
        title,
        x_label,
        y_label,
        (
            Curve(f"measured, order {measured:.2f}", np.array(counts, dtype=float), PER_CENT * np.array(errors), "o-"),
            Curve(
                f"order {order:g}",
                np.array(counts, dtype=float),
                PER_CENT * errors[0] * (counts[0] / np.array(counts)) ** order,
                "--",
            ),
        ),
        "xy",
    )
    return Row.order(label, measured, order), chart


def panels() -> Study:
    """Panels and steps of the lattice refined together, against Theodorsen."""
    counts = [12, 18, 27, 40]
    cases = [oscillating("plunge", K, accurate(n), 4 * n) for n in counts]
    there = exact("plunge", K).lift
    found = [loads(case, history).lift / there for case, history in zip(cases, run(cases), strict=True)]
    return _study(
        "UVLM: cosine panels, and four steps a panel", "Panels", "Error of the lift (%)",
        "UVLM, cosine panels and steps together", counts, [abs(ratio - 1.0) for ratio in found], 1.0,
    )  # fmt: skip


def lattice_steps() -> Study:
    """Time step of the paper's lattice, compared with twice as many steps."""
    counts = [200, 400, 800]
    cases = [oscillating("plunge", K, papers(12), n, beats=2) for n in (*counts, 2 * counts[-1])]
    found = [loads(case, history).lift for case, history in zip(cases, run(cases), strict=True)]
    return _study(
        "UVLM: time step, 12 uniform panels", "Steps a period", "Change of the lift with twice the steps (%)",
        "UVLM, time step alone", counts, [abs(now / finer - 1.0) for now, finer in itertools.pairwise(found)], 1.0,
    )  # fmt: skip


def _flap(*settings: str) -> Case:
    return hawkmoth("solver=dbet", "time.periods=1", "wing.modes=1", *settings)


def blade_steps() -> Study:
    """Time step of a coupled DBET run."""
    counts = [80, 160, 320]
    histories = run([_flap(f"time.steps_per_period={n}") for n in (*counts, 8 * counts[-1])])
    tips = [history.amplitude[:: n // 80, 0] for n, history in zip((*counts, 8 * counts[-1]), histories, strict=True)]
    return _study(
        "DBET, coupled: time step", "Steps a beat", "Difference of the tip from 2560 steps (%)",
        "DBET, coupled, time step", counts, _differences(tips), 2.0,
    )  # fmt: skip


def elements() -> Study:
    """Blade elements of a coupled DBET run."""
    counts = [4, 8, 16, 32]
    histories = run([_flap(f"dbet.elements={n}") for n in (*counts, 256)])
    return _study(
        "DBET: elements", "Elements", "Difference of the normal force from 256 (%)",
        "DBET, elements", counts, _differences([history.force[20:, NORMAL] for history in histories]), 2.0,
    )  # fmt: skip


def modes() -> Study:
    """Modes of a coupled DBET run."""
    counts = [1, 2, 3, 4, 5]
    cases = [
        _flap(
            f"wing.modes={n}", "time.periods=2", "time.steps_per_period=2000", "output.every=10",
            "wing.damping_ratio=0.5",
        )
        for n in (*counts, ENOUGH_MODES)
    ]  # fmt: skip
    tips = [
        (history.amplitude @ beam.modes(case.wing).shape([case.wing.chord])[:, 0])[200:]
        for case, history in zip(cases, run(cases), strict=True)
    ]
    return _study(
        "DBET, coupled: modes", "Modes", f"Difference of the tip from {ENOUGH_MODES} modes (%)",
        "DBET, coupled, modes", counts, _differences(tips), 4.0,
    )  # fmt: skip


def _differences(results: list[np.ndarray]) -> list[float]:
    """Largest difference of each result from the last, over the last's largest value."""
    reference = results[-1]
    scale = np.abs(reference).max()
    return [float(np.abs(result - reference).max() / scale) for result in results[:-1]]
