"""Files written by plots and exports: existing files are protected, and no file is left incomplete."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Protocol

from . import disk
from .errors import UserError


class Stored(Protocol):
    """A result or a map: an object with a path, which is None in memory."""

    path: Path | None


class OutputError(UserError):
    """Raised if an output cannot be written; one sentence with the path and the cause."""


def place(result: Stored, path: Path | None, suffix: str = "") -> Path:
    """Path of an output: `path`, or the result's name in that folder, or in the current folder if None."""
    own = Path(result.path.name.removesuffix(".part")).stem if result.path else "result"
    if path is None:
        return Path(f"{own}{suffix}")
    return path / f"{own}{suffix}" if path.is_dir() else path


def check(path: Path, overwrite: bool) -> None:
    """Raise an error if a path is a folder, has no folder, or exists.

    Raises:
        OutputError: if it cannot be written.
    """
    if why := disk.trouble(path):
        raise OutputError(f"{path}: {why}")
    if path.is_dir():
        raise OutputError(f"{path}: is a directory; name a file")
    if not path.parent.is_dir():
        raise OutputError(f"{path}: cannot be written: {path.parent} is not a folder")
    if path.exists() and not overwrite:
        raise OutputError(f"{path}: exists already; use --overwrite to replace it, or name another file")


def make_folder(folder: Path) -> None:
    """Create a folder if it does not exist.

    Raises:
        OutputError: if the system refuses.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise OutputError(f"{folder}: cannot be created: there is a file of this name; name a folder") from None
    except OSError as error:
        raise OutputError(f"{folder}: cannot be created: {error.strerror or error}") from None


@contextlib.contextmanager
def standing_in(path: Path) -> Iterator[Path]:
    """Context with a temporary name next to `path`; the file is renamed to `path` on success and removed otherwise.

    Raises:
        OutputError: if the system refuses.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}.part{path.suffix}")
    try:
        yield draft
        disk.replace(draft, path)
    except OSError as error:
        why = error.strerror or str(error).partition("\n")[0]
        raise OutputError(f"{path}: cannot be written: {why}") from None
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Context with a binary file that is renamed to `path` on success.

    Raises:
        OutputError: if the system refuses.
    """
    with standing_in(path) as draft, open(draft, "wb") as file:
        yield file
