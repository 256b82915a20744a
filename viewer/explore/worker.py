"""The solver process of `explore`, since Taichi holds Python's lock for long and would block every page.

Every browser has at most one request; a newer one replaces it. An outdated run is cancelled unless it is nearly done,
so that results appear while a slider is dragged.
"""

import contextlib
import itertools
import multiprocessing
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from taichiflap.case.case import Case, parse_case
from taichiflap.errors import UserError

PATIENCE = 0.5
"""Maximum remaining time, s, of an outdated run that is completed."""
PLACES = 64
SHARED_MEMORY = Path("/dev/shm")

Answer = Callable[[int, Path | None, str, float], None]
"""Called with the number of a wish and its result file; or None and why there is none, nothing if it was given up;
and the seconds that it took."""


class _GivenUp(Exception):
    """Raised if a run is outdated."""


class Worker:
    """Computes cases in a separate process, for many browsers in turn.

    Args:
        case: computed once at the start, so that the first request does not wait for the compiler.
        threads: number of threads; None for all.
    """

    def __init__(self, case: Case, threads: int | None = None) -> None:
        shared = str(SHARED_MEMORY) if os.access(SHARED_MEMORY, os.W_OK) else None
        self._folder = tempfile.TemporaryDirectory(prefix="taichiflap-explore-", dir=shared)
        context = multiprocessing.get_context("spawn")
        self._wanted = context.Array("Q", PLACES, lock=False)
        self._pipe, other = context.Pipe()
        self._numbers = itertools.count(1)
        self._free = list(range(PLACES))
        self._answers: dict[int, Answer] = {}
        self._lock = threading.Lock()
        self.ready = threading.Event()
        self._process = context.Process(
            target=_work, args=(other, self._wanted, self._folder.name, threads, case.to_dict()), daemon=True
        )
        self._process.start()
        other.close()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def enlist(self, answer: Answer) -> int:
        """Register a browser."""
        with self._lock:
            place = self._free.pop(0)
            self._answers[place] = answer
            return place

    def release(self, place: int) -> None:
        """Unregister a browser."""
        with self._lock:
            self._answers.pop(place, None)
            self._free.append(place)
            self._wanted[place] = next(self._numbers)

    def ask(self, place: int, case: Case) -> int:
        """Request a case, which replaces the browser's previous request; returns the number of the request.

        Raises:
            OSError: if the process has ended.
        """
        with self._lock:
            number = next(self._numbers)
            self._wanted[place] = number
            self._pipe.send((place, number, case.to_dict()))
            return number

    @property
    def alive(self) -> bool:
        """Whether the process is running."""
        return self._process.is_alive()

    def close(self) -> None:
        """End the process."""
        self._process.terminate()
        self._process.join()
        self._pipe.close()
        self._listener.join()
        self._folder.cleanup()

    def _listen(self) -> None:
        while True:
            try:
                place, number, path, reason, seconds = self._pipe.recv()
            except (EOFError, OSError):
                break
            if place is None:
                self.ready.set()
                continue
            with self._lock:
                answer = self._answers.get(place)
            if answer:
                answer(number, path, reason, seconds)
            elif path:
                path.unlink(missing_ok=True)
        self.ready.set()


def _work(pipe: Any, wanted: Any, folder: str, threads: int | None, first: dict[str, Any]) -> None:
    """Main function of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # The pages go first.
    os.nice(5)
    from taichiflap import simulate  # noqa: PLC0415 - in this process alone

    with contextlib.suppress(UserError):
        simulate(parse_case(first), threads=threads).close()
    pipe.send((None, 0, None, "", 0.0))
    wishes: dict[int, tuple[int, dict[str, Any]]] = {}
    while True:
        try:
            while not wishes or pipe.poll():
                place, number, document = pipe.recv()
                # A newer request keeps the turn of the older one.
                wishes[place] = number, document
        except EOFError:
            return
        place = next(iter(wishes))
        number, document = wishes.pop(place)
        answer = _compute(simulate, document, Path(folder) / f"{number}.h5", threads, _Wish(wanted, place, number))
        pipe.send((place, number, *answer))


class _Wish:
    """Whether the current run is still requested."""

    def __init__(self, wanted: Any, place: int, number: int) -> None:
        self._wanted, self._place, self._number = wanted, place, number

    def __call__(self) -> bool:
        return bool(self._wanted[self._place] == self._number)


def _compute(
    simulate: Any, document: dict[str, Any], path: Path, threads: int | None, is_wanted: Callable[[], bool]
) -> tuple[Path | None, str, float]:
    began = time.perf_counter()

    def progress(done: int, total: int) -> None:
        left = (time.perf_counter() - began) * (total - done) / max(done, 1)
        if left > PATIENCE and not is_wanted():
            raise _GivenUp

    try:
        simulate(parse_case(document), path, threads=threads, progress=progress).close()
    except _GivenUp:
        reason = ""
    except (UserError, OSError, ValueError, RuntimeError) as error:
        reason = str(error) or type(error).__name__
    else:
        return path, "", time.perf_counter() - began
    for left in path.parent.glob(f"{path.name}*"):
        left.unlink(missing_ok=True)
    return None, reason, time.perf_counter() - began
