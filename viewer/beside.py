"""The viewer beside a simulation, in a process of its own: neither waits for the other."""

import subprocess
import sys
import threading
from pathlib import Path
from types import TracebackType
from typing import Any

from taichiflap.results.reader import part

LOOK_SECONDS = 0.1


class Beside:
    """Shows a result file from when it is begun; use it as a context around what writes the file.

    On leaving, it serves on until it is interrupted; after an error or an interruption it stops at once.

    Args:
        path: the final name of the file.
        options: more arguments of the `view` command.
    """

    def __init__(self, path: Path, *options: str) -> None:
        self._path, self._file = path, part(path)
        self._options = options
        self._process: subprocess.Popen[Any] | None = None
        self._leftover = self._touched()
        self._over = threading.Event()
        self._watcher = threading.Thread(target=self._start, daemon=True)

    def __enter__(self) -> "Beside":
        self._watcher.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        self._watcher.join()
        if self._process is None:
            if kind is not None:
                return
            # The run was over before anyone looked.
            self._process = self._view(self._path)
        if kind is not None:
            self._process.terminate()
        try:
            self._process.wait()
        except KeyboardInterrupt:
            # The terminal has told the viewer as well.
            self._process.wait()

    def _start(self) -> None:
        while self._touched() == self._leftover:
            if self._over.wait(LOOK_SECONDS):
                return
        self._process = self._view(self._file)

    def _view(self, file: Path) -> subprocess.Popen[Any]:
        return subprocess.Popen([sys.executable, "-m", "taichiflap", "view", str(file), *self._options])

    def _touched(self) -> int:
        """When the file was last written, if there is one: a crash may have left one of this name."""
        try:
            return self._file.stat().st_mtime_ns
        except FileNotFoundError:
            return 0
