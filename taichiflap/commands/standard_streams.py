"""Standard output and error that cannot be written to: no traceback after the work is done."""

import codecs
import contextlib
import errno
import os
import sys
from typing import Any

PLAIN = str.maketrans(
    {
        "±": "+-", "−": "-", "–": "-", "×": "x", "·": ".", "°": " deg", "²": "2", "³": "3", "µ": "u",
        "“": '"', "”": '"', "‘": "'", "’": "'", "…": "...", "→": "->",
    }
)  # fmt: skip
"""Replacements for letters that an encoding lacks; all others become a question mark."""


class Stream:
    """A text stream that records write errors instead of raising them.

    Attributes:
        failure: the first write error, or None.
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self.failure: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write text or record the error; returns the number of characters."""
        self._try(self._stream.write, text)
        return len(text)

    def writelines(self, lines: Any) -> None:
        """Write lines or record the error."""
        self.write("".join(lines))

    def flush(self) -> None:
        """Flush or record the error."""
        self._try(self._stream.flush)

    def _try(self, act: Any, *arguments: Any) -> None:
        if self.failure:
            return
        try:
            act(*arguments)
        except OSError as error:
            self.failure = error
            # Discard the buffer, since Python would try to write it again at exit.
            with contextlib.suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())


def settle() -> None:
    """Make standard output and error accept any text."""
    codecs.register_error("plain", _plainly)
    # A newly opened file would take the number of a closed stream, and receive what libraries write to it.
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            stream = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - for as long as the program runs
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="plain")
        # Replace both names: libraries take a difference between them for a notebook.
        taking = Stream(stream)
        setattr(sys, name, taking)
        setattr(sys, f"__{name}__", taking)


def failed() -> bool:
    """Flush standard output, and report on standard error if it could not be written. A closed pipe is not an error."""
    sys.stdout.flush()
    failure = getattr(sys.stdout, "failure", None)
    if failure is None or failure.errno == errno.EPIPE:
        return False
    print(f"error: standard output cannot be written: {failure.strerror}", file=sys.stderr)
    sys.stderr.flush()
    return True


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end].translate(PLAIN)
    return "".join(letter if letter.isascii() else "?" for letter in text), error.end
