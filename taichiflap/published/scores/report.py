"""The page of scores: tables and figures by regime, as Markdown and as one HTML page."""

import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from ... import files, pages
from ..._version import __version__
from ...scored.regime import Regime
from . import comparison, pictures
from .against import Comparison
from .library import EXCLUDED
from .score import Row
from .table import groups, missing
from .tiers import Tier
from .verdict import hopeless, sentence

MARKDOWN, PAGE, STORE, KNOWN = "scores.md", "scores.html", "scores.json", "known.json"
COMPARISON, COMPARISON_PAGE = "comparison.md", "comparison.html"
RESOLUTION = 150


def write(rows: Sequence[Row], tiers: Sequence[Tier], folder: Path) -> list[Path]:
    """Write the page and its figures into a folder.

    Returns:
        The two pages.

    Raises:
        OutputError: if a file cannot be written.
    """
    _save(folder / KNOWN, json.dumps(known(rows), indent=1).encode() + b"\n")
    figures = pictures.drawn(rows, tiers)
    for name, _, figure in figures:
        for kind in ("png", "svg"):
            save_figure(figure, folder / f"{name}.{kind}")
    found = blocks(rows, tiers, [(name, caption) for name, caption, _ in figures])
    _save(folder / MARKDOWN, pages.markdown(found).encode())
    _save(folder / PAGE, pages.html(found, folder).encode())
    return [folder / MARKDOWN, folder / PAGE]


def write_comparison(found: Sequence[Comparison], tiers: Sequence[Tier], folder: Path) -> list[Path]:
    """Write the page of measurements compared with models, and one figure per measurement.

    Returns:
        The two pages.

    Raises:
        OutputError: when a file cannot be written.
    """
    names = [f"comparison-{number}" for number in range(1, len(found) + 1)]
    for one, name in zip(found, names, strict=True):
        figure = pictures.comparison(one, tiers)
        for kind in ("png", "svg"):
            save_figure(figure, folder / f"{name}.{kind}")
    said = comparison.blocks(found, tiers, names)
    _save(folder / COMPARISON, pages.markdown(said).encode())
    _save(folder / COMPARISON_PAGE, pages.html(said, folder).encode())
    return [folder / COMPARISON, folder / COMPARISON_PAGE]


def known(rows: Sequence[Row]) -> dict[str, Any]:
    """Data for `nearest`: regime and relative errors by tier and quantity of each case."""
    found: dict[str, Any] = {}
    for row in rows:
        one = row.published
        if one.name not in found:
            found[one.name] = {"regime": asdict(Regime.of(one.case())), "errors": {}}
        for tier in row.outcomes:
            own, value = found[one.name]["errors"].setdefault(tier, {}), row.value(tier)
            if value is not None:
                own[row.truth.quantity] = round(row.truth.error(value), 4)
    return found


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the file's name.

    Raises:
        OutputError: when it cannot be written.
    """
    buffer, kind = io.BytesIO(), path.suffix[1:]
    with mpl.rc_context(pictures.STYLE):
        figure.savefig(buffer, format=kind, dpi=RESOLUTION, metadata={"Date": None} if kind == "svg" else None)
    _save(path, buffer.getvalue())


def _save(path: Path, content: bytes) -> None:
    with files.replacing(path) as file:
        file.write(content)


def blocks(rows: Sequence[Row], tiers: Sequence[Tier], figures: Sequence[tuple[str, str]]) -> list[pages.Block]:
    """Blocks of the page."""
    found: list[pages.Block] = [
        pages.Heading(1, "Which model is right where"),
        pages.Paragraph(
            f"Written by `taichiflap score` of version {__version__}. Each row compares the models with a published "
            "or exact value. The band is the scatter between sources, or the error of the instrument. A model's "
            "value is inside the band, within 25 % of the published one, or outside; a phase counts as within 25 % "
            "if its error is below 22.5 deg. In each regime the values that every model misses come first."
        ),
    ]
    named = dict(figures)
    missed = [row for row in rows if hopeless(row)]
    if missed:
        names = "; ".join(f"{row.published.name}, {row.truth.quantity}" for row in missed)
        found.append(pages.Paragraph(f"No model is within 25 % of these values: {names}."))
    for number, (name, own) in enumerate(groups(rows), 1):
        found += [pages.Heading(2, name), pages.Paragraph(sentence(own, tiers)), _table(own, tiers)]
        if f"scores-{number}" in named:
            found.append(pages.Figure(f"scores-{number}", named[f"scores-{number}"]))
        found.append(
            pages.Paragraph("Sources: " + "; ".join(dict.fromkeys(row.published.citation for row in own)) + ".")
        )
    if "scores-histories" in named:
        found += [pages.Heading(2, "Time histories"), pages.Figure("scores-histories", named["scores-histories"])]
    found += [pages.Heading(2, "Not scored"), pages.Table(("data", "reason"), EXCLUDED)]
    return found


def _table(rows: Sequence[Row], tiers: Sequence[Tier]) -> pages.Table:
    heads = ("case", "figure", "published", "band", *(tier.label for tier in tiers))
    body = [
        (
            row.published.about if number == 0 or rows[number - 1].published is not row.published else "",
            row.truth.quantity,
            f"{row.truth.value:.4g}",
            f"{row.truth.low:.4g} to {row.truth.high:.4g}",
            *(_cell(row, tier) for tier in tiers),
        )
        for number, row in enumerate(rows)
    ]
    return pages.Table(heads, body)


def _cell(row: Row, tier: Tier) -> str:
    value = row.value(tier.name)
    if value is None:
        return missing(row, tier)
    return f"{value:.3g}, {100 * row.truth.error(value):+.0f} %, {row.truth.word(value)}"
