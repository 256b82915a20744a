"""The flow around the wing: vorticity or speed as an image, velocity as arrows, streamlines.

All are those of the fluid model; the vorticity of a model that stores none is the curl of its velocity.
"""

import threading
from collections import OrderedDict
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taichiflap.drawing import flow

from .colours import Map, Theme
from .frame import Array
from .frames import Run
from .legend import Bar
from .scene import ARROWS, arrows
from .streaks import Streaks, has_failed

NONE, VORTICITY, SPEED = BACKGROUNDS = ("none", "vorticity", "speed")
ACROSS, FINE = 256, 288
"""Points along the longer side of the picture; of stored vorticity, whose layers are thin."""
SPACING = 11
"""Points from one velocity arrow to the next."""
LINES = 24
"""Streamlines between the least and the largest streamfunction of most of a picture."""
LINE_SHARE = 0.45
"""Opacity of a streamline."""
MARGIN, ASIDE, NEAR = 0.4, 1.8, 0.6
"""The picture reaches so far beyond the first view, above and below it and beside it, chords; beside stored vorticity
little is left to see."""
REACH = 0.3
"""Length of a velocity arrow of full range, chords."""
KEPT = 64


@dataclass(frozen=True)
class Wanted:
    """The parts of a flow that a browser shows.

    Attributes:
        kind: one of `BACKGROUNDS`.
        arrows, streamlines: whether it shows those too.
        riding: whether it is seen from the wing, and moves relative to it.
    """

    kind: str = NONE
    arrows: bool = True
    streamlines: bool = False
    riding: bool = False

    @property
    def read(self) -> "Wanted":
        """Data for the values at a point."""
        return replace(self, kind=SPEED, arrows=False, streamlines=False)

    @property
    def needs_velocity(self) -> bool:
        """Whether more than the vorticity is needed."""
        return self.arrows or self.kind == SPEED


@dataclass(frozen=True)
class Flow:
    """The flow on a grid, bottom row first.

    Attributes:
        box: its corners (left, bottom, right, top), chords.
        vorticity: 1/s.
        velocity: along the page, m/s, (2, row, column); None where nobody asked.
        streamfunction: m2/s; None where nobody asked, or the model knows none.
        stored: whether the vorticity is what the result holds.
    """

    box: Array
    vorticity: Array
    velocity: Array | None = None
    streamfunction: Array | None = None
    stored: bool = False

    def picture(self, kind: str, theme: Theme, limits: tuple[float, float]) -> NDArray[np.uint8]:
        """The picture (row, column, 3), top row first; `limits` are those of vorticity and speed."""
        if kind == SPEED and self.velocity is not None:
            drawn = theme.speed.between(np.hypot(*self.velocity), 0.0, limits[1])
        else:
            drawn = colours(theme, self.stored).symmetric(self.vorticity, limits[0])
        if self.streamfunction is not None:
            low, high = np.quantile(self.streamfunction, (0.02, 0.98))
            share = LINE_SHARE * flow.lines(self.streamfunction, max((high - low) / LINES, 1e-12))[..., None]
            drawn = np.rint(drawn + share * (np.array(theme.velocity) - drawn)).astype(np.uint8)
        return drawn[::-1]

    def at(self, right: float, up: float) -> str:
        """Speed and vorticity at the image point nearest to a position (chords), as text; empty outside."""
        rows, columns = self.vorticity.shape
        left, bottom, east, top = self.box
        column, row = (right - left) / (east - left) * columns, (up - bottom) / (top - bottom) * rows
        if not (0.0 <= column < columns and 0.0 <= row < rows):
            return ""
        here = int(row), int(column)
        text = f"vorticity {float(self.vorticity[here]):+.3g} 1/s"
        if self.velocity is not None:
            along, across = (float(component[here]) for component in self.velocity)
            text = f"speed {np.hypot(along, across):.3g} m/s ({along:+.3g} right, {across:+.3g} up)\n{text}"
        return text.replace("-", "−")

    def arrows(self, speed: float) -> NDArray[np.float32]:
        """Velocity arrows as line segments (n, 2, 3)."""
        assert self.velocity is not None
        shape = self.vorticity.shape
        spacing = max(1, round(SPACING * max(shape) / ACROSS))
        rows, columns = (np.arange(spacing // 2, count, spacing) for count in shape)
        picked = np.ix_(rows, columns)
        right, up = np.meshgrid(*flow.middles(_box(self.box), (shape[0], shape[1])))
        tails = np.stack((right[picked].ravel(), up[picked].ravel()), axis=1)
        vectors = np.stack([component[picked].ravel() for component in self.velocity], axis=1) * (REACH / speed)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        vectors *= np.minimum(1.0, 2.0 * REACH / np.maximum(length, 1e-12))
        return arrows(tails, vectors, ARROWS, 0.07)


class Fields:
    """The flow of a result's frames, computed once for all browsers, in another thread.

    Taichi runs in one dedicated thread, as it requires.

    Args:
        worker: this thread, if it exists.
        warm: whether to start Taichi now.
    """

    def __init__(self, run: Run, worker: ThreadPoolExecutor | None = None, warm: bool = True) -> None:
        self.run = run
        self._owns = worker is None
        self._worker = worker or ThreadPoolExecutor(1, thread_name_prefix="field")
        self._lock = threading.Lock()
        self._flows: OrderedDict[tuple[int, int, Wanted], Future[Flow]] = OrderedDict()
        self._limits: dict[str, float] = {}
        self.streaks = Streaks(run, self._worker)
        if warm and run.draws_flow:
            # Taichi takes a second to start, and holds up all else: now, before there is a page to hold up.
            self._worker.submit(self._warm_up)

    def ask(self, index: int, wanted: Wanted | None = None) -> "Future[Flow]":
        """The flow of a frame, at once or as soon as it is computed."""
        key = self.run.surveys, index, wanted or Wanted(VORTICITY)
        with self._lock:
            if key not in self._flows or has_failed(self._flows[key]):
                self._flows[key] = self._worker.submit(self._compute, index, key[2])
                while len(self._flows) > KEPT:
                    self._flows.popitem(last=False)
            self._flows.move_to_end(key)
            return self._flows[key]

    def limits(self, found: Flow) -> tuple[float, float]:
        """Ranges of vorticity and speed: those of the stored flow, or of the first flow shown."""
        if found.stored:
            self._limits["vorticity"] = self.run.extent(False).limit
        elif "vorticity" not in self._limits:
            self._limits["vorticity"] = _two_digits(float(np.percentile(np.abs(found.vorticity), 99.0)))
        if "speed" not in self._limits and found.velocity is not None:
            self._limits["speed"] = _two_digits(float(np.percentile(np.hypot(*found.velocity), 99.5)))
        return self._limits["vorticity"], self._limits.get("speed", 1.0)

    def close(self) -> None:
        """Stop the thread, unless it belongs to another object."""
        if self._owns:
            self._worker.shutdown(wait=True, cancel_futures=True)

    def _compute(self, index: int, wanted: Wanted) -> Flow:
        run = self.run
        found, stand = run.flow_field(index), run.standpoint(index, wanted.riding)
        stored = found is not None and found.vorticity is not None
        aside = NEAR if stored else ASIDE
        box = run.first_view(wanted.riding) + np.array([-aside, -MARGIN, aside, MARGIN])
        shape = flow.shape_of(_box(box), FINE if stored else ACROSS)
        places = flow.points(stand, _box(box * run.chord), shape)
        if found is None:
            return Flow(box, np.zeros(shape), np.zeros((2, *shape)))
        carried = run.carried(index) if wanted.riding else None
        velocity: Array | None = None
        streamfunction: Array | None = None
        if wanted.needs_velocity or found.vorticity is None:
            moving = found.velocity(places)
            velocity = np.moveaxis(stand.vectors(*moving), -1, 0)
        if found.vorticity is not None:
            vorticity = flow.vorticity(found, places).astype(np.float32)
        else:
            assert velocity is not None
            step = (box[2] - box[0]) * run.chord / shape[1]
            # The page is (Y, Z) turned, so the curl keeps its sign.
            vorticity = np.gradient(velocity[1], step, axis=1) - np.gradient(velocity[0], step, axis=0)
        if velocity is not None:
            if carried is not None:
                velocity = velocity - np.moveaxis(stand.vectors(*carried.velocities(places)), -1, 0)
            velocity = flow.filled(velocity).astype(np.float32)
        if wanted.streamlines and found.streamfunction is not None:
            streamfunction = found.streamfunction(places)
            if carried is not None:
                streamfunction = streamfunction - carried.streamfunction(places)
            streamfunction = flow.filled(streamfunction)
        return Flow(box, vorticity, velocity, streamfunction, stored)

    def _warm_up(self) -> None:
        found = self.run.flow_field(0)
        if found is not None:
            found.velocity(np.zeros((2, 1)))


def colours(theme: Theme, stored: bool) -> Map:
    """Colours of vorticity: strong if only vorticity is shown, faint behind the dots of a wake."""
    return theme.flow if stored else theme.vorticity


def bar(found: Flow, wanted: Wanted, theme: Theme, limits: tuple[float, float]) -> Bar | None:
    """What the legend says about a background."""
    spin, speed = limits
    remark = f"its arrows: {REACH:g} chord = {speed:g} m/s" if wanted.arrows else ""
    if wanted.kind == VORTICITY:
        return Bar("Flow: vorticity", colours(theme, found.stored), -spin, spin, "1/s", remark)
    if wanted.kind == SPEED:
        return Bar("Flow: speed", theme.speed, 0.0, speed, "m/s", remark)
    return None


def _box(edges: Array) -> flow.Box:
    left, bottom, right, top = (float(edge) for edge in edges)
    return left, bottom, right, top


def _two_digits(value: float) -> float:
    return float(f"{max(value, 1e-12):.1e}")
