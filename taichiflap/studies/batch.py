"""Batches of cases with one solver, marched side by side, and the metrics of each case."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from .. import fluids
from ..case.case import Case, CaseError
from ..kernels.runtime import available_threads
from ..maps.design import Design
from ..maps.outcome import Outcome
from ..march import loads
from ..march.march import March
from ..metrics.names import SERIES, measure

LAUNCH_WORK = 6e8
"""Work per launch and thread, in pair interactions: about half a second, which cannot be interrupted."""
BATCH_WORK = 5e8
"""Work per batch and thread: the most that a crash can cost. Small cases need one launch per batch."""
BATCH_BYTES = 2**27
"""Maximum memory of a batch, bytes."""
SHARES = 4
"""Minimum number of cases per thread, so that no thread waits long for the last case."""
WINDOW = 4096
"""Number of cases considered together to form batches of similar cost."""
LOOKED_AT = 512
"""Number of cases sampled to estimate the work of a study."""


@dataclass(frozen=True)
class Batch:
    """Cases of a design with the same solver: their numbers, the cases, and their work."""

    numbers: list[int]
    cases: list[Case]
    work: float


def batches(
    case: Case, design: Design, pending: np.ndarray, threads: int | None
) -> Iterator[Batch | tuple[int, CaseError]]:
    """The pending cases of a design in batches with one solver and similar cost, that fit in memory.

    An invalid case is returned alone, with its error.
    """
    for first in range(0, len(pending), WINDOW):
        found: list[tuple[Any, int, Case]] = []
        for number in pending[first : first + WINDOW].tolist():
            try:
                one = design.case(case, number)
                fluids.check(one)
            except CaseError as error:
                yield number, error
            else:
                found.append(((one.solver, one.steps, work(one)), number, one))
        found.sort(key=lambda entry: entry[:2])
        yield from _split(found, threads or available_threads())


def _split(found: list[tuple[Any, int, Case]], threads: int) -> Iterator[Batch]:
    gathered: list[tuple[Any, int, Case]] = []
    spent = size = 0.0
    for entry in found:
        one = entry[2]
        other = gathered and gathered[-1][0][0] != one.solver
        enough = spent > BATCH_WORK * threads and len(gathered) >= SHARES * threads
        if gathered and (other or enough or size + memory(one) > BATCH_BYTES):
            yield _batch(gathered)
            gathered, spent, size = [], 0.0, 0.0
        gathered.append(entry)
        spent += work(one)
        size += memory(one)
    if gathered:
        yield _batch(gathered)


def _batch(gathered: list[tuple[Any, int, Case]]) -> Batch:
    cases = [case for *_, case in gathered]
    return Batch([number for _, number, _ in gathered], cases, sum(map(work, cases)))


def whole_work(case: Case, design: Design, pending: np.ndarray) -> float:
    """Approximate cost of the pending cases of a design, in pair interactions, estimated from a sample if they are
    many.
    """
    # A random sample, since evenly spaced cases of a grid may share the value of a key.
    several = len(pending) > LOOKED_AT
    looked_at = np.random.default_rng(0).choice(pending, LOOKED_AT, replace=False) if several else pending
    found = 0.0
    for number in looked_at.tolist():
        with suppress(CaseError):
            found += work(design.case(case, number))
    return found * len(pending) / max(1, len(looked_at))


def work(case: Case) -> float:
    """Approximate cost of a case, in pair interactions (about one nanosecond each)."""
    return fluids.load(case.solver).work(case, case.steps // 2) * case.steps


def memory(case: Case) -> float:
    """Memory of a case in a batch, bytes: twice its motion and history, and its wake."""
    tracked = 2.0 * 8.0 * (4 + 4 * case.wing.modes) * case.steps
    return tracked + 2.0 * 8.0 * 8.0 * case.steps + 10.0 * fluids.load(case.solver).frame_bytes(case)


def compute(
    cases: Sequence[Case],
    metrics: Sequence[str],
    keep_series: bool = False,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Outcome]:
    """Run cases with one solver together. The results of a case do not depend on the other cases.

    Args:
        progress: callback of the fraction done, 0 to 1.
    """
    cases = [case.resolved() for case in cases]
    with fluids.blamed(cases[0].solver):
        march = March(cases, fluids.load(cases[0].solver), threads, store_outputs=False)
        march.advance(0)
    blocks = []
    total = sum(work(case) for case in cases)
    steps = max(1, int(march.steps * LAUNCH_WORK * (threads or available_threads()) / total))
    while not march.done:
        blocks.append(march.advance(steps))
        if progress:
            progress(min(march.next_step / (march.steps + 1), 1.0))
    outcomes = []
    for b, failed in enumerate(march.failures()):
        if failed >= 0:
            outcomes.append(Outcome(reason=march.reason(b)))
            continue
        frames = _joined([block[b] for block in blocks])
        run = loads.over_time(cases[b], march.sections[b], march.motion[b], frames)
        kept = {name: run[name] for name in ("time", *SERIES) if name in run} if keep_series else {}
        outcomes.append(Outcome(measure(SimpleNamespace(case=cases[b], variables=list(run), **run), metrics), kept))
    return outcomes


def _joined(blocks: Sequence[Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
    if len(blocks) == 1:
        return dict(blocks[0])
    return {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}
