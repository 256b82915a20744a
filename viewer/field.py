"""The flow around the wing: vorticity or speed as a picture, velocity as arrows.

The velocity is the fluid model's own; vorticity is the curl of that same velocity.
"""

import threading
from collections import OrderedDict
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .colours import Theme
from .frame import Array
from .frames import Run
from .legend import Bar
from .scene import ARROWS, arrows

NONE, VORTICITY, SPEED = BACKGROUNDS = ("none", "vorticity", "speed")
ACROSS = 256
"""Points along the longer side of the picture."""
SPACING = 11
"""Points from one velocity arrow to the next."""
MARGIN, ASIDE = 0.4, 1.8
"""The picture reaches so far beyond the first view, above and below it and beside it, chords."""
REACH = 0.3
"""Length of a velocity arrow of full range, chords."""
KEPT = 64


@dataclass(frozen=True)
class Flow:
    """The flow on a grid: corners (left, bottom, right, top) in chords, velocity in m/s, vorticity in 1/s."""

    box: Array
    velocity: Array
    vorticity: Array

    def picture(self, kind: str, theme: Theme, limits: tuple[float, float]) -> NDArray[np.uint8]:
        """The picture (row, column, 3), top row first; `limits` are those of vorticity and speed."""
        if kind == VORTICITY:
            return theme.vorticity.symmetric(self.vorticity[::-1], limits[0])
        return theme.speed.between(np.hypot(*self.velocity)[::-1], 0.0, limits[1])

    def at(self, right: float, up: float) -> str:
        """Speed and vorticity in the picture's point nearest to a place (chords), in words; nothing beyond it."""
        rows, columns = self.vorticity.shape
        left, bottom, east, top = self.box
        column, row = (right - left) / (east - left) * columns, (up - bottom) / (top - bottom) * rows
        if not (0.0 <= column < columns and 0.0 <= row < rows):
            return ""
        here = int(row), int(column)
        along, across = (float(component[here]) for component in self.velocity)
        text = (
            f"speed {np.hypot(along, across):.3g} m/s ({along:+.3g} right, {across:+.3g} up)\n"
            f"vorticity {float(self.vorticity[here]):+.3g} 1/s"
        )
        return text.replace("-", "−")

    def arrows(self, speed: float) -> NDArray[np.float32]:
        """Velocity arrows as line segments (n, 2, 3)."""
        rows, columns = (np.arange(SPACING // 2, count, SPACING) for count in self.vorticity.shape)
        picked = np.ix_(rows, columns)
        right, up = np.meshgrid(*_axes(self.box, self.vorticity.shape))
        tails = np.stack((right[picked].ravel(), up[picked].ravel()), axis=1)
        vectors = np.stack([component[picked].ravel() for component in self.velocity], axis=1) * (REACH / speed)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        vectors *= np.minimum(1.0, 2.0 * REACH / np.maximum(length, 1e-12))
        return arrows(tails, vectors, ARROWS, 0.07)


class Fields:
    """The flow of a result's frames, computed once for all browsers, away from their thread.

    All of Taichi's work is done by one thread of its own, which it wants.

    Args:
        worker: that thread, if there is one already.
    """

    def __init__(self, run: Run, worker: ThreadPoolExecutor | None = None) -> None:
        self.run = run
        self._owns = worker is None
        self._worker = worker or ThreadPoolExecutor(1, thread_name_prefix="field")
        self._lock = threading.Lock()
        self._flows: OrderedDict[tuple[int, int], Future[Flow]] = OrderedDict()
        self._limits: tuple[float, float] | None = None
        if run.draws_flow:
            # Taichi takes a second to start, and holds up all else: now, before there is a page to hold up.
            self._worker.submit(self._velocity, 0, np.zeros((2, 1)))

    def ask(self, index: int) -> "Future[Flow]":
        """The flow of a frame, at once or as soon as it is computed."""
        key = self.run.surveys, index
        with self._lock:
            if key not in self._flows:
                self._flows[key] = self._worker.submit(self._compute, index)
                while len(self._flows) > KEPT:
                    self._flows.popitem(last=False)
            self._flows.move_to_end(key)
            return self._flows[key]

    def limits(self, flow: Flow) -> tuple[float, float]:
        """Ranges of vorticity and speed: those of the first flow looked at, for good."""
        if self._limits is None:
            spin = np.percentile(np.abs(flow.vorticity), 99.0)
            speed = np.percentile(np.hypot(*flow.velocity), 99.5)
            self._limits = _two_digits(float(spin)), _two_digits(float(speed))
        return self._limits

    def close(self) -> None:
        """Let the thread go, unless it is another's."""
        if self._owns:
            self._worker.shutdown(wait=True, cancel_futures=True)

    def _compute(self, index: int) -> Flow:
        run = self.run
        box = run.box + np.array([-ASIDE, -MARGIN, ASIDE, MARGIN])
        width, height = box[2:] - box[:2]
        finest = max(width, height) / ACROSS
        shape = max(2, round(height / finest)), max(2, round(width / finest))
        right, up = np.meshgrid(*_axes(box, shape))
        places = run.page.off_page(np.stack((right, up), axis=-1))
        along_y, along_z = self._velocity(index, places * run.chord)
        velocity = np.moveaxis(run.page.on_page(along_y, along_z), -1, 0).astype(np.float32)
        step = finest * run.chord
        # The page is (Y, Z) turned, so the curl keeps its sign.
        vorticity = np.gradient(velocity[1], step, axis=1) - np.gradient(velocity[0], step, axis=0)
        return Flow(box, velocity, vorticity)

    def _velocity(self, index: int, points: Array) -> Array:
        flow = self.run.velocity(index)
        return np.zeros_like(points) if flow is None else flow(np.asarray(points, dtype=np.float64))


def bar(kind: str, theme: Theme, limits: tuple[float, float]) -> Bar | None:
    """What the legend says about a background."""
    spin, speed = limits
    remark = f"its arrows: {REACH:g} chord = {speed:g} m/s"
    if kind == VORTICITY:
        return Bar("Flow: vorticity", theme.vorticity, -spin, spin, "1/s", remark)
    if kind == SPEED:
        return Bar("Flow: speed", theme.speed, 0.0, speed, "m/s", remark)
    return None


def _axes(box: Array, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Middles of the picture's columns and rows, chords."""
    left, bottom, right, top = box
    rows, columns = shape
    return (
        left + (np.arange(columns) + 0.5) * (right - left) / columns,
        bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows,
    )


def _two_digits(value: float) -> float:
    return float(f"{max(value, 1e-12):.1e}")
