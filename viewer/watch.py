"""Whether a file that a page shows is still the one that was opened."""

import contextlib
import time
from pathlib import Path

from taichiflap.results.reader import PART

GRACE_SECONDS = 2.0
"""A run that is done closes and renames its file in this time."""


class Watch:
    """Looks at a file now and then.

    Args:
        path: the file; None for one in memory, which stays.
        fixed: whether nobody should write to it any more.
    """

    def __init__(self, path: Path | None, fixed: bool) -> None:
        self._path, self._fixed = path, fixed
        self._first = self._sign() if path else ()
        self._begun = self._seen = time.monotonic()

    def look(self) -> str:
        """What has become of the file since, in a sentence; nothing if it is the one that was opened."""
        if self._path is None:
            return ""
        name, sign = self._path.name.removesuffix(PART), self._sign()
        if not sign:
            gone = time.monotonic() - self._seen > GRACE_SECONDS
            return f"{name} is no longer there: this page shows what was read before." if gone else ""
        self._seen = time.monotonic()
        if sign[:2] != self._first[:2]:
            return f"{name} has been replaced by another file: start the viewer again to see that one."
        if self._seen - self._begun < GRACE_SECONDS:
            self._first = sign
        if self._fixed and sign != self._first:
            return f"{name} has been changed since it was opened: start the viewer again to see it."
        return ""

    def _sign(self) -> tuple[int, ...]:
        """Device, number, size and time of the file, under its final name as well; nothing if it is not there."""
        assert self._path is not None
        for path in (self._path, self._path.with_name(self._path.name.removesuffix(PART))):
            with contextlib.suppress(OSError):
                found = path.stat()
                return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns
        return ()
