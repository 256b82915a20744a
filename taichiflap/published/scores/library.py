"""All published cases, and data that are not scored, with the reason."""

import difflib
import functools
from collections.abc import Iterable

from . import flexible_cases, rigid_cases, viscous_cases
from .tiers import ScoreError
from .truths import Published

EXCLUDED = (
    ("Anderson et al. (1998), plunge of 0.25 chords",
     "the published linear curve is not Garrick's for the stated motion; it differs by a factor of up to 5"),
    ("SD7003 plunging at k = 3.93", "the kinematics of the published trace are not known"),
    ("SD7003 pitching and plunging, lift nearly cancelled", "experiment and computation differ in mean and harmonic"),
    ("Heathcote & Gursul, b/c = 1.41e-3, thrust at St 0.345 and 0.5", "no measurement between St 0.354 and 0.675"),
)  # fmt: skip
"""Data that were examined and excluded."""


@functools.cache
def published() -> tuple[Published, ...]:
    """The cases in the order of the report."""
    return (
        rigid_cases.hover(),
        *rigid_cases.ramps(),
        rigid_cases.turbine(),
        *rigid_cases.propulsion(),
        *flexible_cases.foils(),
        *flexible_cases.plates(),
        *flexible_cases.fluttering(),
        viscous_cases.cylinder(),
        viscous_cases.thin_plate(),
    )


def chosen(names: Iterable[str]) -> tuple[Published, ...]:
    """Published cases by name; all by default.

    Raises:
        ScoreError: for an unknown name.
    """
    known = {one.name: one for one in published()}
    wanted = list(names)
    for name in wanted:
        if name not in known:
            nearest = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {nearest[0]}?" if nearest else f"the cases are {', '.join(known)}"
            raise ScoreError(f"--cases {name}: no such published case; {hint}")
    return tuple(known[name] for name in wanted) or published()
