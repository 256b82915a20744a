"""A run beside another program that keeps one processor busy: more threads must not make it slower."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator

from taichiflap.kernels.runtime import available_threads

from .clock import alternate
from .rows import Row
from .runs import hawkmoth, marching

SECTION = "Threads under load"
CASES = 8


@contextlib.contextmanager
def busy() -> Iterator[None]:
    """One processor kept busy by a process of ours."""
    pin = "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
    code = (pin if hasattr(os, "sched_setaffinity") else "") + "while True: pass"
    with subprocess.Popen([sys.executable, "-c", code]) as process:
        try:
            yield
        finally:
            process.kill()


def rows() -> Iterator[Row]:
    """A batch on all threads against one thread, with one processor busy elsewhere."""
    threads = available_threads()
    cases = [hawkmoth("time.periods=4")] * CASES
    with busy():
        clocked = alternate({"one": marching(cases), "all": marching(cases, None)}, 5)
    ratio = clocked["all"].wall / clocked["one"].wall
    name = f"{CASES} cases, {threads} threads over one, one processor busy elsewhere: time on the wall"
    yield Row(SECTION, name, ratio, "x", 1.1, at_least=False)
