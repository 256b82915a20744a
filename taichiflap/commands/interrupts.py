"""Ctrl-C, or a request to end, during a command: it is never lost, and ends with a word of advice."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import typer

ENDINGS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals of a batch system, of `kill` and of a terminal that closes: they end a command as Ctrl-C does."""


class Ended(KeyboardInterrupt):
    """A signal other than Ctrl-C."""


@contextmanager
def interruptible(*advice: str) -> Iterator[None]:
    """End with words of advice when interrupted, and with code 128 and the signal's number: 130 for Ctrl-C."""
    code = 128 + signal.SIGINT

    def end(number: int, frame: Any) -> None:
        nonlocal code
        code = 128 + number
        raise Ended

    try:
        with _handled(ENDINGS, signal.SIG_DFL, end):
            yield
    except KeyboardInterrupt:
        # A terminal that has closed takes no words.
        with suppress(OSError):
            print("\n".join(advice), file=sys.stderr, flush=True)
        raise typer.Exit(code) from None


@contextmanager
def _handled(numbers: Sequence[int], standard: Any, handler: Callable[[int, Any], None]) -> Iterator[None]:
    """Handle signals in a way of ours, but for those that somebody has arranged otherwise, as `nohup` does."""
    main = threading.current_thread() is threading.main_thread()
    ours = [number for number in numbers if main and signal.getsignal(number) is standard]
    for number in ours:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, standard)


@contextmanager
def heard(progress: Callable[..., None] | None = None) -> Iterator[Callable[..., None]]:
    """Yield a progress callback that raises KeyboardInterrupt once Ctrl-C has been pressed, or an end asked for.

    Python raises it at once, but where that falls into a callback of a library or a destructor the exception is
    dropped, and a long run would go on.
    """
    asked = False
    ending = {number: signal.getsignal(number) for number in ENDINGS}

    def note(number: int, frame: Any) -> None:
        nonlocal asked
        asked = True
        then = ending.get(number, signal.default_int_handler)
        if callable(then):
            then(number, frame)

    def tell(*done: Any) -> None:
        if asked:
            raise KeyboardInterrupt
        if progress:
            progress(*done)

    with ExitStack() as stack:
        stack.enter_context(_handled([signal.SIGINT], signal.default_int_handler, note))
        for number, handler in ending.items():
            if callable(handler):
                stack.enter_context(_handled([number], handler, note))
        yield tell
