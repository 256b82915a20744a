"""Kinds of picture that figures are written as, and how a name asks for one."""

import logging
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from .. import files

BOTH = ("png", "svg")
"""What is written if the name asks for nothing."""
KINDS = ("pdf", "eps", "svg", "png")
OTHERS = ("jpg", "jpeg", "tif", "tiff", "gif", "bmp", "webp", "ps", "pgf", "emf", "wmf")
"""Extensions that mean a picture of another kind."""
RESOLUTION = 300

# EPS knows no transparency, of which matplotlib tells at every figure.
logging.getLogger("matplotlib.backends.backend_ps").setLevel(logging.ERROR)


def asked(stem: Path | None) -> tuple[Path | None, tuple[str, ...]]:
    """How the names of files begin, and their kinds: `fig.pdf` asks for one kind, `fig` for both of `BOTH`.

    Raises:
        OutputError: for an extension of a kind that is not written.
    """
    kind = stem.suffix[1:].lower() if stem is not None and not stem.is_dir() else ""
    if kind in OTHERS:
        raise files.OutputError(f"{stem}: no figure is written as {kind}; there are {', '.join(KINDS)}")
    return (stem.with_suffix(""), (kind,)) if stem is not None and kind in KINDS else (stem, BOTH)


def write(figures: dict[str, Figure], stem: Path, kinds: tuple[str, ...], style: Any, overwrite: bool) -> list[Path]:
    """Write `STEM-NAME.KIND` of every figure by name, or `STEM.KIND` of one without a name.

    Raises:
        OutputError: when a file exists already or cannot be written.
    """
    named = {
        stem.with_name(f"{stem.name}{'-' if name else ''}{name}.{kind}"): (figure, kind)
        for name, figure in figures.items()
        for kind in kinds
    }
    for path in named:
        files.check(path, overwrite)
    for path, (figure, kind) in named.items():
        # Nothing that differs from one day to the next.
        dated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
        with files.replacing(path) as file, mpl.rc_context(style):
            figure.savefig(file, format=kind, dpi=RESOLUTION, metadata=dated.get(kind))
    return list(named)
