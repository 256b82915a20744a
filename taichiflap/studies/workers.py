"""Batches in processes of this machine, for studies whose cases are so short that Python's own work holds them up.

While one process marches and measures its cases, another does the same with others: threads of one process would wait
for each other, as Taichi holds Python's lock while a kernel runs. A worker is a bare interpreter that reads batches
from a pipe and writes their outcomes to another; unlike those of `multiprocessing` it imports nothing of the program
that started it, so a script needs no guard. What fails there is run here, and fails, if it does, with its own words.
"""

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..case.case import Case
from ..case.solver import ELSEWHERE
from ..kernels.arrays import Spare
from ..maps.outcome import Outcome
from .batch import Batch, compute, work

SHORT = 2e7
"""Work of a case, in pair interactions, below which Python's share of it counts: some 20 ms."""
SHARE = 500
"""Cases that are worth a process: it is ready after a second, in which another runs as many."""
AHEAD = 2
"""Batches that a worker has been given, so that it does not wait for the next."""

Found = tuple[Batch, list[Outcome]]


def worth(case: Case, pending: int, threads: int) -> int:
    """How many processes so many cases like this one are worth, the one that asks included."""
    # A model of one's own may be in the program that runs; a program with Python inside is no interpreter.
    python = Path(sys.executable or "").name.startswith("python")
    if not python or case.solver.startswith(ELSEWHERE) or work(case) > SHORT:
        return 1
    return max(1, min(threads, pending // SHARE))


def shared(
    found: Iterable[Batch],
    metrics: Sequence[str],
    keep_series: bool,
    count: int,
    progress: Callable[[Batch, float], None],
) -> Iterator[Found]:
    """Run batches in `count` processes, this one among them, each on one thread; they come in any order.

    Args:
        progress: called with a batch that runs here and the share of it that is done.
    """
    waiting = iter(found)
    come: queue.SimpleQueue[tuple[Worker, Batch, list[Outcome] | None]] = queue.SimpleQueue()

    spare = Spare()

    def here(batch: Batch) -> Found:
        return batch, compute(batch.cases, metrics, keep_series, 1, lambda share: progress(batch, share), spare)

    with contextlib.ExitStack() as stack:
        crew = [stack.enter_context(Worker(come)) for _ in range(count - 1)]
        running = 0
        while True:
            for worker in crew:
                while worker.holds < AHEAD and (batch := next(waiting, None)) is not None:
                    worker.send(batch, metrics, keep_series)
                    running += 1
            own = next(waiting, None)
            if own is not None:
                yield here(own)
            elif not running:
                return
            while running and (own is None or not come.empty()):
                worker, batch, outcomes = come.get()
                running -= 1
                # One that has failed is given no more.
                worker.holds += -1 if outcomes is not None else AHEAD
                yield (batch, outcomes) if outcomes is not None else here(batch)
                if own is None:
                    break


class Worker:
    """A process that runs batches, and the two threads that talk to it.

    Attributes:
        holds: batches that it has been given and not given back.

    Args:
        come: where itself, each batch and what came of it are put, None if the worker failed.
    """

    def __init__(self, come: Any) -> None:
        self.holds = 0
        self._come = come
        self._given: queue.SimpleQueue[tuple[Batch, bytes] | None] = queue.SimpleQueue()
        self._sent: queue.SimpleQueue[Batch | None] = queue.SimpleQueue()
        start = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve()"
        self._process = subprocess.Popen([sys.executable, "-c", start], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._write, self._read)]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> "Worker":
        return self

    def __exit__(self, *_: Any) -> None:
        self._given.put(None)
        self._process.kill()
        for thread in self._threads:
            thread.join()
        for pipe in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()  # type: ignore[union-attr]
        self._process.wait()

    def send(self, batch: Batch, metrics: Sequence[str], keep_series: bool) -> None:
        """Give it a batch."""
        self.holds += 1
        self._given.put((batch, pickle.dumps((batch.cases, list(metrics), keep_series))))

    def _write(self) -> None:
        while given := self._given.get():
            batch, data = given
            self._sent.put(batch)
            with contextlib.suppress(OSError):  # the reader finds out
                self._process.stdin.write(data)  # type: ignore[union-attr]
                self._process.stdin.flush()  # type: ignore[union-attr]
        self._sent.put(None)

    def _read(self) -> None:
        while batch := self._sent.get():
            outcomes = None
            with contextlib.suppress(Exception):  # any exception of pickle for what a dying process has written
                outcomes = pickle.load(self._process.stdout)  # type: ignore[arg-type]
            self._come.put((self, batch, outcomes))


def serve() -> None:
    """What a worker does until nothing more can come."""
    # An interrupt of the terminal is for the process that started it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with os.fdopen(os.dup(1), "wb") as answers:
        # Whatever is printed here must not get between the answers.
        os.dup2(2, 1)
        spare = Spare()
        with contextlib.suppress(EOFError, OSError):
            while True:
                cases, metrics, keep_series = pickle.load(sys.stdin.buffer)
                answer: list[Outcome] | None = None
                with contextlib.suppress(Exception):  # it is run again, and reported, where it came from
                    answer = compute(cases, metrics, keep_series, 1, spare=spare)
                pickle.dump(answer, answers)
                answers.flush()
