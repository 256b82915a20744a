"""The files that plots and exports write: never over another by accident, never left half-written."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Protocol

from . import disk
from .errors import UserError


class Stored(Protocol):
    """A result or a map: what has a path, or none while it is in memory."""

    path: Path | None


class OutputError(UserError):
    """An output that cannot be written: one sentence with the path and the cause."""


def place(result: Stored, path: Path | None, suffix: str = "") -> Path:
    """Where an output goes: to `path`, under the result's name if that is a folder, or here if it is None."""
    own = Path(result.path.name.removesuffix(".part")).stem if result.path else "result"
    if path is None:
        return Path(f"{own}{suffix}")
    return path / f"{own}{suffix}" if path.is_dir() else path


def check(path: Path, overwrite: bool) -> None:
    """Refuse a path that is a folder, is in no folder, or exists already.

    Raises:
        OutputError: when it is to be refused.
    """
    if why := disk.trouble(path):
        raise OutputError(f"{path}: {why}")
    if path.is_dir():
        raise OutputError(f"{path}: is a directory; name a file")
    if not path.parent.is_dir():
        raise OutputError(f"{path}: cannot be written: {path.parent} is not a folder")
    if path.exists() and not overwrite:
        raise OutputError(f"{path}: exists already; --overwrite replaces it, or name another file")


def make_folder(folder: Path) -> None:
    """Make a folder, unless it is there.

    Raises:
        OutputError: when the system refuses.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be made: {error.strerror or error}") from None


@contextlib.contextmanager
def standing_in(path: Path) -> Iterator[Path]:
    """A name beside `path` to write under; the file moves to `path` when all went well, and vanishes otherwise.

    Raises:
        OutputError: when the system refuses.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}.part{path.suffix}")
    try:
        yield draft
        disk.replace(draft, path)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or str(error).splitlines()[0]}") from None
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A binary file that becomes `path` when all went well.

    Raises:
        OutputError: when the system refuses.
    """
    with standing_in(path) as draft, open(draft, "wb") as file:
        yield file
