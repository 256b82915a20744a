"""A case file as text and as nested tables, read within limits whoever wrote it: no size, depth or count gets far."""

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
"""Bytes of a case file, and of a file of points: half a million rows."""
MOST_KEYS = 2000
"""Keys and tables of a case; the longest has a hundred."""
DEEPEST = 16
"""Tables within tables; a case has three."""
LONGEST = 2**63
"""Whole numbers are smaller: none of a case is anywhere near."""
CHAIN = re.compile(r"(?:^|[\[{,])(?:[ \t]*(?:\"[^\"\n]*\"|'[^'\n]*'|[\w-]+)[ \t]*\.){17}", re.MULTILINE | re.ASCII)
"""A dotted key of more parts than any: tomllib takes time that grows with the square of them."""


class DocumentError(ValueError):
    """A file or a text that cannot be a case: one sentence."""


def read_text(path: Path, *, regular: bool = False) -> str:
    """The text of a file in UTF-8, without the mark that may come first.

    Args:
        regular: see `read_bytes`.

    Raises:
        DocumentError: when it is too large, no regular file, or no text.
        OSError: when the system refuses.
    """
    return read_bytes(path, regular=regular).decode("utf-8-sig")


def read_bytes(path: Path, *, regular: bool = False) -> bytes:
    """The bytes of a file.

    Args:
        regular: refuse what is no regular file before it is opened: a pipe would wait, a device never ends.

    Raises:
        DocumentError: when it is too large, or no regular file.
        OSError: when the system refuses.
    """
    if "\0" in str(path):
        raise DocumentError("a name of a file holds no NUL")
    # Opened first and looked at then, so that nothing takes its place in between; a pipe is not waited for.
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_CLOEXEC", 0) | (getattr(os, "O_NONBLOCK", 0) if regular else 0))
    with open(handle, "rb") as file:
        found = os.fstat(handle)
        if regular and not stat.S_ISREG(found.st_mode):
            raise DocumentError("not a regular file")
        data = b"" if found.st_size > MOST_BYTES else file.read(MOST_BYTES + 1)
    if found.st_size > MOST_BYTES or len(data) > MOST_BYTES:
        raise DocumentError(f"larger than {MOST_BYTES >> 20} MB, the most that is read")
    return data


def read_toml(text: str) -> dict[str, Any]:
    """Nested tables of a TOML text.

    Raises:
        DocumentError: when it is not TOML, or keys are deeper than those of any case.
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
    """Refuse what is too deep, too many, or a whole number too large to be told.

    Raises:
        DocumentError: with the key, where it is one key's fault.
    """
    count = 0
    waiting: list[tuple[str, Any, int]] = [("", document, 0)]
    while waiting:
        name, value, depth = waiting.pop()
        if isinstance(value, int) and abs(value) >= LONGEST:
            raise DocumentError(f"{printable(name)}: a whole number of {_digits(value)} digits; give fewer than 19")
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
    # Tables of motion hold millions of numbers.
    kind = type(value)
    return kind is not float and (kind is list or (kind is int and abs(value) >= LONGEST) or isinstance(value, Mapping))


def _digits(value: int) -> int:
    """About how many digits a whole number has; Python writes out no more than 4,300."""
    return int((abs(value).bit_length() - 1) * math.log10(2.0)) + 1


def own_case(text: str) -> dict[str, Any]:
    """The document of a case that a result or a map holds, with texts that can be printed.

    Raises:
        DocumentError: when it is no case.
    """
    return {printable(key): _printable(value) for key, value in read_toml(text).items()}


def names_no_file(document: Mapping[str, Any]) -> None:
    """Refuse a case that names a file where none may be opened.

    Raises:
        DocumentError: with the key.
    """
    motion = document.get("motion")
    for name, table in motion.items() if isinstance(motion, Mapping) else ():
        if isinstance(table, Mapping) and table.get("file") is not None:
            raise DocumentError(
                f"motion.{printable(str(name))}.file: no file is read here; a result and a map hold their points, "
                "and a study takes them from the case file"
            )


def _printable(value: Any) -> Any:
    if isinstance(value, str):
        return printable(value)
    if isinstance(value, dict):
        return {printable(key): _printable(one) for key, one in value.items()}
    # Of lists only those of texts: tables of motion are long.
    return [_printable(one) for one in value] if isinstance(value, list) and any(map(_is_text, value)) else value


def _is_text(value: Any) -> bool:
    return isinstance(value, str | dict)
