"""A flat view: a narrow, distant camera that pans and zooms but does not rotate."""

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
"""Field of view, narrow enough to look flat, since viser has no parallel projection."""
MARGIN = 1.08
"""Ratio of the visible area to the box."""
NARROW = 576.0
"""Width in pixels below which viser shows its controls in a sheet at the bottom."""
SHEET = 0.45
"""Share of such a window covered by the sheet; see `narrow`."""
LEGEND_PIXELS = 250.0
"""Pixels kept free on the left of a wide window."""
NEAREST, FARTHEST = 3.0, 2000.0
"""Bounds of the camera's distance, chords."""

# viser has no option to disable rotation. Its page has a camera-controls object, in which the left button is set to pan
# like the right one, one finger like three, and both angles are fixed.
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
    """Position and target of the camera to see a whole box (left, bottom, right, top; chords).

    Args:
        width, height: size of the canvas, pixels.
        aside: pixels kept free on the left of a wide window.
    """
    left, bottom, right, top = (float(edge) for edge in box)
    sheet = SHEET * height if 1.0 < width <= NARROW else 0.0
    legend = aside if width > 2.0 * aside and not sheet else 0.0
    scale = MARGIN * max((top - bottom) / (height - sheet), (right - left) / (width - legend))
    distance = max(scale * height / (2.0 * math.tan(FIELD_OF_VIEW / 2.0)), NEAREST)
    x, z = 0.5 * (left + right - legend * scale), 0.5 * (bottom + top - sheet * scale)
    return (x, -distance, z), (x, 0.0, z)


def is_narrow(client: Any) -> bool:
    """Whether a browser's window is as narrow as a phone's."""
    return bool(1.0 < client.camera.image_width <= NARROW)


def narrow() -> str:
    """HTML style that gives viser's sheet the full width of a narrow window, below the scene."""
    sheet = '[style*="position: fixed"][style*="width: 20em"]'
    return (
        f"<style>@media (max-width: {NARROW:g}px) {{"
        f" {sheet} {{ width: 100% !important; max-height: {100.0 * SHEET:g}% !important; }}"
        f' {sheet} [style*="width: 20em"] {{ width: 100% !important; }} }}</style>'
    )


def start(server: viser.ViserServer, box: Box) -> None:
    """Set the initial view of new pages."""
    position, target = home(box, 1.0, 1.0)
    camera = server.initial_camera
    camera.fov = FIELD_OF_VIEW
    camera.near, camera.far = 0.5, 2.0 * FARTHEST
    camera.up = (0.0, 0.0, 1.0)
    camera.position, camera.look_at = position, target


class View:
    """The camera of one browser: fitted to the window until the user pans or zooms.

    Args:
        box: initial view: left, bottom, right, top; chords.
        aside: pixels kept free on the left of a wide window.
    """

    def __init__(self, client: Any, box: Box, aside: float = LEGEND_PIXELS) -> None:
        self.box, self._aside = box, aside
        self._camera = client.camera
        self._camera.min_orbit_distance, self._camera.max_orbit_distance = NEAREST, FARTHEST
        self._lock = threading.Lock()
        # Including views sent to the browser whose answers may still arrive.
        self._homes: deque[Any] = deque(maxlen=4)
        self._size = (0, 0)
        self._over = False
        self.reset()
        self._camera.on_update(self._refit)

    def reset(self) -> None:
        """Return to the initial view."""
        with self._lock:
            self._size = self._camera.image_width, self._camera.image_height
            position, target = home(self.box, *self._size, self._aside)
            self._homes.append(position)
            self._camera.fov = FIELD_OF_VIEW
            self._camera.up_direction = (0.0, 0.0, 1.0)
            self._camera.position = np.array(position)
            self._camera.look_at = np.array(target)

    def look_at(self, x: float, z: float, distance: float) -> None:
        """Look at a point of the scene from a distance; the view is kept when the window changes."""
        with self._lock:
            distance = min(max(distance, NEAREST), FARTHEST)
            self._homes.clear()
            self._camera.position, self._camera.look_at = np.array((x, -distance, z)), np.array((x, 0.0, z))

    def fit(self, box: Box) -> None:
        """Set another initial view, and show it unless the user has panned or zoomed."""
        self.box = box
        if self._untouched(self._camera):
            self.reset()

    def leave(self) -> None:
        """Release the camera for another view of the same browser."""
        self._over = True

    def _untouched(self, seen: Any) -> bool:
        return any(np.allclose(seen.position, place, rtol=1e-3, atol=1e-3) for place in self._homes)

    def _refit(self, seen: Any) -> None:
        self._camera = seen
        if not self._over and self._untouched(seen) and (seen.image_width, seen.image_height) != self._size:
            self.reset()


def lock_rotation(client: Any) -> bool:
    """Disable rotation in a browser; False if this version of viser does not allow it."""
    return wire.run(client, LOCK)
