"""Processes of this machine, for studies whose cases are so short that Python's own work holds them up.

While one process marches and measures its cases, another does the same with others: threads of one process would wait
for each other, as Taichi holds Python's lock while a kernel runs. A worker is a bare interpreter that reads numbers of
cases from a pipe and writes their outcomes to another; unlike those of `multiprocessing` it imports nothing of the
program that started it, so a script needs no guard. What fails there is run here, and fails, if it does, with its own
words.
"""

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..case.case import Case
from ..case.solver import ELSEWHERE
from .batch import work
from .runner import Done, Progress, Runner, Study

SHORT = 2e7
"""Work of a case, in pair interactions, below which Python's share of it counts: some 20 ms."""
SHARE = 500
"""Cases that are worth a process: it is ready after a second, in which another runs as many."""
JOB, SMALLEST = 64, 16
"""Number of cases that are run together: as many as make a batch, and fewer towards the end, so that all processes end
at about the same time."""
AHEAD = 2
"""Jobs that a worker has been given, so that it does not wait for the next."""


def worth(case: Case, pending: int, threads: int) -> int:
    """How many processes so many cases like this one are worth, the one that asks included."""
    # A model of one's own may be in the program that runs; a program with Python inside is no interpreter.
    python = Path(sys.executable or "").name.startswith("python")
    if not python or case.solver.startswith(ELSEWHERE) or work(case) > SHORT:
        return 1
    return max(1, min(threads, pending // SHARE))


def shared(here: Runner, pending: np.ndarray, count: int, progress: Progress) -> Iterator[Done]:
    """Run cases in `count` processes, this one among them, each on one thread; they come in any order.

    Args:
        here: what runs them in this process.
        progress: told of the batches that run here.
    """
    waiting = _jobs(here.study, pending, count)
    come: queue.SimpleQueue[tuple[Worker, np.ndarray, list[Done] | None]] = queue.SimpleQueue()
    with contextlib.ExitStack() as stack:
        crew = [stack.enter_context(Worker(here.study, come)) for _ in range(count - 1)]
        running = 0
        while True:
            for worker in crew:
                while worker.holds < AHEAD and (job := next(waiting, None)) is not None:
                    worker.send(job)
                    running += 1
            own = next(waiting, None)
            if own is not None:
                yield from here.run(own, progress)
            elif not running:
                return
            while running and (own is None or not come.empty()):
                worker, job, done = come.get()
                running -= 1
                # One that has failed is given no more.
                worker.holds += -1 if done is not None else AHEAD
                yield from here.run(job, progress) if done is None else done
                if own is None:
                    break


def _jobs(study: Study, pending: np.ndarray, count: int) -> Iterator[np.ndarray]:
    """Numbers of cases that are run together; those with the same motion are sampled and measured together."""
    left = study.design.gathered(pending, "motion")
    while len(left):
        size = min(max(SMALLEST, len(left) // (2 * AHEAD * count)), JOB)
        yield left[:size]
        left = left[size:]


class Worker:
    """A process that runs cases, and the two threads that talk to it.

    Attributes:
        holds: jobs that it has been given and not given back.

    Args:
        come: where itself, each job and what came of it are put, None if the worker failed.
    """

    def __init__(self, study: Study, come: Any) -> None:
        self.holds = 0
        self._come = come
        self._given: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._sent: queue.SimpleQueue[np.ndarray | None] = queue.SimpleQueue()
        start = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve()"
        self._process = subprocess.Popen([sys.executable, "-c", start], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._write, self._read)]
        for thread in self._threads:
            thread.start()
        self._given.put(study)

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

    def send(self, job: np.ndarray) -> None:
        """Give it numbers of cases."""
        self.holds += 1
        self._given.put(job)

    def _write(self) -> None:
        while (given := self._given.get()) is not None:
            if not isinstance(given, Study):
                self._sent.put(given)
            with contextlib.suppress(OSError):  # the reader finds out
                pickle.dump(given, self._process.stdin)  # type: ignore[arg-type]
                self._process.stdin.flush()  # type: ignore[union-attr]
        self._sent.put(None)

    def _read(self) -> None:
        while (job := self._sent.get()) is not None:
            done = None
            with contextlib.suppress(Exception):  # any exception of pickle for what a dying process has written
                done = pickle.load(self._process.stdout)  # type: ignore[arg-type]
            self._come.put((self, job, done))


def serve() -> None:
    """What a worker does until nothing more can come."""
    # An interrupt of the terminal is for the process that started it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with os.fdopen(os.dup(1), "wb") as answers:
        # Whatever is printed here must not get between the answers.
        os.dup2(2, 1)
        with contextlib.suppress(EOFError, OSError):
            runner = Runner(pickle.load(sys.stdin.buffer), 1)
            while True:
                job = pickle.load(sys.stdin.buffer)
                answer: list[Done] | None = None
                with contextlib.suppress(Exception):  # it is run again, and reported, where it came from
                    answer = list(runner.run(job, lambda *_: None))
                pickle.dump(answer, answers)
                answers.flush()
