"""The result file, written: `NAME.part` in blocks of frames, flushed after each, and renamed when complete.

So a crash at any moment leaves something readable.
"""

import contextlib
import itertools
import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ._version import __version__
from .beam import Modes
from .case import Case
from .results import FORMAT, Result, ResultError, first_line, open_result, part
from .variables import AXES, MODE_VARIABLES, VARIABLES, WAKE_COUNT, WAKE_VARIABLES, Variable

NO_COORDINATE = "This is a netCDF dimension but not a netCDF variable."
"""What netCDF-4 calls a dimension scale that holds no values."""

SERIES_CHUNK, FIELD_CHUNK, WAKE_CHUNK = 1024, 64, 8192

_in_memory = itertools.count()


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

    def finish(self, status: str = "complete", **attributes: Any) -> Result:
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
        dataset.attrs.update(variable.attributes)
        for position, name in enumerate(variable.dimensions):
            scales = group if group is not None and name in group else self._file
            dataset.dims[position].attach_scale(scales[name])


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
        raise ResultError(f"{path}: cannot be created: {first_line(error)}") from None


def _make_axis(dataset: Any, name: str, variable: Variable) -> None:
    dataset.make_scale(name)
    dataset.attrs.update(variable.attributes)
