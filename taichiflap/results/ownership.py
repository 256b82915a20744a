"""Ownership of result files: locks and renaming that never replace another run's file."""

import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import h5py

from .. import disk
from .._version import __version__
from ..case.case import Case
from . import hdf, integrity
from .integrity import DamageError
from .reader import Result, ResultError, first_line, open_result, part


def finished(path: Path, case: Case) -> Result | None:
    """The finished result of a case, or None.

    Raises:
        ResultError: if the file holds another case, or is not a result.
    """
    if disk.trouble(path) or not path.is_file():
        return None
    result = open_result(path)
    try:
        _check_same(result.file, path, case)
    except ResultError:
        result.close()
        raise
    return result


def check(path: Path, overwrite: bool) -> None:
    """Raise an error if a result cannot be created at a path.

    Raises:
        ResultError: if the path is a folder, has no folder, or exists.
    """
    if why := disk.trouble(path):
        raise ResultError(f"{path}: {why}")
    if path.is_dir():
        raise ResultError(f"{path}: is a directory; name a file, for example {path / 'result.h5'}")
    if path.exists() and not overwrite:
        raise ResultError(f"{path}: exists already; use --overwrite to replace it, or -o to write elsewhere")
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except (FileNotFoundError, NotADirectoryError):
        raise ResultError(f"{path}: cannot be created: {path.parent} is not a folder") from None
    except OSError as error:
        raise ResultError(f"{path}: cannot be created: {first_line(error)}") from None


def lock(path: Path) -> disk.Lock:
    """Lock for writing a result, and the file left by an interrupted run.

    Raises:
        ResultError: if another run holds it, or no file can be created.
    """
    try:
        return disk.Lock(path)
    except disk.Busy as error:
        raise ResultError(f"{path}: another run is writing it ({error})") from None
    except OSError as error:
        raise ResultError(f"{path}: cannot be created: {first_line(error)}") from None


def reopen(path: Path, case: Case, overwrite: bool, resume: bool) -> hdf.Guarded | None:
    """The file of an interrupted run to continue; None to start from the beginning."""
    if overwrite or not part(path).exists():
        return None
    if not resume:
        left = "an interrupted run left this file; use --resume to continue it, or --overwrite to start again"
        raise ResultError(f"{path}: {left}")
    try:
        with h5py.File(part(path), "r", locking=False) as file:
            _check_same(file, part(path), case)
        open_result(part(path)).close()
        return hdf.Guarded(part(path), fresh=False)
    except OSError as error:
        raise ResultError(f"{part(path)}: cannot be used: {first_line(error)}; use --overwrite to replace it") from None


def copy(source: Path, path: Path, overwrite: bool) -> None:
    """Copy a finished result to another name.

    Raises:
        ResultError: if that exists, is being written, or cannot be written.
    """
    check(path, overwrite)
    held = lock(path)
    draft = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        shutil.copyfile(source, draft)
        move(draft, path, overwrite)
    except OSError as error:
        raise ResultError(f"{path}: cannot be written: {first_line(error)}") from None
    finally:
        draft.unlink(missing_ok=True)
        held.release()


def _check_same(file: Any, path: Path, case: Case) -> None:
    for name, ours in {"case": case.to_toml(), "source": f"taichiflap {__version__}"}.items():
        try:
            theirs = integrity.attribute(file, name)
        except DamageError as error:
            raise ResultError(f"{path}: cannot be resumed: {error}") from None
        if theirs != ours:
            raise ResultError(f"{path}: cannot be resumed: {_difference(name, str(theirs), ours)}")


def _difference(name: str, theirs: str, ours: str) -> str:
    if name == "source":
        return f"it was started with {theirs}, this is {ours}; use --overwrite to start again"
    lines = [one for one in zip(theirs.splitlines(), ours.splitlines(), strict=False) if one[0] != one[1]]
    said = f": {lines[0][0]} there, {lines[0][1]} here" if lines else ""
    return f"it holds another case{said}; use --overwrite to start again"


def move(source: Path, target: Path, overwrite: bool) -> None:
    """Rename a synced file; another file is replaced only on request.

    Raises:
        FileExistsError: if the target exists and may not be replaced.
        OSError: if the system refuses.
    """
    disk.sync(source)
    if overwrite:
        os.replace(source, target)
        return
    try:
        # Unlike a rename, a link never replaces a file that another run has created meanwhile.
        os.link(source, target)
    except FileExistsError:
        raise
    except OSError:  # the file system has no links
        os.rename(source, target)
    else:
        os.unlink(source)
