"""Results, cases and maps as HTML: a summary, curves, and a picture."""

from collections.abc import Iterable, Iterator
from html import escape

import numpy as np

from ..case.case import Case
from ..drawing import palette, scene
from ..drawing.orientation import Orientation
from ..errors import UserError
from ..maps.design import Axis
from ..maps.file import Map
from ..maps.labels import factor_of, model, named
from ..maps.outcome import COMPLETE, FAILED
from ..metrics.names import shown
from ..metrics.summary import Statistic, in_stream, summarise
from ..motion import sampling
from ..notation import prefixed, printable, short
from ..results.reader import Result
from ..run import limits
from . import svg

WIDTH, HEIGHT = 300.0, 220.0
"""Of a picture, at most."""
VORTICES = 600
"""Vortices in a picture, at most: the newest."""
CHORDS = 25
"""Chord lines in the picture of a case."""
CELLS = 40
"""Cells along either side of the picture of a map, at most."""
VIRIDIS = ("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")
GROUND = "background:#fff;color:#16191d;padding:8px;border:1px solid #d5dae0;border-radius:6px;font:13px sans-serif"
CELL = "text-align:left;padding:1px 10px 1px 0"

Rows = Iterable[tuple[str, str]]


def of_result(result: Result) -> str:
    """A result: what it is, its numbers, three curves of the last beat, and the wing with its wake."""
    case = result.case
    rows = [("model", case.model), ("status", f"{result.status}, {result.steps:,} steps"), *_numbers(result)]
    return _card(scene.label(result), rows, curves(result), picture(result))


def of_case(case: Case) -> str:
    """A case: what it is of, its motion over a beat, and the path of the chord."""
    wing, motion, page = case.wing, case.motion, Orientation.of(case)
    first = motion.growth if case.periodic else 0.0
    moved = sampling.sample(motion, first + np.linspace(0.0, case.beat, 8 * (CHORDS - 1) + 1))
    length, metres = prefixed(max(float(np.abs(moved[:, [sampling.PLUNGE, sampling.SURGE]]).max()), wing.chord), "m")
    modes = f"{wing.modes or 'no'} elastic mode{'' if wing.modes == 1 else 's'}"
    rows = [
        ("model", case.model),
        ("wing", f"chord {short(length * wing.chord)} {metres}, {modes}"),
        ("motion", f"{motion.frequency:g} Hz" if motion.frequency else "no frequency"),
        ("fluid", f"{short(case.fluid.density)} kg/m3"),
        ("time", f"{case.steps:,} steps of {short(1e3 * case.step)} ms"),
    ]  # fmt: skip
    series = [
        svg.curve(length * moved[:, sampling.PLUNGE], "Plunge", metres),
        svg.curve(np.degrees(moved[:, sampling.PITCH]), "Pitch", "deg"),
    ]
    shown_at = moved[::8]
    pivot = page.on_page(shown_at[:, sampling.SURGE], shown_at[:, sampling.PLUNGE])
    along = page.on_page(np.cos(shown_at[:, sampling.PITCH]), np.sin(shown_at[:, sampling.PITCH]))
    ahead, behind = pivot - wing.pivot * wing.chord * along, pivot + (1.0 - wing.pivot) * wing.chord * along
    every = np.concatenate((ahead, behind))
    low, high = every.min(axis=0) - 0.2 * wing.chord, every.max(axis=0) + 0.2 * wing.chord
    sheet = svg.Page((low[0], high[0], low[1], high[1]), WIDTH, HEIGHT)
    lines = [svg.line(a, b, palette.LINES[0], 1.0) for a, b in zip(sheet(ahead), sheet(behind), strict=True)]
    ink = np.tile(np.array((22, 25, 29), dtype=np.uint8), (len(ahead), 1))
    lines += svg.dots(sheet(ahead), ink, 1.8)
    drawn = svg.picture(sheet.width, sheet.height, lines, "the chord over a beat, its leading edge a dot")
    return _card(printable(case.title) or "untitled case", rows, series, drawn)


def of_map(sheet: Map) -> str:
    """A map: its cases, the range of each key, the extremes of its metrics, and a picture of the first of them."""
    status, design = sheet.status, sheet.design
    counts = f"{design.size:,}: {np.sum(status == COMPLETE):,} complete, {np.sum(status == FAILED):,} failed"
    rows = [*([("model", model(sheet))] if model(sheet) else []), ("cases", counts)]
    rows += [(axis.key, _range(axis)) for axis in design.axes]
    broken = limits.broken(sheet).reshape(design.shape)
    for name in shown(sheet.metrics):
        known = np.where(broken, np.nan, factor_of(sheet, name) * sheet.values(name))
        if np.isfinite(known).any():
            rows.append((named(name, sheet), f"{np.nanmin(known):.3g} to {np.nanmax(known):.3g}"))
    title = printable(sheet.title) or (printable(sheet.path.stem) if sheet.path else "map")
    return _card(title, rows, [], _heat_map(sheet, broken))


def curves(result: Result) -> list[str]:
    """Sparklines of the last beat: how the wing bends or moves, its force, and its power."""
    try:
        beat = scene.last_steps(result)
    except UserError:
        return []
    stream = result.case.fluid.streams
    force = (
        in_stream(result.case, result.force_y[beat], result.force_z[beat])[0] if stream else result.force_vertical[beat]
    )
    bends = bool(result.case.wing.modes)
    first = ("Tip deflection", result.tip_deflection[beat]) if bends else ("Plunge", result.plunge[beat])
    found = []
    for (title, values), unit in zip(
        (first, ("Lift" if stream else "Vertical force", force), ("Power", result.power[beat])), "mNW", strict=True
    ):
        factor, name = prefixed(float(np.abs(values).max()), unit)
        found.append(svg.curve(factor * values, title, name))
    return found


def picture(result: Result) -> str:
    """The wing at the end of the last beat, with its wake and the fluid's force; nothing before there is a beat."""
    try:
        chosen = scene.last_beats(result)
    except UserError:
        return ""
    last = scene.frame(result, int(chosen[-1]))
    shared = scene.bounds([last], result.case)
    page = svg.Page(shared.page, WIDTH, HEIGHT)
    wake, circulation = page(last.wake[-VORTICES:]), last.circulation[-VORTICES:]
    seen = ((wake > 0.0) & (wake < (page.width, page.height))).all(axis=1)
    wake, circulation = wake[seen], circulation[seen]
    parts = list(svg.dots(wake, palette.colours(circulation, shared.circulation), 1.8))
    parts.append(svg.path(page(last.wing), palette.LIGHT.ink, 3.0))
    tip = last.foot + last.force * (scene.REACH * result.case.wing.chord / shared.force)
    parts.append(svg.line(page(last.foot), page(tip), palette.LIGHT.force, 2.0))
    return svg.picture(page.width, page.height, parts, "the wing at the end of the last beat, its wake and its force")


def _numbers(result: Result) -> Iterator[tuple[str, str]]:
    summary = summarise(result) if result.status != "failed" else None
    if summary is None:
        yield "beats", str(result.attributes.get("reason", "no whole beat yet"))
        return
    beats = f"the last {summary.beats} beats" if summary.beats > 1 else "the last beat"
    yield "over", beats if result.case.periodic else "the whole run"
    for name, value, unit in (
        ("lift", summary.lift, "N"), ("thrust", summary.thrust, "N"),
        ("vertical force", None if summary.lift else summary.force_vertical, "N"),
        ("largest normal force", summary.force_normal_peak, "N"), ("largest tip deflection", summary.tip_peak, "m"),
        ("power", summary.power, "W"),
    ):  # fmt: skip
        if isinstance(value, Statistic):
            factor, shown_in = prefixed(abs(value.mean), unit)
            yield name, f"{value.shown(factor)} {shown_in}".replace("-", "−")


def _range(axis: Axis) -> str:
    if not axis.numeric:
        return ", ".join(map(str, dict.fromkeys(axis.values)))
    return f"{short(min(axis.values))} to {short(max(axis.values))}, {len(axis.values)} values"


def _heat_map(sheet: Map, broken: np.ndarray) -> str:
    axes = sheet.design.axes
    numeric = [i for i, axis in enumerate(axes) if axis.numeric and len(set(axis.values)) > 1]
    if not sheet.design.grid or len(numeric) < 2 or not sheet.metrics:
        return ""
    up, across = numeric[:2]
    name = shown(sheet.metrics)[0]
    cut = tuple(slice(None) if i in (up, across) else 0 for i in range(len(axes)))
    values = np.where(broken, np.nan, factor_of(sheet, name) * sheet.values(name))[cut]
    thin = [np.unique(np.rint(np.linspace(0, n - 1, min(n, CELLS))).astype(int)) for n in values.shape]
    values = values[np.ix_(axes[up].order[thin[0]], axes[across].order[thin[1]])]
    known = values[np.isfinite(values)]
    low, high = (known.min(), known.max()) if known.size else (0.0, 1.0)
    table = palette.table(VIRIDIS)
    wide, tall = WIDTH / values.shape[1], HEIGHT / values.shape[0]
    parts = []
    for row, column in np.ndindex(*values.shape):
        value = values[row, column]
        share = (value - low) / ((high - low) or 1.0)
        colour = svg.css(table[int(share * (len(table) - 1))]) if np.isfinite(value) else palette.LIGHT.faint
        x, y = column * wide, HEIGHT - (row + 1) * tall
        parts.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{wide + 0.3:.1f}" height="{tall + 0.3:.1f}" fill="{colour}"/>'
        )
    words = f"{named(name, sheet)}: up {named(axes[up].key, sheet)}, across {named(axes[across].key, sheet)}"
    drawn = svg.picture(WIDTH, HEIGHT, parts, words)
    return f'{drawn}<div style="font-size:11px;max-width:{WIDTH:g}px">{escape(words)}; {low:.3g} to {high:.3g}</div>'


def _card(title: str, rows: Rows, series: list[str], drawn: str) -> str:
    table = "".join(
        f'<tr style="background:none"><td style="{CELL};color:#5c6570">{escape(name)}</td>'
        f'<td style="{CELL}">{escape(value)}</td></tr>'
        for name, value in rows
    )
    columns = [
        f'<table style="margin:0;border:0;color:inherit;font:inherit">{table}</table>',
        "<br/>".join(series),
        drawn,
    ]
    cells = "".join(f"<div>{one}</div>" for one in columns if one)
    return (
        f'<div style="{GROUND}"><b>{escape(title)}</b>'
        f'<div style="display:flex;flex-wrap:wrap;gap:16px;margin-top:6px">{cells}</div></div>'
    )
