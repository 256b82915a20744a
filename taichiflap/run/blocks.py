"""Run cases: march them in blocks, derive the stored series, write results, report progress."""

import functools
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np

from .. import fluids
from ..case.case import Case
from ..fluids.interface import Model
from ..kernels.runtime import check_threads
from ..march import loads
from ..march.march import March
from ..metrics.summary import Summary, summarise
from ..results import checkpoint
from ..results.checkpoint import Checkpoint
from ..results.layout import Contents
from ..results.memory import Memory
from ..results.ownership import finished
from ..results.reader import Result, ResultError
from ..results.recorder import Recorded, Recorder
from ..results.variables import Variable
from ..results.writer import Writer
from ..scored import nearest
from . import warnings
from .retry import finer_helps

Progress = Callable[[int, int], None]
"""Callback of (steps done, total steps), called after every block."""

BLOCK_SECONDS = 0.1
"""Approximate time between two writes, s; keeps progress and interrupts responsive."""
BLOCK_STEPS = 4096
BLOCK_BYTES = 2**26
"""Maximum number of steps, and of stored bytes, per block."""
FIRST_WORK = 2e7
"""Pair interactions of the first block; later blocks are sized by measured time."""


@overload
def simulate(
    case: Case,
    output: str | Path | None = None,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
    resume: bool = False,
) -> Result: ...


@overload
def simulate(
    case: Sequence[Case],
    output: Sequence[str | Path] | None = None,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
    resume: bool = False,
) -> list[Result]: ...


def simulate(
    case: Case | Sequence[Case],
    output: Any = None,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
    resume: bool = False,
) -> Result | list[Result]:
    """Compute one case, or a batch of cases side by side on all threads.

    Args:
        case: a case, or several with the same solver. A case gives bit-identical results in any batch.
        output: the result file to write, or one for each case; in memory if None.
        threads: number of threads; None for all. It does not affect results.
        progress: callback of (steps done, total steps).
        overwrite: replace existing files, and files of interrupted runs.
        resume: continue an interrupted run of the same case, with bit-identical results. A complete file is opened, and
            a missing one is computed from the start.

    Returns:
        The result, or one for each case, open for reading.

    Raises:
        ResultError: if a file exists, holds another case, or cannot be written.
        ProgramError: for an invalid number of threads, or if other code in this process has started Taichi with other
            settings.
        ValueError: if the cases of a batch have different solvers.
    """
    check_threads(threads)
    single = isinstance(case, Case)
    cases = [one.resolved() for one in ([case] if isinstance(case, Case) else case)]
    one = single or isinstance(output, str | Path)
    paths: list[Any] = [output] if one else list(output or [None] * len(cases))
    if len({one.solver for one in cases}) != 1 or len(paths) != len(cases):
        raise ValueError("give at least one case, all with one solver, and one output per case")
    places = [None if path is None else Path(path) for path in paths]
    named = [path for path in places if path is not None]
    for path in named:
        if named.count(path) > 1:
            raise ResultError(f"{path}: is named for two results; give each its own file")
    run = _resume if resume else _run
    results = run(cases, places, threads, progress, overwrite)
    return results[0] if single else results


def _resume(
    cases: list[Case], paths: list[Path | None], threads: int | None, progress: Progress | None, overwrite: bool
) -> list[Result]:
    """Open complete results and continue the others; runs that stopped at the same step continue as one batch."""
    results: dict[int, Result] = {}
    stopped: dict[int, list[int]] = {}
    states: dict[int, Checkpoint | None] = {}
    for i, (case, path) in enumerate(zip(cases, paths, strict=True)):
        done = None if path is None or overwrite else finished(path, case)
        if done:
            results[i] = done
            continue
        states[i] = None if path is None or overwrite else checkpoint.load(path, case)
        step = states[i].next_step if states[i] else 0  # type: ignore[union-attr]
        stopped.setdefault(step, []).append(i)
    for members in stopped.values():
        found = _run(
            [cases[i] for i in members], [paths[i] for i in members], threads, progress, overwrite,
            [states[i] for i in members],
        )  # fmt: skip
        results.update(zip(members, found, strict=True))
    return [results[i] for i in range(len(cases))]


def _run(
    cases: list[Case],
    paths: list[Path | None],
    threads: int | None,
    progress: Progress | None,
    overwrite: bool,
    resumed: Sequence[Checkpoint | None] | None = None,
) -> list[Result]:
    fluid = fluids.load(cases[0].solver)
    for case in cases:
        fluids.check(case)
    writers: list[Recorder] = []
    try:

        def derive(blocks: list[dict[str, np.ndarray]]) -> Iterator[loads.Derived]:
            for b, (case, frames) in enumerate(zip(cases, blocks, strict=True)):
                yield loads.derive(case, march.sections[b], fluid.nodes(case), march.motion[b], frames)

        with fluids.blamed(cases[0].solver):
            for path, case in zip(paths, cases, strict=True):
                said = warnings.warnings(case)
                again = resumed is not None
                writers.append(Writer(case, path, said, overwrite, again) if path else Memory(case, said))
            size = _step_bytes(cases, fluid)
            march = March(cases, fluid, threads, room=_block(cases, fluid, 0, FIRST_WORK, size)[0])
            for writer, section, sample in zip(writers, march.sections, derive(march.advance(0)), strict=True):
                writer.lay_out(fluid.nodes(writer.case), section, sample, _contents(fluid, writer.case))
        solve_time = _take_up(march, writers, resumed)
        most = FIRST_WORK
        while not march.done:
            steps, work = _block(cases, fluid, march.next_step, most, size)
            began = time.perf_counter()
            blocks = march.advance(steps)
            seconds = time.perf_counter() - began
            solve_time += seconds
            most = min(2.0 * most, work * BLOCK_SECONDS / seconds)
            for b, (writer, variables) in enumerate(zip(writers, derive(blocks), strict=True)):
                writer.append(variables)
                if writer.due:
                    writer.keep(Checkpoint(march.next_step, solve_time, march.state(b)))
            if progress:
                progress(min(march.next_step, march.steps), march.steps)
        results = []
        for b, writer in enumerate(writers):
            reason = march.reason(b, functools.partial(finer_helps, threads=threads))
            figures = {"solve_time": solve_time}
            if reason:
                results.append(writer.finish("failed", figures, reason))
                continue
            summary = _summary(writer)
            more = warnings.outcome(writer.case, writer.written("tip_deflection"), summary)
            more += fluid.outcome(writer.case, writer.written)
            if summary:
                figures |= {
                    name: getattr(summary, name)
                    for name in ("energy_residual", "reference_speed", "reference_area")
                    if getattr(summary, name) is not None
                }
            results.append(writer.finish("complete", figures, "", more))
        return results
    except BaseException:
        for writer in writers:
            writer.abandon()
        raise


def _summary(recorder: Recorder) -> Summary | None:
    run: Any = Recorded(recorder)
    return summarise(run)


def _take_up(march: March, recorders: list[Recorder], resumed: Sequence[Checkpoint | None] | None) -> float:
    """Restore a march from interrupted runs; returns the time (s) they had taken."""
    kept = [one for one in resumed or () if one]
    writers = [one for one in recorders if isinstance(one, Writer)]
    # The file must hold the checkpoint's steps; it may have been moved or restarted.
    if not kept or len(kept) < len(recorders):
        return 0.0
    if behind := [writer for writer in writers if writer.stored < _reached(writer, kept[0])]:
        for writer in behind:
            checkpoint.tell(writer.path, "the file next to it holds fewer steps")
        return 0.0
    try:
        march.restore([one.state for one in kept], kept[0].next_step)
    except ValueError as error:
        for writer in writers:
            checkpoint.tell(writer.path, str(error))
        return 0.0
    for writer in writers:
        writer.rewind(_reached(writer, kept[0]))
    return kept[0].solve_time


def _reached(writer: Writer, kept: Checkpoint) -> int:
    return min(kept.next_step, writer.case.steps + 1)


def _contents(fluid: Model, case: Case) -> Contents:
    axes = {
        name: (np.asarray(axis.values, dtype=np.float64), Variable((), axis.units, axis.long_name, axis.symbol))
        for name, axis in fluid.axes(case).items()
    }
    outputs = {one.name: one.variable for one in fluid.stored(case)}
    return Contents(outputs, axes, fluid.totals(case), functools.partial(nearest.sentence, case))


def _step_bytes(cases: Sequence[Case], fluid: Model) -> float:
    """Mean size of what is stored of a step of all cases."""
    return sum(fluid.frame_bytes(case) / case.output.every + 8.0 * (4 + 4 * case.wing.modes) for case in cases)


def _block(cases: Sequence[Case], fluid: Model, first: int, most: float, size: float) -> tuple[int, float]:
    """Number of steps from `first` to the next write, and their work, within `most` if possible.

    The number is halved until it fits, so that arrays of only a few sizes are allocated.

    Args:
        size: see `_step_bytes`.
    """
    steps = BLOCK_STEPS
    while True:
        # The wake grows, so the last step has the most work.
        work = steps * sum(fluid.work(case, first + steps) for case in cases)
        if steps == 1 or (work <= most and steps * size <= BLOCK_BYTES):
            return steps, work
        steps //= 2
