"""File types of figures, and how they follow from a file's name."""

import logging
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .. import files

BOTH = ("png", "svg")
"""File types without an extension in the name."""
KINDS = ("pdf", "eps", "svg", "png")
OTHERS = ("jpg", "jpeg", "tif", "tiff", "gif", "bmp", "webp", "ps", "pgf", "emf", "wmf")
"""Extensions of unsupported picture types."""
RESOLUTION = 300
COMPRESSION = 3
"""Of PNG: a fifth larger than at 6, in two thirds of the time."""

# EPS has no transparency; matplotlib warns about it at every figure.
logging.getLogger("matplotlib.backends.backend_ps").setLevel(logging.ERROR)


def asked(stem: Path | None) -> tuple[Path | None, tuple[str, ...]]:
    """Stem of the file names, and file types: `fig.pdf` gives one type, `fig` those of `BOTH`.

    Raises:
        OutputError: for an unsupported extension.
    """
    kind = stem.suffix[1:].lower() if stem is not None and not stem.is_dir() else ""
    if kind in OTHERS:
        raise files.OutputError(f"{stem}: figures cannot be written as {kind}; use {', '.join(KINDS)}")
    return (stem.with_suffix(""), (kind,)) if stem is not None and kind in KINDS else (stem, BOTH)


def write(figures: dict[str, Figure], stem: Path, kinds: tuple[str, ...], style: Any, overwrite: bool) -> list[Path]:
    """Write `STEM-NAME.KIND` of every figure by name, or `STEM.KIND` of one without a name.

    Raises:
        OutputError: if a file exists or cannot be written.
    """
    named = {
        stem.with_name(f"{stem.name}{'-' if name else ''}{name}.{kind}"): (figure, kind)
        for name, figure in figures.items()
        for kind in kinds
    }
    for path in named:
        files.check(path, overwrite)
    for figure in figures.values():
        _lay_out(figure, style)
    for path, (figure, kind) in named.items():
        # No metadata that change from day to day.
        dated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
        packed: Any = {"pil_kwargs": {"compress_level": COMPRESSION}} if kind == "png" else {}
        with files.replacing(path) as file, mpl.rc_context(style):
            figure.savefig(file, format=kind, dpi=RESOLUTION, metadata=dated.get(kind), **packed)
    return list(named)


def _lay_out(figure: Figure, style: Any) -> None:
    """Place the panels once, for all kinds: it takes longer than to draw them."""
    layout = figure.get_layout_engine()
    if layout is not None:
        by_hand: Any = {"figure.autolayout": False, "figure.constrained_layout.use": False}
        with mpl.rc_context({**style, **by_hand}):
            figure.set_dpi(RESOLUTION)
            # A canvas that keeps what it measures texts with.
            FigureCanvasAgg(figure)
            layout.execute(figure)
            # Without one, a figure is not drawn once more to find out whether anything has moved.
            figure.set_layout_engine(None)
