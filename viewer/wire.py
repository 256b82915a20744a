"""Direct messages to a browser that bypass viser's handles: new values, and scripts.

viser casts, compares, copies and sends every value separately for each browser, which takes more time than the rest of
a frame. Data drawn once for all browsers need none of this, and are sent as one message per node, chart or control.
"""

import dataclasses
import functools
from typing import Any

import numpy as np
import viser


def send(handle: Any, **values: Any) -> None:
    """Set several values of a scene node, control or chart in one message.

    Arrays must have viser's type and may not change afterwards. This uses a private part of viser; a version without it
    gets the values one by one, at a higher cost.
    """
    try:
        inside, kinds = handle._impl, viser._messages
        if hasattr(inside, "name"):
            queue = inside.api._queue_scene_message
            message = _plain(kinds.SceneNodeUpdateMessage)(inside.name, values)
        else:
            queue = inside.gui_api._websock_interface.queue_message
            message = _plain(kinds.GuiUpdateMessage)(inside.uuid, values)
    except (AttributeError, TypeError):
        for name, value in values.items():
            setattr(handle, name, value)
    else:
        queue(message)


@functools.cache
def _plain(kind: type) -> Any:
    """A viser message that is sent unchanged; viser ignores kinds with this prefix."""

    names = [one.name for one in dataclasses.fields(kind)]

    def pack(message: Any, buffers: list[memoryview] | None = None) -> dict[str, Any]:
        if buffers is None:
            return kind.as_serializable_dict(message) | {"type": kind.__name__}  # type: ignore[attr-defined]
        packed = {name: _pack(value, buffers) for name, value in message.updates.items()}
        return {name: getattr(message, name) for name in names} | {"updates": packed, "type": kind.__name__}

    return type(f"_Plain{kind.__name__}", (kind,), {"as_serializable_dict": pack})


def _pack(value: Any, buffers: list[memoryview]) -> Any:
    """A value with its arrays moved to the buffers and replaced by their indices."""
    if isinstance(value, np.ndarray):
        buffers.append(value.data)
        return {"__binary_index": len(buffers) - 1, "dtype": value.dtype.str}
    if isinstance(value, tuple):
        return tuple(_pack(part, buffers) for part in value)
    return value


def run(client: Any, script: str) -> bool:
    """Run a script in a page; False if this version of viser does not allow it."""
    try:
        message = viser._messages.RunJavascriptMessage(source=script)
        client._websock_connection.queue_message(message)
    except (AttributeError, TypeError):
        return False
    return True
