"""File types of figures, and how they follow from a file's name."""

import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from PIL import Image

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
    with _ticks_once():
        for figure in figures.values():
            _lay_out(figure, style)
        for path, (figure, kind) in named.items():
            # No metadata that change from day to day.
            dated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
            with files.replacing(path) as file, mpl.rc_context(style):
                figure.savefig(file, format=kind, dpi=RESOLUTION, metadata=dated.get(kind))
    return list(named)


def _lay_out(figure: Figure, style: Any) -> None:
    """Place the panels once, for all kinds: it takes longer than to draw them."""
    Canvas(figure)
    layout = figure.get_layout_engine()
    if layout is not None:
        by_hand: Any = {"figure.autolayout": False, "figure.constrained_layout.use": False}
        with mpl.rc_context({**style, **by_hand}):
            figure.set_dpi(RESOLUTION)
            layout.execute(figure)
            # Without one, a figure is not drawn once more to find out whether anything has moved.
            figure.set_layout_engine(None)


class Canvas(FigureCanvasAgg):
    """A canvas that keeps what it measures texts with, and writes opaque pictures without their transparency."""

    def print_png(self, filename_or_obj: Any, **_unused: Any) -> None:
        """Write a PNG; `savefig` calls it."""
        self.draw()
        picture = Image.fromarray(np.asarray(self.buffer_rgba()))
        opaque = to_rgba(self.figure.get_facecolor())[3] == 1.0
        picture = picture.convert("RGB") if opaque else picture
        picture.save(filename_or_obj, "png", compress_level=COMPRESSION, dpi=(RESOLUTION, RESOLUTION))


@contextlib.contextmanager
def _ticks_once() -> Iterator[None]:
    """Context in which the ticks of an axis are placed once for its limits and place.

    Matplotlib places them anew for each of the texts around them, for every measurement and for every drawing.
    """
    axes: Any = Axis
    place = axes._update_ticks
    placed: dict[Any, Any] = {}

    def remembered(axis: Any) -> Any:
        where = (*axis.get_view_interval(), *axis.axes.bbox.bounds)
        if axis not in placed or placed[axis][0] != where:
            placed[axis] = where, place(axis)
        return placed[axis][1]

    axes._update_ticks = remembered
    try:
        yield
    finally:
        axes._update_ticks = place
