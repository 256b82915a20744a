"""A user's own measurement: a CSV file whose columns are named, with their units."""

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...results.variables import VARIABLES
from .tiers import ScoreError

Array = NDArray[np.float64]

PREFIXES = {"": 1.0, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "k": 1e3}
UNITS: Mapping[str, Mapping[str, float]] = {
    "N": {f"{prefix}N": factor for prefix, factor in PREFIXES.items()},
    "W": {f"{prefix}W": factor for prefix, factor in PREFIXES.items()},
    "N m": {f"{prefix}N m": factor for prefix, factor in PREFIXES.items()},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "s": {"s": 1.0, "ms": 1e-3},
    "1": {"1": 1.0, "-": 1.0},
}
"""Units of a column's heading in SI, by what they measure."""
COEFFICIENTS = {"C_L": "lift", "C_D": "drag", "C_T": "thrust", "C_V": "force_vertical"}
"""Force coefficients, and the series that each is of: C_V is of the vertical force."""
SERIES = ("force_vertical", "force_normal", "force_axial", "force_y", "force_z", "lift", "thrust", "power",
          "moment", "tip_deflection")  # fmt: skip
TIMES = {"t/T": "1", "t_over_T": "1", "beats": "1", "time": "s", "t": "s"}
"""Names of the column of time, and what it is in: beats, or s."""
HEADING = re.compile(r"\s*(?P<name>[\w/]+)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*$")
FEWEST_ROWS = 4


@dataclass(frozen=True)
class Trace:
    """A measured trace.

    Attributes:
        path: its file.
        time: in beats, or in s.
        in_beats: which of them.
        values: each quantity, in the unit of its column.
        units: these units, and their factors to SI.
    """

    path: Path
    time: Array
    in_beats: bool
    values: Mapping[str, Array]
    units: Mapping[str, tuple[str, float]]


def read_trace(path: Path) -> Trace:
    """A CSV file whose first line names its columns: a time (`t/T`, or `time [s]`) and quantities with their units.

    A column without a unit is in SI. Lines that begin with `#` are skipped.

    Raises:
        ScoreError: when a column is missing, unknown, named twice or holds something else; one sentence with the cure.
    """
    try:
        lines = [line for line in path.read_text(encoding="utf-8-sig").splitlines() if line and line[0] != "#"]
    except (OSError, UnicodeDecodeError) as error:
        raise ScoreError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or 'not text in UTF-8'}") from None
    if len(lines) <= FEWEST_ROWS:
        raise ScoreError(f"{path}: has {len(lines)} lines; give a line of names and at least {FEWEST_ROWS} rows")
    heads, *rows = csv.reader(lines)
    try:
        table = np.array([[float(cell) for cell in row] for row in rows])
    except ValueError as error:
        raise ScoreError(f"{path}: {error}; give numbers with decimal points between commas") from None
    if table.ndim != 2 or table.shape[1] != len(heads) or not np.isfinite(table).all():
        raise ScoreError(f"{path}: rows differ in their columns, or hold no finite number")
    columns = [_column(path, head) for head in heads]
    times = [i for i, (name, _, _) in enumerate(columns) if name in TIMES]
    if len(times) != 1:
        raise ScoreError(f"{path}: needs one column of time, named t/T or time [s]; it has {', '.join(heads)}")
    ((name, _, factor),) = (columns[i] for i in times)
    time = factor * table[:, times[0]]
    if np.any(np.diff(time) <= 0.0):
        raise ScoreError(f"{path}: times must rise from row to row")
    values = {one: table[:, i] for i, (one, _, _) in enumerate(columns) if i not in times}
    if not values:
        raise ScoreError(f"{path}: has no quantity beside the time; known are {', '.join((*SERIES, *COEFFICIENTS))}")
    if len(values) < len(columns) - 1:
        raise ScoreError(f"{path}: a quantity has two columns; give each its own file")
    units = {one: (unit, scale) for one, unit, scale in columns}
    return Trace(path, time, TIMES[name] == "1", values, units)


def _column(path: Path, head: str) -> tuple[str, str, float]:
    """Name of a column, its unit, and the factor to SI."""
    found = HEADING.match(head)
    name, unit = (found["name"], (found["unit"] or "").strip()) if found else (head, "")
    if name not in TIMES and name not in SERIES and name not in COEFFICIENTS:
        raise ScoreError(
            f'{path}: column "{head}" is not known; name it t/T, time [s], {", ".join((*SERIES, *COEFFICIENTS))}'
        )
    si = TIMES.get(name) or ("1" if name in COEFFICIENTS else VARIABLES[name].units)
    if unit and unit not in UNITS[si]:
        raise ScoreError(f'{path}: column "{head}": unit {unit} is not one of {name}; use {", ".join(UNITS[si])}')
    return name, unit or si, UNITS[si][unit or si]
