"""The flow behind the wing in one browser: images with arrows, each shown only with its own frame.

A page decodes an image some time after it was sent, and drops it if the next one follows too soon. Every image is
therefore a separate hidden node of the scene, sent in advance. From frame to frame only the visibility changes, in the
same message as the wing.
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
from .field import NONE, Fields, Flow, Wanted
from .legend import Bar
from .scene import FIELD, place

PICTURES = 40
"""Maximum number of images per beat."""
AHEAD = 6
"""Number of images requested ahead of the current frame."""
KEPT = 64
"""Maximum number of images in a page."""

# An image is in its own x-y plane; a rotation by 90 degrees about x makes it upright.
UPRIGHT = (np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0)


class Background:
    """The background of one browser's scene.

    Args:
        fields: the flow around the result.
        lock: lock held during changes of the scene.
        told: called once, when the first flow has set the colour ranges.
    """

    def __init__(self, client: Any, fields: Fields, lock: threading.RLock, told: Callable[[], None]) -> None:
        self._client, self._fields, self._lock, self._told = client, fields, lock, told
        self._style: tuple[Wanted, Theme] = Wanted(), LIGHT
        self._pictures: OrderedDict[int, Any] = OrderedDict()
        self._shown: int | None = None
        self._waiting: set[int] = set()
        self._flow: Flow | None = None

    def forget(self) -> None:
        """Reset after the scene has been cleared."""
        self._pictures.clear()
        self._shown = None

    def step(self, index: int) -> int:
        """Frame whose image is shown for a given frame during playback."""
        return index - index % self.stride

    @property
    def stride(self) -> int:
        """Number of frames per image during playback."""
        return max(1, round(self._fields.run.frames_per_beat / PICTURES))

    @property
    def newest(self) -> int:
        """The last frame whose image the page has; 0 for none."""
        return max(self._pictures, default=0)

    def show(self, wanted: Wanted, index: int, theme: Theme, coming: Iterable[int] = ()) -> None:
        """Show the flow of a frame as soon as it is available, and prepare that of the next frames."""
        if (wanted, theme) != self._style:
            for picture in self._pictures.values():
                picture.remove()
            self.forget()
            self._style = wanted, theme
        if wanted.kind == NONE:
            return
        self._show_only(index)
        for one in (index, *coming):
            self._ask(one)

    def bar(self, wanted: Wanted, theme: Theme) -> Bar | None:
        """Entry in the legend, available after the first flow has set the ranges."""
        return field.bar(self._flow, wanted, theme, self._fields.limits(self._flow)) if self._flow else None

    def at(self, right: float, up: float) -> str:
        """Speed and vorticity at a point of the scene as text; empty outside the image or before it exists."""
        if self._shown is None or self._shown not in self._pictures:
            return ""
        found = ""
        for wanted in (self._style[0], self._style[0].read):
            flow = self._fields.ask(self._shown, wanted)
            if flow.done() and not flow.cancelled():
                found = flow.result().at(right, up)
                if flow.result().velocity is not None:
                    break
        return found

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
        wanted = self._style[0]
        found = self._fields.ask(index, wanted)
        if found.done():
            self._paint(index, found.result())
        else:
            self._waiting.add(index)
            found.add_done_callback(lambda done: self._arrive(index, wanted, done))

    def _arrive(self, index: int, wanted: Wanted, found: "Future[Flow]") -> None:
        with self._lock:
            self._waiting.discard(index)
            if found.cancelled() or self._style[0] != wanted:
                return
            # The browser may have disconnected, or a file may be in the middle of a write.
            with contextlib.suppress(RuntimeError, OSError), self._client.atomic():
                self._paint(index, found.result())

    def _paint(self, index: int, flow: Flow) -> None:
        first, self._flow = self._flow is None, flow
        wanted, theme = self._style
        limits = self._fields.limits(flow)
        left, bottom, right, top = (float(edge) for edge in flow.box)
        centre = place(np.array([0.5 * (left + right), 0.5 * (bottom + top)]), FIELD)
        scene, name = self._client.scene, f"/field/{index}"
        self._pictures[index] = scene.add_frame(name, show_axes=False, visible=index == self._shown)
        scene.add_image(
            f"{name}/picture", flow.picture(wanted.kind, theme, limits), right - left, top - bottom, format="jpeg",
            jpeg_quality=92, wxyz=UPRIGHT, position=centre, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        if wanted.arrows:
            scene.add_line_segments(
                f"{name}/arrows", flow.arrows(limits[1]), theme.velocity, thickness=1.2, thickness_units="screen"
            )
        while len(self._pictures) > KEPT:
            oldest = next(one for one in self._pictures if one != self._shown)
            self._pictures.pop(oldest).remove()
        if first:
            self._told()
