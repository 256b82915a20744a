"""Batches of cases with one solver, marched side by side, and the metrics of each case."""

import itertools
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import fluids
from ..case.case import Case, CaseError
from ..kernels.arrays import Spare
from ..kernels.runtime import available_threads
from ..maps.design import Design
from ..maps.outcome import Outcome
from ..march.march import MODAL_FORCE, March
from ..march.reference import Reference, reference
from ..march.series import Series
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
TOGETHER = 16
"""Number of cases that are measured together: their arrays stay in the processor's cache."""
SAME = 4
"""Number of cases with the same motion that are worth to be measured apart from others: less is to be computed."""
LOOKED_AT = 512
"""Number of cases sampled to estimate the work of a study."""


@dataclass(frozen=True)
class Batch:
    """Cases of a design with the same solver: their numbers, the cases, and their work."""

    numbers: list[int]
    cases: list[Case]
    work: float


def batches(
    case: Case, design: Design, pending: np.ndarray, threads: int | None, checked: dict[Any, Any] | None = None
) -> Iterator[Batch | tuple[int, CaseError]]:
    """The pending cases of a design in batches with one solver and similar cost, that fit in memory.

    An invalid case is returned alone, with its error.

    Args:
        checked: see `Case.changed`.
    """
    checked = {} if checked is None else checked
    for first in range(0, len(pending), WINDOW):
        motions: dict[int, int] = {}
        found: list[tuple[Any, int, Case]] = []
        for number in pending[first : first + WINDOW].tolist():
            try:
                one = design.case(case, number, checked)
                fluids.check(one)
            except CaseError as error:
                yield number, error
            else:
                # Cases with the same motion stand together, as they are sampled and measured together.
                motion = motions.setdefault(id(one.motion), number)
                found.append(((one.solver, one.steps, work(one), motion), number, one))
        found.sort(key=lambda entry: entry[:2])
        yield from _split(found, threads or available_threads())


def _split(found: list[tuple[Any, int, Case]], threads: int) -> Iterator[Batch]:
    gathered: list[tuple[Any, int, Case]] = []
    spent = size = 0.0
    for entry in found:
        (solver, _, effort, _), _, one = entry
        other = gathered and gathered[-1][0][0] != solver
        enough = spent > BATCH_WORK * threads and len(gathered) >= SHARES * threads
        room = memory(one)
        if gathered and (other or enough or size + room > BATCH_BYTES):
            yield _batch(gathered)
            gathered, spent, size = [], 0.0, 0.0
        gathered.append(entry)
        spent += effort
        size += room
    if gathered:
        yield _batch(gathered)


def _batch(gathered: list[tuple[Any, int, Case]]) -> Batch:
    cases = [case for *_, case in gathered]
    return Batch([number for _, number, _ in gathered], cases, sum(key[2] for key, *_ in gathered))


def whole_work(case: Case, design: Design, pending: np.ndarray, checked: dict[Any, Any] | None = None) -> float:
    """Approximate cost of the pending cases of a design, in pair interactions, estimated from a sample if they are
    many.

    Args:
        checked: see `Case.changed`.
    """
    # A random sample, since evenly spaced cases of a grid may share the value of a key.
    several = len(pending) > LOOKED_AT
    looked_at = np.random.default_rng(0).choice(pending, LOOKED_AT, replace=False) if several else pending
    found = 0.0
    for number in looked_at.tolist():
        with suppress(CaseError):
            found += work(design.case(case, number, checked))
    return found * len(pending) / max(1, len(looked_at))


def work(case: Case) -> float:
    """Approximate cost of a case, in pair interactions (about one nanosecond each)."""
    return fluids.load(case.solver).work(case, case.steps // 2) * case.steps


def memory(case: Case) -> float:
    """Memory of a case in a batch, bytes: twice its motion and history, and the model's state."""
    tracked = 2.0 * 8.0 * (4 + 4 * case.wing.modes) * case.steps
    return tracked + 2.0 * 8.0 * 8.0 * case.steps + fluids.load(case.solver).memory(case)


def compute(
    cases: Sequence[Case],
    metrics: Sequence[str],
    keep_series: bool = False,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
    spare: Spare | None = None,
) -> list[Outcome]:
    """Run cases with one solver together. The results of a case do not depend on the other cases.

    Args:
        progress: callback of the fraction done, 0 to 1.
        spare: memory of the batch before, and for the one after.
    """
    cases = [case.resolved() for case in cases]
    total = sum(work(case) for case in cases)
    longest = max(case.steps for case in cases)
    steps = max(1, int(longest * LAUNCH_WORK * (threads or available_threads()) / total))
    with fluids.blamed(cases[0].solver):
        march = March(cases, fluids.load(cases[0].solver), threads, store_outputs=False, room=steps, spare=spare)
        march.advance_study(0)
    blocks = []
    while not march.done:
        blocks.append(march.advance_study(steps))
        if progress:
            progress(min(march.next_step / (march.steps + 1), 1.0))
    modes, force = (one[0] if len(one) == 1 else np.concatenate(one, axis=-1) for one in zip(*blocks, strict=True))
    outcomes = {b: Outcome(reason=march.reason(int(b))) for b in np.flatnonzero(march.failures() >= 0).tolist()}
    order: list[int] = []
    series: dict[int, dict[str, np.ndarray]] = {}

    def parts() -> Iterator[Series]:
        for members, scales in _alike(march, [b for b in range(len(cases)) if b not in outcomes]):
            run = _series(march, members, scales, modes, force)
            kept = [name for name in ("time", *SERIES) if name in run.variables] if keep_series else []
            series.update({b: {name: getattr(run, name)[i] for name in kept} for i, b in enumerate(members)})
            order.extend(members)
            yield run

    for b, found in zip(order, measure(parts(), metrics), strict=True):
        outcomes[b] = Outcome(found, series[b])
    march.end()
    return [outcomes[b] for b in range(len(cases))]


def _alike(march: March, members: Sequence[int]) -> Iterator[tuple[list[int], list[Reference]]]:
    """Cases of a batch that `Series` can derive together, with their reference values."""
    groups: dict[Any, list[tuple[int, Reference]]] = {}
    for b in members:
        case, scale = march.cases[b], reference(march.cases[b])
        key = case.steps, march.sections[b].count, case.fluid.streams, bool(scale.force)
        groups.setdefault(key, []).append((b, scale))
    for group in groups.values():
        mixed: list[tuple[int, Reference]] = []
        for _, sharing in itertools.groupby(group, lambda one: id(march.columns[one[0]])):
            same = list(sharing)
            if len(same) < SAME:
                mixed += same
            else:
                yield from _cut(same)
        yield from _cut(mixed)


def _cut(group: Sequence[tuple[int, Reference]]) -> Iterator[tuple[list[int], list[Reference]]]:
    for first in range(0, len(group), TOGETHER):
        members, scales = zip(*group[first : first + TOGETHER], strict=True)
        yield list(members), list(scales)


def _series(
    march: March, members: Sequence[int], scales: Sequence[Reference], modes: np.ndarray, force: np.ndarray
) -> Series:
    """The series of some cases of a batch, of what `March.advance_study` gave."""
    cases, sections = [march.cases[b] for b in members], [march.sections[b] for b in members]
    steps, count = np.arange(cases[0].steps + 1), sections[0].count
    columns = [march.columns[b] for b in members]
    shared = all(one is columns[0] for one in columns)
    # Cases that follow each other need no copy.
    together = members[-1] - members[0] == len(members) - 1
    own = slice(members[0], members[-1] + 1) if together else list(members)
    modes, force = modes[:, :count, own, : len(steps)], force[:, own, : len(steps)]
    moved = columns[0][:, None] if shared else np.stack(columns, axis=1)
    return Series(cases, sections, moved, steps, modes[:MODAL_FORCE], modes[MODAL_FORCE], force, scales)
