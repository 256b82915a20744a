"""Layout of a result file: everything has its full length from the start."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import h5py
import numpy as np

from .._version import __version__
from ..case.case import Case
from ..structure.beam import Modes
from . import hdf
from .reader import FIGURES, FORMAT
from .variables import (
    AXES,
    AXES_OF,
    COMPONENTS,
    FIELD_TIME,
    MODE_VARIABLES,
    NO_COORDINATE,
    VARIABLES,
    Variable,
    count_of,
)

WARNING_BYTES = 512
"""Space reserved for warnings that arise at the end of a run, bytes."""
LARGE = 2**14
"""Size of a frame, in bytes, from which on a field is compressed in a finished file."""
LEVEL = 1
"""Level of the compression; higher levels take twice the time for 5 %."""

Sample = Mapping[str, np.ndarray]
"""Variables for any number of frames, including zero; defines the shape of a frame."""


@dataclass(frozen=True)
class Contents:
    """What a run adds to the file of a case beyond the variables of every model.

    Attributes:
        outputs: stored variables of the fluid model, by name; ragged ones are named `GROUP/NAME`.
        axes: values and descriptions of its additional axes.
        room: length of every ragged axis.
        nearest: function that returns the scored cases nearest to the case, as text.
    """

    outputs: Mapping[str, Variable] = field(default_factory=dict)
    axes: Mapping[str, tuple[np.ndarray, Variable]] = field(default_factory=dict)
    room: Mapping[str, int] = field(default_factory=dict)
    nearest: Callable[[], str] = str


def plan(sample: Sample, contents: Contents) -> dict[str, Variable]:
    """Variables over time of a file: the common ones that are not empty, then the fluid model's own."""
    own = {name: one for name, one in VARIABLES.items() if name in sample} | dict(contents.outputs)
    return {name: one for name, one in own.items() if "/" in name or np.prod(sample[name].shape[1:])}


def size(case: Case, sample: Sample, contents: Contents) -> int:
    """Size of the variables of a case, bytes."""
    total = 0
    for name, one in plan(sample, contents).items():
        ragged = "/" in name
        rows = contents.room[one.dimensions[0]] if ragged else case.frames() if one.field else case.steps + 1
        items = 1 if ragged else int(np.prod(sample[name].shape[1:]))
        total += rows * items * np.dtype(one.dtype).itemsize
    return total


def large(sample: Sample, contents: Contents) -> list[str]:
    """Fields that are compressed in a finished file."""
    return [
        name
        for name, one in plan(sample, contents).items()
        if one.field and np.dtype(one.dtype).itemsize * np.prod(sample[name].shape[1:]) >= LARGE
    ]


def groups(plan: Mapping[str, Variable]) -> list[str]:
    """Ragged groups of a plan."""
    return list(dict.fromkeys(name.partition("/")[0] for name in plan if "/" in name))


def times(case: Case) -> tuple[str, ...]:
    """Time axes of a case: that of the steps, and that of the frames if they differ."""
    return ("time",) if case.output.every == 1 else ("time", FIELD_TIME)


def rows(case: Case) -> dict[str, int]:
    """Length of the time axes."""
    return {"time": case.steps + 1, FIELD_TIME: case.frames()}


def axes(nodes: np.ndarray, section: Modes, contents: Contents) -> dict[str, tuple[np.ndarray, Variable]]:
    """Values and description of every axis except time and ragged axes."""
    found = {
        "mode": np.arange(1, section.count + 1),
        "node": nodes,
        "panel": 0.5 * (nodes[1:] + nodes[:-1]),
        "component": np.array(COMPONENTS, dtype=object),  # for other programs; `Result` has its own
    }
    return {name: (values, AXES[name]) for name, values in found.items() if len(values)} | dict(contents.axes)


def modes(nodes: np.ndarray, section: Modes) -> dict[str, np.ndarray]:
    """Arrays of the group of modes; empty for a rigid wing."""
    if not section.count:
        return {}
    return {
        "frequency": section.frequency,
        "damping_ratio": section.damping_ratio,
        "lambda": section.lam,
        "psi": section.psi,
        "shape": section.shape(nodes),
    }


def words(case: Case, began: float, contents: Contents) -> dict[str, str]:
    """Attributes of a result known from the start.

    Args:
        began: start time, in seconds since the epoch.
    """
    when = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(began))
    return {
        "Conventions": "CF-1.11",
        "title": case.title,
        "source": f"taichiflap {__version__}",
        "history": f"{when} computed with taichiflap {__version__}",
        "case": case.to_toml(),
        "nearest_scored": contents.nearest(),
    }


class Layout:
    """Allocates all arrays of a case in an empty file.

    Args:
        file: file open for writing.
        case: the case being computed.
        began: start time, in seconds since the epoch.
        warnings: warnings about the case.
        nodes: chordwise positions of the nodes, m.
        section: the wing's modes.
        sample: the variables, see `Sample`.
        contents: arrays that the fluid model adds.
        packed: fields to compress, a chunk per frame; their space is allocated when they are written.
    """

    def __init__(
        self, file: Any, case: Case, began: float, warnings: list[str], nodes: np.ndarray, section: Modes,
        sample: Sample, contents: Contents, packed: Sequence[str] = (),
    ) -> None:  # fmt: skip
        self._file = file
        self._packed = packed
        self._every = case.output.every
        self._rows = rows(case)
        self._axes: dict[str, Any] = {}
        self._describe(case, began, warnings, contents)
        for name in times(case):
            self._make_axis(name, _place(file, name, (self._rows[name],), "f8"), AXES[name])
        for name, (values, meaning) in axes(nodes, section, contents).items():
            self._make_axis(name, file.create_dataset(name, data=values), meaning)
        for name, values in modes(nodes, section).items():
            self._attach(file.require_group("modes").create_dataset(name, data=values), MODE_VARIABLES[name])
        found = plan(sample, contents)
        for name, variable in found.items():
            if "/" not in name:
                self._lay_out_variable(name, variable, sample[name].shape[1:])
        for group in groups(found):
            members = {name.partition("/")[2]: one for name, one in found.items() if name.startswith(f"{group}/")}
            self._lay_out_ragged(group, members, contents.room)

    def _describe(self, case: Case, began: float, warnings: list[str], contents: Contents) -> None:
        hdf.note(self._file, words(case, began, contents))
        self._file.attrs.update({"taichiflap_format": FORMAT} | dict.fromkeys(FIGURES, np.nan))
        # With reserved space, so that they can be changed in place.
        warned = "\n".join(warnings)
        hdf.note(self._file, {"warnings": warned}, len(warned.encode()) + WARNING_BYTES)
        hdf.note(self._file, {"status": "running"}, len("complete"))
        hdf.note(self._file, {"reason": ""}, hdf.REASON_BYTES)

    def _lay_out_variable(self, name: str, variable: Variable, shape: tuple[int, ...]) -> None:
        axes = variable.axes(self._every)
        whole = (self._rows[axes[0]], *shape)
        place = _pack if name in self._packed else _place
        self._attach(place(self._file, name, whole, variable.dtype), variable)
        if name not in VARIABLES:
            # Marks a variable of the fluid model for our reader.
            hdf.note(self._file[name], {AXES_OF: " ".join(axes)})

    def _lay_out_ragged(self, name: str, members: Mapping[str, Variable], room: Mapping[str, int]) -> None:
        group = self._file.create_group(name)
        (along,) = {one.dimensions[0] for one in members.values()}
        # In chunks that are never written, so that it takes no space.
        axis = group.create_dataset(along, (room[along],), "f4", chunks=(8192,), maxshape=(None,))
        axis.make_scale(NO_COORDINATE)
        self._axes[along] = axis
        for member, variable in members.items():
            # Future frames have no entries, whatever the disk contains there.
            placed = _place(group, member, (room[along],), variable.dtype, fill_time="never")
            self._attach(placed, variable)
        counted = count_of(name)
        count = _place(group, "count", (self._rows[counted.axes(self._every)[0]],), counted.dtype)
        self._attach(count, counted)
        hdf.note(count, {"sample_dimension": along})

    def _make_axis(self, name: str, dataset: Any, meaning: Variable) -> None:
        dataset.make_scale(name)
        hdf.note(dataset, meaning.attributes)
        self._axes[name] = dataset

    def _attach(self, dataset: Any, variable: Variable) -> None:
        hdf.note(dataset, variable.attributes)
        for position, name in enumerate(variable.axes(self._every)):
            dataset.dims[position].attach_scale(self._axes[name])


def _place(group: Any, name: str, shape: tuple[int, ...], kind: str, **fill: Any) -> Any:
    """A contiguous dataset, allocated and filled at once with NaN (0 for integers)."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    fill = fill or {"fillvalue": 0 if kind.startswith("i") else np.nan}
    return group.create_dataset(name, shape, kind, dcpl=properties, **fill)


def _pack(group: Any, name: str, shape: tuple[int, ...], kind: str) -> Any:
    """A compressed dataset, a chunk per frame."""
    return group.create_dataset(
        name, shape, kind, chunks=(1, *shape[1:]), compression="gzip", compression_opts=LEVEL, shuffle=True
    )
