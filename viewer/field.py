"""The flow around the wing: vorticity or speed as an image, velocity as arrows.

The velocity is that of the fluid model; vorticity is its curl.
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
"""Number of points along the longer side of the image."""
SPACING = 11
"""Number of points between velocity arrows."""
MARGIN, ASIDE = 0.4, 1.8
"""Margin of the image around the initial view, vertically and horizontally, chords."""
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
        """The image (row, column, 3), top row first; `limits` are those of vorticity and speed."""
        if kind == VORTICITY:
            return theme.vorticity.symmetric(self.vorticity[::-1], limits[0])
        return theme.speed.between(np.hypot(*self.velocity)[::-1], 0.0, limits[1])

    def at(self, right: float, up: float) -> str:
        """Speed and vorticity at the image point nearest to a position (chords), as text; empty outside."""
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
    """The flow of a result's frames, computed once for all browsers, in another thread.

    Taichi runs in one dedicated thread, as it requires.

    Args:
        worker: this thread, if it exists.
    """

    def __init__(self, run: Run, worker: ThreadPoolExecutor | None = None) -> None:
        self.run = run
        self._owns = worker is None
        self._worker = worker or ThreadPoolExecutor(1, thread_name_prefix="field")
        self._lock = threading.Lock()
        self._flows: OrderedDict[tuple[int, int], Future[Flow]] = OrderedDict()
        self._limits: tuple[float, float] | None = None
        if run.draws_flow:
            # Start Taichi now, which blocks everything for a second, before the first page opens.
            self._worker.submit(self._velocity, 0, np.zeros((2, 1)))

    def ask(self, index: int) -> "Future[Flow]":
        """The flow of a frame, available at once or as soon as it is computed."""
        key = self.run.surveys, index
        with self._lock:
            if key not in self._flows:
                self._flows[key] = self._worker.submit(self._compute, index)
                while len(self._flows) > KEPT:
                    self._flows.popitem(last=False)
            self._flows.move_to_end(key)
            return self._flows[key]

    def limits(self, flow: Flow) -> tuple[float, float]:
        """Ranges of vorticity and speed, fixed by the first computed flow."""
        if self._limits is None:
            spin = np.percentile(np.abs(flow.vorticity), 99.0)
            speed = np.percentile(np.hypot(*flow.velocity), 99.5)
            self._limits = _two_digits(float(spin)), _two_digits(float(speed))
        return self._limits

    def close(self) -> None:
        """Stop the thread, unless it belongs to another object."""
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
        # The page is (Y, Z) rotated, so that the curl keeps its sign.
        vorticity = np.gradient(velocity[1], step, axis=1) - np.gradient(velocity[0], step, axis=0)
        return Flow(box, velocity, vorticity)

    def _velocity(self, index: int, points: Array) -> Array:
        flow = self.run.velocity(index)
        return np.zeros_like(points) if flow is None else flow(np.asarray(points, dtype=np.float64))


def bar(kind: str, theme: Theme, limits: tuple[float, float]) -> Bar | None:
    """Entry of a background in the legend."""
    spin, speed = limits
    remark = f"its arrows: {REACH:g} chord = {speed:g} m/s"
    if kind == VORTICITY:
        return Bar("Flow: vorticity", theme.vorticity, -spin, spin, "1/s", remark)
    if kind == SPEED:
        return Bar("Flow: speed", theme.speed, 0.0, speed, "m/s", remark)
    return None


def _axes(box: Array, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Centres of the image's columns and rows, chords."""
    left, bottom, right, top = box
    rows, columns = shape
    return (
        left + (np.arange(columns) + 0.5) * (right - left) / columns,
        bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows,
    )


def _two_digits(value: float) -> float:
    return float(f"{max(value, 1e-12):.1e}")
