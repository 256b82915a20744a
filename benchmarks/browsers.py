"""Simulated browsers: connections that send the first messages of a page and ignore the answers."""

import contextlib
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import msgspec
import viser
from taichiflap_viewer.server import Server
from websockets.sync.client import connect

CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": [1.0, 0.0, 0.0, 0.0], "position": [0.0, -50.0, 0.0],
    "fov": 0.14, "near": 0.5, "far": 4000.0, "image_height": 720, "image_width": 700,
    "look_at": [0.0, 0.0, 0.0], "up_direction": [0.0, 0.0, 1.0],
}  # fmt: skip
"""What a page says first."""


@contextlib.contextmanager
def browsers(viewer: Server, count: int) -> Iterator[None]:
    """So many browsers, in a process of their own; inside, each has its session."""
    with subprocess.Popen([sys.executable, "-m", __spec__.name, viewer.address, str(count)]) as process:
        while len(viewer.sessions) < count:
            time.sleep(0.05)
        yield
        process.terminate()
    while viewer.sessions:
        time.sleep(0.05)


def browse(address: str, count: int) -> None:
    """Connect so many browsers, until the server ends."""
    protocol: Any = f"viser-v{viser.__version__}"

    def read() -> None:
        with connect(
            address.replace("http", "ws", 1), subprotocols=[protocol], max_size=None, compression=None
        ) as opened:
            opened.send(msgspec.msgpack.encode(CAMERA))
            for _ in opened:
                pass

    for _ in range(count):
        threading.Thread(target=read).start()


if __name__ == "__main__":
    browse(sys.argv[1], int(sys.argv[2]))
