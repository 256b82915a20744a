"""The map file: metrics of every case of a design, in HDF5 that xarray and netCDF4 can open.

During a study the map is kept in memory and rewritten whenever outcomes are recorded, first under another name, so that
a crash or a full disk costs nothing that was recorded before. A large map is filled in place, values first and then the
status that marks them as valid.
"""

import contextlib
import os
import shutil
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np

from .. import disk
from ..case.case import Case, CaseError
from ..disk import Busy, Lock
from ..errors import UserError, extra
from ..notation import printable
from ..results import hdf, integrity
from ..results.integrity import DAMAGE
from ..results.reader import first_line, refuse_devices
from ..results.variables import VARIABLES, Variable
from . import layout
from .design import Axis, Design
from .layout import FRAME, SAMPLE
from .outcome import COMPLETE, FAILED, TO_DO, Outcome

ATTRIBUTES = (
    "Conventions", "title", "source", "history", "taichiflap_map", "case", "keys", "grid", "metrics", "series",
    "state", "coordinates",
)  # fmt: skip
"""Text attributes of a map."""


MOST_IMAGE = 2**26
"""Maximum size of a map that is rewritten as a whole, bytes."""
SPARE = 2**22
"""Disk space, in bytes, that must remain free when a map is filled in place."""


class MapError(UserError):
    """Raised for a map file that cannot be read or written; one sentence with the path and the cause."""


class Map:
    """An open map. Its methods take numbers of cases in C order.

    Attributes:
        case: the base case.
        design: the cases of the map.
        metrics: names of the metrics.
        keeps_series: whether it contains time series.
        title: its title.
        version: version of taichiflap that created it.
    """

    def __init__(self, file: Any, path: Path | None, lock: Lock | None = None) -> None:
        self.file, self.path, self._lock = file, path, lock
        self._guard: hdf.Guarded | None = None
        self._units: dict[str, str] = {}
        self._columns: dict[str, layout.Column] = {}
        try:
            self.case = layout.read_case(file, str(path))
        except CaseError as error:
            raise MapError(f"{path}: its case is invalid: {error.problems[0]}") from None
        self.design = layout.read_design(file)
        self.metrics = integrity.attribute(file, "metrics").split()
        self.keeps_series = bool(integrity.attribute(file, "series"))
        self.title = str(integrity.attribute(file, "title"))
        self.version = str(integrity.attribute(file, "source")).rpartition(" ")[2]

    def __enter__(self) -> "Map":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close the file. Unsaved data and maps in memory are lost."""
        self.file.close()
        if self._guard:
            self._guard.close()
        if self._lock:
            self._lock.release()

    def _repr_html_(self) -> str:
        from ..notebook import html  # noqa: PLC0415 - notebooks alone ask for it

        return html.of_map(self)

    @property
    def status(self) -> np.ndarray:
        """`TO_DO`, `COMPLETE` or `FAILED` for every case, flat."""
        return self.file["status"][...].ravel()

    @property
    def pending(self) -> np.ndarray:
        """Numbers of the cases that have yet to run."""
        return np.flatnonzero(self.status == TO_DO)

    def values(self, metric: str) -> np.ndarray:
        """A metric over the map, shape `design.shape`; NaN where undefined."""
        return self.file[metric][...]

    def units(self, name: str) -> str:
        """Unit of a metric or of a key."""
        if name not in self._units:
            self._units[name] = str(self._words(name).get("units", ""))
        return self._units[name]

    def outcomes(self, numbers: Sequence[int]) -> list[Outcome | None]:
        """Outcome of each of the given cases: its metrics or the reason of its failure; None if it has not run."""
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
            return printable(integrity.plain(self.file["reason"][place]))
        except DAMAGE:
            raise MapError(f"{self.path}: damaged: the reason of a failed case cannot be read") from None

    def record(self, numbers: Sequence[int], outcomes: Sequence[Outcome]) -> None:
        """Store the outcomes of some cases, and write them to the disk.

        Raises:
            MapError: if it cannot be written; earlier cases are safe.
        """
        flat = np.asarray(numbers)
        places = np.stack(np.unravel_index(flat, self.design.shape), axis=1)
        statuses = [FAILED if outcome.reason else COMPLETE for outcome in outcomes]
        nowhere = dict.fromkeys(self.metrics, np.nan)
        rows = np.array([[*map((nowhere | outcome.metrics).get, self.metrics)] for outcome in outcomes])
        try:
            self._check_room(outcomes)
            for name, values in zip(self.metrics, rows.T, strict=True):
                self._column(name).write(flat, values)
            for place, outcome in zip(map(tuple, places), outcomes, strict=True):
                if outcome.reason:
                    self.file["reason"][place] = outcome.reason.encode()[: hdf.REASON_BYTES]
                for name, series in outcome.series.items():
                    kept = layout.series_of(self.file, self.design, name, len(series))
                    kept[(*place, slice(len(series)))] = series
            self.file.flush()
            if self._guard:
                self._guard.sync()
            self._column("status").write(flat, np.array(statuses))
        except OSError as error:
            raise MapError(f"{self.path}: cannot be written: {first_line(error)}") from None
        self.save()

    def _column(self, name: str) -> "layout.Column":
        """The status or a metric, to be written."""
        if name not in self._columns:
            self._columns[name] = layout.Column(self.file, name, whole=self._guard is None)
        return self._columns[name]

    def extend(self, axes: Sequence[Axis]) -> range:
        """Add cases to the end of a sample; returns their numbers."""
        self._columns.clear()
        first = self.design.size
        last = first + len(axes[0].values)
        for name in (SAMPLE, "status", "reason", *self.metrics):
            self.file[name].resize(last, axis=0)
        self.file[SAMPLE][first:] = np.arange(first, last)
        for old, new in zip(self.design.axes, axes, strict=True):
            layout.lengthen(self.file[new.key], Axis(new.key, old.values + new.values))
        self.design = layout.read_design(self.file)
        return range(first, last)

    def finish(self) -> None:
        """Mark the map as complete.

        Raises:
            MapError: when the disk refuses.
        """
        hdf.rewrite(self.file, "state", "complete")
        self.save()

    def note(self, texts: Mapping[str, str]) -> None:
        """Store text attributes with the map.

        Raises:
            MapError: when the disk refuses.
        """
        hdf.note(self.file, texts)
        self.save()

    def save(self) -> None:
        """Write the map to the disk.

        Raises:
            MapError: if it cannot be written; the existing file remains.
        """
        if self.path is None:
            return
        draft = self.path.with_name(f".{self.path.name}.{os.getpid()}.part")
        try:
            self.file.flush()
            if self._guard:
                self._guard.check()
                return
            image = self.file.id.get_file_image()
            draft.write_bytes(image)
            disk.replace(draft, self.path)
        except OSError as error:
            raise MapError(f"{self.path}: cannot be written: {first_line(error)}") from None
        finally:
            with contextlib.suppress(OSError):
                draft.unlink(missing_ok=True)
        if len(image) > MOST_IMAGE:
            self._fill_in_place()

    def _fill_in_place(self) -> None:
        """Continue in the file itself."""
        assert self.path is not None
        self._columns.clear()
        self.file.close()
        try:
            self._guard = hdf.Guarded(self.path, fresh=False)
        except OSError as error:
            raise MapError(f"{self.path}: cannot be written: {first_line(error)}") from None
        self.file = h5py.File(self._guard, "r+", libver=hdf.VERSION)

    def _check_room(self, outcomes: Sequence[Outcome]) -> None:
        """Raise an error if the disk has too little space, before HDF5 starts to write."""
        if self._guard is None or self.path is None:
            return
        series = sum(values.nbytes for outcome in outcomes for values in outcome.series.values())
        free = shutil.disk_usage(self.path.parent).free
        if free < SPARE + series + 8 * len(outcomes) * (len(self.metrics) + hdf.REASON_BYTES):
            raise MapError(f"{self.path}: cannot be written: only {free / 1e6:.3g} MB are free on the disk")

    def to_xarray(self) -> Any:
        """The map as an `xarray.Dataset` in memory, with named coordinates and units.

        Raises:
            MapError: if xarray is not installed.
        """
        xarray = extra("xarray", "xarray", "an xarray.Dataset needs xarray", MapError)
        axes = layout.dimensions(self.design)
        coordinates = {
            axis.key: ((axis.key,) if self.design.grid else axes, np.array(axis.values), self._words(axis.key))
            for axis in self.design.axes
        }
        if not self.design.grid:
            coordinates[SAMPLE] = ((SAMPLE,), *self._described(SAMPLE))
        kept = [name for name in ("time", *VARIABLES) if name in self.file and name not in self.metrics]
        variables = {name: (axes, *self._described(name)) for name in (*self.metrics, "status", "reason")} | {
            name: ((*axes, FRAME), *self._described(name)) for name in kept
        }
        return xarray.Dataset(variables, coordinates, integrity.attributes(self.file, ATTRIBUTES))

    def _described(self, name: str) -> tuple[np.ndarray, dict[str, Any]]:
        dataset = self.file[name]
        values = dataset.asstr(errors="replace")[...] if dataset.dtype.kind == "S" else dataset[...]
        flags = {"flag_values": layout.FLAGS} if name == "status" else {}
        return values, self._words(name) | flags

    def _words(self, name: str) -> dict[str, Any]:
        return integrity.attributes(self.file[name], ("units", "long_name", "symbol", "comment", "flag_meanings"))


def create(
    path: Path | None,
    case: Case,
    design: Design,
    metrics: Mapping[str, Variable],
    *,
    series: bool = False,
    title: str = "",
) -> Map:
    """Create a map with no cases run yet; in memory if `path` is None. An existing file is replaced.

    The file gets its name only after its layout is complete.

    Raises:
        MapError: if the file cannot be created.
    """
    if path is None:
        file = hdf.create(f"map in memory {time.monotonic_ns()}", driver="core", backing_store=False)
        layout.lay_out(file, case, design, metrics, series, title or case.title)
        return Map(file, path)
    _check_place(path)
    lock = _lock(path)
    try:
        file = hdf.create(path, driver="core", backing_store=False)
        layout.lay_out(file, case, design, metrics, series, title or case.title)
        made = Map(file, path, lock)
        made.save()
    except BaseException:
        lock.release()
        raise
    return made


def open_map(path: str | Path, *, write: bool = False) -> Map:
    """Open a map file, complete or partial; with `write` missing cases can be added.

    Raises:
        MapError: if it is missing, damaged, not a map, of a newer version, or being written by another process.
    """
    path = Path(path)
    refuse_devices(path, MapError)
    lock = _lock(path) if write and path.is_file() else None
    try:
        opened = _opened(path, lock)
        if lock and path.stat().st_size > MOST_IMAGE:
            opened._fill_in_place()
    except BaseException:
        if lock:
            lock.release()
        raise
    return opened


def _opened(path: Path, lock: Lock | None) -> Map:
    """An open map; in memory, if it is locked."""
    try:
        writing = {"mode": "r+", "libver": hdf.VERSION, "driver": "core", "backing_store": False}
        file = h5py.File(path, **(writing if lock else {"mode": "r", "locking": False}))
    except FileNotFoundError:
        raise MapError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise MapError(f"{path}: is a directory") from None
    except OSError as error:
        raise MapError(f"{path}: not a readable map: {first_line(error)}") from None
    try:
        if "taichiflap_map" not in file.attrs:
            raise MapError(f"{path}: this HDF5 file is not a taichiflap map")
        version = integrity.attribute(file, "taichiflap_map")
        if version > layout.FORMAT:
            raise MapError(f"{path}: written by a newer taichiflap (format {version}, this one reads {layout.FORMAT})")
        layout.check(file)
        return Map(file, path, lock)
    except MapError:
        file.close()
        raise
    except DAMAGE as error:
        file.close()
        raise MapError(f"{path}: damaged: {error}") from None


def is_map(path: Path) -> bool:
    """Whether a file is a map instead of a result."""
    try:
        refuse_devices(Path(path), MapError)
        with h5py.File(path, "r", locking=False) as file:
            return "taichiflap_map" in file.attrs
    except DAMAGE:
        return False


def _check_place(path: Path) -> None:
    """Raise an error if a map cannot be created at a path. A file to be replaced may be of any kind."""
    if why := disk.trouble(path):
        raise MapError(f"{path}: {why}")
    if path.is_dir():
        raise MapError(f"{path}: is a directory; name a file, for example {path / 'map.h5'}")
    if not path.parent.is_dir():
        raise MapError(f"{path}: cannot be created: {path.parent} is not a folder")


def _lock(path: Path) -> Lock:
    try:
        return Lock(path)
    except Busy as error:
        raise MapError(f"{path}: another study is writing it ({error})") from None
    except OSError as error:
        raise MapError(f"{path}: cannot be written: {first_line(error)}") from None
