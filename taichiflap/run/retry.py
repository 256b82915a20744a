"""Trial of a diverged case with half the time step, to see whether a finer step helps."""

import numpy as np

from .. import fluids
from ..case.case import Case, CaseError
from ..march.march import March
from ..march.state import AMPLITUDE

WORK = 1e10
"""Maximum pair interactions of a trial, about ten seconds."""
BEYOND = 1.25
"""A trial runs to at least this multiple of the time of failure."""
PIECES = 20
"""Number of launches of a trial, between which it can be interrupted."""


def finer_helps(case: Case, failed: int, threads: int | None = None) -> bool | None:
    """Whether a case with twice the steps passes the time of divergence with a tip deflection below a chord.

    Args:
        failed: step at which the case diverged.

    Returns:
        None if the trial would take too long.
    """
    finer = _finer(case)
    if finer is None:
        return None
    steps = _affordable(finer, 2 * failed)
    if steps is None:
        return None
    march = March([finer], fluids.load(finer.solver), threads, store_outputs=False)
    march.advance(0)
    tip = march.sections[0].shape([finer.wing.chord])[:, 0]
    while march.next_step <= steps and march.failures()[0] < 0:
        amplitudes = march.advance(max(1, steps // PIECES))[0]["q"][:, AMPLITUDE]
        if len(tip) and np.abs(amplitudes @ tip).max(initial=0.0) > finer.wing.chord:
            return False
    return bool(march.failures()[0] < 0)


def _finer(case: Case) -> Case | None:
    time = case.time
    half = {"time.step": 0.5 * case.step} if time.periods is None else {
        "time.steps_per_period": 2 * round(case.steps_per_beat)
    }  # fmt: skip
    try:
        return case.changed(half)
    except CaseError:
        return None


def _affordable(case: Case, place: int) -> int | None:
    """Last step of a trial; None if it cannot run far enough."""
    model = fluids.load(case.solver)
    least = min(case.steps, int(BEYOND * place) + 10)
    for steps in (case.steps, 2 * place, least):
        if least <= steps <= case.steps and 0.5 * steps * model.work(case, steps) <= WORK:
            return steps
    return None
