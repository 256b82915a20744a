"""The legend: meaning of colours and arrows with numbers and units, and notes on missing parts."""

from dataclasses import dataclass
from html import escape

from taichiflap.drawing.palette import SHEETS
from taichiflap.notation import prefixed

from .colours import RUNS, Map, Theme, css
from .frames import Run
from .scene import common_ranges

GRADIENT = "height:10px;border-radius:2px;border:1px solid rgba(128,128,128,.4);background:linear-gradient(90deg,{});"
ROW = "display:flex;justify-content:space-between;font-size:11px;line-height:1.3;"
HEAD = "font-size:12px;margin-top:7px;"
TURN = "positive: counter-clockwise"


@dataclass(frozen=True)
class Bar:
    """A colour bar: title, minimum and maximum with their unit, and a remark."""

    title: str
    colours: Map
    low: float
    high: float
    unit: str
    remark: str = ""


def legend(runs: list[Run], theme: Theme, background: Bar | None) -> str:
    """The legend of a scene as HTML."""
    ranges = common_ranges(runs)
    several = len(runs) > 1
    parts = [_named(runs)] if several else []
    if not several:
        parts.append(bar_html(Bar("Wing: pressure jump", theme.pressure, -ranges.pressure, ranges.pressure, "Pa")))
    if any(run.has_wake for run in runs):
        limit = 1e3 * ranges.circulation
        parts.append(bar_html(Bar("Wake: circulation", theme.circulation, -limit, limit, "10⁻³ m²/s", TURN)))
        if any(run.has_sheets for run in runs):
            edges = zip(SHEETS, ("trailing edge", "leading edge"), strict=True)
            parts.append("two sheets: " + " ".join(_swatch(colour) + edge for colour, edge in edges))
    elif not several and not runs[0].stores_vorticity:
        parts.append(f"{runs[0].case.model} has no wake.")
    if not several and runs[0].draws_flow:
        edges = zip(SHEETS, ("trailing edge", "leading edge"), strict=True)
        parts.append("streak lines: " + " ".join(_swatch(colour) + edge for colour, edge in edges))
    if background:
        parts.append(bar_html(background))
    colours = (theme.force, theme.load, theme.velocity, theme.faint)
    factor, unit = prefixed(ranges.force, "N")
    texts = (
        f"force: 1 chord = {factor * ranges.force:g} {unit}",
        f"local force: ½ chord = {ranges.pressure:g} Pa",
        f"wing velocity: ½ chord = {ranges.speed:g} m/s",
        "thin line: undeformed" if several else f"undeformed{'; stroke plane' if runs[0].path is not None else ''}",
    )
    swatches = ["" if several else _swatch(css(colour)) for colour in colours]
    parts.append("<br>".join(swatch + text for swatch, text in zip(swatches, texts, strict=True)))
    lines = "".join(f'<div style="{HEAD}">{part}</div>' for part in parts)
    return f'<div data-legend style="padding:0 4px 8px;line-height:1.45">{lines}</div>'


def _named(runs: list[Run]) -> str:
    lines = []
    for run, colour, mark in zip(runs, RUNS, ("●", "◆"), strict=True):
        wake = f"vortices {mark}" if run.has_wake else f"{run.case.model}, no wake"
        lines.append(f"{_swatch(colour)}<b>{escape(run.label)}</b>, {wake}")
    return "<br>".join(lines)


def _swatch(colour: str) -> str:
    return (
        f'<span style="display:inline-block;width:16px;height:4px;margin-right:4px;vertical-align:middle;'
        f'background:{colour}"></span>'
    )


def bar_html(bar: Bar) -> str:
    """A colour bar as HTML."""
    values = (bar.low, 0.5 * (bar.low + bar.high), bar.high)
    numbers = "".join(f"<span>{_signed(value, bar.low < 0.0)}</span>" for value in values)
    gradient = GRADIENT.format(",".join(css(colour) for colour in bar.colours.table[::16]))
    return f"{bar.title}, {bar.unit}<div style='{gradient}'></div><div style='{ROW}'>{numbers}</div>{bar.remark}"


def _signed(value: float, sign: bool) -> str:
    text = f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
    return f"{'+' if value > 0.0 else ''}{text}".replace("-", "−") if sign else text
