"""Export formats of results: their names, files and writers."""

from pathlib import Path

from .. import files
from ..drawing import palette
from ..drawing.orientation import FRAMES, INERTIAL
from ..maps.file import Map
from ..results.reader import Result

FORMATS = ("csv", "vtkhdf", "html", "mp4", "gif", "flow.vtkhdf", "nc")
FILMS = ("mp4", "gif")
SEEN = ("html", "mp4", "gif", "flow.vtkhdf", "nc")
"""Formats with a choice of the frame of reference; the last two contain the flow on a uniform grid."""
BEATS = {"html": 4, "mp4": 2, "gif": 1}
"""Formats that show the last beats, and the default number of beats."""


def export(
    result: Result,
    kind: str,
    path: Path | None = None,
    beats: int | None = None,
    overwrite: bool = False,
    dark: bool = False,
    reference: str = INERTIAL,
) -> Path:
    """Write a result in another format and return the file's name.

    Args:
        kind: one of `FORMATS`.
        path: the file, or its folder; if None, the result's name in the current folder.
        beats: number of last beats in a page or a film; fewer if the run has fewer.
        dark: draw a film on a dark background.
        reference: frame of reference of a page, a film or a plain grid: `inertial` or `wing`.

    Raises:
        OutputError: for an unknown format, or if the file exists or cannot be written.
        SceneError: if there is nothing to show.
    """
    if kind not in FORMATS:
        raise files.OutputError(f"unknown format {kind!r}; use {', '.join(FORMATS)}")
    if beats is not None and kind not in BEATS:
        raise files.OutputError(f"{kind} contains the whole run; --beats applies to {', '.join(BEATS)}")
    if beats is not None and beats < 1:
        raise files.OutputError(f"--beats {beats}: must be at least 1")
    if reference not in FRAMES:
        raise files.OutputError(f"unknown frame {reference!r}; use {' or '.join(FRAMES)}")
    if reference != INERTIAL and kind not in SEEN:
        raise files.OutputError(f"--frame applies to {', '.join(SEEN)}")
    if dark and kind not in FILMS:
        raise files.OutputError(f"--dark applies to {' and '.join(FILMS)}")
    path = files.place(result, path, f".{kind}")
    files.check(path, overwrite)
    if not result.frames:
        raise files.OutputError(f"{result.path or 'this result'}: has no frames yet")
    # Each writer is imported only for its own format, since three of them need heavy libraries.
    if kind == "csv":
        from .table import write_csv  # noqa: PLC0415

        write_csv(result, path)
    elif kind == "vtkhdf":
        from .vtkhdf import write_vtkhdf  # noqa: PLC0415

        write_vtkhdf(result, path)
    elif kind == "html":
        from .page import write_html  # noqa: PLC0415

        write_html(result, path, beats or BEATS[kind], reference)
    elif kind in ("flow.vtkhdf", "nc"):
        from .grid import write_flow, write_netcdf  # noqa: PLC0415

        (write_netcdf if kind == "nc" else write_flow)(result, path, reference)
    else:
        from .film import write_gif, write_mp4  # noqa: PLC0415

        theme = palette.DARK if dark else palette.LIGHT
        (write_mp4 if kind == "mp4" else write_gif)(result, path, beats or BEATS[kind], theme, reference)
    return path


def export_map(sheet: Map, kind: str, path: Path | None = None, overwrite: bool = False) -> Path:
    """Write a map as a table and return the file's name.

    Args:
        kind: `csv`.
        path: the file, or its folder; if None, the map's name in the current folder.

    Raises:
        OutputError: for another format, or if the file exists or cannot be written.
    """
    if kind != "csv":
        raise files.OutputError(f"a map can only be exported as csv, not as {kind!r}; use taichiflap plot to draw it")
    path = files.place(sheet, path, f".{kind}")
    files.check(path, overwrite)
    from .table import write_map_csv  # noqa: PLC0415 - as above

    write_map_csv(sheet, path)
    return path
