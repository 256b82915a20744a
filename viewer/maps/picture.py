"""Content of a map's picture, and the positions of its cases. Independent of the browser.

Every combination of two keys is a cell of a heat map; anything else over anything else, such as lift over power, is a
point for every case.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import contourpy
import numpy as np
from numpy.typing import NDArray

from taichiflap.maps.design import Axis
from taichiflap.maps.file import Map
from taichiflap.maps.labels import factor_of, is_log
from taichiflap.metrics.names import POWER, gains, shown
from taichiflap.metrics.pareto import pareto_front
from taichiflap.run import limits

from .ticks import Ticks, of_cells, of_points, round_numbers

NEAR = 0.03
"""A click reaches a point at this share of the picture's width, or less."""

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Choice:
    """Choices of a browser: names of keys or metrics, and indices of the keys that a heat map holds fixed."""

    across: str
    up: str
    colour: str
    fixed: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Picture:
    """Cells or points. Positions are fractions of the picture, from its lower left corner.

    Attributes:
        numbers: of the cases, shape (rows, columns) from the lowest row, or (points,).
        values: of the metric that gives the colour, alike; not-a-number where a case has none.
        broken, bent: cases for which the model does not hold, alike, whose value is left out; and cases whose wing
            bends further than a linear beam is good for.
        points: where the points are, shape (points, 2); None for cells.
        fronts: of lift against power, for every kind of case: the points that none of its kind beats in both.
        across, up: what the lower and the left edge say.
    """

    numbers: NDArray[np.intp]
    values: Array
    broken: Mask
    bent: Mask
    points: Array | None
    across: Ticks
    up: Ticks
    fronts: Sequence[NDArray[np.intp]] = ()

    @property
    def limits(self) -> tuple[float, float]:
        """Minimum and maximum; 0 and 1 without values."""
        known = self.values[np.isfinite(self.values)]
        return (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)

    def contours(self) -> list[tuple[float, list[Array]]]:
        """Contours of a heat map: a round value, and its lines as fractions of the picture, shape (n, 2)."""
        known = self.values[np.isfinite(self.values)]
        if self.points is not None or min(self.values.shape) < 2 or known.size < 4 or np.ptp(known) == 0.0:
            return []
        rows, columns = self.values.shape
        middles = (np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows
        lines: Any = contourpy.contour_generator(*middles, np.ma.masked_invalid(self.values))
        return [(float(level), list(lines.lines(level))) for level in round_numbers(known, log=False)]

    def cell(self, number: int) -> tuple[int, int]:
        """Row and column of a case of a heat map."""
        row, column = np.argwhere(self.numbers == number)[0]
        return int(row), int(column)

    def at(self, across: float, up: float) -> int | None:
        """Number of the case at a position of the picture; None if absent."""
        if self.points is not None:
            distance = np.hypot(*(self.points - (across, up)).T)
            if not np.any(distance <= NEAR):
                return None
            return int(self.numbers[np.nanargmin(distance)])
        if not (0.0 <= across < 1.0 and 0.0 <= up < 1.0):
            return None
        rows, columns = self.numbers.shape
        return int(self.numbers[int(up * rows), int(across * columns)])


@dataclass(frozen=True)
class Profile:
    """A metric along one key with all others fixed: the key, its values, which rise, and the metric, in display units.

    Attributes:
        log: whether the key is drawn by its logarithm.
    """

    key: str
    log: bool
    places: Array
    values: Array


def opening(sheet: Map) -> Choice:
    """The initial choice: the first metric over the first two keys, or over the only one."""
    varying = [axis for axis in sheet.design.axes if len(set(axis.values)) > 1] or list(sheet.design.axes)
    keys = [axis.key for axis in sorted(varying, key=lambda axis: not axis.numeric)]
    metric = shown(sheet.metrics)[0]
    return Choice(keys[1], keys[0], metric) if len(keys) > 1 else Choice(keys[0], metric, metric)


def held(sheet: Map, choice: Choice) -> list[Axis]:
    """The keys that a heat map holds fixed; none for a scatter, which has a point for every case."""
    if not _is_heat_map(sheet, choice):
        return []
    return [axis for axis in sheet.design.axes if axis.key not in (choice.across, choice.up) and len(axis.values) > 1]


def read(sheet: Map, choice: Choice) -> Picture:
    """The picture of a choice; failed cases, and cases in which the model is invalid, have no value."""
    numbers = np.arange(sheet.design.size)
    broken, bent = limits.broken(sheet), limits.bent(sheet)
    values = np.where(broken, np.nan, _column(sheet, choice.colour))
    if _is_heat_map(sheet, choice):
        axes = sheet.design.axes
        keys = [axis.key for axis in axes]
        index = tuple(slice(None) if key in (choice.across, choice.up) else choice.fixed.get(key, 0) for key in keys)
        rising = (axis.order for axis in axes if axis.key in (choice.across, choice.up))
        cut = numbers.reshape(sheet.design.shape)[index][np.ix_(*rising)]
        cells = cut if keys.index(choice.up) < keys.index(choice.across) else cut.T
        across, up = (of_cells(axes[keys.index(name)], factor_of(sheet, name)) for name in (choice.across, choice.up))
        return Picture(cells, values[cells], broken[cells], bent[cells], None, across, up)
    sides = [of_points(_axis(sheet, name), _column(sheet, name)) for name in (choice.across, choice.up)]
    points = np.stack([places for places, _ in sides], axis=1)
    sides_of = {choice.across, choice.up}
    gain = next((name for name in gains(sheet.metrics) if sides_of == {name, POWER}), None)
    fronts = _fronts(sheet, gain) if gain else ()
    return Picture(numbers, values, broken, bent, points, sides[0][1], sides[1][1], fronts)


def profiles(sheet: Map, choice: Choice, picture: Picture, number: int) -> list[Profile]:
    """The metric through a case along either key of a heat map; None for a scatter."""
    if picture.points is not None:
        return []
    row, column = picture.cell(number)
    lines = ((choice.across, picture.values[row]), (choice.up, picture.values[:, column]))
    found = [(_axis(sheet, name), name, values) for name, values in lines]
    return [
        Profile(name, is_log(axis), factor_of(sheet, name) * np.array(axis.values, dtype=float)[axis.order], values)
        for axis, name, values in found
        if axis and axis.numeric
    ]


def _is_heat_map(sheet: Map, choice: Choice) -> bool:
    keys = [axis.key for axis in sheet.design.axes]
    return sheet.design.grid and choice.across != choice.up and choice.across in keys and choice.up in keys


def _fronts(sheet: Map, gain: str) -> list[NDArray[np.intp]]:
    """Pareto fronts of a force against power: one for each value of the first key of text, or one of all cases."""
    force = np.where(limits.broken(sheet), np.nan, sheet.values(gain).ravel())
    power = sheet.values(POWER).ravel()
    texts = [_column(sheet, axis.key) for axis in sheet.design.axes if not axis.numeric]
    kinds = texts[0] if texts else np.zeros(len(force))
    alike = [np.flatnonzero(kinds == kind) for kind in np.unique(kinds)]
    return [numbers[pareto_front(power[numbers], force[numbers])] for numbers in alike]


def _axis(sheet: Map, name: str) -> Axis | None:
    return next((axis for axis in sheet.design.axes if axis.key == name), None)


def _column(sheet: Map, name: str) -> Array:
    """A metric or a key of every case, in its display unit; a text key as the index of its value."""
    axis = _axis(sheet, name)
    if axis is None:
        return factor_of(sheet, name) * sheet.values(name).ravel()
    kinds = list(dict.fromkeys(axis.values))
    scaled = factor_of(sheet, name) * np.array(axis.values) if axis.numeric else [kinds.index(v) for v in axis.values]
    if not sheet.design.grid:
        return np.array(scaled, dtype=float)
    position = sheet.design.axes.index(axis)
    places = np.unravel_index(np.arange(sheet.design.size), sheet.design.shape)[position]
    return np.array(scaled, dtype=float)[places]
