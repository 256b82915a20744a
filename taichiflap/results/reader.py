"""Reading of result files: HDF5 that also opens in xarray, netCDF4 and MATLAB."""

import bisect
import functools
import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np

from ..case.case import Case, CaseError, held_case
from ..errors import UserError, extra
from . import integrity
from .integrity import DAMAGE, DamageError
from .variables import (
    AXES,
    AXES_OF,
    COMPONENTS,
    FIELD_TIME,
    MODE_VARIABLES,
    VARIABLES,
    WAKE_EDGE,
    WAKE_VARIABLES,
    Variable,
)

FORMAT = 2
"""Version of the layout; readers refuse files of a newer version. Version 1 stored series only in the frames."""

PART = ".part"
"""Suffix of a file that is not complete yet."""

ATTRIBUTES = (
    "Conventions", "title", "source", "history", "taichiflap_format", "case", "warnings", "solve_time", "status",
    "reason", "energy_residual", "reference_speed", "reference_area", "nearest_scored",
)  # fmt: skip
"""Text attributes of a file."""

FIGURES = ("solve_time", "energy_residual", "reference_speed", "reference_area")
"""Numeric attributes, known at the end: solve time, s; unaccounted share of the work; reference speed and area of
coefficients, m/s and m2. NaN if undefined.
"""

STATUSES = ("running", "complete", "failed")

REQUIRED = (
    "plunge", "pitch", "q", "q_rate", "tip_deflection", "force_normal", "force_axial", "force_y", "force_z",
    "force_vertical", "force_vertical_normal", "moment", "power", "power_aerodynamic", "power_inertial",
    "node_position", "pressure_jump",
)  # fmt: skip
"""Variables of every model; those over modes only for a flexible wing."""


class ResultError(UserError):
    """Raised for a result file that cannot be read or written; one sentence with the path and the cause."""


class Result:
    """A result, read on demand, in SI units: `result.tip_deflection` is an array, `result.case` the case.

    Every variable of the file is an attribute; `dir(result)` and `result.variables` list them. Series have a value at
    every step, at `result.time`. Fields have a frame every `output.every` steps and at the last step, at
    `result.field_time`.
    """

    def __init__(self, file: Any, path: Path | None = None) -> None:
        self.file = file
        self.path = path
        self._steps = _whole_steps(file)
        self._ends: dict[str, np.ndarray] = {}
        # Open datasets cache their chunks, so that consecutive frames are read from memory.
        self._open: dict[str, Any] = {}

    def __getattr__(self, name: str) -> np.ndarray:
        # Its own attributes are looked for here while it is being unpickled.
        if name.startswith("_") or "file" not in self.__dict__:
            raise AttributeError(name)
        if name not in self.variables:
            raise AttributeError(f"this result has no variable {name!r}; it has {', '.join(self.variables)}")
        return self._read(self.file[name], name, slice(self._rows(name)))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.variables]

    def __enter__(self) -> "Result":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Result {self.case.title!r}, {self.status}, {self.steps} steps, {self.frames} frames>"

    def _repr_html_(self) -> str:
        from ..notebook import html  # noqa: PLC0415 - notebooks alone ask for it

        return html.of_result(self)

    def view(self, height: int = 600) -> Any:
        """The viewer of this result, as the value of a notebook's cell; a picture where no viewer can be reached.

        It runs in a process of its own, which ends with the notebook, or with `close()` of what is returned.

        Args:
            height: of the viewer, pixels.
        """
        from ..notebook.inline import Inline  # noqa: PLC0415 - notebooks alone ask for it

        return Inline(self, height)

    def close(self) -> None:
        """Close the file. A result in memory is lost unless it was saved."""
        self.file.close()

    @functools.cached_property
    def variables(self) -> list[str]:
        """Names of the variables over time."""
        return [name for name in ("time", FIELD_TIME, *VARIABLES) if name in self.file] + list(self._own)

    @functools.cached_property
    def _own(self) -> dict[str, Variable]:
        """Variables that only the fluid model defines."""
        return _own_variables(self.file)

    def describe(self, name: str) -> Variable:
        """Axes, units and description of a variable."""
        if name in (*AXES, *self._own):
            return AXES[name] if name in AXES else self._own[name]
        return replace(VARIABLES[name], dimensions=VARIABLES[name].axes(self.case.output.every))

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the file: title, source, status, solve time ..."""
        said = self._said(ATTRIBUTES)
        # Set at the end of a run.
        unknown = [name for name, value in said.items() if value != value or (name == "reason" and not value)]  # noqa: PLR0124
        return {name: value for name, value in said.items() if name not in unknown}

    def _said(self, names: Iterable[str]) -> dict[str, Any]:
        """Those of the given attributes that exist."""
        return integrity.attributes(self.file, names)

    @property
    def status(self) -> str:
        """`running`, `complete` or `failed`."""
        return str(self._said(["status"])["status"])

    @functools.cached_property
    def case(self) -> Case:
        """The case that was computed, overrides included."""
        return held_case(integrity.attribute(self.file, "case"), "the result's case")

    @property
    def steps(self) -> int:
        """Number of stored steps, including step 0, when opened or last refreshed."""
        return self._steps

    @property
    def frames(self) -> int:
        """Number of stored frames, when opened or last refreshed."""
        return self.case.frames(self._steps)

    @property
    def field_time(self) -> np.ndarray:
        """Times of the frames, s; equal to `time` if every step stores its fields."""
        name = FIELD_TIME if FIELD_TIME in self.file else "time"
        return self._read(self.file[name], name, slice(self.frames))

    def _rows(self, name: str) -> int:
        return self.frames if self._is_field(name) else self._steps

    def _is_field(self, name: str) -> bool:
        if name in VARIABLES:
            return VARIABLES[name].field
        return name == FIELD_TIME or (name in self._own and self._own[name].field)

    @property
    def modes(self) -> dict[str, np.ndarray]:
        """`frequency` (Hz), `damping_ratio`, `lambda`, `psi` and `shape` (mode, node) of the elastic modes.

        Empty for a rigid wing, whose file has no modal variables and no `mode` axis.
        """
        return {name: values[...] for name, values in self.file.get("modes", {}).items()}

    def frame(self, name: str, index: int) -> np.ndarray:
        """One frame of a variable, read alone; for a series the value at the frame's time."""
        index = range(self.frames)[index]
        row = index if self._is_field(name) else int(self.case.step_of(index))
        return self._read(self._dataset(name), name, row)

    def between(self, name: str, first: int, last: int, stride: int = 1) -> np.ndarray:
        """Every `stride`-th step of a series, or frame of a field, from `first` to `last`, both included."""
        return self._read(self._dataset(name), name, slice(first, min(last + 1, self._rows(name)), stride))

    @property
    def stations(self) -> np.ndarray:
        """Positions of the nodes along the undeformed chord, from the pivot, m."""
        return self.file["node"][...]

    @property
    def has_wake(self) -> bool:
        """Whether the model computes a wake."""
        return "wake" in self.file

    @property
    def has_sheets(self) -> bool:
        """Whether the wake has two sheets, one from each edge."""
        return f"wake/{WAKE_EDGE}" in self.file

    def wake(self, index: int) -> dict[str, np.ndarray]:
        """Wake vortices of one frame, oldest first.

        They are `y`, `z` (m), `circulation` (m2/s), `birth` (step) and `edge` (0: shed by the trailing edge, 1: by the
        leading edge). All arrays are empty for a model without a wake.
        """
        if not self.has_wake:
            return {name: np.empty(0) for name in WAKE_VARIABLES}
        found = self.ragged("wake", _wake_names(self.file["wake"]), index)
        return {WAKE_EDGE: np.zeros(len(found["y"]), dtype=np.int32)} | found

    def ragged(self, group: str, names: Iterable[str], index: int) -> dict[str, np.ndarray]:
        """One frame of some variables of a ragged group."""
        index = range(self.frames)[index]
        if group not in self._ends:
            self._ends[group] = np.cumsum(self.file[f"{group}/count"][: self.frames], dtype=np.int64)
        ends = self._ends[group]
        first, last = 0 if index == 0 else int(ends[index - 1]), int(ends[index])
        return {name: self._read(self._dataset(f"{group}/{name}"), name, slice(first, last)) for name in names}

    def save(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write the result to a file, identical to that of `simulate(case, path)`.

        Args:
            overwrite: replace an existing file.

        Raises:
            ResultError: if the file exists or cannot be written.
        """
        from .ownership import copy  # noqa: PLC0415 - it reads results itself

        if self.path is None or not self.path.exists():
            raise ResultError(f"{path}: the file to copy does not exist")
        copy(self.path, Path(path), overwrite)

    def refresh(self) -> None:
        """Update a result whose file is still being written, or has been completed meanwhile.

        Raises:
            ResultError: if it cannot be read at this moment, for instance during a write; the result stays closed until
                a later `refresh` succeeds.
        """
        if self.path is None:
            return
        # Close it first, since HDF5 would reuse cached data of the open file.
        self.file.close()
        path = self.path if self.path.exists() else self.path.with_name(self.path.name.removesuffix(PART))
        fresh = vars(open_result(path))
        vars(self).clear()
        vars(self).update(fresh)

    def _read(self, dataset: Any, name: str, key: Any) -> Any:
        try:
            return integrity.numbers(dataset[key], name)
        except DamageError as error:
            raise ResultError(f"{self.path}: damaged: {error}") from None
        except OSError as error:
            raise ResultError(f"{self.path}: damaged: {name}: {first_line(error)}") from None

    def _dataset(self, name: str) -> Any:
        if name not in self._open:
            self._open[name] = self.file[name]
        return self._open[name]

    def to_xarray(self) -> Any:
        """The variables over time as an `xarray.Dataset` with coordinates, units and attributes.

        Raises:
            ResultError: if xarray is not installed.
        """
        xarray = extra("xarray", "xarray", "to_xarray needs xarray", ResultError)
        described = {name: self.describe(name) for name in self.variables if name not in ("time", FIELD_TIME)}
        arrays = {name: (one.dimensions, getattr(self, name), one.attributes) for name, one in described.items()}
        used = {axis for one in described.values() for axis in one.dimensions} - {"time", FIELD_TIME, "component"}
        axes = {name: (name, self.file[name][...]) for name in sorted(used)}
        times = {name: getattr(self, name) for name in ("time", FIELD_TIME) if name in self.variables}
        coordinates = {**times, "component": list(COMPONENTS), **axes}
        return xarray.Dataset(arrays, coordinates, self.attributes)


def open_result(path: str | Path) -> Result:
    """Open a result file, complete or still being written.

    Raises:
        ResultError: if it is missing, damaged, not a result, or of a newer version.
    """
    path = Path(path)
    # Unlike Path.exists, without an error where the system refuses to look.
    if not os.path.exists(path) and os.path.exists(part(path)):
        path = part(path)
    refuse_devices(path, ResultError)
    try:
        file = h5py.File(path, "r", locking=False)
    except FileNotFoundError:
        raise ResultError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise ResultError(f"{path}: is a directory") from None
    except OSError as error:
        case = "this is a case file, not a result; run it with taichiflap simulate"
        said = case if path.suffix == ".toml" else f"not a readable result file: {first_line(error)}"
        raise ResultError(f"{path}: {said}") from None
    except DAMAGE as error:
        raise ResultError(f"{path}: not a readable result file: {str(error).partition(chr(10))[0]}") from None
    try:
        return _checked(file, path)
    except ResultError:
        file.close()
        raise


def refuse_devices(path: Path, error: type[UserError]) -> None:
    """Raise an error for a pipe, which would block HDF5, and a device, which may never end.

    Raises:
        UserError: an `error`, if it is one.
    """
    if os.path.exists(path) and not (path.is_file() or path.is_dir()):
        raise error(f"{path}: not a regular file")


def part(path: Path) -> Path:
    """Name of a file until it is complete."""
    return path.with_name(path.name + PART)


def _whole_steps(file: Any) -> int:
    """Number of stored steps; future steps have no time yet."""
    time = file["time"]
    return bisect.bisect_left(range(len(time)), True, key=lambda index: bool(np.isnan(time[index])))


def _own_variables(file: Any) -> dict[str, Variable]:
    """Variables over time of the file's fluid model, as described in the file."""
    found = {}
    for name in file:
        if name in VARIABLES or not isinstance(file.get(name, getlink=True), h5py.HardLink):
            continue
        if isinstance(file[name], h5py.Dataset) and AXES_OF in file[name].attrs:
            words = integrity.attributes(file[name], ("units", "long_name", "symbol", "comment", AXES_OF))
            axes = tuple(str(words.pop(AXES_OF)).split())
            kind = file[name].dtype.str[1:]
            found[name] = Variable(axes, **{"units": "", "long_name": name} | words, dtype=kind, field=len(axes) > 1)
    return found


def _checked(file: Any, path: Path) -> Result:
    """The result in a file, after checks."""
    try:
        version = integrity.attributes(file, ("taichiflap_format",)).get("taichiflap_format")
        if version is None:
            raise ResultError(f"{path}: this HDF5 file is not a taichiflap result")
        if version > FORMAT:
            raise ResultError(f"{path}: written by a newer taichiflap (format {version}, this one reads {FORMAT})")
        case = held_case(integrity.attribute(file, "case"), str(path))
        if version < FORMAT and case.output.every > 1:
            raise ResultError(
                f"{path}: written by an older taichiflap with output.every = {case.output.every}, without the steps "
                "in between; compute it again"
            )
        _check_contents(file, case)
    except ResultError:
        raise
    except CaseError as error:
        raise ResultError(f"{path}: its case is invalid: {error.problems[0]}") from None
    except DamageError as error:
        raise ResultError(f"{path}: damaged: {error}") from None
    except DAMAGE as error:
        raise ResultError(f"{path}: damaged: {str(error).partition(chr(10))[0]}") from None
    return Result(file, path)


def _check_contents(file: Any, case: Case) -> None:
    """Check that all arrays exist with the sizes that follow from the case."""
    said = integrity.attributes(file, ATTRIBUTES)
    numbers = all(isinstance(said.get(name, 0.0), float) for name in FIGURES)
    if not numbers or not isinstance(said.get("warnings", ""), str):
        raise DamageError("solve_time or warnings have the wrong type")
    if integrity.attribute(file, "status") not in STATUSES:
        raise DamageError("no status")
    modes = case.wing.modes
    (nodes,) = integrity.array(file, "node", (None,), "f")
    sizes = {
        "time": case.steps + 1, FIELD_TIME: case.frames(), "mode": modes, "node": nodes, "panel": nodes - 1,
        "component": len(COMPONENTS),
    }  # fmt: skip
    times = ("time",) if case.output.every == 1 else ("time", FIELD_TIME)
    for name in times:
        integrity.array(file, name, (sizes[name],), "f")
    integrity.array(file, "panel", (sizes["panel"],), "f")
    for name, variable in VARIABLES.items():
        shape = tuple(sizes[axis] for axis in variable.axes(case.output.every))
        if 0 not in shape and (name in REQUIRED or name in file):
            integrity.array(file, name, shape, "f")
    for name, variable in _own_variables(file).items():
        for axis in variable.dimensions:
            if axis not in sizes:
                (sizes[axis],) = integrity.array(file, axis, (None,), "f")
        if variable.dimensions[:1] != (times[-1],) if variable.field else variable.dimensions != ("time",):
            raise DamageError(f"{name} does not depend on {times[-1]}")
        integrity.array(file, name, tuple(sizes[axis] for axis in variable.dimensions), "if")
    if modes:
        integrity.array(file, "mode", (modes,), "i")
        group = integrity.group(file, "modes")
        for name, variable in MODE_VARIABLES.items():
            integrity.array(group, name, tuple(sizes[axis] for axis in variable.dimensions), "f")
            integrity.numbers(group[name][...], name)
    for name in _ragged_groups(file):
        _check_ragged(integrity.group(file, name), name, sizes[times[-1]])
    steps = _whole_steps(file)
    _check_times(file["time"][:steps], np.arange(steps), case, "step")
    if FIELD_TIME in times:
        frames = case.frames(steps)
        _check_times(file[FIELD_TIME][:frames], case.step_of(np.arange(frames)), case, "frame")


def _ragged_groups(file: Any) -> list[str]:
    links = {name: file.get(name, getlink=True) for name in file}
    held = [name for name, link in links.items() if name != "modes" and isinstance(link, h5py.HardLink)]
    return [name for name in held if isinstance(file[name], h5py.Group)]


def _wake_names(group: Any) -> list[str]:
    """Variables of a file's wake."""
    return [name for name in WAKE_VARIABLES if name != WAKE_EDGE or name in group]


def _check_ragged(group: Any, name: str, frames: int) -> None:
    """Check that the arrays of a ragged group have one length that fits the counts of the frames."""
    integrity.array(group, "count", (frames,), "i")
    names = _wake_names(group) if name == "wake" else [one for one in group if one != "count"]
    lengths = {integrity.array(group, one, (None,), "if", whole=one in WAKE_VARIABLES) for one in names}
    if len(lengths) > 1:
        raise DamageError(f"the arrays of {name} have different lengths")


def _check_times(times: np.ndarray, steps: np.ndarray, case: Case, what: str) -> None:
    astray = np.flatnonzero(~(np.abs(times - case.step * steps) <= 1e-6 * case.duration))
    if len(astray):
        raise DamageError(f"{what} {astray[0]} has the time {times[astray[0]]:g} s")


def first_line(error: OSError) -> str:
    """The cause as reported by the system or HDF5."""
    return error.strerror or (os.strerror(error.errno) if error.errno else str(error).splitlines()[0])
