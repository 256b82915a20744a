"""Standard output and error that cannot take what is written: never a traceback after the work is done."""

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
"""What stands for letters that an encoding lacks; any other is a question mark."""


class Stream:
    """A text stream whose failures to write are noted, once, and not raised.

    Attributes:
        failure: why it could not be written; None while all is well.
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self.failure: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, or note why not; the number of letters."""
        self._try(self._stream.write, text)
        return len(text)

    def writelines(self, lines: Any) -> None:
        """Write lines, or note why not."""
        self.write("".join(lines))

    def flush(self) -> None:
        """Flush, or note why not."""
        self._try(self._stream.flush)

    def _try(self, act: Any, *arguments: Any) -> None:
        if self.failure:
            return
        try:
            act(*arguments)
        except OSError as error:
            self.failure = error
            # What is still in its buffer goes nowhere, lest Python tries once more as it ends.
            with contextlib.suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())


def settle() -> None:
    """Make standard output and error take anything."""
    codecs.register_error("plain", _plainly)
    # A file would get the number of a closed stream, and what libraries write to that stream.
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
        # Both names: libraries take a difference between them for a notebook.
        taking = Stream(stream)
        setattr(sys, name, taking)
        setattr(sys, f"__{name}__", taking)


def failed() -> bool:
    """Flush both, and tell on standard error if standard output could not be written; who closed a pipe has enough."""
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
