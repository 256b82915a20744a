"""Results for ParaView and VTK: a temporal PolyData in VTK's own HDF5 dialect.

Only `taichiflap.results` reads and writes our files, and only this module writes VTK's.

Each frame is one piece: the wake as vertices, then the wing as one line per panel. The page of
`taichiflap.drawing.scene` is the plane z = 0, so x is Z, y is -Y and up is up.

- Point data: `circulation` (m2/s), `age` (s) and `edge` (1: shed by the leading edge, 0: by the trailing edge) of the
  wake vortices, zero on the wing.
- Cell data: `pressure_jump` (Pa) of the panels, zero on the wake; `wing`, 1 on the panels and 0 on the wake.
"""

import contextlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .. import files
from ..drawing.orientation import Orientation
from ..results import hdf
from ..results.reader import Result

VERSION = (2, 2)
TOPOLOGIES = ("Vertices", "Lines", "Polygons", "Strips")
BLOCK = 64
"""Frames between two writes."""
CHUNK = 16384
UNITS = {"Points": "m", "circulation": "m2 s-1", "age": "s", "pressure_jump": "Pa", "wing": "1", "Values": "s"}


def write_vtkhdf(result: Result, path: Path) -> None:
    """Write all frames.

    Raises:
        OutputError: when the file cannot be written.
    """
    with (
        files.standing_in(path) as draft,
        contextlib.closing(hdf.Guarded(draft)) as guard,
        h5py.File(guard, "w") as file,
    ):
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = VERSION
        root.attrs.create("Type", np.bytes_(b"PolyData"))
        for first in range(0, result.frames, BLOCK):
            guard.check()
            pieces = [_piece(result, index) for index in range(first, min(first + BLOCK, result.frames))]
            for name in pieces[0]:
                _extend(root, name, np.concatenate([piece[name] for piece in pieces]))
        _describe_steps(root, result)
        file.close()
        guard.check()


def _piece(result: Result, index: int) -> dict[str, NDArray[Any]]:
    """Datasets of one frame, by their paths in the file."""
    wake = result.wake(index)
    nodes = result.frame("node_position", index)
    vortices, panels = len(wake["y"]), len(nodes) - 1
    points = np.zeros((vortices + panels + 1, 3), "f4")
    points[:vortices, :2] = Orientation().on_page(wake["y"], wake["z"])
    points[vortices:, :2] = Orientation().on_page(nodes[:, 0], nodes[:, 1])
    step = round(float(result.frame("time", index)) / result.case.step)
    left = np.arange(vortices, vortices + panels)
    cells = {
        "Vertices": (np.arange(vortices), np.arange(vortices + 1)),
        "Lines": (np.stack((left, left + 1), axis=1).ravel(), 2 * np.arange(panels + 1)),
        "Polygons": (np.empty(0, int), np.zeros(1, int)),
        "Strips": (np.empty(0, int), np.zeros(1, int)),
    }
    piece = {"NumberOfPoints": np.array([len(points)]), "Points": points}
    for name, (connectivity, offsets) in cells.items():
        piece[f"{name}/NumberOfCells"] = np.array([len(offsets) - 1])
        piece[f"{name}/NumberOfConnectivityIds"] = np.array([len(connectivity)])
        piece[f"{name}/Connectivity"] = connectivity
        piece[f"{name}/Offsets"] = offsets
    on_wing, on_wake = np.zeros(panels + 1, "f4"), np.zeros(vortices, "f4")
    piece["PointData/circulation"] = np.concatenate((wake["circulation"], on_wing)).astype("f4")
    piece["PointData/edge"] = np.concatenate((wake["edge"], on_wing)).astype("f4")
    piece["PointData/age"] = np.concatenate(((step - wake["birth"]) * result.case.step, on_wing)).astype("f4")
    piece["CellData/pressure_jump"] = np.concatenate((on_wake, result.frame("pressure_jump", index)))
    piece["CellData/wing"] = np.repeat(np.array([0, 1], "u1"), (vortices, panels))
    return piece


def _extend(root: Any, name: str, values: NDArray[Any]) -> None:
    if name not in root:
        kind = "i8" if values.dtype.kind == "i" else values.dtype
        shape = values.shape[1:]
        root.create_dataset(
            name, (0, *shape), kind, maxshape=(None, *shape), chunks=(CHUNK, *shape), compression=1, shuffle=True
        )
        unit = UNITS.get(name.rpartition("/")[2])
        if unit:
            root[name].attrs["units"] = unit
    dataset = root[name]
    dataset.resize(len(dataset) + len(values), axis=0)
    dataset[len(dataset) - len(values) :] = values


def _describe_steps(root: Any, result: Result) -> None:
    """Write the offset of each frame in the flat datasets."""
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = result.frames
    steps["Values"] = result.field_time
    steps["Values"].attrs["units"] = UNITS["Values"]
    steps["PartOffsets"] = np.arange(result.frames)
    steps["NumberOfParts"] = np.ones(result.frames, "i8")
    points = _starts(root["NumberOfPoints"][...])
    cells = np.stack([_starts(root[name]["NumberOfCells"][...]) for name in TOPOLOGIES], axis=1)
    steps["PointOffsets"] = points
    steps["CellOffsets"] = cells
    steps["ConnectivityIdOffsets"] = np.stack(
        [_starts(root[name]["NumberOfConnectivityIds"][...]) for name in TOPOLOGIES], axis=1
    )
    for name in root["PointData"]:
        steps[f"PointDataOffsets/{name}"] = points
    for name in root["CellData"]:
        steps[f"CellDataOffsets/{name}"] = cells.sum(axis=1)


def _starts(counts: NDArray[Any]) -> NDArray[Any]:
    return np.concatenate(([0], np.cumsum(counts[:-1])))
