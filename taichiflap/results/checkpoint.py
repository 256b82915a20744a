"""The state of an unfinished run, stored as `NAME.state`, from which it continues after a crash."""

import contextlib
import logging
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import disk
from .._version import __version__
from ..case.case import MAX_STEPS, Case
from ..notation import printable

SUFFIX = ".state"
SECONDS = 1.0
"""Time between two checkpoints, s: the most that a crash can cost, unless they take long to write."""


@dataclass(frozen=True)
class Checkpoint:
    """What a march needs to continue: the next step, the case's arrays, and the time (s) spent so far."""

    next_step: int
    solve_time: float
    state: Mapping[str, np.ndarray]


def beside(path: Path) -> Path:
    """Path of the checkpoint of the run that writes `path`."""
    return path.with_name(path.name + SUFFIX)


def save(path: Path, case: Case, checkpoint: Checkpoint) -> None:
    """Write the checkpoint of a run. After a crash at any moment this one or the previous one exists.

    Raises:
        OSError: if it cannot be written.
    """
    place = beside(path)
    draft = place.with_name(f".{place.name}.{os.getpid()}")
    try:
        with open(draft, "wb") as file:
            np.savez(
                file, of=_origin(case), next_step=checkpoint.next_step, solve_time=checkpoint.solve_time,
                **{f"state.{name}": values for name, values in checkpoint.state.items()},  # type: ignore[arg-type]
            )  # fmt: skip
        disk.replace(draft, place)
    finally:
        draft.unlink(missing_ok=True)


def load(path: Path, case: Case) -> Checkpoint | None:
    """The checkpoint of a case, or None; a run without one starts from the beginning, with the same results.

    The march checks whether its state fits the case.
    """
    try:
        with open(beside(path), "rb") as file:
            if not zipfile.is_zipfile(file) or any(one.compress_type for one in zipfile.ZipFile(file).infolist()):
                raise ValueError("its checksum does not match")
            file.seek(0)
            with np.load(file, allow_pickle=False) as stored:
                if str(stored["of"]) != _origin(case):
                    raise ValueError("it belongs to another case")
                state = {name.removeprefix("state."): stored[name] for name in stored if name.startswith("state.")}
                next_step, solve_time = int(stored["next_step"]), float(stored["solve_time"])
        if not 0.0 <= solve_time < np.inf or not 0 < next_step <= MAX_STEPS + 1:
            raise ValueError("its next step or its time is out of range")
        return Checkpoint(next_step, solve_time, state)
    except FileNotFoundError:
        return None
    except Exception as error:  # any exception of NumPy and zipfile for damaged data
        tell(path, str(error).partition("\n")[0])
        return None


def tell(path: Path | None, why: str) -> None:
    """Log that a checkpoint cannot be used."""
    if path is not None:
        logging.getLogger("taichiflap").warning(
            "%s cannot be used, so the run starts from the beginning: %s", printable(str(beside(path))), printable(why)
        )


def discard(path: Path) -> None:
    """Remove the checkpoint, if it exists."""
    with contextlib.suppress(OSError):
        beside(path).unlink()


def _origin(case: Case) -> str:
    return f"taichiflap {__version__}\n{case.to_toml()}"
