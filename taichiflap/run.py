"""Run cases: march them in blocks, derive what users ask for, write it, report progress."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np

from . import fluids, plausible, series
from .case import Case
from .march import March
from .results import Result
from .writer import Writer

Progress = Callable[[int, int], None]
"""Called with the steps done and all steps, after every block."""

BLOCK_STEPS = 4096
BLOCK_WORK = 2e8
"""A block is at most so many steps, or so many pair interactions: about 0.1 s."""
BLOCK_BYTES = 2**26
"""... or so many bytes of frames."""


@overload
def simulate(
    case: Case,
    output: str | Path | None = None,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
) -> Result: ...


@overload
def simulate(
    case: Sequence[Case],
    output: Sequence[str | Path] | None = None,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
) -> list[Result]: ...


def simulate(
    case: Case | Sequence[Case],
    output: Any = None,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
) -> Result | list[Result]:
    """Compute one case, or a batch of cases side by side on all threads.

    Args:
        case: a case, or several that share their solver. A case gives the same bits in any batch.
        output: the result file to write, or one for each case; in memory if None.
        threads: how many threads to use; all of them if None. It does not change any result.
        progress: called with the steps done and all steps.
        overwrite: replace existing files.

    Returns:
        The result, or one for each case, open for reading.

    Raises:
        ResultError: when a file exists already or cannot be written.
        ValueError: when the cases of a batch do not share their solver.
    """
    single = isinstance(case, Case)
    cases = [one.resolved() for one in ([case] if isinstance(case, Case) else case)]
    paths: list[Any] = [output] if single else list(output or [None] * len(cases))
    if len({one.solver for one in cases}) != 1 or len(paths) != len(cases):
        raise ValueError("give at least one case, all of one solver, and as many outputs as cases")
    results = _run(cases, [None if path is None else Path(path) for path in paths], threads, progress, overwrite)
    return results[0] if single else results


def _run(
    cases: list[Case],
    paths: list[Path | None],
    threads: int | None,
    progress: Progress | None,
    overwrite: bool,
) -> list[Result]:
    fluid = fluids.load(cases[0].solver)
    writers: list[Writer] = []
    try:
        for path, case in zip(paths, cases, strict=True):
            writers.append(Writer(case, path, plausible.warnings(case), overwrite))
        march = March(cases, fluid, threads)
        for writer, case, section in zip(writers, cases, march.sections, strict=True):
            writer.lay_out(fluid.nodes(case), section)
        march.advance(0)
        solve_time = 0.0
        while not march.done:
            steps = block_steps(cases, fluid, march.next_step)
            began = time.perf_counter()
            blocks = march.advance(steps)
            solve_time += time.perf_counter() - began
            for b, (writer, frames) in enumerate(zip(writers, blocks, strict=True)):
                nodes = fluid.nodes(cases[b])
                writer.append(series.derive(cases[b], march.sections[b], nodes, march.motion[b], frames))
            if progress:
                progress(min(march.next_step, march.steps), march.steps)
        return [_finish(writer, step, solve_time) for writer, step in zip(writers, march.failures(), strict=True)]
    except BaseException:
        for writer in writers:
            writer.abandon()
        raise


def block_steps(cases: Sequence[Case], fluid: Any, step: int) -> int:
    """Steps to march from `step` on before the next write: a lively progress bar, and bounded memory."""
    work = sum(fluid.work(case, step) for case in cases)
    size = sum(fluid.frame_bytes(case) / case.output.every for case in cases)
    return max(1, int(min(BLOCK_STEPS, BLOCK_WORK / work, BLOCK_BYTES / size)))


def _finish(writer: Writer, failed: np.int32, solve_time: float) -> Result:
    if failed < 0:
        return writer.finish("complete", solve_time=solve_time)
    return writer.finish("failed", solve_time=solve_time, reason=failure(int(failed)))


def failure(step: int) -> str:
    """Why a case that failed at `step` did, and what may help."""
    cures = "more steps a period, fewer modes, or a larger uvlm.core may help"
    return f"values ceased to be finite at step {step}; {cures}"
