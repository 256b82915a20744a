"""The result file, written so that no crash can damage it.

Every array has its full length and its place from the start: a run only fills numbers in, and nothing by which HDF5
finds its way changes until the end. What is not computed yet reads as NaN, `time` is filled last, so the frames
that have a time are whole. The file stands as `NAME.part` until it is complete.
"""

import contextlib
import io
import os
import shutil
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from . import checkpoint
from ._version import __version__
from .beam import Modes
from .case import Case
from .checkpoint import Checkpoint
from .results import FORMAT, Result, ResultError, first_line, open_result, part
from .variables import AXES, MODE_VARIABLES, VARIABLES, WAKE_COUNT, WAKE_VARIABLES, Variable

NO_COORDINATE = "This is a netCDF dimension but not a netCDF variable."
"""What netCDF-4 calls a dimension scale that holds no values."""
REASON_BYTES = 512
"""Room for the reason of a failure."""
WARNING_BYTES = 512
"""Room for what turns out to be implausible in the end."""


class WriteError(ResultError):
    """A run that cannot go on because its file cannot be written; what was written before is safe."""

    exit_code = 1


class Writer:
    """Writes one result: construct, `lay_out`, `append` block by block, `finish`.

    Args:
        case: what is being computed.
        path: the file to write, or None to keep the result in memory.
        warnings: what makes the case implausible.
        overwrite: replace an existing file, and what an interrupted run has left.
        resume: go on with the file that an interrupted run has left, if there is one.

    Raises:
        ResultError: when the file exists already, is being written by another run, is of another case, or cannot be
            created.
    """

    def __init__(
        self, case: Case, path: Path | None, warnings: list[str], overwrite: bool = False, resume: bool = False
    ) -> None:
        self.case = case
        self.path = path
        self.frames = 0
        self._overwrite = overwrite
        self._kept = time.monotonic()
        self._warnings = warnings
        self._vortices = 0
        self._file: Any = None
        self._raw: Any = None
        self._places: dict[str, tuple[int, np.dtype[Any]]] = {}
        self._axes: dict[str, Any] = {}
        self._draft: Path | None = None
        if path is not None:
            _check_place(path, overwrite)
            self._file = _reopen(path, case, overwrite, resume)
        if self._file is not None:
            self._find_places()

    def lay_out(self, nodes: np.ndarray, section: Modes, sample: Mapping[str, np.ndarray], vortices: int = 0) -> None:
        """Give everything its place; a file that is resumed has it already.

        Args:
            nodes: chordwise positions of the nodes, m.
            section: the wing's modes.
            sample: what `append` will get, of any number of frames, none included.
            vortices: sum over all frames of the number of wake vortices.

        Raises:
            ResultError: when there is no room, or another run has begun the same file.
        """
        if self._file is not None:
            return
        frames = self.case.steps // self.case.output.every + 1
        try:
            self._check_room(frames * sum(_row_bytes(name, sample) for name in VARIABLES) + 16 * vortices)
            self._file = self._create()
            self._describe()
            self._lay_out_axes(frames, nodes, section)
            for name, variable in VARIABLES.items():
                if name in sample and np.prod(sample[name].shape[1:]):
                    self._lay_out_variable(name, variable, (frames, *sample[name].shape[1:]))
            if "wake_count" in sample:
                self._lay_out_wake(frames, vortices)
            self._file.flush()
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
        """Frames that the file holds."""
        return Result(self._file).frames

    def written(self, name: str) -> np.ndarray:
        """What was appended of a variable of one value a frame; past HDF5, which need not know of it yet."""
        offset, kind = self._places[name]
        self._raw.seek(offset)
        return np.frombuffer(self._raw.read(self.frames * kind.itemsize), kind)

    def rewind(self, frames: int) -> None:
        """Go on after so many frames; those behind are written anew."""
        self.frames = frames
        self._vortices = int(np.sum(self._file["wake/count"][:frames], dtype=np.int64)) if "wake" in self._file else 0

    def append(self, variables: Mapping[str, np.ndarray]) -> None:
        """Add a block of frames and hand it to the system.

        Raises:
            WriteError: when the disk refuses; the frames before are safe.
        """
        blocks = {name: (self.frames, variables[name]) for name in VARIABLES if name in variables}
        vortices = 0
        if "wake_count" in variables:
            vortices = len(variables["wake_birth"])
            wake = (*variables["wake"], variables["wake_birth"])
            blocks |= {f"wake/{name}": (self._vortices, row) for name, row in zip(WAKE_VARIABLES, wake, strict=True)}
            blocks["wake/count"] = (self.frames, variables["wake_count"])
        # Its time says that a frame is whole, so nothing of the frame may come later.
        blocks["time"] = (self.frames, variables["time"])
        try:
            for name, (first, values) in blocks.items():
                if name in self._places:
                    self._put(name, first, values)
        except OSError as error:
            raise WriteError(f"{self.path}: cannot be written: {first_line(error)}") from None
        self.frames += len(variables["time"])
        self._vortices += vortices

    def _put(self, name: str, first: int, values: np.ndarray) -> None:
        """Write rows straight to their place in the file: HDF5 takes ten times as long to find it."""
        offset, kind = self._places[name]
        row = np.ascontiguousarray(values, dtype=kind)
        self._raw.seek(offset + first * (row.nbytes // max(1, len(row))))
        left = row.reshape(-1).view(np.uint8)
        while len(left):
            left = left[self._raw.write(left.data) :]

    def keep(self, state: Checkpoint) -> None:
        """Store what a resumed run needs to go on from here, unless it was done a moment ago.

        Raises:
            WriteError: when the disk refuses.
        """
        if self.path is None or time.monotonic() - self._kept < checkpoint.SECONDS:
            return
        try:
            checkpoint.save(self.path, self.case, state)
        except OSError as error:
            raise WriteError(f"{self.path}: its checkpoint cannot be written: {first_line(error)}") from None
        self._kept = time.monotonic()

    def finish(
        self, status: str = "complete", solve_time: float = np.nan, reason: str = "", warnings: Sequence[str] = ()
    ) -> Result:
        """Close the file under its final name and open it for reading.

        Args:
            status: `complete` or `failed`.
            solve_time: seconds spent on the physics.
            reason: why the run failed.
            warnings: what makes its outcome implausible.

        Raises:
            WriteError: when the file cannot get its name; it stays under its `.part` name.
        """
        try:
            warned = "\n".join([*self._warnings, *warnings])
            for name, value in {"status": status, "reason": reason, "warnings": warned}.items():
                self._write(name, value)
            self._file.attrs.modify("solve_time", solve_time)
            if self.path is None:
                return Result(self._file)
            self._file.close()
            self._raw.close()
            _move(part(self.path), self.path, self._overwrite)
            checkpoint.discard(self.path)
        except OSError as error:
            raise WriteError(f"{self.path}: cannot be written: {first_line(error)}") from None
        return open_result(self.path)

    def _write(self, name: str, value: str) -> None:
        """Change an attribute of fixed size where it stands."""
        room = self._file.attrs.get_id(name).dtype.itemsize
        self._file.attrs.modify(name, np.bytes_(value.encode()[:room]))

    def abandon(self) -> None:
        """Close the file where it stands, under its `.part` name if it has one."""
        with contextlib.suppress(OSError, RuntimeError):
            for one in (self._file, self._raw):
                if one is not None:
                    one.close()
        self._discard_draft()

    def _check_room(self, size: int) -> None:
        """Refuse what does not fit before HDF5 has begun it: HDF5 does not survive a file that it cannot close."""
        if self.path is None:
            return
        free = shutil.disk_usage(self.path.parent).free
        if size > free:
            room = f"needs {_size(size)}, the disk has {_size(free)} free; a larger output.every makes it smaller"
            raise ResultError(f"{self.path}: {room}")
        self._draft = self.path.with_name(f".{self.path.name}.{os.getpid()}.part")
        with open(self._draft, "wb") as file:
            file.truncate(size)

    def _create(self) -> Any:
        if self._draft is not None:
            return h5py.File(self._draft, "w")
        self._raw = io.BytesIO()
        return h5py.File(self._raw, "w")

    def _find_places(self) -> None:
        """Where in the file the variables over time begin."""
        if self.path is not None:
            self._raw = open(part(self.path), "r+b", buffering=0)  # noqa: SIM115 - closed by `finish` or `abandon`
        names = [name for name in ("time", *VARIABLES) if name in self._file]
        names += [f"wake/{name}" for name in (*WAKE_VARIABLES, "count") if f"wake/{name}" in self._file]
        for name in names:
            dataset = h5py.h5d.open(self._file.id, name.encode())
            self._places[name] = (dataset.get_offset(), dataset.dtype)

    def _publish(self) -> None:
        """The laid out file becomes `NAME.part`, once it is good to read at any moment."""
        if self.path is None or self._draft is None:
            return
        checkpoint.discard(self.path)
        try:
            _move(self._draft, part(self.path), self._overwrite)
        except FileExistsError:
            raise ResultError(f"{self.path}: another run has begun this file") from None
        self._draft = None

    def _discard_draft(self) -> None:
        if self._draft is not None:
            self._draft.unlink(missing_ok=True)

    def _describe(self) -> None:
        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        self._file.attrs.update(
            {
                "Conventions": "CF-1.11",
                "title": self.case.title,
                "source": f"taichiflap {__version__}",
                "history": f"{now} computed with taichiflap {__version__}",
                "taichiflap_format": FORMAT,
                "case": self.case.to_toml(),
                "solve_time": np.nan,
            }
        )
        # Of fixed size, so that they too change where they stand.
        warned = "\n".join(self._warnings).encode()
        for name, value, room in (
            ("warnings", warned, len(warned) + WARNING_BYTES),
            ("status", b"running", len("complete")),
            ("reason", b"", REASON_BYTES),
        ):
            self._file.attrs.create(name, value, dtype=h5py.string_dtype("utf-8", room))

    def _lay_out_axes(self, frames: int, nodes: np.ndarray, section: Modes) -> None:
        self._make_axis("time", _place(self._file, "time", (frames,), "f8", fillvalue=np.nan))
        axes = {
            "mode": np.arange(1, section.count + 1),
            "node": nodes,
            "panel": 0.5 * (nodes[1:] + nodes[:-1]),
            "component": np.array(["Y", "Z"], dtype=object),
        }
        for name, values in axes.items():
            if len(values):
                self._make_axis(name, self._file.create_dataset(name, data=values))
        if not section.count:
            return
        group = self._file.create_group("modes")
        for name, values in {
            "frequency": section.frequency,
            "damping_ratio": section.damping_ratio,
            "lambda": section.lam,
            "psi": section.psi,
            "shape": section.shape(nodes),
        }.items():
            self._attach(group.create_dataset(name, data=values), MODE_VARIABLES[name])

    def _lay_out_variable(self, name: str, variable: Variable, shape: tuple[int, ...]) -> None:
        kind = "f4" if variable.single else "f8"
        self._attach(_place(self._file, name, shape, kind, fillvalue=np.nan), variable)

    def _lay_out_wake(self, frames: int, vortices: int) -> None:
        group = self._file.create_group("wake")
        # In chunks that are never written: it takes no room.
        axis = group.create_dataset("vortex", (vortices,), "f4", chunks=(8192,), maxshape=(None,))
        axis.make_scale(NO_COORDINATE)
        self._axes["vortex"] = axis
        for name, variable in WAKE_VARIABLES.items():
            kind = "i4" if name == "birth" else "f4"
            # Whatever stands there: the frames to come count no vortices.
            self._attach(_place(group, name, (vortices,), kind, fill_time="never"), variable)
        count = _place(group, "count", (frames,), "i4", fillvalue=0)
        self._attach(count, WAKE_COUNT)
        count.attrs["sample_dimension"] = "vortex"

    def _make_axis(self, name: str, dataset: Any) -> None:
        dataset.make_scale(name)
        _note(dataset, AXES[name].attributes)
        self._axes[name] = dataset

    def _attach(self, dataset: Any, variable: Variable) -> None:
        _note(dataset, variable.attributes)
        for position, name in enumerate(variable.dimensions):
            dataset.dims[position].attach_scale(self._axes[name])


def finished(path: Path, case: Case) -> Result | None:
    """The finished result of a case, or None.

    Raises:
        ResultError: when the file is of another case, or no result.
    """
    if not path.is_file():
        return None
    result = open_result(path)
    try:
        _check_same(result.file, path, case)
    except ResultError:
        result.close()
        raise
    return result


def _check_place(path: Path, overwrite: bool) -> None:
    if path.is_dir():
        raise ResultError(f"{path}: is a directory; name a file, for example {path / 'result.h5'}")
    if path.exists() and not overwrite:
        raise ResultError(f"{path}: exists already; --overwrite replaces it, -o writes elsewhere")
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise ResultError(f"{path}: cannot be created: {first_line(error)}") from None


def _reopen(path: Path, case: Case, overwrite: bool, resume: bool) -> Any:
    """The file that an interrupted run has left, to go on with; None to begin anew.

    While it is open, HDF5's lock keeps every other run away.
    """
    if not part(path).exists():
        return None
    try:
        file = h5py.File(part(path), "r+")
    except BlockingIOError:
        raise ResultError(f"{path}: another run is writing it") from None
    except OSError as error:
        if overwrite:
            return None
        raise ResultError(f"{part(path)}: is in the way: {first_line(error)}; --overwrite replaces it") from None
    try:
        if overwrite:
            return None
        if not resume:
            left = "an interrupted run has left its frames; --resume goes on with them, --overwrite begins anew"
            raise ResultError(f"{path}: {left}")
        _check_same(file, part(path), case)
        kept, file = file, None
        return kept
    finally:
        if file is not None:
            file.close()


def _check_same(file: Any, path: Path, case: Case) -> None:
    for name, ours in {"case": case.to_toml(), "source": f"taichiflap {__version__}"}.items():
        theirs = file.attrs.get(name)
        if theirs != ours:
            raise ResultError(f"{path}: cannot be resumed: {_difference(name, str(theirs), ours)}")


def _difference(name: str, theirs: str, ours: str) -> str:
    if name == "source":
        return f"{theirs} began it, this is {ours}; --overwrite begins anew"
    lines = [one for one in zip(theirs.splitlines(), ours.splitlines(), strict=False) if one[0] != one[1]]
    said = f": {lines[0][0]} there, {lines[0][1]} here" if lines else ""
    return f"it is of another case{said}; --overwrite begins anew"


def _move(source: Path, target: Path, overwrite: bool) -> None:
    """Rename a file; only if told so, in the place of another.

    Raises:
        FileExistsError: when the target exists and is not to be replaced.
    """
    if overwrite:
        os.replace(source, target)
        return
    try:
        # Unlike a renaming, a link never takes the place of what another run has put there in the meantime.
        os.link(source, target)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        os.rename(source, target)
    else:
        os.unlink(source)


def _place(group: Any, name: str, shape: tuple[int, ...], kind: str, **fill: Any) -> Any:
    """A dataset in one piece whose room is reserved, and filled, at once."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return group.create_dataset(name, shape, kind, dcpl=properties, **fill)


def _row_bytes(name: str, sample: Mapping[str, np.ndarray]) -> int:
    """Bytes of a frame of a variable."""
    items = int(np.prod(sample[name].shape[1:])) if name in sample else 0
    return items * (4 if VARIABLES[name].single else 8)


def _size(number: float) -> str:
    return f"{number / 1e9:.3g} GB" if number >= 1e9 else f"{number / 1e6:.3g} MB"


def _note(dataset: Any, texts: Mapping[str, str]) -> None:
    """Texts as attributes, as h5py writes them, in a third of its time: a file has a hundred."""
    kind, one = h5py.string_dtype(), h5py.h5s.create(h5py.h5s.SCALAR)
    stored = h5py.h5t.py_create(kind, logical=True)
    for name, text in texts.items():
        h5py.h5a.create(dataset.id, name.encode(), stored, one).write(np.array(text, dtype=kind))
