"""The flow behind the wing in one browser: pictures with arrows, each shown with its own frame or not at all.

A page decodes a picture some time after it was sent, and gives up one that the next follows too soon. So every picture
is a node of the scene of its own, sent ahead and hidden; what moves from frame to frame is which of them is visible,
and that goes out together with the wing.
"""

import contextlib
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from typing import Any

import numpy as np

from . import field
from .colours import LIGHT, Theme
from .field import NONE, Fields, Flow
from .legend import Bar
from .scene import FIELD, place

PICTURES = 40
"""A beat is played through so many pictures at most."""
AHEAD = 6
"""Pictures that are asked for ahead of the frame shown."""
KEPT = 64
"""Pictures that a page holds."""

# An image lies in its own x and y, rows along y: a quarter turn about x stands it up.
UPRIGHT = (np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0)


class Background:
    """The background of one browser's scene.

    Args:
        fields: the flow around the result.
        lock: held while anything that the browser sees changes.
        told: called once, when the first flow has set the ranges of the colours.
    """

    def __init__(self, client: Any, fields: Fields, lock: threading.RLock, told: Callable[[], None]) -> None:
        self._client, self._fields, self._lock, self._told = client, fields, lock, told
        self._style: tuple[str, Theme] = NONE, LIGHT
        self._pictures: OrderedDict[int, Any] = OrderedDict()
        self._shown: int | None = None
        self._waiting: set[int] = set()
        self._flow: Flow | None = None

    def forget(self) -> None:
        """Take notice that the scene has been emptied."""
        self._pictures.clear()
        self._shown = None

    def step(self, index: int) -> int:
        """The frame with a picture that is shown in the place of a frame while playing."""
        return index - index % self.stride

    @property
    def stride(self) -> int:
        """Frames from one picture to the next while playing."""
        return max(1, round(self._fields.run.frames_per_beat / PICTURES))

    def show(self, kind: str, index: int, theme: Theme, coming: Iterable[int] = ()) -> None:
        """Show the flow of a frame, or none until it is there; have that of the frames to come at hand."""
        if (kind, theme) != self._style:
            for picture in self._pictures.values():
                picture.remove()
            self.forget()
            self._style = kind, theme
        if kind == NONE:
            return
        self._show_only(index)
        for wanted in (index, *coming):
            self._ask(wanted)

    def bar(self, kind: str, theme: Theme) -> Bar | None:
        """What the legend says about it, once there is a flow to tell the ranges."""
        return field.bar(kind, theme, self._fields.limits(self._flow)) if self._flow else None

    def at(self, right: float, up: float) -> str:
        """Speed and vorticity at a place of the scene, in words; nothing beyond the picture, or before there is one."""
        if self._shown is None or self._shown not in self._pictures:
            return ""
        flow = self._fields.ask(self._shown)
        return flow.result().at(right, up) if flow.done() and not flow.cancelled() else ""

    def _show_only(self, index: int) -> None:
        if self._shown is not None and self._shown != index and self._shown in self._pictures:
            self._pictures[self._shown].visible = False
        self._shown = index
        if index in self._pictures:
            self._pictures.move_to_end(index)
            self._pictures[index].visible = True

    def _ask(self, index: int) -> None:
        if index in self._pictures or index in self._waiting:
            return
        found = self._fields.ask(index)
        if found.done():
            self._paint(index, found.result())
        else:
            self._waiting.add(index)
            found.add_done_callback(lambda done: self._arrive(index, done))

    def _arrive(self, index: int, found: "Future[Flow]") -> None:
        with self._lock:
            self._waiting.discard(index)
            if found.cancelled() or self._style[0] == NONE:
                return
            # The browser may have left, and a file may be in the middle of a write.
            with contextlib.suppress(RuntimeError, OSError), self._client.atomic():
                self._paint(index, found.result())

    def _paint(self, index: int, flow: Flow) -> None:
        first, self._flow = self._flow is None, flow
        kind, theme = self._style
        limits = self._fields.limits(flow)
        left, bottom, right, top = (float(edge) for edge in flow.box)
        centre = place(np.array([0.5 * (left + right), 0.5 * (bottom + top)]), FIELD)
        scene, name = self._client.scene, f"/field/{index}"
        self._pictures[index] = scene.add_frame(name, show_axes=False, visible=index == self._shown)
        scene.add_image(
            f"{name}/picture", flow.picture(kind, theme, limits), right - left, top - bottom, format="jpeg",
            jpeg_quality=92, wxyz=UPRIGHT, position=centre, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        scene.add_line_segments(
            f"{name}/arrows", flow.arrows(limits[1]), theme.velocity, thickness=1.2, thickness_units="screen"
        )
        while len(self._pictures) > KEPT:
            oldest = next(one for one in self._pictures if one != self._shown)
            self._pictures.pop(oldest).remove()
        if first:
            self._told()
