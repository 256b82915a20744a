"""Ticks along an axis of a map: round numbers and their positions."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichiflap.maps.design import Axis
from taichiflap.maps.labels import is_log
from taichiflap.notation import short

MOST_TICKS = 6
MOST_STEPS = 8
"""Ticks along an edge: of cells, and steps between those of points."""
MARGIN = 0.04
"""Free around the points, as a share of the picture."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ticks:
    """Numbers along an edge of the picture: where, as a share of it, and what they say."""

    places: Array
    texts: list[str]


def of_cells(axis: Axis, factor: float) -> Ticks:
    """Ticks of cells, one for each value of a key: the values themselves where they are few and plain or no range."""
    count = len(axis.values)
    middles = (np.arange(count) + 0.5) / count
    values = factor * np.array(axis.values)[axis.order] if axis.numeric else np.zeros(0)
    rises = len(values) > 1 and bool((np.diff(values) > 0).all())
    plain = all(float(f"{value:.2g}") == float(f"{value:.6g}") for value in values)
    if rises and not (plain and count <= MOST_TICKS):
        log = is_log(axis)
        marks = round_numbers(values, log)
        along = (np.log(marks), np.log(values)) if log else (marks, values)
        if len(marks) > 1:
            return Ticks(np.interp(along[0], along[1], middles), [f"{mark:.4g}" for mark in marks])
    chosen = np.arange(0, count, -(-count // MOST_TICKS))
    texts = [values[i] if axis.numeric else axis.values[i] for i in chosen]
    return Ticks(middles[chosen], [short(text) for text in texts])


def of_points(axis: Axis | None, values: Array) -> tuple[Array, Ticks]:
    """Where points of some values are along an edge, of a key's axis or of a metric, and what that edge says."""
    known = values[np.isfinite(values)]
    log = axis is not None and axis.numeric and is_log(axis)
    if axis is not None and not axis.numeric:
        kinds = list(dict.fromkeys(axis.values))
        marks, texts = np.arange(float(len(kinds))), [str(kind) for kind in kinds]
    else:
        marks = round_numbers(known, log)
        texts = [f"{mark:.4g}" for mark in marks]
    scaled, ends, marks = (np.log(part) if log else part for part in (values, known, marks))
    low, high = (float(ends.min()), float(ends.max())) if ends.size else (0.0, 1.0)
    spare = MARGIN * (high - low) or 0.5
    span = high - low + 2.0 * spare
    return (scaled - low + spare) / span, Ticks((marks - low + spare) / span, texts)


def round_numbers(values: Array, log: bool) -> Array:
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
