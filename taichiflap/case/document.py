"""A case file as text and as nested tables, with limits on size, depth and number of keys, since files may be
untrusted.
"""

import math
import os
import re
import stat
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..notation import printable

MOST_BYTES = 2**24
"""Maximum size, in bytes, of a case file or a motion table: half a million rows."""
MOST_KEYS = 2000
"""Maximum number of keys and tables; the longest case has a hundred."""
DEEPEST = 16
"""Maximum nesting of tables; a case has three levels."""
LONGEST = 2**63
"""Upper bound of whole numbers, far above any value in a case."""
CHAIN = re.compile(r"(?:^|[\[{,])(?:[ \t]*(?:\"[^\"\n]*\"|'[^'\n]*'|[\w-]+)[ \t]*\.){17}", re.MULTILINE | re.ASCII)
"""A dotted key with too many parts; the time that tomllib takes grows with their square."""


class DocumentError(ValueError):
    """Raised for a file or text that cannot be a case; one sentence."""


def read_text(path: Path, *, regular: bool = False) -> str:
    """Text of a UTF-8 file, without a byte order mark.

    Args:
        regular: see `read_bytes`.

    Raises:
        DocumentError: if it is too large, not a regular file, or not text.
        OSError: when the system refuses.
    """
    return read_bytes(path, regular=regular).decode("utf-8-sig")


def read_bytes(path: Path, *, regular: bool = False) -> bytes:
    """The bytes of a file.

    Args:
        regular: accept only regular files, since a pipe would block and a device never ends.

    Raises:
        DocumentError: if it is too large or not a regular file.
        OSError: when the system refuses.
    """
    if "\0" in str(path):
        raise DocumentError("a file name cannot contain NUL")
    # Open first, then check, so that the file cannot be replaced in between; do not wait for a pipe.
    at_once = getattr(os, "O_NONBLOCK", 0) if regular else 0
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | at_once)) as file:
        found = os.fstat(file.fileno())
        if regular and not stat.S_ISREG(found.st_mode):
            raise DocumentError("not a regular file")
        data = b"" if found.st_size > MOST_BYTES else file.read(MOST_BYTES + 1)
    if found.st_size > MOST_BYTES or len(data) > MOST_BYTES:
        raise DocumentError(f"larger than the limit of {MOST_BYTES >> 20} MB")
    return data


def read_toml(text: str) -> dict[str, Any]:
    """Nested tables of a TOML text.

    Raises:
        DocumentError: if it is not TOML or is nested too deeply.
    """
    if CHAIN.search(text):
        raise DocumentError("not a case file: tables nested too deeply")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise DocumentError(f"not valid TOML: {error}") from None
    except RecursionError:
        raise DocumentError("not a case file: tables nested too deeply") from None
    except (ValueError, OverflowError) as error:
        raise DocumentError(f"not valid TOML: {str(error).partition(';')[0]}") from None


def check(document: Mapping[str, Any]) -> None:
    """Raise an error if a document is nested too deeply, has too many keys, or has a whole number out of range.

    Raises:
        DocumentError: names the key at fault, if there is one.
    """
    count = 0
    waiting: list[tuple[str, Any, int]] = [("", document, 0)]
    while waiting:
        name, value, depth = waiting.pop()
        if isinstance(value, int) and abs(value) >= LONGEST:
            raise DocumentError(f"{printable(name)}: whole number with {_digits(value)} digits; give at most 18")
        if depth > DEEPEST:
            raise DocumentError("not a case file: tables nested too deeply")
        if isinstance(value, Mapping):
            count += len(value)
            if count > MOST_KEYS:
                raise DocumentError(f"not a case file: more than {MOST_KEYS:,} keys")
            inside = f"{name}." if name else ""
            waiting += [(f"{inside}{key}", one, depth + 1) for key, one in value.items() if _may_hide(one)]
        elif isinstance(value, list):
            waiting += [(name, one, depth + 1) for one in value if _may_hide(one)]


def _may_hide(value: Any) -> bool:
    # Motion tables hold millions of numbers.
    kind = type(value)
    return kind is not float and (kind is list or (kind is int and abs(value) >= LONGEST) or isinstance(value, Mapping))


def _digits(value: int) -> int:
    """Approximate number of digits of a whole number; Python prints at most 4,300."""
    return int((abs(value).bit_length() - 1) * math.log10(2.0)) + 1


def own_case(text: str) -> dict[str, Any]:
    """The case document stored in a result or map, with its text made printable.

    Raises:
        DocumentError: if it is not a case.
    """
    return {printable(key): _printable(value) for key, value in read_toml(text).items()}


def names_no_file(document: Mapping[str, Any]) -> None:
    """Raise an error if a case names a file where no file may be opened.

    Raises:
        DocumentError: names the key.
    """
    motion = document.get("motion")
    for name, table in motion.items() if isinstance(motion, Mapping) else ():
        if isinstance(table, Mapping) and table.get("file") is not None:
            raise DocumentError(
                f"motion.{printable(str(name))}.file: no file may be read here; results and maps contain their "
                "points, and a study reads them from the case file"
            )


def _printable(value: Any) -> Any:
    if isinstance(value, str):
        return printable(value)
    if isinstance(value, dict):
        return {printable(key): _printable(one) for key, one in value.items()}
    # Only lists of text are followed, since motion tables are long.
    return [_printable(one) for one in value] if isinstance(value, list) and any(map(_is_text, value)) else value


def _is_text(value: Any) -> bool:
    return isinstance(value, str | dict)
