"""Detection of files that have been changed or deleted while they are shown."""

import contextlib
import time
from pathlib import Path

from taichiflap.results.reader import PART

GRACE_SECONDS = 2.0
"""Time within which a completed run closes and renames its file, s."""


class Watch:
    """Checks a file from time to time.

    Args:
        path: the file; None in memory.
        fixed: whether the file should not change any more.
    """

    def __init__(self, path: Path | None, fixed: bool) -> None:
        self._path, self._fixed = path, fixed
        self._first = self._sign() if path else ()
        self._begun = self._seen = time.monotonic()

    def look(self) -> str:
        """Sentence about a changed or deleted file; empty if it is unchanged."""
        if self._path is None:
            return ""
        name, sign = self._path.name.removesuffix(PART), self._sign()
        if not sign:
            gone = time.monotonic() - self._seen > GRACE_SECONDS
            return f"{name} has been deleted; this page shows the data read before." if gone else ""
        self._seen = time.monotonic()
        if sign[:2] != self._first[:2]:
            return f"{name} has been replaced by another file; restart the viewer to see it."
        if self._seen - self._begun < GRACE_SECONDS:
            self._first = sign
        if self._fixed and sign != self._first:
            return f"{name} has been changed since it was opened; restart the viewer to see it."
        return ""

    def _sign(self) -> tuple[int, ...]:
        """Device, inode, size and time of the file, also under its final name; empty if it does not exist."""
        assert self._path is not None
        for path in (self._path, self._path.with_name(self._path.name.removesuffix(PART))):
            with contextlib.suppress(OSError):
                found = path.stat()
                return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns
        return ()
