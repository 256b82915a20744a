"""What the colours and arrows mean: numbers, units and, where something is missing, why."""

from html import escape

from .colours import Map, Theme, css
from .frames import Run
from .scene import circulation_limit

BAR = "height:10px;border-radius:2px;border:1px solid rgba(128,128,128,.4);background:linear-gradient(90deg,{});"
ROW = "display:flex;justify-content:space-between;font-size:11px;line-height:1.3;"
HEAD = "font-size:12px;margin-top:7px;"


def legend(runs: list[Run], theme: Theme, field: tuple[str, Map, float, float, str] | None) -> str:
    """The legend as HTML.

    Args:
        field: what the background shows, if it does: its name, map, lowest and highest value and unit.
    """
    run = runs[0]
    parts = []
    if len(runs) > 1:
        marks = ("&#9679;", "&#9670;")
        for other, colour, mark in zip(runs, theme.runs, marks, strict=True):
            vortices = f", vortices {mark}" if other.has_wake else ", no wake: blade elements (DBET)"
            parts.append(f"{_swatch(colour)} <b>{escape(other.label)}</b>{vortices}")
    else:
        parts.append(_bar("Wing: pressure jump", theme.pressure, -run.ranges.pressure,
                          run.ranges.pressure, "Pa"))  # fmt: skip
    if any(one.has_wake for one in runs):
        limit = circulation_limit(runs)
        parts.append(_bar("Wake: circulation", theme.circulation, -1e3 * limit, 1e3 * limit,
                          "10⁻³ m²/s"))  # fmt: skip
    elif len(runs) == 1:
        parts.append("No wake: blade elements (DBET) compute none.")
    if field:
        name, colours, low, high, unit = field
        parts.append(_bar(name, colours, low, high, unit))
    parts.append(
        f"{_swatch(css(theme.force))} force: 1 chord = {1e3 * run.ranges.force:g} mN"
        f"<br>{_swatch(css(theme.load))} local force: ½ chord = {run.ranges.pressure:g} Pa"
        f"<br>{_swatch(css(theme.velocity))} velocity: ½ chord = {run.ranges.speed:g} m/s"
        f"<br>{_swatch(css(theme.faint))} undeformed; stroke plane"
        if len(runs) == 1
        else f"Arrows: force, 1 chord = {1e3 * run.ranges.force:g} mN; along the wing, ½ chord = "
        f"{run.ranges.pressure:g} Pa; velocity, ½ chord = {run.ranges.speed:g} m/s. Thin line: undeformed chord."
    )
    lines = "".join(f'<div style="{HEAD}">{part}</div>' for part in parts)
    return f'<div data-legend style="padding:0 4px 8px;line-height:1.45">{lines}</div>'


def _swatch(colour: str) -> str:
    return (
        f'<span style="display:inline-block;width:16px;height:4px;margin-right:4px;vertical-align:middle;'
        f'background:{colour}"></span>'
    )


def _bar(title: str, colours: Map, low: float, high: float, unit: str) -> str:
    middle = 0.5 * (low + high)
    numbers = "".join(f"<span>{_signed(value)}</span>" for value in (low, middle, high))
    return f"{title}, {unit}<div style='{BAR.format(','.join(colours.stops))}'></div><div style='{ROW}'>{numbers}</div>"


def _signed(value: float) -> str:
    return f"{value:+g}".replace("-", "−") if value else "0"
