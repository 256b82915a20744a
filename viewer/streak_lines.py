"""The streak lines in one browser's scene, each shown only with its own frame."""

import contextlib
import threading
from collections.abc import Iterable
from concurrent.futures import Future
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taichiflap.drawing.palette import SHEETS

from . import wire
from .colours import Theme, rgb
from .frame import Array
from .scene import STREAK, place
from .streaks import Points, Streaks

GAP = 0.5
"""Distance of neighbouring particles, chords, beyond which their line is interrupted."""
WIDTH = 1.8


class StreakLines:
    """The streak lines of one browser: those of the edges in the colours of their sheets, those of points in ink.

    Args:
        client: viser's handle of the browser.
        streaks: those of the result.
        lock: lock held during changes of the scene.
    """

    def __init__(self, client: Any, streaks: Streaks, lock: threading.RLock) -> None:
        self._client, self._streaks, self._lock = client, streaks, lock
        self._node: Any = None
        self._drawn: tuple[Any, ...] = ()
        self._wanted: tuple[int, Points, bool] | None = None

    def forget(self) -> None:
        """Reset after the scene has been cleared."""
        self._node, self._wanted = None, None

    def show(self, index: int, points: Points, riding: bool, theme: Theme, coming: Iterable[int] = ()) -> None:
        """Show the lines of a frame as soon as they are available, and prepare those of the next frames."""
        self._wanted = index, points, riding
        found = self._streaks.ask(index, points)
        for one in coming:
            self._streaks.ask(one, points)
        if found.done():
            self._draw(index, found, riding, theme)
        else:
            self.hide()
            self._wanted = index, points, riding
            found.add_done_callback(lambda done: self._arrive((index, points, riding), theme, done))

    def hide(self) -> None:
        """Show none."""
        self._wanted = None
        if self._node is not None and self._node.visible:
            self._node.visible = False

    def _arrive(self, wanted: tuple[int, Points, bool], theme: Theme, found: "Future[Array]") -> None:
        with self._lock:
            if found.cancelled() or self._wanted != wanted:
                return
            # The browser may have disconnected.
            with contextlib.suppress(RuntimeError), self._client.atomic():
                self._draw(wanted[0], found, wanted[2], theme)

    def _draw(self, index: int, found: "Future[Array]", riding: bool, theme: Theme) -> None:
        # A file may be in the middle of a write.
        with contextlib.suppress(OSError):
            particles, run = found.result(), self._streaks.run
            places = run.standpoint(index, riding).places(*particles) / run.chord
            segments = lines(places)
            style = len(segments), len(places), theme.background
            if self._node is None or self._drawn != style:
                self._drawn = style
                self._node = self._client.scene.add_line_segments(
                    "/streaks", segments, _colours(places, theme), thickness=WIDTH, thickness_units="screen"
                )
            wire.send(self._node, points=segments)
            if not self._node.visible:
                self._node.visible = True


def lines(places: Array) -> NDArray[np.float32]:
    """Segments (n, 2, 3) of lines of particles (line, particle, 2); those of a gap have no length."""
    ends = np.stack((places[:, :-1], places[:, 1:]), axis=2)
    length = np.hypot(*np.moveaxis(ends[:, :, 1] - ends[:, :, 0], -1, 0))
    ends = np.where((length <= GAP)[..., None, None], ends, places[:, :1, None])
    return place(ends.reshape(-1, 2, 2), STREAK)


def _colours(places: Array, theme: Theme) -> NDArray[np.uint8]:
    """Colours (n, 2, 3) of these segments."""
    trailing, leading = (rgb(colour) for colour in SHEETS)
    each = np.array([leading, trailing, *[theme.ink] * (len(places) - 2)], dtype=np.uint8)
    return np.repeat(np.repeat(each, places.shape[1] - 1, axis=0)[:, None], 2, axis=1)
