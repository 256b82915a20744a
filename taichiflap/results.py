"""The result file: HDF5 that opens in xarray, netCDF4 and MATLAB with no code of ours. Writer and reader.

The only module that knows h5py. A file is written as `NAME.part` in blocks of frames, flushed after each, and
renamed when complete, so that a crash at any moment leaves something readable.
"""

import contextlib
import itertools
import os
import time
import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np

from ._version import __version__
from .beam import Modes
from .case import Case, CaseError, parse_case
from .errors import UserError
from .variables import AXES, MODE_VARIABLES, VARIABLES, WAKE_COUNT, WAKE_VARIABLES, Variable

FORMAT = 1
"""Version of the layout; a reader refuses files of a newer one."""

NO_COORDINATE = "This is a netCDF dimension but not a netCDF variable."
"""What netCDF-4 calls a dimension scale that holds no values."""

PART = ".part"
"""What the name of a file ends in until it is complete."""

SERIES_CHUNK, FIELD_CHUNK, WAKE_CHUNK = 1024, 64, 8192

_in_memory = itertools.count()


class ResultError(UserError):
    """A result file that cannot be read or written: one sentence with the path and the cause."""


class Writer:
    """Writes one result, block by block: construct, `lay_out`, `append` as often as it takes, `finish`.

    Args:
        case: what is being computed.
        path: the file to write, or None to keep the result in memory.
        warnings: what makes the case implausible.
        overwrite: replace an existing file.

    Raises:
        ResultError: when the file exists already, or cannot be created.
    """

    def __init__(self, case: Case, path: Path | None, warnings: list[str], overwrite: bool = False) -> None:
        self.path = path
        self._file = _create(path, overwrite)
        self._frames = 0
        self._vortices = 0
        self._describe(case, warnings)

    def lay_out(self, nodes: np.ndarray, section: Modes) -> None:
        """Write the axes and the wing's modes; `nodes` are chordwise positions, m."""
        axis = self._file.create_dataset("time", (0,), "f8", maxshape=(None,), chunks=(SERIES_CHUNK,))
        _make_axis(axis, "time", AXES["time"])
        axes = {
            "mode": np.arange(1, section.count + 1),
            "node": nodes,
            "panel": 0.5 * (nodes[1:] + nodes[:-1]),
            "component": np.array(["Y", "Z"], dtype=object),
        }
        for name, values in axes.items():
            if len(values):
                _make_axis(self._file.create_dataset(name, data=values), name, AXES[name])
        if section.count:
            self._lay_out_modes(nodes, section)

    def _lay_out_modes(self, nodes: np.ndarray, section: Modes) -> None:
        group = self._file.create_group("modes")
        for name, values in {
            "frequency": section.frequency,
            "damping_ratio": section.damping_ratio,
            "lambda": section.lam,
            "psi": section.psi,
            "shape": section.shape(nodes),
        }.items():
            self._attach(group.create_dataset(name, data=values), MODE_VARIABLES[name])

    def append(self, variables: Mapping[str, np.ndarray]) -> None:
        """Add a block of frames and flush it to the disk.

        Raises:
            ResultError: when the disk refuses; the frames before are safe.
        """
        count = len(variables["time"])
        try:
            self._extend(self._file["time"], self._frames, variables["time"])
            for name, variable in VARIABLES.items():
                if name in variables and variables[name].size:
                    self._extend(self._dataset(name, variable, self._file), self._frames, variables[name])
            if "wake_count" in variables:
                self._append_wake(variables)
            self._frames += count
            self._file.flush()
        except OSError as error:
            raise ResultError(f"{self.path}: cannot be written: {error}") from None

    def finish(self, status: str = "complete", **attributes: Any) -> "Result":
        """Close the file under its final name and open it for reading.

        Args:
            status: `complete` or `failed`.
            attributes: what else is to be remembered, such as `solve_time` or the reason of a failure.
        """
        self._file.attrs.update({"status": status, **attributes})
        if self.path is None:
            return Result(self._file)
        self._file.close()
        os.replace(part(self.path), self.path)
        return open_result(self.path)

    def abandon(self) -> None:
        """Close the file where it stands, under its `.part` name."""
        with contextlib.suppress(OSError, RuntimeError):
            self._file.close()

    def _describe(self, case: Case, warnings: list[str]) -> None:
        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        self._file.attrs.update(
            {
                "Conventions": "CF-1.11",
                "title": case.title,
                "source": f"taichiflap {__version__}",
                "history": f"{now} computed with taichiflap {__version__}",
                "taichiflap_format": FORMAT,
                "case": case.to_toml(),
                "warnings": "\n".join(warnings),
                "status": "running",
            }
        )

    def _dataset(self, name: str, variable: Variable, group: Any) -> Any:
        if name in group:
            return group[name]
        lengths = [len(self._file[axis]) for axis in variable.dimensions[1:]]
        if variable.single:
            options = {"chunks": (FIELD_CHUNK, *lengths), "compression": 1, "shuffle": True}
        else:
            options = {"chunks": (SERIES_CHUNK, *lengths)}
        kind = "f4" if variable.single else "f8"
        dataset = group.create_dataset(name, (0, *lengths), kind, maxshape=(None, *lengths), **options)
        self._attach(dataset, variable)
        return dataset

    def _append_wake(self, variables: Mapping[str, np.ndarray]) -> None:
        group = self._file.get("wake")
        if group is None:
            group = self._file.create_group("wake")
            axis = group.create_dataset("vortex", (0,), "f4", maxshape=(None,), chunks=(WAKE_CHUNK,))
            axis.make_scale(NO_COORDINATE)
            for name, variable in WAKE_VARIABLES.items():
                kind = "i4" if name == "birth" else "f4"
                dataset = group.create_dataset(
                    name, (0,), kind, maxshape=(None,), chunks=(WAKE_CHUNK,), compression=1, shuffle=True
                )
                self._attach(dataset, variable, group)
            count = group.create_dataset("count", (0,), "i4", maxshape=(None,), chunks=(SERIES_CHUNK,))
            self._attach(count, WAKE_COUNT)
            count.attrs["sample_dimension"] = "vortex"
        y, z, circulation = variables["wake"]
        last = self._vortices + len(y)
        parts = {"y": y, "z": z, "circulation": circulation, "birth": variables["wake_birth"]}
        group["vortex"].resize(last, axis=0)
        for name, values in parts.items():
            self._extend(group[name], self._vortices, values)
        self._extend(group["count"], self._frames, variables["wake_count"])
        self._vortices = last

    @staticmethod
    def _extend(dataset: Any, first: int, values: np.ndarray) -> None:
        dataset.resize(first + len(values), axis=0)
        dataset[first:] = values

    def _attach(self, dataset: Any, variable: Variable, group: Any = None) -> None:
        _explain(dataset, variable)
        for position, name in enumerate(variable.dimensions):
            scales = group if group is not None and name in group else self._file
            dataset.dims[position].attach_scale(scales[name])


class Result:
    """A result, read as needed: `result.tip_deflection` is an array, `result.case` the case, in SI units.

    Every variable of the file is an attribute; `dir(result)` and `result.variables` list them.
    """

    def __init__(self, file: Any, path: Path | None = None) -> None:
        self.file = file
        self.path = path
        self._frames = _whole_frames(file)
        self._wake_ends = np.empty(0, dtype=np.int64)
        # An open dataset keeps its chunks: frames in a row are read from memory.
        self._open: dict[str, Any] = {}

    def __getattr__(self, name: str) -> np.ndarray:
        if name.startswith("_") or name not in self.variables:
            raise AttributeError(f"no variable {name!r} in this result; it has {', '.join(self.variables)}")
        return self.file[name][: self.frames]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.variables]

    def __enter__(self) -> "Result":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Result {self.case.title!r}, {self.status}, {self.frames} frames>"

    def close(self) -> None:
        """Close the file; a result in memory is lost."""
        self.file.close()

    @property
    def variables(self) -> list[str]:
        """Names of the variables over time."""
        return [name for name in ("time", *VARIABLES) if name in self.file]

    @property
    def attributes(self) -> dict[str, Any]:
        """The file's own attributes: title, source, status, solve time ..."""
        return dict(self.file.attrs)

    @property
    def status(self) -> str:
        """`running`, `complete` or `failed`."""
        return str(self.file.attrs["status"])

    @property
    def case(self) -> Case:
        """The case that was computed, overrides included."""
        return parse_case(tomllib.loads(self.file.attrs["case"]), "the result's case")

    @property
    def frames(self) -> int:
        """Number of frames stored, as of the opening or the last `refresh`."""
        return self._frames

    @property
    def modes(self) -> dict[str, np.ndarray]:
        """`frequency` (Hz), `damping_ratio`, `lambda`, `psi` and `shape` (mode, node) of the elastic modes.

        A rigid wing has none: its file has no modal variable and no `mode` axis.
        """
        return {name: values[...] for name, values in self.file.get("modes", {}).items()}

    def frame(self, name: str, index: int) -> np.ndarray:
        """One frame of a variable, without reading the others."""
        return self._dataset(name)[range(self.frames)[index]]

    def wake(self, index: int) -> dict[str, np.ndarray]:
        """Wake vortices of one frame, oldest first: `y`, `z` (m), `circulation` (m2/s) and `birth` (step).

        A model without a wake has none: all arrays are empty.
        """
        if "wake" not in self.file:
            return {name: np.empty(0) for name in WAKE_VARIABLES}
        index = range(self.frames)[index]
        if not len(self._wake_ends):
            self._wake_ends = np.cumsum(self.file["wake/count"][: self.frames], dtype=np.int64)
        first = 0 if index == 0 else int(self._wake_ends[index - 1])
        last = int(self._wake_ends[index])
        return {name: self._dataset(f"wake/{name}")[first:last] for name in WAKE_VARIABLES}

    def refresh(self) -> None:
        """Look again at a file that is still being written, or that has got its final name since.

        Raises:
            ResultError: when it cannot be read just now, for instance in the middle of a write; the result is
                closed until a later `refresh` succeeds.
        """
        if self.path is None:
            return
        # First: HDF5 would lend what it remembers of an open file to the next to open it.
        self.file.close()
        path = self.path if self.path.exists() else self.path.with_name(self.path.name.removesuffix(PART))
        vars(self).update(vars(open_result(path)))

    def _dataset(self, name: str) -> Any:
        if name not in self._open:
            self._open[name] = self.file[name]
        return self._open[name]

    def to_xarray(self) -> Any:
        """The variables over time as an `xarray.Dataset` with coordinates, units and attributes.

        Raises:
            ResultError: when xarray is not installed.
        """
        try:
            import xarray  # noqa: PLC0415 - an optional extra
        except ImportError:
            raise ResultError('to_xarray needs xarray: pip install "taichiflap[xarray]"') from None
        arrays = {
            name: (VARIABLES[name].dimensions, self.file[name][...], _explanation(VARIABLES[name]))
            for name in self.variables
            if name != "time"
        }
        axes = {
            name: (name, self.file[name].asstr()[...] if name == "component" else self.file[name][...])
            for name in ("time", "mode", "node", "panel", "component")
            if name in self.file
        }
        return xarray.Dataset(arrays, axes, self.attributes)


def open_result(path: str | Path) -> Result:
    """Open a result file, complete or still being written.

    Raises:
        ResultError: when it is missing, damaged, of another kind, or of a newer version.
    """
    path = Path(path)
    if not path.exists() and part(path).exists():
        path = part(path)
    try:
        file = h5py.File(path, "r", locking=False)
    except FileNotFoundError:
        raise ResultError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise ResultError(f"{path}: is a directory") from None
    except OSError as error:
        raise ResultError(f"{path}: not a readable result file: {_first_line(error)}") from None
    try:
        _check(file, path)
    except ResultError:
        file.close()
        raise
    return Result(file, path)


def part(path: Path) -> Path:
    """The name under which a file stands until it is complete."""
    return path.with_name(path.name + PART)


def _whole_frames(file: Any) -> int:
    """Frames of which every variable is stored: a file may be opened in the middle of a write."""
    frames = min([len(file["time"]), *(len(file[name]) for name in VARIABLES if name in file)])
    if "wake" in file and file.attrs["status"] == "running":
        frames = min(frames, len(file["wake/count"]))
        ends = np.cumsum(file["wake/count"][:frames], dtype=np.int64)
        frames = int(np.searchsorted(ends, len(file["wake/circulation"]), side="right"))
    return frames


def _check(file: Any, path: Path) -> None:
    try:
        version = int(file.attrs["taichiflap_format"])
        if version > FORMAT:
            raise ResultError(f"{path}: written by a newer taichiflap (format {version}, this one reads {FORMAT})")
        parse_case(tomllib.loads(file.attrs["case"]), str(path))
        str(file.attrs["status"])
        _whole_frames(file)
    except CaseError as error:
        raise ResultError(f"{path}: the case inside it is not valid: {error.problems[0]}") from None
    except (KeyError, TypeError, ValueError, OSError, RuntimeError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{path}: an HDF5 file, but not a result of taichiflap") from None


def _create(path: Path | None, overwrite: bool) -> Any:
    if path is None:
        name = f"result {next(_in_memory)} in memory"  # HDF5 takes two open files of one name for the same file
        return h5py.File(name, "w", driver="core", backing_store=False)
    if path.is_dir():
        raise ResultError(f"{path}: is a directory; name a file, for example {path / 'result.h5'}")
    if path.exists() and not overwrite:
        raise ResultError(f"{path}: exists already; --overwrite replaces it, -o writes elsewhere")
    try:
        return h5py.File(part(path), "w")
    except OSError as error:
        raise ResultError(f"{path}: cannot be created: {_first_line(error)}") from None


def _first_line(error: OSError) -> str:
    return error.strerror or str(error).splitlines()[0]


def _explanation(variable: Variable) -> dict[str, str]:
    words = {name: getattr(variable, name) for name in ("units", "long_name", "symbol", "comment")}
    return {name: text for name, text in words.items() if text}


def _make_axis(dataset: Any, name: str, variable: Variable) -> None:
    dataset.make_scale(name)
    _explain(dataset, variable)


def _explain(dataset: Any, variable: Variable) -> None:
    dataset.attrs.update(_explanation(variable))
