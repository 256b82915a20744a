"""Style of figures: the default style, optionally with a style of matplotlib or of the user on top."""

import difflib
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import matplotlib as mpl
from cycler import cycler

from ..drawing import palette
from ..files import OutputError

WIDTH = 7.1
"""Width of a figure across two columns of a journal, inches."""
NARROW = 4.5
"""Width, inches, below which a figure is for one column: its panels stand one above the other."""
LETTERS = 15.5
"""Letters of a legend per inch."""

HOUSE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.prop_cycle": cycler(color=palette.SEVERAL),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "savefig.dpi": 200,
    # Text stays editable in a journal's editor.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.hashsalt": "taichiflap",
    "text.parse_math": False,
    "text.color": palette.LIGHT.ink,
    "axes.labelcolor": palette.LIGHT.ink,
    "axes.edgecolor": palette.LIGHT.muted,
    "xtick.color": palette.LIGHT.muted,
    "ytick.color": palette.LIGHT.muted,
    "xtick.labelcolor": palette.LIGHT.ink,
    "ytick.labelcolor": palette.LIGHT.ink,
}
KEPT = ("svg.hashsalt", "text.parse_math")
"""Settings that no other style changes: figures are reproducible, and titles are not parsed as formulas."""

_over: ContextVar[Any] = ContextVar("style", default=None)


def wrapped(text: str, width: float) -> str:
    """A text in lines of at most `width` inches, in the size of legends."""
    return textwrap.fill(text, max(int(LETTERS * width), 20))


def current() -> Any:
    """The current style, as settings of matplotlib."""
    return HOUSE | (_over.get() or {})


@contextmanager
def using(name: str | None) -> Iterator[None]:
    """Context that applies a style to figures: the name of a matplotlib style, or a `.mplstyle` file.

    Raises:
        OutputError: if there is no such style.
    """
    before = _over.set({key: value for key, value in _settings(name).items() if key not in KEPT} if name else {})
    try:
        yield
    finally:
        _over.reset(before)


def _settings(name: str) -> Any:
    from matplotlib import style  # noqa: PLC0415 - reads all styles

    if name in style.library:
        return dict(style.library[name])
    path = Path(name)
    if path.suffix == ".mplstyle" and path.is_file():
        return dict(mpl.rc_params_from_file(path, use_default_template=False))
    near = difflib.get_close_matches(name, style.available, 1)
    hint = f"did you mean {near[0]}?" if near else "give a .mplstyle file, or one of matplotlib.style.available"
    raise OutputError(f"--style {name}: no such style; {hint}")
