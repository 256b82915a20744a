"""The map file: what came of every case of a design, in HDF5 that xarray and netCDF4 open as they are.

Besides the modules of the result file the only one that knows h5py. All room is laid out before the first case runs,
numbers are flushed before the status that vouches for them, and both after every batch: a crash at any moment costs
no more than the batch that was running.
"""

import math
import os
import time
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np

from . import intact
from ._version import __version__
from .case import Case, CaseError, parse_case
from .design import MOST_CASES, Axis, Design
from .errors import UserError
from .intact import DAMAGE, DamageError
from .problems import key_units
from .variables import VARIABLES, Variable

FORMAT = 1
"""Version of the layout; a reader refuses files of a newer one."""

TO_DO, COMPLETE, FAILED = range(3)
"""What `status` says of a case."""
FLAGS = np.array([TO_DO, COMPLETE, FAILED], "i1")

ATTRIBUTES = (
    "Conventions", "title", "source", "history", "taichiflap_map", "case", "keys", "grid", "metrics", "series",
    "state", "coordinates",
)  # fmt: skip
"""What a map says about itself."""
SAMPLE, FRAME = "sample", "frame"
SAMPLE_CHUNK = 1024
NO_COORDINATE = "This is a netCDF dimension but not a netCDF variable."
_TEXT = h5py.string_dtype()


class MapError(UserError):
    """A map file that cannot be read or written: one sentence with the path and the cause."""


@dataclass(frozen=True)
class Outcome:
    """What came of a case: its metrics and series by name, or the reason why it has none."""

    metrics: dict[str, float] = field(default_factory=dict)
    series: dict[str, np.ndarray] = field(default_factory=dict)
    reason: str = ""


class Map:
    """A map, open: `numbers` name cases of its design in C order.

    Attributes:
        case: the base case.
        design: which cases the map is of.
        metrics: names of the metrics.
        keeps_series: whether it holds time series too.
        title: what it is.
        version: of the taichiflap that began it.
    """

    def __init__(self, file: Any, path: Path | None) -> None:
        self.file, self.path = file, path
        self.case = _base_case(file, path)
        self.design = _read_design(file)
        self.metrics = intact.attribute(file, "metrics").split()
        self.keeps_series = bool(intact.attribute(file, "series"))
        self.title = str(intact.attribute(file, "title"))
        self.version = str(intact.attribute(file, "source")).rpartition(" ")[2]

    def __enter__(self) -> "Map":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; a map in memory is lost."""
        self.file.close()

    @property
    def status(self) -> np.ndarray:
        """`TO_DO`, `COMPLETE` or `FAILED` for every case, flat."""
        return self.file["status"][...].ravel()

    @property
    def pending(self) -> np.ndarray:
        """Numbers of the cases that have yet to run."""
        return np.flatnonzero(self.status == TO_DO)

    def values(self, metric: str) -> np.ndarray:
        """A metric over the map, shape `design.shape`; not-a-number where it has none."""
        return self.file[metric][...]

    def units(self, name: str) -> str:
        """Unit of a metric or of a key."""
        return str(self._words(name).get("units", ""))

    def outcomes(self, numbers: Sequence[int]) -> list[Outcome | None]:
        """For each of some cases its metrics, or why it has none; None if it has yet to run."""
        status = self.status
        columns = {name: self.values(name).ravel() for name in self.metrics}
        found: list[Outcome | None] = []
        for number in numbers:
            if status[number] == FAILED:
                place = np.unravel_index(number, self.design.shape)
                found.append(Outcome(reason=self._reason(place)))
            elif status[number] == COMPLETE:
                found.append(Outcome({name: float(column[number]) for name, column in columns.items()}))
            else:
                found.append(None)
        return found

    def _reason(self, place: tuple[Any, ...]) -> str:
        try:
            return intact.plain(self.file["reason"].asstr(errors="replace")[place])
        except DAMAGE:
            raise MapError(f"{self.path}: damaged: the reason of a failed case cannot be read") from None

    def record(self, numbers: Sequence[int], outcomes: Sequence[Outcome]) -> None:
        """Store what came of some cases, and flush it to the disk.

        Raises:
            MapError: when the disk refuses; the cases before are safe.
        """
        places = np.stack(np.unravel_index(np.asarray(numbers), self.design.shape), axis=1)
        try:
            for name in self.metrics:
                _scatter(self.file[name], places, [outcome.metrics.get(name, np.nan) for outcome in outcomes])
            for place, outcome in zip(map(tuple, places), outcomes, strict=True):
                if outcome.reason:
                    self.file["reason"][place] = outcome.reason
                for name, values in outcome.series.items():
                    self._keep(name, place, values)
            self.file.flush()
            _scatter(self.file["status"], places, [FAILED if outcome.reason else COMPLETE for outcome in outcomes])
            self.file.flush()
        except OSError as error:
            raise MapError(f"{self.path}: cannot be written: {_first_line(error)}") from None

    def extend(self, axes: Sequence[Axis]) -> range:
        """Add cases to the end of a sample; returns their numbers."""
        first = self.design.size
        last = first + len(axes[0].values)
        for name in (SAMPLE, "status", "reason", *self.metrics):
            self.file[name].resize(last, axis=0)
        self.file[SAMPLE][first:] = np.arange(first, last)
        for axis in axes:
            self.file[axis.key].resize(last, axis=0)
            self.file[axis.key][first:] = axis.values
        self.design = _read_design(self.file)
        return range(first, last)

    def finish(self) -> None:
        """Mark the map as complete."""
        self.file.attrs["state"] = "complete"
        self.file.flush()

    def to_xarray(self) -> Any:
        """The map as an `xarray.Dataset` in memory, with named coordinates and units.

        Raises:
            MapError: when xarray is not installed.
        """
        try:
            import xarray  # noqa: PLC0415 - an optional extra
        except ImportError:
            raise MapError('an xarray.Dataset needs xarray: pip install "taichiflap[xarray]"') from None
        dimensions = _dimensions(self.design)
        keys = [axis.key for axis in self.design.axes]
        coordinates = {name: (self._over(name, dimensions), *self._described(name)) for name in keys}
        if not self.design.grid:
            coordinates[SAMPLE] = ((SAMPLE,), *self._described(SAMPLE))
        kept = [name for name in ("time", *VARIABLES) if name in self.file and name not in self.metrics]
        variables = {name: (dimensions, *self._described(name)) for name in (*self.metrics, "status", "reason")} | {
            name: ((*dimensions, FRAME), *self._described(name)) for name in kept
        }
        return xarray.Dataset(variables, coordinates, intact.attributes(self.file, ATTRIBUTES))

    def _over(self, key: str, dimensions: tuple[str, ...]) -> tuple[str, ...]:
        return (key,) if self.design.grid else dimensions

    def _described(self, name: str) -> tuple[np.ndarray, dict[str, Any]]:
        dataset = self.file[name]
        values = dataset.asstr()[...] if h5py.check_string_dtype(dataset.dtype) else dataset[...]
        flags = {"flag_values": FLAGS} if name == "status" else {}
        return values, self._words(name) | flags

    def _words(self, name: str) -> dict[str, Any]:
        return intact.attributes(self.file[name], ("units", "long_name", "symbol", "comment", "flag_meanings"))

    def _keep(self, name: str, place: tuple[int, ...], values: np.ndarray) -> None:
        shape = self.design.shape
        if FRAME not in self.file:
            axis = self.file.create_dataset(FRAME, (0,), "f4", maxshape=(None,), chunks=(1024,))
            axis.make_scale(NO_COORDINATE)
        if len(self.file[FRAME]) < len(values):
            self.file[FRAME].resize(len(values), axis=0)
        if name not in self.file:
            dataset = self.file.create_dataset(
                name, (*shape, len(values)), "f8", maxshape=(*shape, None), fillvalue=np.nan,
                chunks=(*(1 for _ in shape), max(1, len(values))), compression=1, shuffle=True,
            )  # fmt: skip
            variable = VARIABLES.get(name, Variable((), "s", "time", "t"))
            _describe(self.file, dataset, variable, (*_dimensions(self.design), FRAME))
        dataset = self.file[name]
        if dataset.shape[-1] < len(values):
            for kept in ("time", *VARIABLES):
                if kept in self.file:
                    self.file[kept].resize(len(values), axis=len(shape))
        dataset[(*place, slice(len(values)))] = values


def create(
    path: Path | None,
    case: Case,
    design: Design,
    metrics: Mapping[str, Variable],
    *,
    series: bool = False,
    title: str = "",
) -> Map:
    """A new map with all cases to do; in memory if `path` is None. An existing file is replaced.

    Raises:
        MapError: when the file cannot be created.
    """
    file = _create(path)
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    file.attrs.update(
        {
            "Conventions": "CF-1.11",
            "title": title or case.title,
            "source": f"taichiflap {__version__}",
            "history": f"{now} begun with taichiflap {__version__}",
            "taichiflap_map": FORMAT,
            "case": case.to_toml(),
            "keys": " ".join(axis.key for axis in design.axes),
            "grid": int(design.grid),
            "metrics": " ".join(metrics),
            "series": int(series),
            "state": "running",
        }
    )
    if not design.grid:
        file.attrs["coordinates"] = file.attrs["keys"]
        axis = file.create_dataset(SAMPLE, data=np.arange(design.size), maxshape=(None,), chunks=(SAMPLE_CHUNK,))
        axis.make_scale(SAMPLE)
    for axis in design.axes:
        _lay_axis(file, axis, design.grid)
    statuses = file.create_dataset("status", **_room(design, "i1", TO_DO))
    statuses.attrs["flag_values"] = FLAGS
    statuses.attrs["flag_meanings"] = "to_do complete failed"
    dimensions = _dimensions(design)
    _describe(file, statuses, Variable((), "", "what came of the case"), dimensions)
    reasons = file.create_dataset("reason", **_room(design, _TEXT, ""))
    _describe(file, reasons, Variable((), "", "why a failed case has no metrics"), dimensions)
    for name, variable in metrics.items():
        _describe(file, file.create_dataset(name, **_room(design, "f8", np.nan)), variable, dimensions)
    file.flush()
    return Map(file, path)


def open_map(path: str | Path, *, write: bool = False) -> Map:
    """Open a map file, complete or not; with `write` to add what is missing.

    Raises:
        MapError: when it is missing, damaged, of another kind, of a newer version, or being written by another.
    """
    path = Path(path)
    try:
        file = h5py.File(path, "r+") if write else h5py.File(path, "r", locking=False)
    except FileNotFoundError:
        raise MapError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise MapError(f"{path}: is a directory") from None
    except BlockingIOError:
        raise MapError(f"{path}: another study is writing it") from None
    except OSError as error:
        raise MapError(f"{path}: not a readable map: {_first_line(error)}") from None
    try:
        if "taichiflap_map" not in file.attrs:
            raise MapError(f"{path}: an HDF5 file, but not a map of taichiflap")
        version = intact.attribute(file, "taichiflap_map")
        if version > FORMAT:
            raise MapError(f"{path}: written by a newer taichiflap (format {version}, this one reads {FORMAT})")
        _check(file)
        opened = Map(file, path)
    except MapError:
        file.close()
        raise
    except DAMAGE as error:
        file.close()
        raise MapError(f"{path}: damaged: {error}") from None
    return opened


def is_map(path: Path) -> bool:
    """Whether a file is a map, and not a result."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            return "taichiflap_map" in file.attrs
    except DAMAGE:
        return False


def _check(file: Any) -> None:
    """Refuse a file that a reader could trip over.

    Raises:
        DamageError: when something is missing, cut off, elsewhere or of an impossible size.
    """
    said = {name: intact.attribute(file, name) for name in ("title", "source", "keys", "metrics", "grid", "series")}
    keys, grid = said["keys"].split(), bool(said["grid"])
    lengths = tuple(intact.array(file, key, (None,), "ifO", whole=False)[0] for key in keys)
    shape = lengths if grid else lengths[:1]
    if not keys or math.prod(shape) > MOST_CASES or (not grid and len(set(lengths)) > 1):
        raise DamageError(f"a design of {' x '.join(map(str, lengths))} cases")
    intact.array(file, "status", shape, "i", whole=False)
    intact.array(file, "reason", shape, "O", whole=False)
    for name in said["metrics"].split():
        intact.array(file, name, shape, "f", whole=False)
    for name in ("time", *VARIABLES):
        if name in file:
            intact.array(file, name, (*shape, None), "f", whole=False)
    if not grid:
        intact.array(file, SAMPLE, shape, "i", whole=False)


def _create(path: Path | None) -> Any:
    if path is None:
        return h5py.File(f"map in memory {time.monotonic_ns()}", "w", driver="core", backing_store=False)
    if path.is_dir():
        raise MapError(f"{path}: is a directory; name a file, for example {path / 'map.h5'}")
    try:
        return h5py.File(path, "w")
    except BlockingIOError:
        raise MapError(f"{path}: another study is writing it") from None
    except OSError as error:
        raise MapError(f"{path}: cannot be created: {_first_line(error)}") from None


def _room(design: Design, kind: Any, fill: Any) -> dict[str, Any]:
    room = {"shape": design.shape, "dtype": kind, "fillvalue": fill}
    if not design.grid:
        room |= {"maxshape": (None,), "chunks": (SAMPLE_CHUNK,)}
    return room


def _dimensions(design: Design) -> tuple[str, ...]:
    return tuple(axis.key for axis in design.axes) if design.grid else (SAMPLE,)


def _lay_axis(file: Any, axis: Axis, grid: bool) -> None:
    values = np.array(axis.values) if axis.numeric else np.array(axis.values, dtype=object)
    growth = {} if grid else {"maxshape": (None,), "chunks": (SAMPLE_CHUNK,)}
    dataset = file.create_dataset(axis.key, data=values, dtype=None if axis.numeric else _TEXT, **growth)
    if grid:
        dataset.make_scale(axis.key)
    else:
        dataset.dims[0].attach_scale(file[SAMPLE])
    units, text = key_units(axis.key, Case)
    dataset.attrs.update({name: value for name, value in (("units", units), ("long_name", text)) if value})


def _describe(file: Any, dataset: Any, variable: Variable, dimensions: Sequence[str]) -> None:
    words = {name: getattr(variable, name) for name in ("units", "long_name", "symbol", "comment")}
    dataset.attrs.update({name: text for name, text in words.items() if text})
    for position, name in enumerate(dimensions):
        dataset.dims[position].attach_scale(file[name])


def _scatter(dataset: Any, places: np.ndarray, values: Sequence[float]) -> None:
    """Write single points in one call; h5py's own indexing takes one a call."""
    space = dataset.id.get_space()
    space.select_elements(places.astype(np.uint64))
    dataset.id.write(h5py.h5s.create_simple((len(values),)), space, np.array(values, dataset.dtype))


def _base_case(file: Any, path: Path | None) -> Case:
    try:
        return parse_case(tomllib.loads(intact.attribute(file, "case")), str(path))
    except CaseError as error:
        raise MapError(f"{path}: the case inside it is not valid: {error.problems[0]}") from None


def _read_design(file: Any) -> Design:
    axes = []
    for key in intact.attribute(file, "keys").split():
        text = h5py.check_string_dtype(file[key].dtype)
        axes.append(
            Axis(
                key,
                tuple(map(intact.plain, file[key].asstr(errors="replace")[...]) if text else file[key][...].tolist()),
            )
        )
    return Design(tuple(axes), bool(intact.attribute(file, "grid")))


def _first_line(error: OSError) -> str:
    return error.strerror or (os.strerror(error.errno) if error.errno else str(error).splitlines()[0])
