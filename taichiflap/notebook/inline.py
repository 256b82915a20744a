"""The viewer inside a notebook, in a separate process, so that a running cell does not block its page."""

import contextlib
import subprocess
import sys
import tempfile
import threading
import weakref
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from ..results.reader import Result
from . import html

WAIT_SECONDS = 60.0
"""Time limit, s, for the viewer to print its address."""


class Inline:
    """A viewer of one result, shown as the value of a cell; a picture is shown where no viewer can be reached.

    Attributes:
        address: address of the viewer's page, with its token; empty if it did not start.
    """

    def __init__(self, result: Result, height: int = 600, options: Sequence[str] = ()) -> None:
        self.height, self._still = height, html.of_result(result)
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        path = result.path
        if path is None:
            self._folder = tempfile.TemporaryDirectory(prefix="taichiflap-")
            path = Path(self._folder.name, "result.h5")
            result.save(path)
        command = [sys.executable, "-m", "taichiflap", "view", str(path), "--no-browser", *options]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self._end = weakref.finalize(self, _stop, self._process, self._folder)
        self.address = self._said()

    def close(self) -> None:
        """Stop the viewer; the picture remains."""
        self._end()
        self.address = ""

    def __enter__(self) -> "Inline":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<viewer at {self.address}>" if self.address else "<viewer, stopped>"

    def _repr_html_(self) -> str:
        if not self.address:
            return self._still
        # If the object cannot be loaded, as in a notebook read elsewhere, a browser shows its content.
        return (
            f'<object data="{escape(self.address)}" type="text/html" style="width:100%;height:{self.height}px">'
            f"{self._still}</object>"
        )

    def _said(self) -> str:
        """The address, from the last line that the viewer prints at start."""
        lines: list[str] = []

        def read() -> None:
            for line in self._process.stdout or ():
                lines.append(line)
                if "Ctrl-C" in line:
                    return

        reader = threading.Thread(target=read, daemon=True)
        reader.start()
        reader.join(WAIT_SECONDS)
        return next((line.split()[0] for line in lines if "Ctrl-C" in line), "")


def _stop(process: "subprocess.Popen[str]", folder: Any) -> None:
    process.terminate()
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(5.0)
    if process.stdout:
        process.stdout.close()
    if folder:
        folder.cleanup()
