"""A flat view: a narrow lens from afar, straight on, that pans and zooms but does not turn."""

import math
import threading
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from . import wire

Box = Sequence[float] | NDArray[np.floating]
Point = tuple[float, float, float]

FIELD_OF_VIEW = math.radians(8.0)
"""Narrow enough to look flat: viser has no parallel projection."""
MARGIN = 1.08
"""What is seen over what the box takes."""
NARROW = 576.0
"""viser shows a window of fewer pixels its controls on a sheet at the bottom."""
SHEET = 0.45
"""Share of such a window that the sheet takes; see `narrow`."""
LEGEND_PIXELS = 250.0
"""A wide window has this much free on the left."""
NEAREST, FARTHEST = 3.0, 2000.0
"""Bounds of the camera's distance, chords."""

# viser offers no way to stop the camera from turning. Its page holds a camera-controls object, though: there, the
# left button comes to pan as the right one does, one finger as three do, and both angles are held where they are.
LOCK = """
let tries = 0;
const lock = () => {
  const controls = window.__viserMutable && window.__viserMutable.cameraControl;
  if (!controls) { if (tries++ < 200) setTimeout(lock, 50); return; }
  controls.mouseButtons.left = controls.mouseButtons.right;
  controls.touches.one = controls.touches.three;
  controls.dollyToCursor = true;
  controls.minPolarAngle = controls.maxPolarAngle = Math.PI / 2;
  controls.azimuthRotateSpeed = 0;
  controls.polarRotateSpeed = 0;
  const angle = controls.azimuthAngle;
  controls.minAzimuthAngle = controls.maxAzimuthAngle = angle;
};
lock();
"""


def home(box: Box, width: float, height: float, aside: float = LEGEND_PIXELS) -> tuple[Point, Point]:
    """Position of the camera and what it looks at, to see a box (left, bottom, right, top; chords) whole.

    Args:
        width, height: of the canvas, pixels.
        aside: pixels that a wide window keeps free on the left.
    """
    left, bottom, right, top = (float(edge) for edge in box)
    sheet = SHEET * height if 1.0 < width <= NARROW else 0.0
    legend = aside if width > 2.0 * aside and not sheet else 0.0
    scale = MARGIN * max((top - bottom) / (height - sheet), (right - left) / (width - legend))
    distance = max(scale * height / (2.0 * math.tan(FIELD_OF_VIEW / 2.0)), NEAREST)
    x, z = 0.5 * (left + right - legend * scale), 0.5 * (bottom + top - sheet * scale)
    return (x, -distance, z), (x, 0.0, z)


def narrow() -> str:
    """A style sheet, as HTML, that spreads viser's sheet over the width of a narrow window, below the scene."""
    sheet = '[style*="position: fixed"][style*="width: 20em"]'
    return (
        f"<style>@media (max-width: {NARROW:g}px) {{"
        f" {sheet} {{ width: 100% !important; max-height: {100.0 * SHEET:g}% !important; }}"
        f' {sheet} [style*="width: 20em"] {{ width: 100% !important; }} }}</style>'
    )


def start(server: viser.ViserServer, box: Box) -> None:
    """Give pages that are yet to open their view, so that the first picture is the right one."""
    position, target = home(box, 1.0, 1.0)
    camera = server.initial_camera
    camera.fov = FIELD_OF_VIEW
    camera.near, camera.far = 0.5, 2.0 * FARTHEST
    camera.up = (0.0, 0.0, 1.0)
    camera.position, camera.look_at = position, target


class View:
    """The camera of one browser: fitted to the window, and to its changes until somebody pans or zooms.

    Args:
        box: what the first view shows: left, bottom, right, top; chords.
        aside: pixels that a wide window keeps free on the left.
    """

    def __init__(self, client: Any, box: Box, aside: float = LEGEND_PIXELS) -> None:
        self.box, self._aside = box, aside
        self._camera = client.camera
        self._camera.min_orbit_distance, self._camera.max_orbit_distance = NEAREST, FARTHEST
        self._lock = threading.Lock()
        # Those on their way to the browser too: its answers to them may yet come.
        self._homes: deque[Any] = deque(maxlen=4)
        self._size = (0, 0)
        self._over = False
        self.reset()
        self._camera.on_update(self._refit)

    def reset(self) -> None:
        """Turn back to the first view."""
        with self._lock:
            self._size = self._camera.image_width, self._camera.image_height
            position, target = home(self.box, *self._size, self._aside)
            self._homes.append(position)
            self._camera.fov = FIELD_OF_VIEW
            self._camera.up_direction = (0.0, 0.0, 1.0)
            self._camera.position = np.array(position)
            self._camera.look_at = np.array(target)

    def look_at(self, x: float, z: float, distance: float) -> None:
        """Look at a place of the scene, from so far; not back at the first view when the window changes."""
        with self._lock:
            distance = min(max(distance, NEAREST), FARTHEST)
            self._homes.clear()
            self._camera.position, self._camera.look_at = np.array((x, -distance, z)), np.array((x, 0.0, z))

    def fit(self, box: Box) -> None:
        """Take another box for the first view, and show it unless somebody has panned or zoomed."""
        self.box = box
        if self._untouched(self._camera):
            self.reset()

    def leave(self) -> None:
        """Leave the camera to another view of the same browser."""
        self._over = True

    def _untouched(self, seen: Any) -> bool:
        return any(np.allclose(seen.position, place, rtol=1e-3, atol=1e-3) for place in self._homes)

    def _refit(self, seen: Any) -> None:
        self._camera = seen
        if not self._over and self._untouched(seen) and (seen.image_width, seen.image_height) != self._size:
            self.reset()


def lock_rotation(client: Any) -> bool:
    """Keep a browser's view from turning; False if this viser has no way to."""
    return wire.run(client, LOCK)
