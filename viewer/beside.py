"""The viewer during a simulation, in a separate process, so that neither waits for the other."""

import subprocess
import sys
import threading
from pathlib import Path
from types import TracebackType
from typing import Any

from taichiflap.results.reader import part

LOOK_SECONDS = 0.1


class Beside:
    """Context around the code that writes a result file; shows the file from its creation.

    At the end the viewer stays open until it is interrupted; after an error or interruption it stops at once.

    Args:
        path: the final name of the file.
        options: additional arguments of the `view` command.
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
            # The run ended before the viewer started.
            self._process = self._view(self._path)
        if kind is not None:
            self._process.terminate()
        try:
            self._process.wait()
        except KeyboardInterrupt:
            # The terminal has sent the signal to the viewer as well.
            self._process.wait()

    def _start(self) -> None:
        while self._touched() == self._leftover:
            if self._over.wait(LOOK_SECONDS):
                return
        self._process = self._view(self._file)

    def _view(self, file: Path) -> subprocess.Popen[Any]:
        return subprocess.Popen([sys.executable, "-m", "taichiflap", "view", str(file), *self._options])

    def _touched(self) -> int:
        """Time of the last write to the file, if it exists; a crash may have left a file of this name."""
        try:
            return self._file.stat().st_mtime_ns
        except FileNotFoundError:
            return 0
