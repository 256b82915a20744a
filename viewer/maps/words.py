"""What the page of a map says: the map, its cases and its picture in words."""

from html import escape

import numpy as np

from taichiflap.maps.file import Map
from taichiflap.maps.labels import factor_of, model, named
from taichiflap.maps.outcome import COMPLETE, FAILED
from taichiflap.notation import short
from taichiflap.run.warnings import BENT, BROKEN

from . import picture

FRONT = "Line: Pareto front of lift and power."
NOTHING = "Grey: a case without this metric."
DOUBTFUL = f"Hatched grey: the model is invalid (tip deflection above {BROKEN:g} chord, or unphysical forces)."
HATCHED = f"Hatched: tip deflection above {BENT:g} chords."


def headline(sheet: Map) -> str:
    """The map, its model and its number of cases, as HTML."""
    status = sheet.status
    counts = [*filter(None, [model(sheet)]), f"{sheet.design.size:,} cases"]
    counts += [f"{count:,} to run" for count in [int(np.sum((status != COMPLETE) & (status != FAILED)))] if count]
    counts += [f"{count:,} failed" for count in [int(np.sum(status == FAILED))] if count]
    name = escape(sheet.case.title or (sheet.path.stem if sheet.path else ""))
    return f'<div data-map style="padding:2px 4px 6px;line-height:1.45"><b>{name}</b><br>{", ".join(counts)}</div>'


def remarks(shown: picture.Picture) -> str:
    """What is grey, hatched or joined by a line, as HTML."""
    cells = shown.points is None
    said = {
        NOTHING: bool((~np.isfinite(shown.values) & ~shown.broken).any()),
        DOUBTFUL if cells else DOUBTFUL.replace("Hatched grey", "Grey"): bool(shown.broken.any()),
        HATCHED: cells and bool((shown.bent & ~shown.broken).any()), FRONT: bool(len(shown.fronts)),
    }  # fmt: skip
    return "".join(f"{text}<br>" for text, true in said.items() if true)


def of_case(sheet: Map, number: int, metric: str, shown: picture.Picture) -> list[str]:
    """A case in plain words: what makes it, its metric, or why it has none, and whether the model holds."""
    outcome = sheet.outcomes([number])[0]
    lines = [f"case {number}", *(f"{key} = {short(value)}" for key, value in sheet.design.point(number).items())]
    if outcome is None:
        return [*lines, "not run yet"]
    if outcome.reason:
        return [*lines, outcome.reason]
    title, _, unit = named(metric, sheet).partition(" (")
    lines.append(f"{title} = {factor_of(sheet, metric) * outcome.metrics[metric]:.4g} {unit.rstrip(')')}")
    place = np.nonzero(shown.numbers == number)
    if shown.broken[place].any():
        lines.append("the model is invalid")
    elif shown.bent[place].any():
        lines.append(f"tip deflection above {BENT:g} chords")
    return lines


def case_lines(sheet: Map, number: int, metric: str, shown: picture.Picture) -> list[str]:
    """`of_case` as HTML."""
    first, *rest = map(escape, of_case(sheet, number, metric, shown))
    return [f"<b>{first.capitalize()}</b>", *rest]


def title_and_unit(name: str, sheet: Map) -> tuple[str, str]:
    """A metric, as HTML, and its unit."""
    title, _, unit = named(name, sheet).partition(" (")
    return escape(title), unit.rstrip(")")


def as_html(lines: list[str]) -> str:
    """Lines of HTML below one another."""
    style = "padding:4px;font-size:12px;line-height:1.4;overflow-wrap:anywhere"
    return f'<div data-case style="{style}">{"<br>".join(lines)}</div>'


def digits(value: float) -> float:
    """A number to three digits."""
    return float(f"{value:.3g}")
