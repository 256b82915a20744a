"""The report of a validation: Markdown, one self-contained HTML page, and one figure per reference."""

import base64
import html
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from .. import files
from .._version import __version__
from ..drawing import palette
from .checks import Chart, Check
from .validate import HEADINGS, row_cells, verdict

TITLE = "Validation against exact solutions"
MARKDOWN, PAGE = "validation.md", "validation.html"
COLUMNS, WIDTH, HEIGHT = 2, 8.0, 2.9
"""Charts per row, and inches of a figure and of a row of charts."""
RESOLUTION = 150
DECADES = 3
"""Logarithmic axes with a smaller range are labelled at 1, 2 and 5."""
COLOURS = ("#16191d", "#0060a8", "#d55e00", "#008560", "#8a4fbf")

_INK = palette.LIGHT
_STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.prop_cycle": cycler(color=COLOURS),
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "svg.hashsalt": "taichiflap",
    "text.color": _INK.ink,
    "axes.labelcolor": _INK.ink,
    "axes.edgecolor": _INK.muted,
    "xtick.color": _INK.muted,
    "ytick.color": _INK.muted,
    "xtick.labelcolor": _INK.ink,
    "ytick.labelcolor": _INK.ink,
}
_SHEET = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#16191d}"
    "table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}"
    "td,th{padding:.15rem .7rem;border-bottom:1px solid #dde2e7;text-align:right}"
    "td:first-child,th:first-child{text-align:left}.fail{color:#b3261e;font-weight:bold}"
    "img{max-width:100%;margin:1rem 0}"
)


def check_folder(folder: Path, overwrite: bool) -> None:
    """Create the report's folder; an existing report is protected.

    Raises:
        OutputError: if the folder cannot be created or contains a report that may not be replaced.
    """
    files.make_folder(folder)
    for name in (MARKDOWN, PAGE):
        files.check(folder / name, overwrite)


def write(checks: Sequence[Check], folder: Path) -> list[Path]:
    """Write the report and its figures into a folder.

    Returns:
        The two pages.

    Raises:
        OutputError: if a file cannot be written.
    """
    pictures = {}
    for check in checks:
        drawn = figure(check.charts)
        for kind in ("png", "svg"):
            pictures[check.name, kind] = _rendered(drawn, kind)
            _save(folder / f"validation-{check.name}.{kind}", pictures[check.name, kind])
    _save(folder / MARKDOWN, markdown(checks).encode())
    _save(folder / PAGE, page(checks, {check.name: pictures[check.name, "png"] for check in checks}).encode())
    return [folder / MARKDOWN, folder / PAGE]


def _save(path: Path, content: bytes) -> None:
    with files.replacing(path) as file:
        file.write(content)


def _rendered(drawn: Figure, kind: str) -> bytes:
    buffer = io.BytesIO()
    with mpl.rc_context(_STYLE):
        drawn.savefig(buffer, format=kind, dpi=RESOLUTION, metadata={"Date": None} if kind == "svg" else None)
    return buffer.getvalue()


def figure(charts: Sequence[Chart]) -> Figure:
    """The charts of a check side by side."""
    with mpl.rc_context(_STYLE):
        lines = math.ceil(len(charts) / COLUMNS)
        columns = min(len(charts), COLUMNS)
        drawn = Figure(figsize=(WIDTH * columns / COLUMNS, HEIGHT * lines), layout="constrained")
        for number, chart in enumerate(charts, 1):
            axes = drawn.add_subplot(lines, columns, number)
            for curve in chart.curves:
                axes.plot(curve.x, curve.y, curve.style, label=curve.label)
            axes.set(title=chart.title, xlabel=chart.x_label, ylabel=chart.y_label)
            for axis in chart.log:
                axes.set(**{f"{axis}scale": "log"})
            if "y" not in chart.log and all(low < 0 < high for low, high in [axes.get_ylim()]):
                axes.axhline(0.0, color=_INK.muted, linewidth=0.6)
            if "x" in chart.log:
                places = sorted({float(x) for curve in chart.curves for x in curve.x if len(curve.x) <= 10})
                axes.set_xticks(places, [f"{place:g}" for place in places])
            if "y" in chart.log and math.log10(axes.get_ylim()[1] / axes.get_ylim()[0]) < DECADES:
                axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
                axes.yaxis.set_major_formatter("{x:g}")
            axes.minorticks_off()
            if len(chart.curves) > 1:
                axes.legend()
    return drawn


def markdown(checks: Sequence[Check]) -> str:
    """The report in Markdown, with links to its figures."""
    parts = [f"# {TITLE}", _opening(checks)]
    for check in checks:
        parts += [f"## {check.reference}", check.about, _table(check)]
        parts.append(f"![{check.reference}](validation-{check.name}.svg)")
    return "\n\n".join(parts) + "\n"


def _table(check: Check) -> str:
    lines = [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
        for cells in (HEADINGS, *map(row_cells, check.rows))
    ]
    return "\n".join([lines[0], "|---|--:|--:|--:|--:|---|", *lines[1:]])


def _opening(checks: Sequence[Check]) -> str:
    failed = [f"{row.setting} ({row.error:.2f} {row.unit})" for check in checks for row in check.rows if not row.passed]
    return (
        f"Written by `taichiflap validate` of version {__version__}: {verdict(checks)}. Each row compares the "
        "solver with an exact or published solution. Tolerances follow from what the scheme should reach; a row "
        "outside its tolerance says FAIL." + (f" Beyond their tolerance: {'; '.join(failed)}." if failed else "")
    )


def page(checks: Sequence[Check], pictures: dict[str, bytes]) -> str:
    """The report as one HTML page with embedded figures, given as PNG by the name of the check."""
    parts = [f"<h1>{TITLE}</h1>", f"<p>{html.escape(_opening(checks)).replace('`', '')}</p>"]
    for check in checks:
        parts += [f"<h2 id='{check.name}'>{html.escape(check.reference)}</h2>", f"<p>{html.escape(check.about)}</p>"]
        parts.append(
            "<table>" + _row(HEADINGS, "th") + "".join(_row(row_cells(row), "td") for row in check.rows) + "</table>"
        )
        picture = base64.b64encode(pictures[check.name]).decode()
        width = 100 * min(len(check.charts), COLUMNS) // COLUMNS
        parts.append(
            f"<img width='{width}%' alt='{html.escape(check.reference)}' src='data:image/png;base64,{picture}'>"
        )
    return (
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{TITLE}</title>"
        f"<style>{_SHEET}</style></head><body>{''.join(parts)}</body></html>\n"
    )


def _row(cells: Sequence[str], tag: str) -> str:
    kind = " class='fail'" if cells[-1] == "FAIL" else ""
    return f"<tr{kind}>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"
