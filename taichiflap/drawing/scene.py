"""Content of a drawing of a result: its last beats, seen from the wing tip, rotated as in `orientation`."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..errors import UserError
from ..notation import printable
from ..results.reader import Result
from .orientation import INERTIAL, Orientation, Standpoint
from .palette import rounded_up, symmetric_limit

Array = NDArray[np.float64]

OUTLYING = 0.003
"""Share of the wake that may lie outside each edge of the page."""
SLENDER = 0.4
"""Minimum ratio of the page's short side to its long side."""
MARGIN = 0.3
"""Margin around the content, chords."""
FAR, FAR_IN_STREAM = 5.0, 12.0
"""Maximum distance of the page's edge from the wing, chords, so that the wing stays visible next to a long wake."""
STILL = 1e-6
"""Minimum travel of the pivot, chords, that is drawn as a stroke."""
REACH = 1.0
"""Length of the arrow of the largest force, chords."""


class SceneError(UserError):
    """Raised if a result cannot be drawn; one sentence with the file and the cause."""


@dataclass(frozen=True)
class Frame:
    """One instant.

    Attributes:
        beats: time over the period, t/T, or over the duration of a non-periodic run.
        index: of the frame in the result.
        stand: the viewpoint, see `orientation.Standpoint`.
        wing: positions of the nodes on the page, m, shape (nodes, 2).
        wake: positions of the wake vortices on the page, m, oldest first, shape (vortices, 2).
        circulation: circulation of the wake vortices, m2/s.
        age: time since shedding, beats.
        edge: edge that shed them, 0 for trailing and 1 for leading edge.
        force: fluid force on the page, N, shape (2,).
        traction: fluid force per area on the page at the midpoints of the panels, Pa, shape (panels, 2).
    """

    beats: float
    index: int
    stand: Standpoint
    wing: Array
    wake: Array
    circulation: Array
    age: Array
    edge: NDArray[np.int64]
    force: Array
    traction: Array

    @property
    def middles(self) -> Array:
        """Midpoints of the panels on the page, m, shape (panels, 2)."""
        return 0.5 * (self.wing[1:] + self.wing[:-1])

    @property
    def foot(self) -> Array:
        """Start of the resultant force's arrow: mid-chord, m, shape (2,)."""
        return cast(Array, self.wing[len(self.wing) // 2])


@dataclass(frozen=True)
class Bounds:
    """Bounds and limits shared by the frames of a drawing.

    Attributes:
        page: left, right, bottom and top of the drawing, m.
        circulation: colour limit of the wake, m2/s.
        force: largest resultant force, N.
        traction: largest force per area, Pa.
        saturated: whether some circulation exceeds the limit.
    """

    page: tuple[float, float, float, float]
    circulation: float
    force: float
    traction: float
    saturated: bool


def label(result: Result) -> str:
    """Name of a result in a drawing: its title, or else its file name."""
    return printable(result.case.title or (Path(result.path).stem if result.path else "untitled"))


def last_beats(result: Result, beats: int = 1) -> NDArray[np.intp]:
    """Indices of the frames of the last whole beats, both ends included.

    Raises:
        SceneError: if the run has no whole beat yet, has failed there, or has too few frames.
    """
    frames = _within(result, result.field_time, beats)
    if len(frames) < 2:
        raise SceneError(f"{result.path or label(result)}: has too few frames per beat to draw; reduce output.every")
    return frames


def last_steps(result: Result, beats: int = 1) -> slice:
    """Steps of the last whole beats, both ends included.

    Raises:
        SceneError: if the run has no whole beat yet, or has failed there.
    """
    steps = _within(result, result.time, beats)
    return slice(int(steps[0]), int(steps[-1]) + 1)


def _within(result: Result, time: Array, beats: int) -> NDArray[np.intp]:
    """Indices of the times in the last whole beats of a run."""
    run = result.time / result.case.beat
    whole = math.floor(round(float(run[-1]), 9)) if len(run) else 0
    if whole < 1:
        raise SceneError(f"{result.path or label(result)}: nothing to draw, since it has no whole beat yet")
    first = whole - min(beats, whole)
    shown = np.flatnonzero((run >= first - 1e-9) & (run <= whole + 1e-9))
    if not np.isfinite(result.file["force_normal"][shown[0] : shown[-1] + 1]).all():
        raise SceneError(f"{result.path or label(result)}: nothing to draw, since the run failed in its last beats")
    turns = time / result.case.beat
    return np.flatnonzero((turns >= first - 1e-9) & (turns <= whole + 1e-9))


def frame(result: Result, index: int, reference: str = INERTIAL) -> Frame:
    """One frame of a result, read alone.

    Args:
        reference: the frame of reference that it is drawn in, one of `orientation.FRAMES`.
    """
    stand = Standpoint.of(result, index, reference)
    on_page = stand.vectors
    nodes = result.frame("node_position", index)
    wake = result.wake(index)
    pitch = float(result.frame("pitch", index))
    normal = np.asarray(result.frame("pressure_jump", index), dtype=float)
    axial = np.asarray(result.frame("shear", index), dtype=float) if "shear" in result.variables else 0.0 * normal
    return Frame(
        beats=float(result.frame("time", index)) / result.case.beat,
        index=range(result.frames)[index],
        stand=stand,
        wing=stand.places(nodes[:, 0], nodes[:, 1]),
        wake=stand.places(wake["y"], wake["z"]),
        circulation=np.asarray(wake["circulation"], dtype=float),
        age=(float(result.case.step_of(range(result.frames)[index])) - wake["birth"]) / result.case.steps_per_beat,
        edge=np.asarray(wake["edge"], dtype=int),
        force=on_page(result.frame("force_y", index), result.frame("force_z", index)),
        traction=on_page(
            axial * math.cos(pitch) - normal * math.sin(pitch), axial * math.sin(pitch) + normal * math.cos(pitch)
        ),
    )


def bounds(frames: list[Frame], case: Case, flow: tuple[float, float, float, float] | None = None) -> Bounds:
    """Bounds for all frames: the wing with its forces, and the wake near it without outliers.

    Args:
        flow: the box (left, bottom, right, top, m) of a picture of the flow behind them.
    """
    chord = case.wing.chord
    force = rounded_up(max(math.hypot(*f.force) for f in frames) or 1.0)
    traction = rounded_up(max(float(np.hypot(*f.traction.T).max()) for f in frames) or 1.0)
    shown = [f.wing for f in frames] + [(f.foot + f.force * REACH * chord / force)[None, :] for f in frames]
    wings = np.concatenate(shown)
    wake = np.concatenate([f.wake for f in frames])
    far = chord * (FAR_IN_STREAM if case.fluid.streams else FAR)
    near = ((wake > wings.min(axis=0) - far) & (wake < wings.max(axis=0) + far)).all(axis=1)
    wake, circulation = wake[near], np.concatenate([f.circulation for f in frames])[near]
    # From the last beat, since vortices that have absorbed others are many times as strong as new ones.
    limit = symmetric_limit(np.concatenate([f.circulation[f.age < 1.0] for f in frames]))
    if flow is not None:
        shown.append(np.reshape(flow, (2, 2)))
    elif len(wake):
        shown.append(np.quantile(wake, (OUTLYING, 1.0 - OUTLYING), axis=0))
    else:
        shown += [f.middles + f.traction * REACH * chord / traction for f in frames]
    low, high = np.min(np.concatenate(shown), axis=0), np.max(np.concatenate(shown), axis=0)
    middle, half = 0.5 * (high + low), 0.5 * (high - low) + MARGIN * chord
    half = np.maximum(half, SLENDER * half.max())
    low, high = middle - half, middle + half
    return Bounds(
        page=(float(low[0]), float(high[0]), float(low[1]), float(high[1])),
        circulation=limit,
        force=force,
        traction=traction,
        saturated=bool(np.abs(circulation).max(initial=0.0) > limit),
    )


def abscissa(case: Case) -> tuple[float, str]:
    """Length of a beat on the time axis, and the axis label; chords or milliseconds for a non-periodic motion."""
    if case.periodic:
        return 1.0, "Time in the last beat, t/T"
    stream = math.hypot(*case.fluid.velocity)
    if stream:
        return stream * case.beat / case.wing.chord, "Chords travelled by the stream, Ut/c"
    return 1e3 * case.beat, "Time, t (ms)"


def when(case: Case, beats: float) -> str:
    """Time within the beat as text, t/T; in ms for a non-periodic motion."""
    return f"t/T = {beats % 1.0:.3f}" if case.periodic else f"t = {1e3 * beats * case.beat:.4g} ms"


def stroke(result: Result, frames: NDArray[np.intp]) -> Array | None:
    """Both ends of the pivot's path in some frames, on the page, m, shape (2, 2); None if it is at rest."""
    steps = result.case.step_of(frames)
    surge = result.surge[steps] if "surge" in result.variables else np.zeros(len(steps))
    way = Orientation.of(result.case).on_page(surge, result.plunge[steps])
    travel = np.ptp(way, axis=0)
    if travel.max() <= STILL * result.case.wing.chord:
        return None
    along = way[:, int(np.argmax(travel))]
    return way[[int(np.argmin(along)), int(np.argmax(along))]]


def stream(case: Case) -> str:
    """The free stream as text; empty without one."""
    speed = math.hypot(*case.fluid.velocity)
    return f"U = {speed:.3g} m/s" if speed else ""


def pace(case: Case, seconds_per_beat: float) -> str:
    """How much slower, or faster, than life a beat is shown, as text."""
    slower = seconds_per_beat / case.beat
    times, word = (slower, "slower") if slower >= 1.0 else (1.0 / slower, "faster")
    return f"{times:{'.0f' if times >= 10.0 else '.2g'}} times {word}"
