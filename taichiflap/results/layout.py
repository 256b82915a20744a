"""What stands where in a result file: everything at its full length, from the start."""

import time
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

from .._version import __version__
from ..case.case import Case
from ..structure.beam import Modes
from . import hdf
from .reader import FORMAT
from .variables import (
    AXES,
    COMPONENTS,
    MODE_VARIABLES,
    NO_COORDINATE,
    VARIABLES,
    WAKE_COUNT,
    WAKE_VARIABLES,
    Variable,
)

WARNING_BYTES = 512
"""Room for what turns out to be implausible in the end."""

Sample = Mapping[str, np.ndarray]
"""The variables of any number of frames, none included: it gives the shape of a frame."""


def size(case: Case, sample: Sample, vortices: int) -> int:
    """Bytes that the frames of a case take."""
    return frames(case) * sum(_row_bytes(name, sample) for name in VARIABLES) + 16 * vortices


def frames(case: Case) -> int:
    """Frames of a whole run."""
    return case.steps // case.output.every + 1


class Layout:
    """Gives everything of a case its place in an empty file.

    Args:
        file: open for writing.
        case: what is being computed.
        warnings: what makes the case implausible.
        nodes: chordwise positions of the nodes, m.
        section: the wing's modes.
        sample: the variables, see `Sample`.
        vortices: sum over all frames of the number of wake vortices.
    """

    def __init__(
        self, file: Any, case: Case, warnings: list[str], nodes: np.ndarray, section: Modes, sample: Sample,
        vortices: int,
    ) -> None:  # fmt: skip
        self._file = file
        self._axes: dict[str, Any] = {}
        count = frames(case)
        self._describe(case, warnings)
        self._lay_out_axes(count, nodes, section)
        for name, variable in VARIABLES.items():
            if name in sample and np.prod(sample[name].shape[1:]):
                self._lay_out_variable(name, variable, (count, *sample[name].shape[1:]))
        if "wake_count" in sample:
            self._lay_out_wake(count, vortices)

    def _describe(self, case: Case, warnings: list[str]) -> None:
        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        hdf.note(
            self._file,
            {
                "Conventions": "CF-1.11",
                "title": case.title,
                "source": f"taichiflap {__version__}",
                "history": f"{now} computed with taichiflap {__version__}",
                "case": case.to_toml(),
            },
        )
        self._file.attrs.update({"taichiflap_format": FORMAT, "solve_time": np.nan})
        # With room, so that they too change where they stand.
        warned = "\n".join(warnings)
        hdf.note(self._file, {"warnings": warned}, len(warned.encode()) + WARNING_BYTES)
        hdf.note(self._file, {"status": "running"}, len("complete"))
        hdf.note(self._file, {"reason": ""}, hdf.REASON_BYTES)

    def _lay_out_axes(self, frames: int, nodes: np.ndarray, section: Modes) -> None:
        self._make_axis("time", _place(self._file, "time", (frames,), "f8", fillvalue=np.nan))
        axes = {
            "mode": np.arange(1, section.count + 1),
            "node": nodes,
            "panel": 0.5 * (nodes[1:] + nodes[:-1]),
            "component": np.array(COMPONENTS, dtype=object),  # for others: a `Result` knows them
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
        hdf.note(count, {"sample_dimension": "vortex"})

    def _make_axis(self, name: str, dataset: Any) -> None:
        dataset.make_scale(name)
        hdf.note(dataset, AXES[name].attributes)
        self._axes[name] = dataset

    def _attach(self, dataset: Any, variable: Variable) -> None:
        hdf.note(dataset, variable.attributes)
        for position, name in enumerate(variable.dimensions):
            dataset.dims[position].attach_scale(self._axes[name])


def _place(group: Any, name: str, shape: tuple[int, ...], kind: str, **fill: Any) -> Any:
    """A dataset in one piece whose room is reserved, and filled, at once."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return group.create_dataset(name, shape, kind, dcpl=properties, **fill)


def _row_bytes(name: str, sample: Mapping[str, np.ndarray]) -> int:
    """Bytes of a frame of a variable."""
    items = int(np.prod(sample[name].shape[1:])) if name in sample else 0
    return items * (4 if VARIABLES[name].single else 8)
