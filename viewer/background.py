"""The flow behind the wing in one browser: a picture and arrows, painted as soon as they are computed."""

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import numpy as np

from . import field
from .colours import LIGHT, Theme
from .field import NONE, Fields, Flow
from .legend import Bar
from .scene import FIELD, place


class Background:
    """The background of one browser's scene.

    Args:
        fields: the flow around the result.
        lock: held while anything that the browser sees changes.
        told: called once, when the first flow has set the ranges of the colours.
    """

    def __init__(self, client: Any, fields: Fields, lock: threading.RLock, told: Callable[[], None]) -> None:
        self._client, self._fields, self._lock, self._told = client, fields, lock, told
        self._wanted: tuple[str, int, Theme] = NONE, 0, LIGHT
        self._painted: tuple[str, int, Theme] | None = None
        self._asked = False
        self._flow: Flow | None = None
        self._handles: tuple[Any, Any] | None = None

    def forget(self) -> None:
        """Take notice that the scene has been emptied."""
        self._handles = self._painted = None

    def show(self, kind: str, index: int, theme: Theme) -> None:
        """Show the flow of a frame; while playing on a slow machine, that is a moment late."""
        self._wanted = kind, index, theme
        if kind == NONE:
            for handle in self._handles or ():
                handle.remove()
            self.forget()
        elif self._wanted != self._painted and not self._asked:
            found = self._fields.ask(index)
            if found.done():
                self._paint(index, found.result())
            else:
                self._asked = True
                found.add_done_callback(lambda done: self._arrive(index, done))

    def bar(self, kind: str, theme: Theme) -> Bar | None:
        """What the legend says about it, once there is a flow to tell the ranges."""
        return field.bar(kind, theme, self._fields.limits(self._flow)) if self._flow else None

    def _arrive(self, index: int, found: "Future[Flow]") -> None:
        with self._lock:
            self._asked = False
            if found.cancelled() or self._wanted[0] == NONE:
                return
            # The browser may have left, and a file may be in the middle of a write.
            with contextlib.suppress(RuntimeError, OSError), self._client.atomic():
                self._paint(index, found.result())
                self.show(*self._wanted)

    def _paint(self, index: int, flow: Flow) -> None:
        first, self._flow = self._flow is None, flow
        kind, _, theme = self._wanted
        self._painted = kind, index, theme
        limits = self._fields.limits(flow)
        picture, lines = flow.picture(kind, theme, limits), flow.arrows(limits[1])
        if self._handles is None:
            left, bottom, right, top = (float(edge) for edge in flow.box)
            centre = place(np.array([0.5 * (left + right), 0.5 * (bottom + top)]), FIELD)
            # An image lies in its own x and y, rows along y: a quarter turn about x stands it up.
            self._handles = (
                self._client.scene.add_image(
                    "/field/picture", picture, right - left, top - bottom, format="jpeg", jpeg_quality=92,
                    wxyz=(np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0), position=centre,
                    cast_shadow=False, receive_shadow=False,
                ),
                self._client.scene.add_line_segments(
                    "/field/arrows", lines, theme.velocity, thickness=1.2, thickness_units="screen"
                ),
            )  # fmt: skip
        else:
            self._handles[0].image, self._handles[1].points = picture, lines
        if first:
            self._told()
