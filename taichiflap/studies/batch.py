"""Many cases of one solver, marched side by side, and what a map keeps of each."""

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
"""Work of one launch a thread, in pair interactions: about half a second, in which nothing can be interrupted."""
BATCH_WORK = 5e8
"""Work of a batch a thread: what a crash may cost. One launch does a batch of small cases."""
BATCH_BYTES = 2**27
"""Memory of a batch."""
SHARES = 4
"""Least number of cases a thread, so that no thread waits long for the last."""
WINDOW = 4096
"""Cases that are looked at together to make batches of like cost."""
LOOKED_AT = 512
"""Cases from which the work of a study is told before they run."""


@dataclass(frozen=True)
class Batch:
    """Some cases of a design that share their solver: their numbers, the cases themselves, and their work."""

    numbers: list[int]
    cases: list[Case]
    work: float


def batches(
    case: Case, design: Design, pending: np.ndarray, threads: int | None
) -> Iterator[Batch | tuple[int, CaseError]]:
    """The pending cases of a design in batches of one solver, of like cost, that fit in memory.

    A case whose values do not go together comes alone, with what is wrong with it.
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
    """Rough cost of the pending cases of a design, in pair interactions: from a sample of them, if they are many."""
    # At random: evenly spaced numbers of a grid may all have the same value of a key.
    several = len(pending) > LOOKED_AT
    looked_at = np.random.default_rng(0).choice(pending, LOOKED_AT, replace=False) if several else pending
    found = 0.0
    for number in looked_at.tolist():
        with suppress(CaseError):
            found += work(design.case(case, number))
    return found * len(pending) / max(1, len(looked_at))


def work(case: Case) -> float:
    """Rough cost of a case, in pair interactions (about a nanosecond)."""
    return fluids.load(case.solver).work(case, case.steps // 2) * case.steps


def memory(case: Case) -> float:
    """Bytes that a case takes in a batch: its motion and what the march tracks of it, twice; and the wake's ring."""
    tracked = 2.0 * 8.0 * (4 + 4 * case.wing.modes) * case.steps
    return tracked + 2.0 * 8.0 * 8.0 * case.steps + 10.0 * fluids.load(case.solver).frame_bytes(case)


def compute(
    cases: Sequence[Case],
    metrics: Sequence[str],
    keep_series: bool = False,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Outcome]:
    """Run cases of one solver together. What comes of a case does not depend on its company.

    Args:
        progress: called with the share that is done, 0 to 1.
    """
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
