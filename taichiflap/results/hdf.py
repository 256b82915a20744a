"""What our HDF5 files have in common: a structure with checksums, and texts of a fixed length.

HDF5 keeps texts of varying length in a heap of their own without checksums, and where that is damaged the library
itself may go round in circles for ever. So every text that is read back stands where it belongs, at its full length.
"""

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

VERSION = ("v108", "latest")
"""HDF5's layouts of 2008 and later: with checksums, and with room for attributes over 64 kB."""
REASON_BYTES = 512
"""Room for the reason of a failure."""


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
