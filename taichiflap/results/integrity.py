"""Checks of an HDF5 file before any of its data are read.

A damaged or hostile file may declare more data than it holds, refer to other files by links, external storage or
virtual datasets, or ask for filters that HDF5 would load from disk. All of this is refused before it can do harm.
"""

import functools
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import h5py
import numpy as np

from ..errors import UserError
from ..notation import printable

Found = TypeVar("Found")

OF_LINES = ("case", "warnings", "history")
"""Attributes that may have several lines; extra lines in others could imitate our own output."""
MOST_TEXT = 2**26
"""Maximum size of an attribute, bytes; a case contains its motion tables."""
MOST_LABEL = 2**12
"""Maximum size of a text in an array, bytes."""
MOST_NUMBERS = 10**8
"""Maximum number of entries of an array whose space is not allocated in the file yet."""
SAFE_FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE)
LARGEST = {4: 1e18, 8: 1e100}
"""Maximum magnitude of a value by the size of its type in bytes; its square is finite."""

DAMAGE = (OSError, RuntimeError, LookupError, TypeError, ValueError, ArithmeticError, MemoryError)
"""Exceptions that HDF5 and h5py raise for damaged files."""


class DamageError(UserError):
    """Raised for invalid content of a file; a short description."""


def _in_words(look: Callable[..., Found]) -> Callable[..., Found]:
    @functools.wraps(look)
    def looked(place: Any, name: str, *arguments: Any, **options: Any) -> Found:
        try:
            return look(place, name, *arguments, **options)
        except DamageError:
            raise
        except DAMAGE as error:
            raise DamageError(f"{name}: {str(error).partition(chr(10))[0]}") from None

    return looked


def plain(value: str | bytes) -> str:
    """Lines made printable: without invalid characters and terminal control codes."""
    text = value.decode(errors="replace") if isinstance(value, bytes) else value
    text = text.encode(errors="surrogateescape").decode(errors="replace")
    return "\n".join(map(printable, text.replace("\t", " ").split("\n")))


@_in_words
def attribute(file: Any, name: str) -> Any:
    """A scalar attribute: plain text or a number.

    Raises:
        DamageError: if it is missing, too large, or of another type.
    """
    if name not in file.attrs:
        raise DamageError(f"{name} is missing")
    stored = h5py.h5a.open(file.id, name.encode())
    if stored.shape != () or stored.get_storage_size() > MOST_TEXT:
        raise DamageError(f"{name} is neither text nor a number")
    if stored.dtype.kind == "O":
        raise DamageError(
            f"{name} is text of variable length, as written by other programs and by taichiflap before November 2026"
        )
    value = file.attrs[name]
    if isinstance(value, str | bytes):
        return plain(value) if name in OF_LINES else printable(plain(value))
    if not isinstance(value, np.number):
        raise DamageError(f"{name} is neither text nor a number")
    return value.item()


def attributes(file: Any, names: Iterable[str]) -> dict[str, Any]:
    """Those of the given scalar attributes that exist.

    Raises:
        DamageError: if one is invalid.
    """
    return {name: attribute(file, name) for name in names if _has(file, name)}


@_in_words
def _has(file: Any, name: str) -> bool:
    return name in file.attrs


@_in_words
def array(group: Any, name: str, shape: tuple[int | None, ...], kinds: str, *, whole: bool = True) -> tuple[int, ...]:
    """Check a dataset, and return its shape.

    Args:
        shape: expected shape; None for any length.
        kinds: NumPy kind letters that are allowed, such as "if"; "S" is text.
        whole: whether it must be fully allocated: contiguous, or one chunk per entry of its first axis.

    Raises:
        DamageError: if it is invalid or stored outside the file.
    """
    if name not in group or not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise DamageError(f"{name} is missing")
    dataset = group[name]
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in kinds:
        raise DamageError(f"{name} is not an array of numbers")
    if dataset.dtype.itemsize > (MOST_LABEL if dataset.dtype.kind == "S" else 8):
        raise DamageError(f"{name} has entries of {dataset.dtype.itemsize} bytes")
    found = dataset.shape or ()
    if len(found) != len(shape) or any(want not in (None, have) for want, have in zip(shape, found, strict=True)):
        raise DamageError(f"{name} has shape {found}")
    made = dataset.id.get_create_plist()
    filters = [made.get_filter(i)[0] for i in range(made.get_nfilters())]
    if made.get_external_count() or dataset.is_virtual or any(one not in SAFE_FILTERS for one in filters):
        raise DamageError(f"{name} is not in the file itself")
    if whole and dataset.chunks:
        _check_chunks(dataset, name)
    elif whole:
        offset, size = dataset.id.get_offset(), int(dataset.nbytes)
        if size and (offset is None or offset + size > group.file.id.get_filesize()):
            raise DamageError(f"{name} is truncated")
    elif dataset.size > MOST_NUMBERS:
        raise DamageError(f"{name} is too large")
    return tuple(found)


def _check_chunks(dataset: Any, name: str) -> None:
    """Check that every entry of the first axis is a chunk of its own that lies within the file."""
    if dataset.chunks != (1, *dataset.shape[1:]) or np.prod(dataset.chunks) > MOST_NUMBERS:
        raise DamageError(f"{name} is not stored frame by frame")
    ends: list[int] = []
    dataset.id.chunk_iter(lambda one: ends.append(one.byte_offset + one.size))
    if len(ends) != len(dataset) or max(ends, default=0) > dataset.file.id.get_filesize():
        raise DamageError(f"{name} is truncated")


@_in_words
def group(file: Any, name: str) -> Any:
    """A group stored in the file itself.

    Raises:
        DamageError: if there is none.
    """
    if name not in file or not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise DamageError(f"{name} is missing")
    if not isinstance(file[name], h5py.Group):
        raise DamageError(f"{name} is not a group")
    return file[name]


def numbers(values: np.ndarray, name: str) -> np.ndarray:
    """The values, if all are finite and within range.

    Raises:
        DamageError: if a value is not.
    """
    if values.dtype.kind == "f" and not np.abs(values).max(initial=0.0) < LARGEST[values.dtype.itemsize]:
        raise DamageError(f"{name} has values that are not numbers or out of range")
    return values
