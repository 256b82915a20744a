"""Common parts of our HDF5 files: structures with checksums, and text of fixed length.

HDF5 stores text of variable length in a heap without checksums, and damage there can make the library loop endlessly.
All text that is read back therefore has a fixed length.
"""

import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

VERSION = ("v108", "latest")
"""HDF5 layouts of 2008 and later: with checksums, and attributes over 64 kB."""
REASON_BYTES = 512
"""Space reserved for the reason of a failure, bytes."""


class Guarded(io.RawIOBase):
    """A file object for HDF5 that hides write errors, since HDF5 may crash on them.

    After the first error the file is no longer touched: HDF5 sees success, and `error` holds the system's error.

    Args:
        path: the file; it is replaced if `fresh`.
        fresh: whether to create a new file.

    Raises:
        OSError: if it cannot be opened.
    """

    def __init__(self, path: Path, fresh: bool = True) -> None:
        super().__init__()
        self._raw = open(path, "w+b" if fresh else "r+b", buffering=0)  # noqa: SIM115 - closed by `close`
        self._end = self._raw.seek(0, 2)
        self._place = 0
        self.error: OSError | None = None

    def check(self) -> None:
        """Raise the first write error.

        Raises:
            OSError: the first write error.
        """
        if self.error:
            raise self.error

    def sync(self) -> None:
        """Make the system write the file to the disk.

        Raises:
            OSError: the first write error.
        """
        self.check()
        os.fsync(self._raw.fileno())

    def stop(self) -> None:
        """Stop touching the file."""
        self.error = self.error or OSError("given up")

    def close(self) -> None:
        """Close the flushed file."""
        if not self.closed:
            self._raw.close()
        super().close()

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = 0) -> int:
        self._place = offset + (0, self._place, self._end)[whence]
        return self._place

    def tell(self) -> int:
        return self._place

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        view[:] = bytes(len(view))
        done = 0
        try:
            self._raw.seek(self._place)
            while done < len(view) and (got := self._raw.readinto(view[done:])):
                done += got
        except OSError as error:
            self.error = self.error or error
        self._place += len(view)
        return len(view)

    def write(self, data: Any) -> int:
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            if not self.error:
                self._raw.seek(self._place)
            while len(left) and not self.error:
                left = left[self._raw.write(left) :]
        except OSError as error:
            self.error = error
        self._place += size
        self._end = max(self._end, self._place)
        return size

    def truncate(self, size: int | None = None) -> int:
        self._end = self._place if size is None else size
        try:
            if not self.error:
                self._raw.truncate(self._end)
        except OSError as error:
            self.error = error
        return self._end

    def flush(self) -> None:
        """There is no buffer to flush."""


def create(place: Any, **options: Any) -> Any:
    """Create a new file at a path or in a buffer."""
    return h5py.File(place, "w", libver=VERSION, **options)


def note(place: Any, texts: Mapping[str, str], room: int = 0) -> None:
    """Write text attributes of a file or dataset; existing ones are replaced.

    Args:
        room: minimum number of bytes reserved for a later `rewrite`.
    """
    # Faster than h5py's own method by a factor of three; a file has a hundred attributes.
    one = h5py.h5s.create(h5py.h5s.SCALAR)
    for name, text in texts.items():
        key, value = name.encode(), text.encode()
        kind = text_type(max(room, len(value)))
        if h5py.h5a.exists(place.id, key):
            h5py.h5a.delete(place.id, key)
        stored = h5py.h5t.py_create(kind, logical=True)
        h5py.h5a.create(place.id, key, stored, one).write(np.array(value, dtype=kind))


def rewrite(place: Any, name: str, text: str) -> None:
    """Change a text in place; text beyond the reserved space is cut off."""
    room = place.attrs.get_id(name).dtype.itemsize
    place.attrs.modify(name, np.bytes_(text.encode()[:room]))


def text_type(size: int) -> np.dtype[Any]:
    """Type of a text with a number of bytes; HDF5 needs at least one."""
    return h5py.string_dtype("utf-8", max(1, size))
