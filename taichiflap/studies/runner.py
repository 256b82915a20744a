"""Cases of a study, run in this process one batch after the other."""

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..case.case import Case, CaseError
from ..kernels.arrays import Spare
from ..maps.design import Design
from ..maps.outcome import Outcome
from .batch import Batch, batches, compute

Progress = Callable[[Batch, float], None]
"""Callback of a batch that runs, and the share of it that is done."""


@dataclass(frozen=True)
class Study:
    """What it takes to run a case of a study by its number: the base case, the design, and what is stored."""

    case: Case
    design: Design
    metrics: list[str]
    keep_series: bool


class Done(NamedTuple):
    """Numbers of cases that have run, their outcomes, and their work in pair interactions."""

    numbers: list[int]
    outcomes: list[Outcome]
    work: float


class Runner:
    """Runs cases of a study.

    Args:
        threads: number of threads; None for all.
        checked: see `Case.changed`.
    """

    def __init__(self, study: Study, threads: int | None, checked: dict[Any, Any] | None = None) -> None:
        self.study, self._threads = study, threads
        self._checked = {} if checked is None else checked
        self._spare = Spare()

    def run(self, numbers: np.ndarray, progress: Progress) -> Iterator[Done]:
        """Run cases, batch by batch."""
        study = self.study
        for one in batches(study.case, study.design, numbers, self._threads, self._checked):
            if isinstance(one, Batch):
                tell = functools.partial(progress, one)
                outcomes = compute(one.cases, study.metrics, study.keep_series, self._threads, tell, self._spare)
                yield Done(one.numbers, outcomes, one.work)
            else:
                yield invalid(*one)


def invalid(number: int, error: CaseError) -> Done:
    """A case that cannot run."""
    return Done([number], [Outcome(reason="; ".join(error.problems))], 0.0)
