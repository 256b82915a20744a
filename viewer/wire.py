"""What goes to a browser past viser's own handles: new values as they are, and scripts.

viser casts, compares, copies and sends a property at a time, for each browser anew: more work than everything else
that a frame asks for. What is drawn once for all browsers needs none of it, and goes out as one message a node.
"""

from typing import Any

import viser


def send(handle: Any, **values: Any) -> None:
    """Give a node of the scene new values in one message.

    Arrays have the type that viser keeps, and never change afterwards. The way in is private to viser: a version
    without it gets the values one by one, at a higher cost.
    """
    try:
        queue = handle._impl.api._queue_scene_message
        message = viser._messages.SceneNodeUpdateMessage(handle._impl.name, values)
    except (AttributeError, TypeError):
        for name, value in values.items():
            setattr(handle, name, value)
    else:
        queue(message)


def run(client: Any, script: str) -> bool:
    """Run a script in a page; False if this viser has no way to."""
    try:
        message = viser._messages.RunJavascriptMessage(source=script)
        client._websock_connection.queue_message(message)
    except (AttributeError, TypeError):
        return False
    return True
