"""What our HDF5 files have in common: a structure with checksums, and texts of a fixed length.

HDF5 keeps texts of varying length in a heap of their own without checksums, and where that is damaged the library
itself may go round in circles for ever. So every text that is read back stands where it belongs, at its full length.
"""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

VERSION = ("v108", "latest")
"""HDF5's layouts of 2008 and later: with checksums, and with room for attributes over 64 kB."""
REASON_BYTES = 512
"""Room for the reason of a failure."""


class Guarded(io.RawIOBase):
    """A file as HDF5 writes it, where the disk's refusal does not reach HDF5, which would not survive it.

    After the first refusal nothing touches the file any more: HDF5 is told that all went well, and `error` has what
    the system said.

    Args:
        path: the file; a new one replaces it.
        fresh: whether it is a new one.

    Raises:
        OSError: when it cannot be opened.
    """

    def __init__(self, path: Path, fresh: bool = True) -> None:
        super().__init__()
        self._raw = open(path, "w+b" if fresh else "r+b", buffering=0)  # noqa: SIM115 - closed by `close`
        self._end = self._raw.seek(0, 2)
        self._place = 0
        self.error: OSError | None = None

    def check(self) -> None:
        """Raise what the disk refused.

        Raises:
            OSError: the first refusal.
        """
        if self.error:
            raise self.error

    def stop(self) -> None:
        """Let nothing touch the file any more."""
        self.error = self.error or OSError("given up")

    def close(self) -> None:
        """Close the file, which has been flushed."""
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
        """Nothing waits here."""


def create(place: Any, **options: Any) -> Any:
    """A new file, in a path or a buffer."""
    return h5py.File(place, "w", libver=VERSION, **options)


def note(place: Any, texts: Mapping[str, str], room: int = 0) -> None:
    """Texts as attributes of a file or dataset, in the place of those of the same names.

    Args:
        room: bytes to keep at least, for what `rewrite` will put there.
    """
    # Past h5py's own way, which takes three times as long: a file has a hundred.
    one = h5py.h5s.create(h5py.h5s.SCALAR)
    for name, text in texts.items():
        key, value = name.encode(), text.encode()
        kind = text_type(max(room, len(value)))
        if h5py.h5a.exists(place.id, key):
            h5py.h5a.delete(place.id, key)
        stored = h5py.h5t.py_create(kind, logical=True)
        h5py.h5a.create(place.id, key, stored, one).write(np.array(value, dtype=kind))


def rewrite(place: Any, name: str, text: str) -> None:
    """Change a text where it stands; what has no room there is cut off."""
    room = place.attrs.get_id(name).dtype.itemsize
    place.attrs.modify(name, np.bytes_(text.encode()[:room]))


def text_type(size: int) -> np.dtype[Any]:
    """The type of a text of so many bytes; HDF5 knows none of no bytes at all."""
    return h5py.string_dtype("utf-8", max(1, size))
