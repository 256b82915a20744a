"""Crash-safe writing of the result file.

Every array has its full length and position from the start. A run only fills in numbers, and the structure of the HDF5
file does not change until the end. Values not computed yet are NaN, and `time` is filled last, so that frames with a
time are complete. The file is named `NAME.part` until it is complete.
"""

import contextlib
import functools
import os
import shutil
import time
from collections.abc import Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..case.case import Case
from ..structure.beam import Modes
from . import checkpoint, hdf, layout, ownership, packing
from .checkpoint import Checkpoint
from .layout import Contents, Layout, Sample
from .reader import Result, ResultError, first_line, open_result, part
from .recorder import Recorder

MOST_SPENT = 0.05
"""Maximum share of a run's time that checkpoints may take; on a slow disk there are fewer."""


class WriteError(ResultError):
    """Raised if a run cannot continue because its file cannot be written; earlier data are safe."""

    exit_code = 1


class Writer(Recorder):
    """Writes one result to a file.

    Args:
        case: the case being computed.
        path: the file to write.
        warnings: warnings about the case.
        overwrite: replace an existing file, and the file of an interrupted run.
        resume: continue the file of an interrupted run, if it exists.

    Raises:
        ResultError: if the file exists, is being written by another run, holds another case, or cannot be created.
    """

    def __init__(
        self, case: Case, path: Path, warnings: list[str], overwrite: bool = False, resume: bool = False
    ) -> None:
        super().__init__(case, warnings)
        self.path = path
        self._overwrite = overwrite
        self._kept, self._spent = time.monotonic(), 0.0
        self._file: Any = None
        self._raw: Any = None
        self._places: dict[str, tuple[int, np.dtype[Any]]] = {}
        self._draft: Path | None = None
        self._guard: hdf.Guarded | None = None
        self._large: list[str] = []
        ownership.check(path, overwrite)
        self._lock = ownership.lock(path)
        try:
            self._guard = ownership.reopen(path, case, overwrite, resume)
            if self._guard is not None:
                self._file = h5py.File(self._guard, "r+", libver=hdf.VERSION)
        except BaseException:
            self.abandon()
            raise

    def lay_out(self, nodes: np.ndarray, section: Modes, sample: Sample, contents: Contents | None = None) -> None:
        """Allocate all arrays, unless the file is resumed. Same arguments as `Recorder.lay_out`.

        Raises:
            ResultError: if there is not enough space, or another run has created the same file.
        """
        contents = contents or Contents()
        self._plan = layout.plan(sample, contents)
        self._layout = functools.partial(
            Layout, case=self.case, began=self.began, warnings=self._warnings, nodes=nodes, section=section,
            sample=sample, contents=contents,
        )  # fmt: skip
        self._large = layout.large(sample, contents)
        if self._file is not None:
            self._find_places()
            return
        try:
            self._guard = hdf.Guarded(self._reserve(layout.size(self.case, sample, contents)))
            self._file = hdf.create(self._guard)
            self._layout(self._file)
            self._file.flush()
            self._guard.check()
            self._publish()
            self._find_places()
        except ResultError:
            raise
        except (OSError, ValueError, RuntimeError) as error:
            # HDF5 reports a full disk as any of these exceptions, including the system's message.
            inside = str(error).partition("error message = '")[2].partition("'")[0]
            said = inside or (first_line(error) if isinstance(error, OSError) else str(error).splitlines()[0])
            raise ResultError(f"{self.path}: cannot be created: {said}") from None

    @property
    def stored(self) -> int:
        """Number of steps in the file."""
        return Result(self._file).steps

    def written(self, name: str) -> np.ndarray:
        """Appended values of a variable with one value per step, read without HDF5."""
        offset, kind = self._places[name]
        self._raw.seek(offset)
        return np.frombuffer(self._raw.read(self.steps * kind.itemsize), kind)

    def rewind(self, steps: int) -> None:
        """Continue after a number of steps; later steps are overwritten."""
        self.steps = steps
        frames = self.case.frames(steps)
        self._entries = {
            group: int(np.sum(self._file[f"{group}/count"][:frames], dtype=np.int64))
            for group in layout.groups(self._plan)
        }

    def append(self, variables: MutableMapping[str, Any]) -> None:
        """Append a block of steps with its frames, and pass it to the system.

        Raises:
            WriteError: if it cannot be written; earlier steps are safe.
        """
        try:
            super().append(variables)
        except OSError as error:
            raise WriteError(f"{self.path}: cannot be written: {first_line(error)}") from None

    def _put(self, name: str, first: int, values: np.ndarray) -> None:
        """Write rows directly to their position in the file, ten times as fast as through HDF5."""
        offset, kind = self._places[name]
        row = np.ascontiguousarray(values, dtype=kind)
        self._raw.seek(offset + first * (row.nbytes // max(1, len(row))))
        left = row.reshape(-1).view(np.uint8)
        while len(left):
            left = left[self._raw.write(left.data) :]

    @property
    def due(self) -> bool:
        """Whether a new checkpoint is due."""
        return time.monotonic() - self._kept >= checkpoint.SECONDS * max(1.0, self._spent / MOST_SPENT)

    def keep(self, state: Checkpoint) -> None:
        """Write a checkpoint, after the steps that it counts on.

        Raises:
            WriteError: if it cannot be written.
        """
        began = time.monotonic()
        try:
            os.fsync(self._raw.fileno())
            checkpoint.save(self.path, self.case, state)
        except OSError as error:
            raise WriteError(f"{self.path}: its checkpoint cannot be written: {first_line(error)}") from None
        self._kept = time.monotonic()
        self._spent = self._kept - began

    def finish(
        self,
        status: str = "complete",
        figures: Mapping[str, float] | None = None,
        reason: str = "",
        warnings: Sequence[str] = (),
    ) -> Result:
        """Close the file under its final name and open it for reading. Same arguments as `Recorder.finish`.

        Raises:
            WriteError: if the file cannot be renamed; it keeps its `.part` name.
        """
        try:
            warned = "\n".join([*self._warnings, *warnings])
            for name, value in {"status": status, "reason": reason, "warnings": warned}.items():
                hdf.rewrite(self._file, name, value)
            for name, number in (figures or {}).items():
                self._file.attrs.modify(name, number)
            self._file.close()
            if self._guard:
                self._guard.check()
                self._guard.close()
            self._raw.close()
            if self._packed():
                ownership.move(self._draft_name, self.path, self._overwrite)
                part(self.path).unlink()
            else:
                ownership.move(part(self.path), self.path, self._overwrite)
            checkpoint.discard(self.path)
        except OSError as error:
            raise WriteError(f"{self.path}: cannot be written: {first_line(error)}") from None
        self._lock.release()
        return open_result(self.path)

    def abandon(self) -> None:
        """Close the file under its current name."""
        if self._guard is not None:
            # Discard HDF5's pending writes: all complete data are on the disk.
            self._guard.stop()
        with contextlib.suppress(OSError, RuntimeError):
            for one in (self._file, self._guard, self._raw):
                if one is not None:
                    one.close()
        self._discard_draft()
        self._lock.release()

    def _packed(self) -> bool:
        """Whether the finished file has been written again with its large fields compressed; not without space."""
        if not self._large:
            return False
        self._draft = self._draft_name
        try:
            packing.pack(part(self.path), self._draft, self._layout, self.names, self._large)
        except (OSError, RuntimeError):
            self._discard_draft()
            return False
        return True

    @property
    def _draft_name(self) -> Path:
        """A file that nobody looks for yet."""
        return self.path.with_name(f".{self.path.name}.{os.getpid()}.part")

    def _reserve(self, size: int) -> Path:
        """A draft with space for all data. HDF5 does not survive a file that it cannot close, so the free space is
        checked first.
        """
        free = shutil.disk_usage(self.path.parent).free
        if size > free:
            room = f"needs {_size(size)} but the disk has {_size(free)} free; increase output.every to make it smaller"
            raise ResultError(f"{self.path}: {room}")
        self._draft = self._draft_name
        with open(self._draft, "wb") as file:
            file.truncate(size)
        return self._draft

    def _find_places(self) -> None:
        """Offsets of the variables over time in the file."""
        self._raw = open(part(self.path), "r+b", buffering=0)  # noqa: SIM115 - closed by `finish` or `abandon`
        for name in self.names:
            dataset = h5py.h5d.open(self._file.id, name.encode())
            self._places[name] = (dataset.get_offset(), dataset.dtype)

    def _publish(self) -> None:
        """Rename the laid-out file to `NAME.part`, once it is readable at any moment."""
        if self._draft is None:
            return
        checkpoint.discard(self.path)
        try:
            ownership.move(self._draft, part(self.path), self._overwrite)
        except FileExistsError:
            raise ResultError(f"{self.path}: another run has created this file") from None
        self._draft = None

    def _discard_draft(self) -> None:
        if self._draft is not None:
            with contextlib.suppress(OSError):
                self._draft.unlink(missing_ok=True)


def _size(number: float) -> str:
    return f"{number / 1e9:.3g} GB" if number >= 1e9 else f"{number / 1e6:.3g} MB"
