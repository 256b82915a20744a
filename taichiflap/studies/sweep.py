"""Run every missing case of a map, batch by batch, locally or on a cluster."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import disk
from .._version import __version__
from ..case.case import Case
from ..errors import extra
from ..kernels.runtime import available_threads, check_threads
from ..maps import file as maps
from ..maps.design import Design, design
from ..maps.file import Map, MapError
from ..maps.outcome import Outcome
from ..metrics.names import METRICS, choose
from . import workers
from .batch import Batch, whole_work
from .runner import Done, Runner, Study

WRITTEN_EVERY = 1.0
"""Seconds between two times at which a map is written: the most that a crash costs beside the batches that run."""

Progress = Callable[[float, int, float], None]
"""Callback of (cases done, counting parts of running ones; all cases; fraction of this call's work done)."""


@dataclass
class Tally:
    """Progress of a study: cases done, and work done (pair interactions)."""

    done: int
    cases: int
    work: float
    told: Progress | None
    spent: float = 0.0

    def tell(self, batch: Batch | None = None, share: float = 0.0) -> None:
        """Report progress, including a fraction of a batch."""
        cases, work = (share * len(batch.cases), share * batch.work) if batch else (0.0, 0.0)
        if self.told:
            self.told(self.done + cases, self.cases, min((self.spent + work) / self.work, 1.0) if self.work else 1.0)

    def add(self, cases: int, work: float) -> None:
        """Count cases as done, and report."""
        self.done, self.spent = self.done + cases, self.spent + work
        self.tell()


class Unwritten:
    """Outcomes of cases that the map does not yet hold, so that short batches are written together."""

    def __init__(self, sheet: Map) -> None:
        self._sheet, self._written = sheet, time.monotonic()
        self._numbers: list[int] = []
        self._outcomes: list[Outcome] = []

    def add(self, numbers: Sequence[int], outcomes: Sequence[Outcome]) -> None:
        """Keep outcomes, and write them if it is time to, or at once if they hold series.

        Raises:
            MapError: if the map cannot be written.
        """
        self._numbers += numbers
        self._outcomes += outcomes
        if self._sheet.keeps_series or time.monotonic() - self._written >= WRITTEN_EVERY:
            self.write()

    def write(self) -> None:
        """Write all of them.

        Raises:
            MapError: if the map cannot be written.
        """
        numbers, outcomes = self._numbers, self._outcomes
        self._numbers, self._outcomes = [], []
        if numbers:
            self._sheet.record(numbers, outcomes)
        self._written = time.monotonic()


def sweep(
    case: Case,
    vary: Mapping[str, Any],
    output: str | Path | None = None,
    *,
    sample: str | None = None,
    seed: int = 0,
    metrics: Sequence[str] = (),
    keep: str | None = None,
    cluster: str | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
) -> Any:
    """Run a case over a design and return its map as an `xarray.Dataset` with named coordinates and units.

    Args:
        case: the base case.
        vary: values of each key, or `"a:b:n"`, `"a:b:n:log"`; see `taichiflap.maps.design.design`.
        output: the map file, or None for a map in memory. Cases that a file of the same design already contains are not
            run again.
        sample, seed: sample instead of a grid: `"sobol:256"` or `"lhs:300"`.
        metrics: metrics to store; all if empty.
        keep: `"series"` also stores the time series.
        cluster: address of a Dask scheduler, or `"local:N"` for N local worker processes.
        threads: number of threads; None for all. It does not affect results.
        progress: callback of (cases done, all cases, fraction of the work done).
        overwrite: replace an existing file of another design.

    Raises:
        UserError: for an invalid design, metric, file or cluster; one sentence.
    """
    check_threads(threads)
    extra("xarray", "xarray", "sweep returns an xarray.Dataset, which needs xarray", MapError)
    planned = design(case, vary, sample, seed)
    with prepare(case, planned, output, metrics=metrics, keep=keep, overwrite=overwrite) as sheet:
        fill(sheet, cluster=cluster, threads=threads, progress=progress)
        return sheet.to_xarray()


def prepare(
    case: Case,
    planned: Design,
    output: str | Path | None,
    *,
    metrics: Sequence[str] = (),
    keep: str | None = None,
    overwrite: bool = False,
) -> Map:
    """The map to fill: a new one, or that of an earlier run of the same study.

    Raises:
        MapError: if the file belongs to another study.
        MetricError: for an unknown metric.
    """
    chosen = choose(metrics, list(planned.examples(case)))
    if keep not in (None, "series"):
        raise MapError(f"--keep {keep}: only series can be stored besides the metrics")
    path = None if output is None else Path(output)
    if path is not None and not disk.trouble(path) and path.exists() and not path.is_dir() and not overwrite:
        sheet = maps.open_map(path, write=True)
        try:
            _check_same(sheet, case, planned, chosen, keep is not None)
        except MapError:
            sheet.close()
            raise
    else:
        kept = {name: METRICS[name] for name in chosen}
        sheet = maps.create(path, case, planned, kept, series=keep is not None)
    sheet.case = case  # which knows the files of its tables, as the map does not
    return sheet


def fill(
    sheet: Map, *, cluster: str | None = None, threads: int | None = None, progress: Progress | None = None
) -> None:
    """Run the missing cases of a map. Short batches are written together, see `WRITTEN_EVERY`.

    Raises:
        MapError: if the map cannot be written.
        ClusterError: if the cluster does not answer, or cannot run taichiflap.
    """
    pending = sheet.pending
    checked: dict[Any, Any] = {}
    work = whole_work(sheet.case, sheet.design, pending, checked) if progress else 0.0
    tally = Tally(sheet.design.size - len(pending), sheet.design.size, work, progress)
    study = Study(sheet.case, sheet.design, sheet.metrics, sheet.keeps_series)
    processes = workers.worth(sheet.case, len(pending), threads or available_threads())
    if cluster and len(pending):
        done = _there(cluster, study, pending)
    elif processes > 1:
        done = workers.shared(Runner(study, 1, checked), pending, processes, tally.tell)
    else:
        done = Runner(study, threads, checked).run(pending, tally.tell)
    unwritten = Unwritten(sheet)
    tally.tell()
    try:
        for numbers, outcomes, spent in done:
            unwritten.add(numbers, outcomes)
            tally.add(len(numbers), spent)
    finally:
        unwritten.write()
    sheet.finish()


def _there(cluster: str, study: Study, pending: np.ndarray) -> Iterator[Done]:
    from .cluster import there  # noqa: PLC0415 - an optional extra

    return there(cluster, study, pending)


def _check_same(sheet: Map, case: Case, planned: Design, metrics: list[str], series: bool) -> None:
    differences = {
        "another case file or other --set": sheet.case.to_dict() != case.to_dict(),
        "another --vary, --sample or --seed": sheet.design != planned,
        "other metrics": sheet.metrics != metrics,
        "another --keep": sheet.keeps_series != series,
        f"taichiflap {sheet.version}": sheet.version != __version__,
    }
    found = [name for name, differs in differences.items() if differs]
    if found:
        raise MapError(
            f"{sheet.path}: holds a study with {', '.join(found)}; name another file with -o, or use --overwrite to "
            "replace it"
        )
