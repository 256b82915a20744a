"""Reade & Jankauski (2020), ASME IDETC DETC2020-22638: printed numbers and cases.

Tables 1 to 4 define the cases; gaps and misprints are corrected as docs/theory/errata.md lists.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...case.case import Case, parse_case

REVERSAL = 0.25
"""The paper's plots have the stroke reverse at t/T = 0.25 and 0.75; with the phases of Table 2 it does at 0 and 0.5."""

TABLE_5 = {("dbet", 0): 2.76e-3, ("dbet", 1): 2.97e-3, ("uvlm", 0): 3.08e-3, ("uvlm", 1): 6.67e-3}
"""Mean vertical force (N) by solver and number of modes: 0 is the rigid wing, 1 the flexible one."""
GAIN = {"dbet": 0.07, "uvlm": 1.16}
"""What flexibility adds to the mean vertical force, as a fraction."""
TIP = 7.5e-3
"""Largest tip deflection of both models, m."""
TIP_TIME = 0.33
"""Time of the peak, as t/T in the paper's plots."""
FORCE_LAG = 18.0
"""Degrees by which the DBET normal force of the flexible wing lags the UVLM one."""
SOLVE_TIME = {"dbet": 2.95, "uvlm": 46.81}
"""Seconds for 15 beats."""
FREQUENCY = 80.0
"""First natural frequency, Hz (Table 1)."""
ENOUGH_ELEMENTS = 5
"""Blade elements beyond which the tip deflection changes by less than 1 %, by the text beside Fig. 4."""
AIR = 1.225
"""Density of the fluid, kg/m3. Not stated in the paper."""
DENSITY_OF_THE_ROW = 1.29
"""The density at which DBET without added mass gives the paper's mean forces, kg/m3."""

_CASE: dict[str, Any] = {
    "wing": {
        "chord": 0.02,
        "span": 0.05,
        "thickness": 40e-6,
        "density": 1000.0,
        "youngs_modulus": 24.5e9,
        "modes": 1,
        "damping_ratio": 0.05,
    },
    "motion": {
        "frequency": 25.0,
        "plunge": {"amplitude": 0.02, "phase_deg": 90.0},
        "pitch": {"amplitude_deg": 15.0, "phase_deg": 0.0},
    },
    "fluid": {"density": AIR},
    "dbet": {
        "elements": 50,
        "coefficients": "reade_jankauski",
        "frame": "chord",
        "added_mass": "strip",
        "attached": False,
        "rotation": 0.0,
        "friction": "none",
    },
    "uvlm": {
        "panels": 50,
        "spacing": "uniform",
        "loads": "panels",
        "wake": 200,
        "old_wake": "drop",
        "shedding": "fixed",
        "shedding_distance": 0.05,
        "convection": "euler",
        "crossing": "pass",
        "core": 0.0,
        "core_growth": 0.0,
    },
}


@dataclass(frozen=True)
class Settings:
    """How much of the paper to compute. The defaults are the paper's own, and beyond.

    Attributes:
        periods, steps_per_period: duration and step of every case.
        elements: numbers of blade elements of Fig. 4; the last one stands for the converged solution.
        panels: numbers of panels of Fig. 5; the last one stands for the converged solution.
        wakes: numbers of wake vortices of Fig. 5; its last one stands for the converged solution.
        long_wakes: longer wakes.
        modes: numbers of elastic modes.
        densities: densities of the fluid, kg/m3.
    """

    periods: int = 15
    steps_per_period: int = 200
    elements: tuple[int, ...] = (1, 2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 40, 50)
    panels: tuple[int, ...] = (5, 10, 15, 20, 30, 40, 50, 60, 70)
    wakes: tuple[int, ...] = (5, 10, 20, 30, 50, 75, 100, 150, 200, 250, 300)
    long_wakes: tuple[int | str, ...] = (400, 600, 1000, "all")
    modes: tuple[int, ...] = (1, 2, 3, 5)
    densities: tuple[float, ...] = (1.0, 1.1, 1.15, 1.2, AIR, DENSITY_OF_THE_ROW, 1.3)


def described(settings: Settings) -> str:
    """The settings as a sentence for a report."""
    return (
        f"Blade elements: {_listed(settings.elements)}. Panels: {_listed(settings.panels)}. Wake vortices: "
        f"{_listed((*settings.wakes, *settings.long_wakes))}. Modes: {_listed(settings.modes)}. Densities (kg/m³): "
        f"{_listed(settings.densities)}."
    )


def _listed(values: Sequence[Any]) -> str:
    return ", ".join(map(str, values))


def case(settings: Settings, solver: str, *overrides: str) -> Case:
    """The paper's case for a solver, `"dbet"` or `"uvlm"`, with some keys changed, such as `"wing.modes=0"`."""
    time = {"periods": settings.periods, "steps_per_period": settings.steps_per_period}
    title = f"{solver.upper()}{', ' if overrides else ''}{', '.join(overrides)}"
    return parse_case({**_CASE, "solver": solver, "time": time, "title": title}).override(*overrides)
