"""Building blocks of the validation: rows that pass or fail, error curves, and the runs that produce them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .. import fluids
from ..case.case import Case, parse_case
from ..march.march import March

Array = NDArray[np.float64]

BLOCK = 100
"""Number of steps per block, so that the stored outputs of a batch stay small."""


@dataclass(frozen=True)
class Row:
    """One computed value compared with a reference.

    Attributes:
        setting: the compared value and its parameters.
        measured, expected: the two values, in the same unit.
        error: their difference, in `unit`.
        tolerance: the largest error that passes.
        unit: `%` of the expected value, `deg`, ...; empty for a plain number.
    """

    setting: str
    measured: float
    expected: float
    error: float
    tolerance: float
    unit: str = ""

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; a value that is not finite never passes."""
        return bool(abs(self.error) <= self.tolerance)

    @classmethod
    def relative(cls, setting: str, measured: float, expected: float, percent: float) -> "Row":
        """A row whose error is in percent of the expected value."""
        error = 100.0 * (measured / expected - 1.0)
        return cls(setting, float(measured), float(expected), float(error), percent, "%")

    @classmethod
    def order(cls, setting: str, measured: float, expected: float) -> "Row":
        """A row for an order of convergence; the error is the shortfall from the expected order."""
        return cls(setting, float(measured), expected, max(0.0, expected - float(measured)), 0.2)


@dataclass(frozen=True)
class Curve:
    """A line or, with a style such as `o`, points of a chart."""

    label: str
    x: Array
    y: Array
    style: str = "-"


@dataclass(frozen=True)
class Chart:
    """One pair of axes; labels carry the unit, `log` names the logarithmic axes (`x`, `y` or `xy`)."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    log: str = ""


@dataclass(frozen=True)
class Check:
    """One reference solution: its rows, the charts of its figure, and a description of the comparison.

    Attributes:
        name: short, for file names and anchors.
        reference: the solution, for a heading.
        about: settings, source, and limits of the comparison.
    """

    name: str
    reference: str
    about: str
    rows: tuple[Row, ...]
    charts: tuple[Chart, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """Whether every row passed."""
        return all(row.passed for row in self.rows)


@dataclass(frozen=True)
class History:
    """History of one case.

    Attributes:
        step: numbers of the time steps.
        force: shape (step, 4), in the order of `taichiflap.march.state`.
        amplitude: of each mode, shape (step, mode).
    """

    step: NDArray[np.int64]
    force: Array
    amplitude: Array


@dataclass(frozen=True)
class Grid:
    """A kind of lattice with a number of panels.

    Attributes:
        panels: panels along the chord.
        kind: its name, `cosine` or `uniform`.
        settings: its keys in the case file.
    """

    panels: int
    kind: str
    settings: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.panels} {self.kind} panels"


def accurate(panels: int = 20) -> Grid:
    """The default lattice of a case."""
    return Grid(panels, "cosine", ())


def papers(panels: int = 50) -> Grid:
    """The paper's lattice with the consistent shedding rule; the paper's fixed distance causes an error of 16 % in
    Wagner's start.
    """
    settings = "spacing=uniform", "loads=panels", "convection=euler", "core=0.0", "core_growth=0.0"
    return Grid(panels, "uniform", tuple(f"uvlm.{setting}" for setting in settings))


def plate(*settings: str, grid: Grid | None = None) -> Case:
    """A rigid plate of unit chord and span in a unit stream of unit density, at rest at no incidence.

    The force is then half the coefficient. The lattice is `accurate()` by default.
    """
    grid = grid or accurate()
    document = {
        "solver": "uvlm",
        "wing": {"chord": 1.0, "span": 1.0, "thickness": 1e-3, "density": 1e3, "youngs_modulus": 1e9, "modes": 0},
        "motion": {"frequency": 1.0},
        "fluid": {"density": 1.0, "velocity": [1.0, 0.0]},
        "uvlm": {"panels": grid.panels},
    }
    return parse_case(document, "validation").override(*grid.settings, *settings)


def run(cases: Sequence[Case]) -> list[History]:
    """March cases with one solver side by side; returns their forces and amplitudes."""
    return follow(March(cases, fluids.load(cases[0].solver)))


def follow(march: March) -> list[History]:
    """March to the end from the current step."""
    blocks = []
    while not march.done:
        blocks.append([(case["step"], case["force"], case["q"][:, 0]) for case in march.advance(BLOCK)])
    return [
        History(*(np.concatenate(parts) for parts in zip(*case, strict=True))) for case in zip(*blocks, strict=True)
    ]


def observed_order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Order of convergence: slope of log(error) over log(size), size being a step or panel length."""
    return float(np.polyfit(np.log(np.asarray(sizes)), np.log(np.abs(np.asarray(errors))), 1)[0])
