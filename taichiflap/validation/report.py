"""The report of a validation: Markdown, one self-contained HTML page, and one figure per reference."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from .. import files, pages
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
    for check in checks:
        drawn = figure(check.charts)
        for kind in ("png", "svg"):
            metadata = {"Date": None} if kind == "svg" else None
            with mpl.rc_context(_STYLE), files.replacing(folder / f"validation-{check.name}.{kind}") as file:
                drawn.savefig(file, format=kind, dpi=RESOLUTION, metadata=metadata)
    said = blocks(checks)
    for name, text in ((MARKDOWN, pages.markdown(said, "svg")), (PAGE, pages.html(said, folder))):
        with files.replacing(folder / name) as file:
            file.write(text.encode())
    return [folder / MARKDOWN, folder / PAGE]


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


def blocks(checks: Sequence[Check]) -> list[pages.Block]:
    """Blocks of the report."""
    failed = [f"{row.setting} ({row.error:.2f} {row.unit})" for check in checks for row in check.rows if not row.passed]
    opening = (
        f"Written by `taichiflap validate` of version {__version__}: {verdict(checks)}. Each row compares the "
        "solver with an exact or published solution. Tolerances follow from the expected accuracy of the schemes; a "
        "row outside its tolerance is marked FAIL."
        + (f" Beyond their tolerance: {'; '.join(failed)}." if failed else "")
    )
    said: list[pages.Block] = [pages.Heading(1, TITLE), pages.Paragraph(opening)]
    for check in checks:
        said += [pages.Heading(2, check.reference), pages.Paragraph(check.about)]
        said += [pages.Table(HEADINGS, [row_cells(row) for row in check.rows])]
        said += [pages.Figure(f"validation-{check.name}", "", check.reference)]
    return said
