"""What a validation is made of: rows that pass or fail, curves that show how errors fall, and marches to get them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .. import fluids
from ..case.case import Case, parse_case
from ..march.march import March

Array = NDArray[np.float64]

BLOCK = 100
"""Steps between two looks at a march, so that the stored outputs of a batch stay small."""


@dataclass(frozen=True)
class Row:
    """One measurement against a reference.

    Attributes:
        setting: what was measured, and at which parameters.
        measured, expected: the two values, in the same unit.
        error: how far apart they are, in `unit`.
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
        """A row whose error is in per cent of the expected value."""
        error = 100.0 * (measured / expected - 1.0)
        return cls(setting, float(measured), float(expected), float(error), percent, "%")

    @classmethod
    def order(cls, setting: str, measured: float, expected: float) -> "Row":
        """A row for an order of convergence; what it falls short of the expected order is the error."""
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
    """One reference: its rows, the figure's charts, and a word on what was compared with what.

    Attributes:
        name: short, for file names and anchors.
        reference: the solution, for a heading.
        about: settings, source, and what the comparison cannot show.
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
    """Frames of one case: time steps, forces (step, 4) as `taichiflap.march.state` orders them, modal amplitudes."""

    step: NDArray[np.int64]
    force: Array
    amplitude: Array


@dataclass(frozen=True)
class Grid:
    """A kind of lattice with a number of panels.

    Attributes:
        panels: panels along the chord.
        kind: what to call it, `cosine` or `uniform`.
        settings: keys of the case file that make it.
    """

    panels: int
    kind: str
    settings: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.panels} {self.kind} panels"


def accurate(panels: int = 20) -> Grid:
    """The lattice that a case has by default."""
    return Grid(panels, "cosine", ())


def papers(panels: int = 50) -> Grid:
    """The paper's lattice, but for where new vortices stand: its fixed distance is wrong by 16 % on Wagner's start."""
    settings = "spacing=uniform", "loads=panels", "convection=euler", "core=0.0", "core_growth=0.0"
    return Grid(panels, "uniform", tuple(f"uvlm.{setting}" for setting in settings))


def plate(*settings: str, grid: Grid | None = None) -> Case:
    """A rigid plate of unit chord and span in a unit stream of unit density, at rest at no incidence.

    A force is then half its coefficient. The lattice is `accurate()` by default.
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
    """March cases of one solver side by side and keep their forces and amplitudes."""
    return follow(March(cases, fluids.load(cases[0].solver)))


def follow(march: March) -> list[History]:
    """March to the end from where a march stands."""
    blocks = []
    while not march.done:
        blocks.append([(case["step"], case["force"], case["q"][:, 0]) for case in march.advance(BLOCK)])
    return [
        History(*(np.concatenate(parts) for parts in zip(*case, strict=True))) for case in zip(*blocks, strict=True)
    ]


def observed_order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Order of convergence: slope of log(error) over log(size), size being a step or panel length."""
    return float(np.polyfit(np.log(np.asarray(sizes)), np.log(np.abs(np.asarray(errors))), 1)[0])
