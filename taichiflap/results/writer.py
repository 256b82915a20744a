"""The result file, written so that no crash can damage it.

Every array has its full length and its place from the start: a run only fills numbers in, and nothing by which HDF5
finds its way changes until the end. What is not computed yet reads as NaN, `time` is filled last, so the frames
that have a time are whole. The file stands as `NAME.part` until it is complete.
"""

import contextlib
import os
import shutil
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..case.case import Case
from ..structure.beam import Modes
from . import checkpoint, hdf, layout, ownership
from .checkpoint import Checkpoint
from .layout import Contents, Layout, Sample
from .reader import Result, ResultError, first_line, open_result, part
from .recorder import Recorder


class WriteError(ResultError):
    """A run that cannot go on because its file cannot be written; what was written before is safe."""

    exit_code = 1


class Writer(Recorder):
    """Writes one result to a file.

    Args:
        case: what is being computed.
        path: the file to write.
        warnings: what makes the case implausible.
        overwrite: replace an existing file, and what an interrupted run has left.
        resume: go on with the file that an interrupted run has left, if there is one.

    Raises:
        ResultError: when the file exists already, is being written by another run, is of another case, or cannot be
            created.
    """

    def __init__(
        self, case: Case, path: Path, warnings: list[str], overwrite: bool = False, resume: bool = False
    ) -> None:
        super().__init__(case, warnings)
        self.path = path
        self._overwrite = overwrite
        self._kept = time.monotonic()
        self._file: Any = None
        self._raw: Any = None
        self._places: dict[str, tuple[int, np.dtype[Any]]] = {}
        self._draft: Path | None = None
        self._guard: hdf.Guarded | None = None
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
        """Give everything its place; a file that is resumed has it already. Arguments as of `Recorder.lay_out`.

        Raises:
            ResultError: when there is no room, or another run has begun the same file.
        """
        contents = contents or Contents()
        self._plan = layout.plan(sample, contents)
        if self._file is not None:
            self._find_places()
            return
        try:
            self._guard = hdf.Guarded(self._reserve(layout.size(self.case, sample, contents)))
            self._file = hdf.create(self._guard)
            Layout(self._file, self.case, self.began, self._warnings, nodes, section, sample, contents)
            self._file.flush()
            self._guard.check()
            self._publish()
            self._find_places()
        except ResultError:
            raise
        except (OSError, ValueError, RuntimeError) as error:
            # HDF5 reports a full disk as any of them, with the system's words inside.
            inside = str(error).partition("error message = '")[2].partition("'")[0]
            said = inside or (first_line(error) if isinstance(error, OSError) else str(error).splitlines()[0])
            raise ResultError(f"{self.path}: cannot be created: {said}") from None

    @property
    def stored(self) -> int:
        """Steps that the file holds."""
        return Result(self._file).steps

    def written(self, name: str) -> np.ndarray:
        """What was appended of a variable of one value a step; past HDF5, which need not know of it yet."""
        offset, kind = self._places[name]
        self._raw.seek(offset)
        return np.frombuffer(self._raw.read(self.steps * kind.itemsize), kind)

    def rewind(self, steps: int) -> None:
        """Go on after so many steps; what is behind them is written anew."""
        self.steps = steps
        frames = self.case.frames(steps)
        self._entries = {
            group: int(np.sum(self._file[f"{group}/count"][:frames], dtype=np.int64))
            for group in layout.groups(self._plan)
        }

    def append(self, variables: Mapping[str, np.ndarray]) -> None:
        """Add a block of steps, and of the frames among them, and hand it to the system.

        Raises:
            WriteError: when the disk refuses; the steps before are safe.
        """
        try:
            super().append(variables)
        except OSError as error:
            raise WriteError(f"{self.path}: cannot be written: {first_line(error)}") from None

    def _put(self, name: str, first: int, values: np.ndarray) -> None:
        """Write rows straight to their place in the file: HDF5 takes ten times as long to find it."""
        offset, kind = self._places[name]
        row = np.ascontiguousarray(values, dtype=kind)
        self._raw.seek(offset + first * (row.nbytes // max(1, len(row))))
        left = row.reshape(-1).view(np.uint8)
        while len(left):
            left = left[self._raw.write(left.data) :]

    @property
    def due(self) -> bool:
        """Whether the last state was kept some time ago."""
        return time.monotonic() - self._kept >= checkpoint.SECONDS

    def keep(self, state: Checkpoint) -> None:
        """Store what a resumed run needs to go on from here.

        Raises:
            WriteError: when the disk refuses.
        """
        try:
            checkpoint.save(self.path, self.case, state)
        except OSError as error:
            raise WriteError(f"{self.path}: its checkpoint cannot be written: {first_line(error)}") from None
        self._kept = time.monotonic()

    def finish(
        self,
        status: str = "complete",
        figures: Mapping[str, float] | None = None,
        reason: str = "",
        warnings: Sequence[str] = (),
    ) -> Result:
        """Close the file under its final name and open it for reading. Arguments as of `Recorder.finish`.

        Raises:
            WriteError: when the file cannot get its name; it stays under its `.part` name.
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
            ownership.move(part(self.path), self.path, self._overwrite)
            checkpoint.discard(self.path)
        except OSError as error:
            raise WriteError(f"{self.path}: cannot be written: {first_line(error)}") from None
        self._lock.release()
        return open_result(self.path)

    def abandon(self) -> None:
        """Close the file where it stands, under its `.part` name if it has one."""
        if self._guard is not None:
            # What HDF5 may still have in mind stays there: what was complete is on the disk.
            self._guard.stop()
        with contextlib.suppress(OSError, RuntimeError):
            for one in (self._file, self._guard, self._raw):
                if one is not None:
                    one.close()
        self._discard_draft()
        self._lock.release()

    def _reserve(self, size: int) -> Path:
        """A draft with room for everything. HDF5 does not survive a file that it cannot close, so what does not fit is
        refused before HDF5 has begun it."""
        free = shutil.disk_usage(self.path.parent).free
        if size > free:
            room = f"needs {_size(size)}, the disk has {_size(free)} free; a larger output.every makes it smaller"
            raise ResultError(f"{self.path}: {room}")
        self._draft = self.path.with_name(f".{self.path.name}.{os.getpid()}.part")
        with open(self._draft, "wb") as file:
            file.truncate(size)
        return self._draft

    def _find_places(self) -> None:
        """Where in the file the variables over time begin."""
        self._raw = open(part(self.path), "r+b", buffering=0)  # noqa: SIM115 - closed by `finish` or `abandon`
        for name in self.names:
            dataset = h5py.h5d.open(self._file.id, name.encode())
            self._places[name] = (dataset.get_offset(), dataset.dtype)

    def _publish(self) -> None:
        """The laid out file becomes `NAME.part`, once it is good to read at any moment."""
        if self._draft is None:
            return
        checkpoint.discard(self.path)
        try:
            ownership.move(self._draft, part(self.path), self._overwrite)
        except FileExistsError:
            raise ResultError(f"{self.path}: another run has begun this file") from None
        self._draft = None

    def _discard_draft(self) -> None:
        if self._draft is not None:
            with contextlib.suppress(OSError):
                self._draft.unlink(missing_ok=True)


def _size(number: float) -> str:
    return f"{number / 1e9:.3g} GB" if number >= 1e9 else f"{number / 1e6:.3g} MB"
