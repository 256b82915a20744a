"""What a drawing shows of a result: its last beats, seen from the wing tip, turned as `orientation` says."""

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
from .orientation import Orientation
from .palette import rounded_up, symmetric_limit

Array = NDArray[np.float64]

OUTLYING = 0.003
"""Share of the wake that may lie beyond either edge of the page."""
SLENDER = 0.4
"""The page's short side is at least so much of the long one."""
MARGIN = 0.3
"""Free space around what is drawn, chords."""
FAR, FAR_IN_STREAM = 5.0, 12.0
"""The page ends so many chords from the wing, lest a wake of many beats leave nothing of the wing to be seen."""
STILL = 1e-6
"""A pivot that moves by less than so many chords has no stroke."""
REACH = 1.0
"""Length of the arrow of the largest force, chords."""


class SceneError(UserError):
    """A result that has nothing to draw: one sentence with the file and the cause."""


@dataclass(frozen=True)
class Frame:
    """One instant.

    Attributes:
        beats: time over the period, t/T, or over the run's duration where nothing repeats.
        wing: positions of the nodes on the page, m, shape (nodes, 2).
        wake: positions of the wake vortices on the page, m, oldest first, shape (vortices, 2).
        circulation: theirs, m2/s.
        age: time since each was shed, beats.
        edge: that shed them, 0 the trailing and 1 the leading edge.
        force: fluid force on the page, N, shape (2,).
        traction: fluid force per area on the page at the middles of the panels, Pa, shape (panels, 2).
    """

    beats: float
    wing: Array
    wake: Array
    circulation: Array
    age: Array
    edge: NDArray[np.int64]
    force: Array
    traction: Array

    @property
    def middles(self) -> Array:
        """Middles of the panels on the page, m, shape (panels, 2)."""
        return 0.5 * (self.wing[1:] + self.wing[:-1])

    @property
    def foot(self) -> Array:
        """Where the arrow of the resultant force begins: half-way along the chord, m, shape (2,)."""
        return cast(Array, self.wing[len(self.wing) // 2])


@dataclass(frozen=True)
class Bounds:
    """What the frames of a drawing share.

    Attributes:
        page: left, right, bottom and top of what is drawn, m.
        circulation: limit of the colours of the wake, m2/s.
        force: largest resultant force, N.
        traction: largest force per area, Pa.
        saturated: whether some circulation lies beyond the limit.
    """

    page: tuple[float, float, float, float]
    circulation: float
    force: float
    traction: float
    saturated: bool


def label(result: Result) -> str:
    """What a result is called in a drawing: its title, or else its file's name."""
    return printable(result.case.title or (Path(result.path).stem if result.path else "untitled"))


def last_beats(result: Result, beats: int = 1) -> NDArray[np.intp]:
    """Indices of the frames of the last whole beats, the first of them and the last included.

    Raises:
        SceneError: when the run has not got so far, has failed there, or stores hardly any frames.
    """
    frames = _within(result, result.field_time, beats)
    if len(frames) < 2:
        raise SceneError(f"{result.path or label(result)}: stores too few frames a beat to draw; see output.every")
    return frames


def last_steps(result: Result, beats: int = 1) -> slice:
    """The steps of the last whole beats, the first of them and the last included.

    Raises:
        SceneError: when the run has not got so far, or has failed there.
    """
    steps = _within(result, result.time, beats)
    return slice(int(steps[0]), int(steps[-1]) + 1)


def _within(result: Result, time: Array, beats: int) -> NDArray[np.intp]:
    """Which of some times lie in the last whole beats that the run has."""
    run = result.time / result.case.beat
    whole = math.floor(round(float(run[-1]), 9)) if len(run) else 0
    if whole < 1:
        raise SceneError(f"{result.path or label(result)}: has no whole beat yet, so there is nothing to draw")
    first = whole - min(beats, whole)
    shown = np.flatnonzero((run >= first - 1e-9) & (run <= whole + 1e-9))
    if not np.isfinite(result.file["force_normal"][shown[0] : shown[-1] + 1]).all():
        raise SceneError(
            f"{result.path or label(result)}: the run failed in its last beats, so there is nothing to draw"
        )
    turns = time / result.case.beat
    return np.flatnonzero((turns >= first - 1e-9) & (turns <= whole + 1e-9))


def frame(result: Result, index: int) -> Frame:
    """One frame of a result, read without the others."""
    on_page = Orientation.of(result.case).on_page
    nodes = result.frame("node_position", index)
    wake = result.wake(index)
    pitch = float(result.frame("pitch", index))
    normal = np.asarray(result.frame("pressure_jump", index), dtype=float)
    axial = np.asarray(result.frame("shear", index), dtype=float) if "shear" in result.variables else 0.0 * normal
    return Frame(
        beats=float(result.frame("time", index)) / result.case.beat,
        wing=on_page(nodes[:, 0], nodes[:, 1]),
        wake=on_page(wake["y"], wake["z"]),
        circulation=np.asarray(wake["circulation"], dtype=float),
        age=(float(result.case.step_of(range(result.frames)[index])) - wake["birth"]) / result.case.steps_per_beat,
        edge=np.asarray(wake["edge"], dtype=int),
        force=on_page(result.frame("force_y", index), result.frame("force_z", index)),
        traction=on_page(
            axial * math.cos(pitch) - normal * math.sin(pitch), axial * math.sin(pitch) + normal * math.cos(pitch)
        ),
    )


def bounds(frames: list[Frame], case: Case) -> Bounds:
    """Bounds that hold for all the frames: the wing with its forces, and all but the farthest of the wake near it."""
    chord = case.wing.chord
    force = rounded_up(max(math.hypot(*f.force) for f in frames) or 1.0)
    traction = rounded_up(max(float(np.hypot(*f.traction.T).max()) for f in frames) or 1.0)
    shown = [f.wing for f in frames] + [(f.foot + f.force * REACH * chord / force)[None, :] for f in frames]
    wings = np.concatenate(shown)
    wake = np.concatenate([f.wake for f in frames])
    far = chord * (FAR_IN_STREAM if any(case.fluid.velocity) else FAR)
    near = ((wake > wings.min(axis=0) - far) & (wake < wings.max(axis=0) + far)).all(axis=1)
    wake, circulation = wake[near], np.concatenate([f.circulation for f in frames])[near]
    # Of the last beat: what a full wake has absorbed is many times as strong as what a wing sheds.
    limit = symmetric_limit(np.concatenate([f.circulation[f.age < 1.0] for f in frames]))
    if len(wake):
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
    """What a beat is on the axis of times, and what the axis says: where nothing repeats, chords or milliseconds."""
    if case.periodic:
        return 1.0, "Time in the last beat, t/T"
    stream = math.hypot(*case.fluid.velocity)
    if stream:
        return stream * case.beat / case.wing.chord, "Chords travelled by the stream, Ut/c"
    return 1e3 * case.beat, "Time, t (ms)"


def when(case: Case, beats: float) -> str:
    """A time within the beat in words, t/T; in ms where nothing repeats."""
    return f"t/T = {beats % 1.0:.3f}" if case.periodic else f"t = {1e3 * beats * case.beat:.4g} ms"


def stroke(result: Result, frames: NDArray[np.intp]) -> Array | None:
    """Both ends of the pivot's way in some frames, on the page, m, shape (2, 2); None if it stays where it is."""
    steps = result.case.step_of(frames)
    surge = result.surge[steps] if "surge" in result.variables else np.zeros(len(steps))
    way = Orientation.of(result.case).on_page(surge, result.plunge[steps])
    travel = np.ptp(way, axis=0)
    if travel.max() <= STILL * result.case.wing.chord:
        return None
    along = way[:, int(np.argmax(travel))]
    return way[[int(np.argmin(along)), int(np.argmax(along))]]


def stream(case: Case) -> str:
    """The free stream in words; nothing where there is none."""
    speed = math.hypot(*case.fluid.velocity)
    return f"U = {speed:.3g} m/s" if speed else ""


def slow_down(case: Case, seconds_per_beat: float) -> float:
    """How many times slower than life a beat is shown."""
    return seconds_per_beat / case.beat
