"""A verdict: one statement of the paper compared with the computation, and shared helpers."""

from dataclasses import dataclass

from .paper import TABLE_5
from .plan import Runs, key

CLOSE = 0.10
"""Relative tolerance within which a number counts as reproduced."""
NAMES = {"dbet": "DBET", "uvlm": "UVLM"}
DEFINITIONS = {"force_vertical": "full vector", "force_vertical_normal": "wing-normal part"}


@dataclass(frozen=True)
class Verdict:
    """One statement of the paper compared with the computation.

    Attributes:
        what: the quantity.
        printed, here: the paper's statement and ours.
        reproduced: whether they agree; None where agreement is not the point.
        why: closeness of the agreement, or the reason of a difference.
    """

    what: str
    printed: str
    here: str
    reproduced: bool | None
    why: str

    @classmethod
    def number(cls, what: str, printed: float, here: float, unit: str, remark: str) -> "Verdict":
        """The verdict on a number, reproduced if it is within `CLOSE` of the paper's."""
        off = here / printed - 1.0
        why = f"{remark}; within {abs(off):.1%}" if abs(off) <= CLOSE else f"{remark}; {off:+.0%}"
        return cls(what, f"{printed:.4g} {unit}", f"{here:.4g} {unit}", abs(off) <= CLOSE, why)

    @property
    def state(self) -> str:
        """The verdict in a word or two."""
        return "measured" if self.reproduced is None else "reproduced" if self.reproduced else "NOT reproduced"

    def __str__(self) -> str:
        return f"{self.state}: {self.what}: paper {self.printed}, here {self.here}; {self.why}"


def mean_force(runs: Runs, solver: str, modes: int, definition: str) -> float:
    """Mean vertical force (N) of the paper's case by one of the two definitions."""
    return getattr(runs[key(solver, f"wing.modes={modes}")].summary, definition).mean


def closer(runs: Runs, solver: str, modes: int) -> str:
    """The definition that comes closer to the number of Table 5."""
    printed = TABLE_5[solver, modes]
    return min(DEFINITIONS, key=lambda definition: abs(mean_force(runs, solver, modes, definition) - printed))
