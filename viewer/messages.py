"""Validation of messages from a page. viser accepts messages of any form, and fails on those that its own page never
sends.

Unexpected and malformed messages are dropped, and values of controls are limited to their bounds. No message can
therefore cause a traceback, or make viser open its public tunnel.
"""

import dataclasses
import math
from typing import Any

import msgspec
from viser import _messages
from websockets.asyncio.server import ServerConnection

KINDS = {
    kind.__name__: kind
    for kind in (
        _messages.ViewerCameraMessage, _messages.ScenePointerMessage, _messages.GuiUpdateMessage,
        _messages.CommandTriggerMessage, _messages.LocalStorageGetItemResponseMessage,
    )
}  # fmt: skip
"""Messages that our pages send; excludes uploads, renders and `ShareUrlRequest`."""
FARTHEST = 1e20
"""Maximum magnitude of numbers of a camera or a pointer."""
LONGEST = 2**14
"""Maximum length of a text and of a list."""


class Connection(ServerConnection):
    """A websocket that passes on only valid messages."""

    async def recv(self, decode: bool | None = None) -> Any:
        """The next valid message."""
        while True:
            raw = await super().recv(decode)
            if is_in_shape(raw):
                return raw


def is_in_shape(raw: str | bytes) -> bool:
    """Whether a message is of an allowed kind, with valid fields and numbers."""
    if not isinstance(raw, bytes):
        return False
    try:
        said = msgspec.msgpack.decode(raw)
        kind = KINDS[said.pop("type")]
        msgspec.convert(said, kind)
    except (msgspec.MsgspecError, KeyError, TypeError, AttributeError, ValueError, RecursionError):
        return False
    return (
        set(said) <= {one.name for one in dataclasses.fields(kind)} and _is_modest(said) and _is_plausible(kind, said)
    )


def _is_plausible(kind: type, said: dict[str, Any]) -> bool:
    if kind is _messages.GuiUpdateMessage:
        return set(said["updates"]) == {"value"}
    if kind is _messages.ViewerCameraMessage:
        return min(said["image_width"], said["image_height"]) >= 1
    if kind is _messages.ScenePointerMessage:
        return said["event_type"] == "click" and all(
            said[name] for name in ("ray_origin", "ray_direction", "screen_pos")
        )
    return True


def _is_modest(value: Any) -> bool:
    """Whether all its numbers and text lengths are within bounds."""
    if isinstance(value, int | float):
        return abs(value) <= FARTHEST
    if isinstance(value, str):
        return len(value) <= LONGEST
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return len(parts) <= LONGEST and all(map(_is_modest, parts))


def guard(gui: Any) -> None:
    """Limit the values of a page's controls to those offered.

    This uses a private part of viser; a version without it fails here.
    """
    inner, sockets = gui._handle_gui_updates, gui._websock_interface

    async def hear(page: Any, message: _messages.GuiUpdateMessage) -> None:
        handle = gui._gui_input_handle_from_uuid.get(message.uuid)
        value = None if handle is None else fitted(handle._impl.props, handle._impl.value, message.updates["value"])
        if value is not None:
            message.updates = {"value": value}
            await inner(page, message)

    sockets.unregister_handler(_messages.GuiUpdateMessage, inner)
    sockets.register_handler(_messages.GuiUpdateMessage, hear)


def fitted(props: Any, now: Any, value: Any) -> Any:
    """The allowed value of a control nearest to the one sent by a page; None for an invalid value.

    Args:
        props: the control's `options`, or `min` and `max`, if any.
        now: its current value, which defines the type.
    """
    options = getattr(props, "options", None)
    if options is not None:
        return value if isinstance(value, str) and value in options else None
    if isinstance(now, bool):
        return value if isinstance(value, bool) else None
    if isinstance(now, str):
        return value if isinstance(value, str) and len(value) <= LONGEST else None
    if isinstance(now, int | float):
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
            return None
        low, high = getattr(props, "min", None), getattr(props, "max", None)
        value = max(value, -math.inf if low is None else low)
        value = min(value, math.inf if high is None else high)
        return type(now)(round(value) if isinstance(now, int) else value) if math.isfinite(value) else None
    return None
