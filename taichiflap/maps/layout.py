"""Layout of a map in HDF5, readable by xarray and netCDF4: space for every case is allocated before the first run."""

import json
import math
import time
from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np

from .._version import __version__
from ..case.case import Case, held_case
from ..case.messages import key_units
from ..results import hdf, integrity
from ..results.integrity import DamageError
from ..results.variables import NO_COORDINATE, VARIABLES, Variable
from .design import MOST_CASES, Axis, Design
from .outcome import COMPLETE, FAILED, TO_DO

FORMAT = 1
"""Version of the layout; a reader refuses files of a newer one."""
FLAGS = np.array([TO_DO, COMPLETE, FAILED], "i1")
SAMPLE, FRAME = "sample", "frame"
SAMPLE_CHUNK = 1024


def lay_out(file: Any, case: Case, design: Design, metrics: Mapping[str, Variable], series: bool, title: str) -> None:
    """Lay out an empty map with no cases run yet."""
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    keys = " ".join(axis.key for axis in design.axes)
    hdf.note(
        file,
        {
            "Conventions": "CF-1.11",
            "title": title,
            "source": f"taichiflap {__version__}",
            "history": f"{now} begun with taichiflap {__version__}",
            "case": case.to_toml(),
            "keys": keys,
            "metrics": " ".join(metrics),
        },
    )
    hdf.note(file, {"state": "running"}, len("complete"))
    file.attrs.update({"taichiflap_map": FORMAT, "grid": int(design.grid), "series": int(series)})
    if not design.grid:
        hdf.note(file, {"coordinates": keys})
        axis = file.create_dataset(SAMPLE, data=np.arange(design.size), maxshape=(None,), chunks=(SAMPLE_CHUNK,))
        axis.make_scale(SAMPLE)
    for axis in design.axes:
        _lay_axis(file, axis, design.grid)
    statuses = file.create_dataset("status", **_room(design, "i1", TO_DO))
    statuses.attrs["flag_values"] = FLAGS
    hdf.note(statuses, {"flag_meanings": "to_do complete failed"})
    _describe(file, statuses, Variable((), "", "status of the case"), dimensions(design))
    # Without a fill value, since netCDF4 corrupts its memory when it reads that of a text.
    reasons = file.create_dataset("reason", **_room(design, hdf.text_type(hdf.REASON_BYTES), None))
    _describe(file, reasons, Variable((), "", "reason why the case failed"), dimensions(design))
    for name, variable in metrics.items():
        _describe(file, file.create_dataset(name, **_room(design, "f8", np.nan)), variable, dimensions(design))
    file.flush()


def series_of(file: Any, design: Design, name: str, frames: int) -> Any:
    """Dataset of a time series, with space for at least a number of frames of every case."""
    shape = design.shape
    if FRAME not in file:
        axis = file.create_dataset(FRAME, (0,), "f4", maxshape=(None,), chunks=(1024,))
        axis.make_scale(NO_COORDINATE)
    if len(file[FRAME]) < frames:
        file[FRAME].resize(frames, axis=0)
    if name not in file:
        dataset = file.create_dataset(
            name, (*shape, frames), "f8", maxshape=(*shape, None), fillvalue=np.nan,
            chunks=(*(1 for _ in shape), max(1, frames)), compression=1, shuffle=True,
        )  # fmt: skip
        variable = VARIABLES.get(name, Variable((), "s", "time", "t"))
        _describe(file, dataset, variable, (*dimensions(design), FRAME))
    if file[name].shape[-1] < frames:
        for kept in ("time", *VARIABLES):
            if kept in file:
                file[kept].resize(frames, axis=len(shape))
    return file[name]


def check(file: Any) -> None:
    """Raise an error for a file that is not a valid map.

    Raises:
        DamageError: if something is missing, truncated, stored elsewhere or of an invalid size.
    """
    said = {name: integrity.attribute(file, name) for name in ("title", "source", "keys", "metrics", "grid", "series")}
    keys, grid = said["keys"].split(), bool(said["grid"])
    lengths = tuple(integrity.array(file, key, (None,), "ifO", whole=False)[0] for key in keys)
    shape = lengths if grid else lengths[:1]
    if not keys or math.prod(shape) > MOST_CASES or (not grid and len(set(lengths)) > 1):
        raise DamageError(f"a design of {' x '.join(map(str, lengths))} cases")
    integrity.array(file, "status", shape, "i", whole=False)
    integrity.array(file, "reason", shape, "S", whole=False)
    for name in said["metrics"].split():
        integrity.array(file, name, shape, "f", whole=False)
    for name in ("time", *VARIABLES):
        if name in file:
            integrity.array(file, name, (*shape, None), "f", whole=False)
    if not grid:
        integrity.array(file, SAMPLE, shape, "i", whole=False)


def read_case(file: Any, source: str) -> Case:
    """The base case.

    Raises:
        CaseError: if it is no longer valid.
    """
    return held_case(integrity.attribute(file, "case"), source)


def read_design(file: Any) -> Design:
    """Design of a checked file.

    Raises:
        DamageError: if an axis of text has labels that do not match its entries.
    """
    keys = integrity.attribute(file, "keys").split()
    axes = tuple(Axis(key, tuple(_axis_values(key, file[key]))) for key in keys)
    return Design(axes, bool(integrity.attribute(file, "grid")))


def _axis_values(key: str, dataset: Any) -> list[Any]:
    if dataset.dtype.kind != "O":
        values: list[Any] = dataset[...].tolist()
        return values
    labels = json.loads(integrity.attribute(dataset, "labels"))
    if (
        not isinstance(labels, list)
        or len(labels) != len(dataset)
        or not all(isinstance(one, str) and one.isprintable() for one in labels)
    ):
        raise DamageError(f"labels of {key} do not match its entries")
    return labels


def lengthen(dataset: Any, axis: Axis) -> None:
    """Give the dataset of a sample's key the values of a longer axis."""
    dataset.resize(len(axis.values), axis=0)
    dataset[...] = axis.values
    if not axis.numeric:
        hdf.note(dataset, {"labels": _labels(axis)})


def dimensions(design: Design) -> tuple[str, ...]:
    """Names of a map's dimensions."""
    return tuple(axis.key for axis in design.axes) if design.grid else (SAMPLE,)


class Column:
    """A dataset with a number of every case, of which some are written at a time.

    Args:
        whole: whether all of it is kept here and written every time, as to write points takes long; for a file in
            memory.
    """

    def __init__(self, file: Any, name: str, whole: bool) -> None:
        dataset = file[name]
        self.name, self._dataset, self._shape, self._type = name, dataset.id, dataset.shape, dataset.dtype
        self._values = np.ascontiguousarray(dataset[...]) if whole else None

    def write(self, numbers: np.ndarray, values: np.ndarray) -> None:
        """Write the values of the cases with these numbers."""
        values = np.ascontiguousarray(values, self._type)
        if self._values is not None:
            self._values.reshape(-1)[numbers] = values
            self._dataset.write(h5py.h5s.ALL, h5py.h5s.ALL, self._values)
            return
        # h5py's indexing needs one call per point.
        space = self._dataset.get_space()
        space.select_elements(np.stack(np.unravel_index(numbers, self._shape), axis=1).astype(np.uint64))
        self._dataset.write(h5py.h5s.create_simple((len(values),)), space, values)


def _room(design: Design, kind: Any, fill: Any) -> dict[str, Any]:
    room = {"shape": design.shape, "dtype": kind, "fillvalue": fill}
    if not design.grid:
        room |= {"maxshape": (None,), "chunks": (SAMPLE_CHUNK,)}
    return room


def _lay_axis(file: Any, axis: Axis, grid: bool) -> None:
    values = np.array(axis.values, dtype=None if axis.numeric else h5py.string_dtype())
    growth = {} if grid else {"maxshape": (None,), "chunks": (SAMPLE_CHUNK,)}
    dataset = file.create_dataset(axis.key, data=values, **growth)
    if grid:
        dataset.make_scale(axis.key)
    else:
        dataset.dims[0].attach_scale(file[SAMPLE])
    units, text = key_units(axis.key, Case)
    words = (("units", units), ("long_name", text), ("labels", _labels(axis)))
    hdf.note(dataset, {name: value for name, value in words if value})


def _labels(axis: Axis) -> str:
    """Text entries as a text of fixed length, which our reader uses; the entries are for other programs."""
    return "" if axis.numeric else json.dumps(axis.values)


def _describe(file: Any, dataset: Any, variable: Variable, names: Sequence[str]) -> None:
    hdf.note(dataset, variable.attributes)
    for position, name in enumerate(names):
        dataset.dims[position].attach_scale(file[name])
