"""What of a map a browser shows, and which case lies where. No browser in here, only arithmetic.

Every combination of two keys is a cell of a heat map; anything else over anything else, such as lift over power, is a
point for every case.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from taichiflap.maps.design import Axis
from taichiflap.maps.file import Map
from taichiflap.maps.labels import factor_of, is_log
from taichiflap.metrics.names import POWER, gains, shown
from taichiflap.metrics.pareto import pareto_front
from taichiflap.notation import short
from taichiflap.run import limits

MOST_TICKS = 6
MOST_STEPS = 8
"""Ticks along an edge: of cells, and steps between those of points."""
NEAR = 0.03
"""A click reaches a point at this share of the picture's width, or less."""
MARGIN = 0.04
"""Free around the points, as a share of the picture."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Choice:
    """What a browser wants to see: names of keys or metrics, and places of the keys that a heat map holds fixed."""

    across: str
    up: str
    colour: str
    fixed: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Ticks:
    """Numbers along an edge of the picture: where, as a share of it, and what they say."""

    places: Array
    texts: list[str]


@dataclass(frozen=True)
class Picture:
    """Cells or points. Places are shares of the picture, from its lower left corner.

    Attributes:
        numbers: of the cases, shape (rows, columns) from the lowest row, or (points,).
        values: of the metric that gives the colour, alike; not-a-number where a case has none.
        points: where the points are, shape (points, 2); None for cells.
        fronts: of lift against power, for every kind of case: the points that none of its kind beats in both.
        across, up: what the lower and the left edge say.
    """

    numbers: NDArray[np.intp]
    values: Array
    points: Array | None
    across: Ticks
    up: Ticks
    fronts: Sequence[NDArray[np.intp]] = ()

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest value; 0 and 1 if there is none."""
        known = self.values[np.isfinite(self.values)]
        return (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)

    def at(self, across: float, up: float) -> int | None:
        """Number of the case at a place of the picture, if there is one."""
        if self.points is not None:
            distance = np.hypot(*(self.points - (across, up)).T)
            if not np.any(distance <= NEAR):
                return None
            return int(self.numbers[np.nanargmin(distance)])
        if not (0.0 <= across < 1.0 and 0.0 <= up < 1.0):
            return None
        rows, columns = self.numbers.shape
        return int(self.numbers[int(up * rows), int(across * columns)])


def opening(sheet: Map) -> Choice:
    """What is shown at first: the first metric over the first two keys, or over the only one."""
    varying = [axis for axis in sheet.design.axes if len(set(axis.values)) > 1] or list(sheet.design.axes)
    keys = [axis.key for axis in sorted(varying, key=lambda axis: not axis.numeric)]
    metric = shown(sheet.metrics)[0]
    return Choice(keys[1], keys[0], metric) if len(keys) > 1 else Choice(keys[0], metric, metric)


def held(sheet: Map, choice: Choice) -> list[Axis]:
    """The keys that a heat map holds fixed; none for points, of which there is one for every case."""
    if not _is_heat_map(sheet, choice):
        return []
    return [axis for axis in sheet.design.axes if axis.key not in (choice.across, choice.up) and len(axis.values) > 1]


def read(sheet: Map, choice: Choice) -> Picture:
    """The picture of a choice; a case for which the model does not hold has no value, as one that failed."""
    numbers = np.arange(sheet.design.size)
    values = np.where(limits.broken(sheet), np.nan, _column(sheet, choice.colour))
    if _is_heat_map(sheet, choice):
        axes = sheet.design.axes
        keys = [axis.key for axis in axes]
        index = tuple(slice(None) if key in (choice.across, choice.up) else choice.fixed.get(key, 0) for key in keys)
        cut = numbers.reshape(sheet.design.shape)[index]
        cells = cut if keys.index(choice.up) < keys.index(choice.across) else cut.T
        across, up = (_of_cells(axes[keys.index(name)], factor_of(sheet, name)) for name in (choice.across, choice.up))
        return Picture(cells, values[cells], None, across, up)
    sides = [_of_points(sheet, name) for name in (choice.across, choice.up)]
    points = np.stack([places for places, _ in sides], axis=1)
    sides_of = {choice.across, choice.up}
    gain = next((name for name in gains(sheet.metrics) if sides_of == {name, POWER}), None)
    fronts = _fronts(sheet, gain) if gain else ()
    return Picture(numbers, values, points, sides[0][1], sides[1][1], fronts)


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
    """A metric or a key of every case, in the unit that it is drawn in; a key of text as the place of its value."""
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


def _of_cells(axis: Axis, factor: float) -> Ticks:
    count = len(axis.values)
    chosen = np.arange(0, count, -(-count // MOST_TICKS))
    values = [axis.values[i] for i in chosen]
    return Ticks((chosen + 0.5) / count, [short(factor * v if not isinstance(v, str) else v) for v in values])


def _of_points(sheet: Map, name: str) -> tuple[Array, Ticks]:
    """Where the points are along one edge, and what that edge says."""
    axis, values = _axis(sheet, name), _column(sheet, name)
    known = values[np.isfinite(values)]
    log = axis is not None and axis.numeric and is_log(axis)
    if axis is not None and not axis.numeric:
        kinds = list(dict.fromkeys(axis.values))
        marks, texts = np.arange(float(len(kinds))), [str(kind) for kind in kinds]
    else:
        marks = _round_numbers(known, log)
        texts = [f"{mark:.4g}" for mark in marks]
    scaled, ends, marks = (np.log(part) if log else part for part in (values, known, marks))
    low, high = (float(ends.min()), float(ends.max())) if ends.size else (0.0, 1.0)
    spare = MARGIN * (high - low) or 0.5
    span = high - low + 2.0 * spare
    return (scaled - low + spare) / span, Ticks((marks - low + spare) / span, texts)


def _round_numbers(values: Array, log: bool) -> Array:
    """1, 2 or 5 times powers of ten between the least and the greatest value: all of them, or evenly spaced."""
    if not values.size:
        return np.zeros(0)
    low, high = float(values.min()), float(values.max())
    if log:
        powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.log10(high) + 1.0)
        marks = np.outer(powers, (1.0, 2.0, 5.0)).ravel()
        marks = marks[(marks >= low) & (marks <= high)]
        return marks if len(marks) <= MOST_TICKS + 2 else marks[:: -(-len(marks) // MOST_TICKS)]
    if low == high:
        return np.array([low])
    rough = (high - low) / MOST_STEPS
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= rough * (1.0 - 1e-9))
    # Adding zero takes the sign from a zero that has one.
    return step * np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1.0) + 0.0
