"""One HTML file that plays a result's last beats offline, with its own player (`player.html`)."""

import base64
import html
import json
import math
import zlib
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import files
from ..drawing import flow, palette, scene
from ..drawing.orientation import INERTIAL
from ..metrics.waves import reversals
from ..motion.stream import in_stream
from ..notation import prefixed
from ..results.reader import Result

BUDGET = 7_000_000
"""Maximum size of the numbers in a page, in bytes, for a page below 10 MB."""
MOST, FEWEST = 100, 20
"""Frames per beat, enough for smooth motion."""
ACROSS = 288
"""Points along the longer side of a picture of the flow."""
STEPS = 32767
"""Largest integer for the quantised numbers."""


def write_html(result: Result, path: Path, beats: int, reference: str = INERTIAL) -> int:
    """Write a page with the last beats, or as many of them as fit in 10 MB, and return its number of frames.

    Args:
        reference: the frame of reference that it is drawn in.

    Raises:
        SceneError: when the result has no whole beat.
        OutputError: if not even one beat fits, or the file cannot be written.
    """
    indices, per_beat = _fitting(result, path, beats, reference)
    page = _page(
        result, [scene.frame(result, int(index), reference) for index in indices], indices, per_beat, reference
    )
    with files.replacing(path) as file:
        file.write(page.encode())
    return len(indices)


def pack(values: ArrayLike) -> dict[str, Any]:
    """Numbers as 16-bit integers in base64: value = offset + scale * integer; the error is at most half of `scale`."""
    flat = np.asarray(values, dtype=float).ravel()
    low, high = (float(flat.min()), float(flat.max())) if flat.size else (0.0, 0.0)
    offset = 0.5 * (low + high)
    scale = 0.5 * (high - low) / STEPS or 1.0
    whole = np.rint((flat - offset) / scale).astype("<i2")
    return {"offset": offset, "scale": scale, "data": _base64(whole)}


def pack_picture(levels: NDArray[np.uint8]) -> bytes:
    """A picture (rows, columns) as differences from pixel to pixel along its rows, deflated."""
    changes = np.diff(levels, axis=1, prepend=np.uint8(0))
    return zlib.compress(np.ascontiguousarray(changes, np.uint8).tobytes(), 9)


def levels(backdrop: flow.Backdrop, frame: scene.Frame, page: tuple[float, float, float, float]) -> bytes:
    """The packed picture behind a frame, top row first: 1 to 255 from limit to limit, 128 for nothing."""
    scaled = np.clip(backdrop.vorticity(frame, page, ACROSS) / backdrop.limit, -1.0, 1.0)
    return pack_picture(np.rint(128.0 + 127.0 * scaled)[::-1].astype(np.uint8))


def _fitting(result: Result, path: Path, beats: int, reference: str) -> tuple[NDArray[np.intp], float]:
    """Frames that fit in the budget, and their number per beat."""
    stored = result.case.steps_per_beat / result.case.output.every
    picture = 0
    last = scene.last_beats(result)
    if backdrop := flow.Backdrop.of(result, last, reference):
        frame = scene.frame(result, int(last[-1]), reference)
        picture = round(1.2 * len(levels(backdrop, frame, scene.bounds([frame], result.case, backdrop.box).page)))
    for count in range(beats, 0, -1):
        indices = scene.last_beats(result, count)[:-1]
        nodes = result.file["node_position"].shape[1]
        most_vortices = max(len(result.wake(int(index))["y"]) for index in (indices[0], indices[-1]))
        room = BUDGET / (2.0 * (3 * most_vortices + 4 * nodes + 4) + picture)
        stride = max(math.ceil(stored / MOST), math.ceil(len(indices) / room))
        if stored / stride >= min(FEWEST, stored):
            return indices[::stride], stored / stride
    raise files.OutputError(f"{path}: one beat of this wake exceeds the limit of 10 MB; export it as mp4")


def _page(result: Result, frames: list[scene.Frame], indices: NDArray[np.intp], per_beat: float, reference: str) -> str:
    case = result.case
    steps = case.step_of(indices)
    backdrop = flow.Backdrop.of(result, indices, reference)
    shared = scene.bounds(frames, case, backdrop.box if backdrop else None)
    left, right, bottom, top = shared.page
    way = scene.stroke(result, indices) if reference == INERTIAL else None
    lift = result.force_vertical[steps]
    if case.fluid.streams:
        lift, _ = in_stream(case, result.force_y[steps], result.force_z[steps])
    loaded = not any(len(frame.wake) for frame in frames) and backdrop is None
    data = {
        "chord": case.wing.chord,
        "beat": case.beat,
        "periodic": case.periodic,
        "stroke": None if way is None else way.tolist(),
        "stream": scene.stream(case) if reference == INERTIAL else "",
        "first": frames[0].beats,
        "reversals": _reversals(result, frames[0].beats, per_beat, len(frames)),
        "per_beat": per_beat,
        "page": shared.page,
        "limit": backdrop.limit if backdrop else shared.circulation,
        "saturated": backdrop is not None or shared.saturated,
        "size": flow.shape_of((left, bottom, right, top), ACROSS)[::-1],
        "pictures": [_encoded(levels(backdrop, frame, shared.page)) for frame in frames] if backdrop else [],
        "force_limit": shared.force,
        "force_unit": prefixed(shared.force, "N"),
        "tip_unit": prefixed(float(np.abs(result.tip_deflection[steps]).max()), "m") if case.wing.modes else None,
        "traction_limit": shared.traction,
        "reach": scene.REACH,
        "nodes": len(frames[0].wing),
        "panels": len(frames[0].traction) if loaded else 0,
        "counts": [len(frame.wake) for frame in frames],
        "wing": pack([frame.wing for frame in frames]),
        "wake": pack(np.concatenate([frame.wake for frame in frames])),
        "circulation": pack(np.concatenate([frame.circulation for frame in frames])),
        "traction": pack([frame.traction for frame in frames] if loaded else []),
        "force": pack([frame.force for frame in frames]),
        "tip": pack(result.tip_deflection[steps]),
        "lift": pack(lift),
        "lift_name": "lift" if case.fluid.streams else "vertical force",
        "tables": {
            name: _base64(palette.table(theme.flow if backdrop else theme.anchors))
            for name, theme in (("light", palette.LIGHT), ("dark", palette.DARK))
        },
    }
    model = f"{case.model}, {'flexible' if case.wing.modes else 'rigid'} wing"
    if case.motion.frequency:
        model += f", {case.motion.frequency:g} Hz"
    if not (result.has_wake or backdrop):
        model += "; the model has no wake"
    return Template(resources.files(__package__).joinpath("player.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(scene.label(result)),
        model=html.escape(model),
        light=_properties(palette.LIGHT),
        dark=_properties(palette.DARK),
        key="vorticity ω (1/s)" if backdrop else "wake circulation Γ (m²/s)",
        data=json.dumps(data).replace("<", "\\u003c"),
        timeline=resources.files("taichiflap.drawing").joinpath("timeline.js").read_text(encoding="utf-8"),
    )


def _reversals(result: Result, first: float, per_beat: float, count: int) -> list[int]:
    """Frames of the page at which the stroke reverses, the first being at a time in beats."""
    found = reversals(result.case, first, first + (count - 1) / per_beat)
    return [round((float(beats) - first) * per_beat) for beats in found]


def _properties(theme: palette.Theme) -> str:
    names = ("ground", "ink", "muted", "faint", "force")
    return " ".join(f"--{name}: {getattr(theme, name)};" for name in names)


def _base64(values: NDArray[Any]) -> str:
    return _encoded(values.tobytes())


def _encoded(content: bytes) -> str:
    return base64.b64encode(content).decode()
