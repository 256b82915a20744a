"""The progress bar of a run in a terminal: beats, rate, time left."""

import contextlib
import math
import sys
import time
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from .case import Case
from .run import Progress as Callback

LOG_SECONDS = 30.0
"""Between two lines of a log."""


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed:,.0f} steps/s" if task.speed else "")


@contextlib.contextmanager
def bar(case: Case) -> Iterator[Callback]:
    """A bar on stderr that vanishes when the run is done; yields what `simulate` calls."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[place]}"),
        _Rate(),
        TimeRemainingColumn(compact=True),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
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
def share(title: str) -> Iterator[Callable[[float], None]]:
    """A bar on stderr for work of many kinds; yields what is called with the share done, 0 to 1."""
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    with Progress(*columns, TimeRemainingColumn(compact=True), console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(title, total=1.0)
        yield lambda done: shown.update(task, completed=done)


@contextlib.contextmanager
def cases(title: str) -> Iterator[Callable[[float, int], None]]:
    """A bar on stderr for a study of many cases: rate and time left; yields what the study calls."""
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[count]}"), _CaseRate())
    with Progress(*columns, TimeRemainingColumn(compact=True), console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(title, total=None, count="")

        def update(done: float, total: int) -> None:
            shown.update(task, completed=done, total=total, count=f"{int(done):,} of {total:,} cases")

        yield update


class _CaseRate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed:,.3g} cases/s" if task.speed else "")


@contextlib.contextmanager
def log(title: str) -> Iterator[Callable[[float, int], None]]:
    """The same as lines on stderr, one in half a minute, for a run that nobody watches."""
    began = said = time.monotonic()
    found: float | None = None

    def update(done: float, total: int) -> None:
        nonlocal said, found
        found = done if found is None else found  # what an earlier run left does not count as speed
        now = time.monotonic()
        if now - said < LOG_SECONDS or done <= found:
            return
        said = now
        rate = (done - found) / (now - began)
        minutes = (total - done) / rate / 60
        said_so_far = f"{title}: {int(done):,} of {total:,} cases"
        print(f"{said_so_far}, {rate:.3g} a second, {minutes:.0f} min left", file=sys.stderr)

    yield update
