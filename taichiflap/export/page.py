"""One HTML file that plays a result's last beats offline, with its own player (`player.html`)."""

import base64
import html
import json
import math
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import files
from ..drawing import palette, scene
from ..metrics.summary import reversals
from ..notation import prefixed
from ..results.reader import Result

BUDGET = 7_000_000
"""Maximum size of the numbers in a page, in bytes, for a page below 10 MB."""
MOST, FEWEST = 100, 20
"""Frames per beat, enough for smooth motion."""
STEPS = 32767
"""Largest integer for the quantised numbers."""


def write_html(result: Result, path: Path, beats: int) -> int:
    """Write a page with the last beats, or as many of them as fit in 10 MB, and return its number of frames.

    Raises:
        SceneError: when the result has no whole beat.
        OutputError: if not even one beat fits, or the file cannot be written.
    """
    indices, per_beat = _fitting(result, path, beats)
    page = _page(result, [scene.frame(result, int(index)) for index in indices], indices, per_beat)
    with files.replacing(path) as file:
        file.write(page.encode())
    return len(indices)


def pack(values: ArrayLike) -> dict[str, Any]:
    """Numbers as 16-bit integers in base64: value = offset + scale * integer, with an error of at most half a "
    "`scale`."""
    flat = np.asarray(values, dtype=float).ravel()
    low, high = (float(flat.min()), float(flat.max())) if flat.size else (0.0, 0.0)
    offset = 0.5 * (low + high)
    scale = 0.5 * (high - low) / STEPS or 1.0
    whole = np.rint((flat - offset) / scale).astype("<i2")
    return {"offset": offset, "scale": scale, "data": _base64(whole)}


def _fitting(result: Result, path: Path, beats: int) -> tuple[NDArray[np.intp], float]:
    """Frames that fit in the budget, and their number per beat."""
    stored = result.case.steps_per_beat / result.case.output.every
    for count in range(beats, 0, -1):
        indices = scene.last_beats(result, count)[:-1]
        nodes = result.file["node_position"].shape[1]
        most_vortices = max(len(result.wake(int(index))["y"]) for index in (indices[0], indices[-1]))
        room = BUDGET / (2.0 * (3 * most_vortices + 4 * nodes + 4))
        stride = max(math.ceil(stored / MOST), math.ceil(len(indices) / room))
        if stored / stride >= min(FEWEST, stored):
            return indices[::stride], stored / stride
    raise files.OutputError(f"{path}: one beat of this wake exceeds the limit of 10 MB; export it as mp4")


def _page(result: Result, frames: list[scene.Frame], indices: NDArray[np.intp], per_beat: float) -> str:
    case = result.case
    steps = case.step_of(indices)
    shared, way = scene.bounds(frames, case), scene.stroke(result, indices)
    loaded = not any(len(frame.wake) for frame in frames)
    data = {
        "chord": case.wing.chord,
        "beat": case.beat,
        "periodic": case.periodic,
        "stroke": None if way is None else way.tolist(),
        "stream": scene.stream(case),
        "first": frames[0].beats,
        "reversals": _reversals(result, frames[0].beats, per_beat, len(frames)),
        "per_beat": per_beat,
        "page": shared.page,
        "limit": shared.circulation,
        "saturated": shared.saturated,
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
        "lift": pack(result.force_vertical[steps]),
        "tables": {
            "light": _base64(palette.table(palette.LIGHT.anchors)),
            "dark": _base64(palette.table(palette.DARK.anchors)),
        },
    }
    model = f"{case.model}, {'flexible' if case.wing.modes else 'rigid'} wing"
    if case.motion.frequency:
        model += f", {case.motion.frequency:g} Hz"
    if not result.has_wake:
        model += "; the model has no wake"
    return Template(resources.files(__package__).joinpath("player.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(scene.label(result)),
        model=html.escape(model),
        light=_properties(palette.LIGHT),
        dark=_properties(palette.DARK),
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
    return base64.b64encode(values.tobytes()).decode()
