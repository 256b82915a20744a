"""Timing: medians of alternating repeats, in wall time and in processor time."""

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

REPEATS = 5
short = False
"""Whether everything is clocked only once, to see that it runs."""


@dataclass(frozen=True)
class Clocked:
    """Medians of several repeats, s: what passed on the wall, and what all threads together used of processors.

    On a machine that others use too, processor time is the fairer of the two.
    """

    wall: float
    cpu: float


Work = Callable[[], Callable[[], object]]
"""Prepares what is to be clocked, and returns it."""


def alternate(works: Mapping[str, Work], repeats: int = REPEATS) -> dict[str, Clocked]:
    """Time several pieces of work in turns, so that changes of the machine's load affect all of them.

    One turn goes ahead unclocked, to compile and to warm caches.
    """
    repeats = 1 if short else repeats
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in works}
    for turn in range(repeats + 1):
        for name, work in works.items():
            clocked = work()
            wall, cpu = time.perf_counter(), time.process_time()
            clocked()
            if turn:
                taken[name].append((time.perf_counter() - wall, time.process_time() - cpu))
    return {name: Clocked(*map(statistics.median, zip(*times, strict=True))) for name, times in taken.items()}
