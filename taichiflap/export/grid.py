"""The flow of a result on a uniform grid: as VTKHDF for ParaView, and as netCDF, for example for xarray.

Both have the vorticity and the velocity of the fluid in every frame, NaN inside the section.

- VTKHDF: a temporal ImageData in the plane z = 0, where `vtkhdf` has the wing: x is Z and y is -Y, with a stream as
  well, or the chord and its normal in the wing's frame; point data `vorticity` (1/s) and `velocity` (m/s).
- netCDF: variables `vorticity`, `velocity_y` and `velocity_z` over time and both axes, `Y` and `Z`, or `y` and `z` from
  the pivot in the wing's frame; and `wing_y`, `wing_z`, the nodes.
"""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .. import files
from ..drawing import flow
from ..drawing.orientation import INERTIAL, Orientation, Standpoint
from ..results import hdf
from ..results.reader import Result
from .vtkhdf import UNITS, VERSION

Array = NDArray[np.float64]

ACROSS = 200
"""Points along the longer side."""
PLAIN = Orientation(1.0, 0.0)
"""An axis along Y and one along Z."""


class GridError(files.OutputError):
    """Raised for a result without a flow that could be sampled: one sentence with the cause."""


class Grid:
    """A grid for all frames of a result.

    Args:
        reference: the frame of reference in which it stands still.
        upright: whether its axes are Z and -Y, instead of Y and Z; without effect in the wing's frame.

    Attributes:
        along, up: its coordinates, m.

    Raises:
        GridError: when the result holds no vorticity.
    """

    def __init__(self, result: Result, reference: str, upright: bool) -> None:
        if not flow.stored(result):
            raise GridError(f"{result.case.model} stores no vorticity, so that it has none to export on a grid")
        self._result, self._reference = result, reference
        self._standing = None if reference != INERTIAL else Standpoint(Orientation() if upright else PLAIN)
        box = flow.extent(result, range(result.frames), reference).box
        if self._standing:
            corners = np.reshape([box[i] for i in (0, 1, 2, 1, 0, 3, 2, 3)], (4, 2))
            right, up = self._standing.vectors(*Orientation.of(result.case).off_page(corners)).T
            box = float(right.min()), float(up.min()), float(right.max()), float(up.max())
        self.box, self.shape = box, flow.shape_of(box, ACROSS)
        self.along, self.up = flow.middles(box, self.shape)

    def stand(self, index: int) -> Standpoint:
        """The frame of reference of a frame."""
        return self._standing or Standpoint.of(self._result, index, self._reference)

    def frames(self) -> Iterator[tuple[Array, Array]]:
        """Vorticity (up, along) and velocity (up, along, 2) of each frame, along the grid's axes."""
        for index in range(self._result.frames):
            found, stand = flow.field(self._result, index), self.stand(index)
            assert found is not None
            assert found.vorticity is not None
            places = flow.points(stand, self.box, self.shape)
            yield found.vorticity(places), stand.vectors(*found.velocity(places))


@contextlib.contextmanager
def _writing(path: Path) -> Iterator[tuple[Any, hdf.Guarded]]:
    with files.standing_in(path) as draft, contextlib.closing(hdf.Guarded(draft)) as guard:
        with h5py.File(guard, "w", track_order=True) as file:
            yield file, guard
        guard.check()


def _frames_of(place: Any, name: str, shape: tuple[int, ...], frames: int) -> Any:
    """A dataset for a variable, with one chunk per frame."""
    return place.create_dataset(
        name, (frames, *shape), "f4", chunks=(1, *shape), compression=1, shuffle=True, fillvalue=np.nan
    )


def write_flow(result: Result, path: Path, reference: str = INERTIAL) -> None:
    """Write all frames as a temporal ImageData.

    Raises:
        GridError: when the result holds no vorticity.
        OutputError: when the file cannot be written.
    """
    grid = Grid(result, reference, upright=True)
    rows, columns = grid.shape
    with _writing(path) as (file, guard):
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = VERSION
        root.attrs.create("Type", np.bytes_(b"ImageData"))
        root.attrs["WholeExtent"] = np.array([0, columns - 1, 0, rows - 1, 0, 0])
        root.attrs["Origin"] = np.array([grid.along[0], grid.up[0], 0.0])
        root.attrs["Spacing"] = np.array([grid.along[1] - grid.along[0], grid.up[1] - grid.up[0], 1.0])
        root.attrs["Direction"] = np.eye(3).ravel()
        data = root.create_group("PointData")
        spin = _frames_of(data, "vorticity", (1, rows, columns), result.frames)
        speed = _frames_of(data, "velocity", (1, rows, columns, 3), result.frames)
        spin.attrs["units"], speed.attrs["units"] = "s-1", "m s-1"
        for index, (vorticity, velocity) in enumerate(grid.frames()):
            guard.check()
            spin[index, 0] = vorticity
            speed[index, 0] = np.concatenate((velocity, np.zeros((rows, columns, 1))), axis=-1)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = result.frames
        steps["Values"] = result.field_time
        steps["Values"].attrs["units"] = UNITS["Values"]
        for name in data:
            steps[f"PointDataOffsets/{name}"] = np.arange(result.frames)


def write_netcdf(result: Result, path: Path, reference: str = INERTIAL) -> None:
    """Write all frames as netCDF-4.

    Raises:
        GridError: when the result holds no vorticity.
        OutputError: when the file cannot be written.
    """
    grid = Grid(result, reference, upright=False)
    first, second = ("Y", "Z") if reference == INERTIAL else ("y", "z")
    where = "inertial frame" if reference == INERTIAL else "from the pivot, in the wing's axes"
    axes = {
        "time": (result.field_time, "s", "time"),
        first: (grid.along, "m", f"{first}, {where}"),
        second: (grid.up, "m", f"{second}, {where}"),
        "node": (result.stations, "m", "chordwise position of the wing's nodes, from the pivot"),
    }
    with _writing(path) as (file, guard):
        hdf.note(file, {"Conventions": "CF-1.11", "title": result.case.title, "case": result.case.to_toml()})
        for name, (values, units, meaning) in axes.items():
            file.create_dataset(name, data=values).make_scale(name)
            hdf.note(file[name], {"units": units, "long_name": meaning})
        shape = grid.shape[::-1]
        over = ("time", first, second)
        meanings = {
            "vorticity": ("s-1", "vorticity of the fluid in the inertial frame, positive counter-clockwise"),
            "velocity_y": ("m s-1", f"velocity of the fluid in the inertial frame, along {first}"),
            "velocity_z": ("m s-1", f"velocity of the fluid in the inertial frame, along {second}"),
        }
        places = {name: _frames_of(file, name, shape, result.frames) for name in meanings}
        wing = {name: _frames_of(file, name, (len(result.stations),), result.frames) for name in ("wing_y", "wing_z")}
        for name, place in (places | wing).items():
            units, meaning = meanings.get(name, ("m", f"position of the wing's nodes along {name[-1]}"))
            hdf.note(place, {"units": units, "long_name": meaning})
            for position, axis in enumerate(over if name in places else ("time", "node")):
                place.dims[position].attach_scale(file[axis])
        for index, (vorticity, velocity) in enumerate(grid.frames()):
            guard.check()
            for place, values in zip(places.values(), (vorticity, velocity[..., 0], velocity[..., 1]), strict=True):
                place[index] = values.T
            node = grid.stand(index).places(*result.frame("node_position", index).T)
            wing["wing_y"][index], wing["wing_z"][index] = node.T
