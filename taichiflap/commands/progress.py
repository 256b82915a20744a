"""Progress of runs and studies in a terminal or a log."""

import contextlib
import math
import sys
import time
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.table import Column
from rich.text import Text

from ..case.case import Case
from ..run.blocks import Progress as Callback

LOG_SECONDS = 30.0
"""Time between two log lines, s."""


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed:,.0f} steps/s" if task.speed else "")


def _shown(*middle: ProgressColumn) -> Progress:
    """A progress bar on stderr with a title, the columns `middle`, and the time left; a narrow terminal shortens the
    title.
    """
    title = TextColumn("{task.description}", table_column=Column(ratio=2, no_wrap=True, overflow="ellipsis"))
    bar = BarColumn(bar_width=None, table_column=Column(ratio=1))
    left = TimeRemainingColumn(compact=True)
    return Progress(title, bar, *middle, left, console=Console(stderr=True), transient=True, expand=True)


@contextlib.contextmanager
def bar(case: Case) -> Iterator[Callback]:
    """A progress bar on stderr that disappears after the run; yields the callback for `simulate`."""
    with _shown(TextColumn("{task.fields[place]}"), _Rate()) as shown:
        # Until the first block is done: seconds, the first time that this machine computes such a case.
        task = shown.add_task(case.title or "simulating", total=case.steps, place="preparing the kernel")

        def update(done: int, total: int) -> None:
            shown.update(task, completed=done, total=total, place=_place(case, done))

        yield update


def _place(case: Case, done: int) -> str:
    if not case.periodic:
        return f"{done * case.step:.4g} of {case.duration:.4g} s"
    beats = case.duration / case.beat
    return f"beat {math.floor(done / case.steps_per_beat + 1e-9)} of {round(beats, 2):g}"


@contextlib.contextmanager
def steps(title: str) -> Iterator[Callback]:
    """A progress bar on stderr for counted work; yields a callback of (done, total)."""
    with _shown(TextColumn("{task.completed:.0f} of {task.total:.0f}")) as shown:
        task = shown.add_task(title, total=1.0)
        yield lambda done, total: shown.update(task, completed=done, total=total)


@contextlib.contextmanager
def share(title: str) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr; yields a callback of the fraction done, 0 to 1."""
    with _shown(TextColumn("{task.percentage:.0f} %")) as shown:
        task = shown.add_task(title, total=1.0)
        yield lambda done: shown.update(task, completed=done)


@contextlib.contextmanager
def cases(title: str) -> Iterator[Callable[[float, int, float], None]]:
    """A progress bar on stderr for a study: rate, and time left estimated from work; yields the study's callback."""
    with _shown(TextColumn("{task.fields[count]}")) as shown:
        task = shown.add_task(title, total=1.0, count="")
        pace = _Pace()

        def update(done: float, total: int, share: float) -> None:
            shown.update(task, completed=share, count=pace.count(done, total))

        yield update


@contextlib.contextmanager
def log(title: str) -> Iterator[Callable[[float, int, float], None]]:
    """The same as lines on stderr, one per half minute, for a log."""
    pace = _Pace()
    said = pace.began

    def update(done: float, total: int, share: float) -> None:
        nonlocal said
        count = pace.count(done, total)
        if pace.now - said >= LOG_SECONDS and share > 0.0:
            said = pace.now
            left = (1.0 - share) / share * (said - pace.began)
            print(f"{title}: {count}, {left / 60.0:.0f} min left", file=sys.stderr)

    yield update


class _Pace:
    """Cases completed since the first call, so that cases of an earlier run do not count as speed."""

    def __init__(self) -> None:
        self.began = self.now = time.monotonic()
        self.first: float | None = None

    def count(self, done: float, total: int) -> str:
        """Number of completed cases, and cases per second."""
        self.now = time.monotonic()
        self.first = done if self.first is None else self.first
        rate = (done - self.first) / (self.now - self.began) if self.now > self.began else 0.0
        return f"{int(done):,} of {total:,} cases" + (f", {rate:.3g} a second" if rate else "")
