"""Ctrl-C and termination signals during a command: they are never lost, and advice is printed at the end."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import typer

ENDINGS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals from a batch system, `kill` or a closing terminal; they end a command like Ctrl-C."""


class Ended(KeyboardInterrupt):
    """Raised for a signal other than Ctrl-C."""


@contextmanager
def interruptible(*advice: str) -> Iterator[None]:
    """Print advice when interrupted, and exit with code 128 plus the signal's number (130 for Ctrl-C)."""
    code = 128 + signal.SIGINT

    def end(number: int, frame: Any) -> None:
        nonlocal code
        code = 128 + number
        raise Ended

    try:
        with _handled(ENDINGS, signal.SIG_DFL, end):
            yield
    except KeyboardInterrupt:
        # A closed terminal cannot be written to.
        with suppress(OSError):
            print("\n".join(advice), file=sys.stderr, flush=True)
        raise typer.Exit(code) from None


@contextmanager
def _handled(numbers: Sequence[int], standard: Any, handler: Callable[[int, Any], None]) -> Iterator[None]:
    """Handle signals with our own handler, except those handled elsewhere already, for example by `nohup`."""
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
    """Yield a progress callback that raises KeyboardInterrupt after Ctrl-C or a termination signal.

    Python raises it at once, but drops the exception inside a library's callback or a destructor; a long run would then
    continue.
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
