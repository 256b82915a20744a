"""Text summary of a map, printed by `sweep` and `info`."""

from collections.abc import Iterator

import numpy as np

from ..maps.design import Axis, Design
from ..maps.file import Map
from ..maps.labels import model
from ..maps.outcome import COMPLETE, FAILED
from ..metrics.names import shown
from ..notation import fraction, printable, short
from ..run import limits
from ..run.warnings import BENT, BROKEN, FORCE, UNACCOUNTED

REASONS = 3
"""Maximum number of failed cases whose reason is printed."""


def map_lines(sheet: Map) -> Iterator[str]:
    """Lines that summarise a map, complete or partial."""
    return map(printable, _lines(sheet))


def _lines(sheet: Map) -> Iterator[str]:
    yield sheet.title or "(no title)"
    lines = list(_labelled(sheet))
    width = max(len(label) for label, _ in lines)
    yield from (f"  {label:<{width}}  {text}" for label, text in lines)
    yield from (f"warning: {doubt}" for doubt in _doubts(sheet))


def _labelled(sheet: Map) -> Iterator[tuple[str, str]]:
    design, status = sheet.design, sheet.status
    counts = f"{np.sum(status == COMPLETE):,} complete, {np.sum(status == FAILED):,} failed"
    yield "file", f"{sheet.path or 'in memory'}, {design.size:,} cases: {counts}"
    if model(sheet):
        yield "model", model(sheet)
    for axis in design.axes:
        yield axis.key, _range(axis, design, sheet.units(axis.key))
    for name in shown(sheet.metrics):
        yield from _extremes(sheet, name)
    failed = np.flatnonzero(status == FAILED)[:REASONS].tolist()
    for number, outcome in zip(failed, sheet.outcomes(failed), strict=True):
        yield "failed", f"{', '.join(design.settings(number))}: {outcome and outcome.reason}"


def _doubts(sheet: Map) -> Iterator[str]:
    """Warnings with the number of cases outside the models' validity, or not yet periodic."""
    complete = sheet.status == COMPLETE
    of = f"of {complete.sum():,} cases"
    broken = limits.broken(sheet)
    bent = np.sum(limits.bent(sheet) & ~broken)
    if broken.any():
        yield (
            f"in {broken.sum():,} {of} the model is invalid: tip deflection above {BROKEN:g} chord, or normal force "
            f"above {FORCE:g} times rho V^2 S / 2; figures show these cases in grey, and min and max leave them out"
        )
    if bent:
        yield (
            f"in {bent:,} {of} the tip deflection exceeds {BENT:g} chords, where the error of the linear beam exceeds "
            "10 %"
        )
    if limits.unbalanced(sheet).any():
        yield (
            f"in {limits.unbalanced(sheet).sum():,} {of} more than {100.0 * UNACCOUNTED:g} % of the work is "
            "unaccounted for (metric energy_residual); increase time.steps_per_period"
        )
    if "settled" in sheet.metrics:
        restless = np.sum(sheet.values("settled").ravel()[complete] == 0.0)
        if restless:
            yield f"in {restless:,} {of} the run is not yet periodic (metric settled)"


def _extremes(sheet: Map, name: str) -> Iterator[tuple[str, str]]:
    """The least and the largest value of a metric, of the cases in which the model is valid, if any."""
    values, broken = sheet.values(name).ravel(), limits.broken(sheet)
    if np.isfinite(values[~broken]).any():
        values = np.where(broken, np.nan, values)
    if np.isnan(values).all():
        return
    for word, number in (("min", int(np.nanargmin(values))), ("max", int(np.nanargmax(values)))):
        found = f"{values[number]:.4g} {fraction(sheet.units(name))}".rstrip()
        yield name if word == "min" else "", f"{word:<3} {found} at {_where(sheet.design, number)}"


def _where(design: Design, number: int) -> str:
    return ", ".join(f"{key} = {short(value)}" for key, value in design.point(number).items())


def _range(axis: Axis, design: Design, units: str) -> str:
    count = len(axis.values) if design.grid else design.size
    if not axis.numeric:
        return ", ".join(map(str, dict.fromkeys(axis.values)))
    low, high = min(axis.values), max(axis.values)
    return f"{short(low)} to {short(high)}{f' {units}' if units else ''}, {count:,} values"
