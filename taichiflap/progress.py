"""The progress bar of a run in a terminal: beats, rate, time left."""

import contextlib
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from .case import Case
from .run import Progress as Callback


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed:,.0f} steps/s" if task.speed else "")


@contextlib.contextmanager
def bar(case: Case) -> Iterator[Callback]:
    """A bar on stderr that vanishes when the run is done; yields what `simulate` calls."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("beat {task.fields[beat]} of {task.fields[beats]}"),
        _Rate(),
        TimeRemainingColumn(compact=True),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(case.title or "simulating", total=case.steps, beat=0, beats=case.time.periods)

        def update(done: int, total: int) -> None:
            shown.update(task, completed=done, total=total, beat=done // case.time.steps_per_period)

        yield update


@contextlib.contextmanager
def share(title: str) -> Iterator[Callable[[float], None]]:
    """A bar on stderr for work of many kinds; yields what is called with the share done, 0 to 1."""
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    with Progress(*columns, TimeRemainingColumn(compact=True), console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(title, total=1.0)
        yield lambda done: shown.update(task, completed=done)
