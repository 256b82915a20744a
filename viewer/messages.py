"""What a page may say. viser takes messages of any shape, and stumbles over those that its own page never sends.

Messages that nobody waits for, or that are not in shape, are dropped; what a control is sent is brought between its
bounds. So nothing that a stranger sends ends in a traceback, and none can ask viser for its tunnel to the outside.
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
"""What our pages send. Not among them: uploads, renders, and `ShareUrlRequest`."""
FARTHEST = 1e20
"""Numbers of a camera or a pointer go no farther."""
LONGEST = 2**14
"""Characters of a text, and elements of a list."""


class Connection(ServerConnection):
    """A websocket that hears only what a page of ours would say."""

    async def recv(self, decode: bool | None = None) -> Any:
        """The next message that is in shape."""
        while True:
            raw = await super().recv(decode)
            if is_in_shape(raw):
                return raw


def is_in_shape(raw: str | bytes) -> bool:
    """Whether a message is of a kind that pages send, with the fields and numbers that it should have."""
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
    """Whether no number in it is infinite or out of all proportion, and no text endless."""
    if isinstance(value, int | float):
        return abs(value) <= FARTHEST
    if isinstance(value, str):
        return len(value) <= LONGEST
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return len(parts) <= LONGEST and all(map(_is_modest, parts))


def guard(gui: Any) -> None:
    """Have the controls of a page take no value but those that they offer.

    Private to viser: how it hears of its controls. A version that does so in another way fails here.
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
    """What a control takes for a value that a page has sent: the nearest that it offers; None for nonsense.

    Args:
        props: the control's own: `options`, or `min` and `max`, where it has any.
        now: its present value, which tells the kind.
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
