"""A map in words: the lines that `sweep` and `info` print."""

from collections.abc import Iterator

import numpy as np

from .design import Axis, Design
from .maps import Map
from .outcome import COMPLETE, FAILED

LABEL = 24
SHOWN = ("force_vertical_mean", "power_mean", "lift_per_power", "tip_peak_mean")
"""Metrics whose range is printed."""
REASONS = 3
"""Failed cases whose reason is printed."""


def map_lines(sheet: Map) -> Iterator[str]:
    """Lines of text that summarise a map, complete or not."""
    design, status = sheet.design, sheet.status
    yield sheet.title or "(no title)"
    counts = f"{np.sum(status == COMPLETE):,} complete, {np.sum(status == FAILED):,} failed"
    yield _line("file", f"{sheet.path or 'in memory'}, {design.size:,} cases: {counts}")
    for axis in design.axes:
        yield _line(axis.key, _range(axis, design, sheet.units(axis.key)))
    for name in SHOWN:
        if name in sheet.metrics:
            yield from _extremes(sheet, name)
    failed = np.flatnonzero(status == FAILED)[:REASONS].tolist()
    for number, outcome in zip(failed, sheet.outcomes(failed), strict=True):
        yield _line("failed", f"{', '.join(design.settings(number))}: {outcome and outcome.reason}")


def _extremes(sheet: Map, name: str) -> Iterator[str]:
    values = sheet.values(name).ravel()
    if np.isnan(values).all():
        return
    for word, number in (("least", int(np.nanargmin(values))), ("most", int(np.nanargmax(values)))):
        where = ", ".join(sheet.design.settings(number))
        yield _line(name if word == "least" else "", f"{word} {values[number]:.4g} {sheet.units(name)} at {where}")


def _range(axis: Axis, design: Design, units: str) -> str:
    count = len(axis.values) if design.grid else design.size
    if not axis.numeric:
        return ", ".join(map(str, dict.fromkeys(axis.values)))
    low, high = min(axis.values), max(axis.values)
    return f"{low:g} to {high:g} {units}, {count:,} values"


def _line(label: str, text: str) -> str:
    return f"  {label:<{LABEL - 2}}  {text}"
