"""The solver process of `explore`, separate because Taichi holds Python's lock for long and would block every page.

Every browser has at most one request; a newer one replaces it. An outdated run is cancelled unless it is nearly done,
so that results appear while a slider is dragged.
"""

import contextlib
import itertools
import math
import multiprocessing
import os
import signal
import tempfile
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from taichiflap import Result, fluids, open_result
from taichiflap.case.case import Case, parse_case
from taichiflap.errors import UserError
from taichiflap.results.reader import PART, part

PATIENCE = 0.5
"""Maximum remaining time, s, of an outdated run that is completed."""
PLACES = 64
SHARED_MEMORY = Path("/dev/shm")

LONG = 1.0
"""A run that takes more seconds is shown while it is computed, and lets the wishes of other browsers go first."""
DEEPEST = 3
"""Runs at most that stand still for another's, one inside the other."""
SHORT = 0.3
"""A run that takes fewer seconds, probably, is handed over in memory: its file takes longer than its flow."""
FIRST_PACE = 3e-9
"""Time of a pair interaction, s, by which the first run of a model is judged."""
BEGUN = "begun"
"""Reason text of a file that is still being written."""
ENDED = "The solver process has ended; restart the viewer."

Found = Path | Result | None
"""The file of a result; a short one itself, through the pipe from our own process."""
Answer = Callable[[int, Found, str, float], None]
"""Called with the number of a wish and what was found; or None and why there is none, nothing if it was given up;
and the seconds that it took. Before that, of a long run, with the file as it is written and `BEGUN`."""


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
        # The newest request of each browser, until it is sent: a process that compiles does not read its pipe.
        self._requests: dict[int, tuple[int, dict[str, Any]]] = {}
        self._news = threading.Condition(self._lock)
        self._closing = self._over = False
        self.ready = threading.Event()
        self._process = context.Process(
            target=_work, args=(other, self._wanted, self._folder.name, threads, case.to_dict()), daemon=True
        )
        self._process.start()
        other.close()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()
        self._sender = threading.Thread(target=self._send, daemon=True)
        self._sender.start()

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
        if not self.alive:
            raise OSError(ENDED)
        with self._news:
            number = next(self._numbers)
            self._wanted[place] = number
            self._requests[place] = number, case.to_dict()
            self._news.notify()
            return number

    @property
    def alive(self) -> bool:
        """Whether the process is running."""
        # A process that has been killed closes its pipe a moment before it is gone.
        return not self._over and self._process.is_alive()

    def close(self) -> None:
        """End the process."""
        with self._news:
            self._closing = True
            self._news.notify()
        self._process.terminate()
        self._process.join()
        self._sender.join()
        self._pipe.close()
        self._listener.join()
        self._folder.cleanup()

    def _send(self) -> None:
        while True:
            with self._news:
                self._news.wait_for(lambda: self._requests or self._closing)
                if self._closing:
                    return
                place = next(iter(self._requests))
                number, document = self._requests.pop(place)
            try:
                self._pipe.send((place, number, document))
            except OSError:
                return

    def _listen(self) -> None:
        while True:
            try:
                place, number, found, reason, seconds = self._pipe.recv()
            except (EOFError, OSError):
                break
            if place is None:
                self.ready.set()
                continue
            with self._lock:
                answer = self._answers.get(place)
            if answer:
                self._tell(answer, number, found, reason, seconds)
            elif isinstance(found, Path) and reason != BEGUN:
                found.unlink(missing_ok=True)
        self.ready.set()
        with self._lock:
            self._over = True
            left = [] if self._closing else list(self._answers.values())
        for answer in left:
            self._tell(answer, next(self._numbers), None, ENDED, 0.0)

    @staticmethod
    def _tell(answer: Answer, *found: Any) -> None:
        """Call a browser's function, whose errors are not those of the others."""
        try:
            answer(*found)
        except Exception:
            traceback.print_exc()


def received(found: Path | Result) -> Result:
    """The result of an answer; only a result that is still being written keeps its file.

    Raises:
        OSError: if it is gone.
        ResultError: if the file cannot be read.
    """
    if isinstance(found, Result):
        return found
    result = open_result(found)
    if found.suffix != PART:
        found.unlink()
    return result


def _work(pipe: Any, wanted: Any, folder: str, threads: int | None, first: dict[str, Any]) -> None:
    """Main function of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # The pages go first.
    os.nice(5)
    from taichiflap import simulate  # noqa: PLC0415 - in this process alone

    with contextlib.suppress(UserError):
        simulate(parse_case(first), threads=threads).close()
    pipe.send((None, 0, None, "", 0.0))
    _Desk(pipe, wanted, Path(folder), threads).serve()


class _Desk:
    """Receives the requests of all browsers and computes one after the other.

    A long run stops at times to let others go first: they are computed inside it.
    """

    def __init__(self, pipe: Any, wanted: Any, folder: Path, threads: int | None) -> None:
        self._pipe, self._wanted, self._folder, self._threads = pipe, wanted, folder, threads
        self._wishes: dict[int, tuple[int, dict[str, Any]]] = {}
        self._paces: dict[str, float] = {}
        self._depth = 0

    def serve(self) -> None:
        """Compute requests until the parent process ends."""
        with contextlib.suppress(EOFError, ConnectionError):
            while True:
                self._hear(wait=not self._wishes)
                self._compute_next()

    def _hear(self, wait: bool = False) -> None:
        while wait or self._pipe.poll():
            place, number, document = self._pipe.recv()
            # A newer request keeps the turn of the older one.
            self._wishes[place] = number, document
            wait = False

    def _compute_next(self) -> None:
        place = next(iter(self._wishes))
        number, document = self._wishes.pop(place)
        self._pipe.send((place, number, *self._compute(place, number, document)))

    def _compute(self, place: int, number: int, document: dict[str, Any]) -> tuple[Found, str, float]:
        from taichiflap import simulate  # noqa: PLC0415 - in this process alone

        path = self._folder / f"{number}.h5"
        began, others, told = time.perf_counter(), 0.0, False

        def progress(done: int, total: int) -> None:
            nonlocal others, told
            taken = time.perf_counter() - began - others
            left = taken * (total - done) / max(done, 1)
            if left > PATIENCE and self._wanted[place] != number:
                raise _GivenUp
            if taken < LONG:
                return
            if not told and part(path).exists():
                told = True
                self._pipe.send((place, number, part(path), BEGUN, taken))
            others += self._let_others_go_first()

        try:
            case = parse_case(document)
            pairs = _pairs(case)
            short = pairs * self._paces.get(case.solver, FIRST_PACE) < SHORT
            result = simulate(case, None if short else path, threads=self._threads, progress=progress)
            if not short:
                result.close()
        except _GivenUp:
            reason = ""
        except (UserError, OSError, ValueError, RuntimeError) as error:
            reason = str(error) or type(error).__name__
        except Exception as error:
            # One case never ends the process that computes for all browsers.
            reason = f"{type(error).__name__}: {error}"
        else:
            taken = time.perf_counter() - began - others
            # The fastest run so far: others were compiled, or shared the processors.
            self._paces[case.solver] = min(self._paces.get(case.solver, math.inf), taken / max(pairs, 1.0))
            return result if short else path, "", taken
        for left in self._folder.glob(f"{path.name}*"):
            left.unlink(missing_ok=True)
        return None, reason, time.perf_counter() - began - others

    def _let_others_go_first(self) -> float:
        """Compute the waiting requests, and send the time taken."""
        began = time.perf_counter()
        self._hear()
        if self._wishes and self._depth < DEEPEST:
            self._depth += 1
            try:
                self._compute_next()
            finally:
                self._depth -= 1
        return time.perf_counter() - began


def _pairs(case: Case) -> float:
    """Pair interactions of a case, about: the measure of what it costs."""
    resolved = case.resolved()
    return fluids.load(case.solver).work(resolved, resolved.steps // 2) * resolved.steps
