"""Why a case diverged: what diverged, when, and what may help."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..motion import sampling
from ..motion.sampling import PITCH_RATE
from ..structure.beam import Modes
from ..structure.chordwise import Profile

RUNAWAY = 10.0
"""Maximum deflection, in chords, due to a single mode; a linear beam is valid only for a fraction of a chord."""


def limits(section: Modes) -> NDArray[np.float64]:
    """Amplitude of every mode at which a case counts as diverged: it deflects some point by `RUNAWAY` chords."""
    return RUNAWAY * section.chord / section.peak


def reason(
    case: Case,
    section: Modes,
    step: int,
    now: NDArray[np.float64],
    before: NDArray[np.float64],
    of_fluid: Sequence[str] = (),
    finer_helps: bool | None = None,
) -> str:
    """One sentence on a diverged case.

    Args:
        of_fluid: settings of the fluid model that may help.
        step: step at which it diverged.
        now, before: modal amplitudes at that step and at the one before, shape (modes,).
        finer_helps: whether a trial with twice the steps ran further; None without a trial.
    """
    when = f"at step {step} (t = {step * case.step:.4g} s, beat {int(step // case.steps_per_beat) + 1})"
    tip = section.shape([case.wing.chord])[:, 0]
    if section.count and np.isfinite(now).all() and np.any(np.abs(now) > limits(section)):
        what = f"the deflection diverged {when}, to {_chords(float(tip @ now), case)}"
    else:
        what = f"the forces became infinite or undefined {when}"
    size = f"; one step earlier the tip deflection was {_chords(float(tip @ before), case)}"
    cures = _cures(case, section, of_fluid)
    if finer_helps:
        return (
            f"{what}{size if section.count else ''}. A trial with twice the steps did not diverge: use {_finer(case)}"
        )
    tried = "" if finer_helps is None else ". A trial with twice the steps diverged as well"
    helpful = f". May help: {'; '.join(cures)}" if cures else ""
    return f"{what}{size if section.count else ''}{tried}{helpful}"


def _finer(case: Case) -> str:
    if case.time.periods is None:
        return f"time.step = {0.5 * case.step:.4g}"
    return f"time.steps_per_period = {2.0 * case.steps_per_beat:g}"


def _chords(deflection: float, case: Case) -> str:
    return f"{abs(deflection) / case.wing.chord:.3g} chords"


def _cures(case: Case, section: Modes, of_fluid: Sequence[str]) -> list[str]:
    """What may help, most likely first."""
    found = []
    moved = sampling.sample(case.motion, case.step * np.arange(case.steps + 1, dtype=np.float64))
    pitch_rate = float(np.abs(moved[:, PITCH_RATE]).max())
    if section.count and pitch_rate > section.omega[0]:
        stiffer = "a larger wing.youngs_modulus or wing.thickness"
        found.append(f"{stiffer} (the wing pitches at up to {pitch_rate:.3g} rad/s, faster than its first mode)")
    if section.count and case.step * section.omega[-1] > 1.0:
        found.append("fewer wing.modes (the highest moves by more than a radian in a step)")
    mass_ratio = _mass_ratio(case, section)
    if section.count and mass_ratio > 1.0:
        heavier = "a smaller fluid.density or a larger wing.density"
        found.append(f"{heavier} (added mass is {mass_ratio:.3g} times the wing's mass)")
    return [*found, *of_fluid]


def _mass_ratio(case: Case, section: Modes) -> float:
    """Ratio of a flat plate's added mass to the wing's mass."""
    area = case.wing.chord * Profile.of(case.wing.span).mean
    return math.pi * case.fluid.density * case.wing.chord * area / (4.0 * section.mass)
