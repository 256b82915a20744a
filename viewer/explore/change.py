"""Changes of a case: its explored part, keys that a change requires, and undo."""

from collections.abc import Iterable
from typing import Any

from taichiflap.case.case import Case, CaseError
from taichiflap.case.solver import ELSEWHERE

from .keys import value_of

BEATS = 5
"""Beats that are computed at most."""
AIR, WATER = 1.5e-5, 1e-6
"""Kinematic viscosity, m2/s, that a case without one is given if its model asks for it; water is a dense fluid."""
DENSE = 100.0
"""Density, kg/m3, from which a fluid is taken for water."""


def brief(case: Case) -> Case:
    """The case with only as many beats as are explored."""
    if case.periodic and (case.time.periods or 0) > BEATS:
        return case.changed({"time.periods": BEATS})
    return case


def changed(case: Case, values: dict[str, Any]) -> Case:
    """The case with some values changed, and with a viscosity if the model requires one.

    Raises:
        CaseError: for a value that is refused.
    """
    try:
        return case.changed(values)
    except CaseError as error:
        if not any("fluid.viscosity" in problem for problem in error.problems):
            raise
    viscosity = WATER if case.fluid.density > DENSE else AIR
    return case.changed({"fluid.viscosity": viscosity} | values)


def addressed(first: Case, given: Iterable[str]) -> Case:
    """The case of an address. Its settings are plain values, so that no address names a file or a module.

    Raises:
        CaseError: for any other setting, and for a value that is refused.
    """
    given = list(given)
    for one in given:
        key, _, value = one.partition("=")
        if "file" in key or ELSEWHERE in value or value.strip().startswith(("[", "{")):
            raise CaseError(first.title, [f"{key}: an address gives plain values, and names no file or module"])
    return first.override(*given)


def settings(first: Case, case: Case, keys: Iterable[str]) -> list[str]:
    """Settings that change the first case into another, in the form of `--set`."""
    different = [key for key in keys if value_of(first, key) != value_of(case, key)]
    return [f"{key}={short_text(value_of(case, key))}" for key in different]


def short_text(value: Any) -> str:
    """A value in the form of `--set`."""
    return str(value).lower() if isinstance(value, bool) else repr(value) if isinstance(value, float) else str(value)


class History:
    """The cases of one browser, for undo and redo."""

    def __init__(self, first: Case) -> None:
        self._cases, self._now = [first], 0

    def add(self, case: Case) -> None:
        """Set the current case; cases that were undone are dropped."""
        self._now += 1
        self._cases[self._now :] = [case]

    def undo(self) -> Case:
        """The case before, or the first."""
        self._now = max(self._now - 1, 0)
        return self._cases[self._now]

    def redo(self) -> Case:
        """The case that was undone last, or the newest."""
        self._now = min(self._now + 1, len(self._cases) - 1)
        return self._cases[self._now]
