"""Ctrl-C during a command: it is never lost, and ends with a word of advice."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer


@contextmanager
def interruptible(*advice: str) -> Iterator[None]:
    """End with code 130 and words of advice when interrupted."""
    try:
        yield
    except KeyboardInterrupt:
        print("\n".join(advice), file=sys.stderr)
        raise typer.Exit(130) from None


@contextmanager
def heard(progress: Callable[..., None] | None = None) -> Iterator[Callable[..., None]]:
    """Yield a progress callback that raises KeyboardInterrupt once Ctrl-C has been pressed.

    Python raises it at once, but where that falls into a callback of a library or a destructor the exception is
    dropped, and a long run would go on.
    """
    asked = False
    before = signal.getsignal(signal.SIGINT)
    # Whoever has arranged for something else, as a shell for a job in the background, has it so.
    ours = before is signal.default_int_handler and threading.current_thread() is threading.main_thread()

    def note(number: int, frame: Any) -> None:
        nonlocal asked
        asked = True
        signal.default_int_handler(number, frame)

    def tell(*done: Any) -> None:
        if asked:
            raise KeyboardInterrupt
        if progress:
            progress(*done)

    if ours:
        signal.signal(signal.SIGINT, note)
    try:
        yield tell
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)
