"""The progress bar of a run in a terminal: beats, rate, time left."""

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
"""Between two lines of a log."""


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed:,.0f} steps/s" if task.speed else "")


def _shown(*middle: ProgressColumn) -> Progress:
    """A bar on stderr with its title, what `middle` tells, and the time left; if narrow, the title gives way."""
    title = TextColumn("{task.description}", table_column=Column(ratio=2, no_wrap=True, overflow="ellipsis"))
    bar = BarColumn(bar_width=None, table_column=Column(ratio=1))
    left = TimeRemainingColumn(compact=True)
    return Progress(title, bar, *middle, left, console=Console(stderr=True), transient=True, expand=True)


@contextlib.contextmanager
def bar(case: Case) -> Iterator[Callback]:
    """A bar on stderr that vanishes when the run is done; yields what `simulate` calls."""
    with _shown(TextColumn("{task.fields[place]}"), _Rate()) as shown:
        task = shown.add_task(case.title or "simulating", total=case.steps, place=_place(case, 0))

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
    """A bar on stderr for work that counts; yields what is called with the number done, and of all."""
    with _shown(TextColumn("{task.completed:.0f} of {task.total:.0f}")) as shown:
        task = shown.add_task(title, total=1.0)
        yield lambda done, total: shown.update(task, completed=done, total=total)


@contextlib.contextmanager
def share(title: str) -> Iterator[Callable[[float], None]]:
    """A bar on stderr for work of many kinds; yields what is called with the share done, 0 to 1."""
    with _shown(TextColumn("{task.percentage:.0f} %")) as shown:
        task = shown.add_task(title, total=1.0)
        yield lambda done: shown.update(task, completed=done)


@contextlib.contextmanager
def cases(title: str) -> Iterator[Callable[[float, int, float], None]]:
    """A bar on stderr for a study of many cases: rate, and time left by work; yields what the study calls."""
    with _shown(TextColumn("{task.fields[count]}")) as shown:
        task = shown.add_task(title, total=1.0, count="")
        pace = _Pace()

        def update(done: float, total: int, share: float) -> None:
            shown.update(task, completed=share, count=pace.count(done, total))

        yield update


@contextlib.contextmanager
def log(title: str) -> Iterator[Callable[[float, int, float], None]]:
    """The same as lines on stderr, one in half a minute, for a run that nobody watches."""
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
    """Cases done since the first call: what an earlier run left does not count as speed."""

    def __init__(self) -> None:
        self.began = self.now = time.monotonic()
        self.first: float | None = None

    def count(self, done: float, total: int) -> str:
        """How many cases are done, and how many a second."""
        self.now = time.monotonic()
        self.first = done if self.first is None else self.first
        rate = (done - self.first) / (self.now - self.began) if self.now > self.began else 0.0
        return f"{int(done):,} of {total:,} cases" + (f", {rate:.3g} a second" if rate else "")
