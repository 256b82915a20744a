"""The models and settings that are scored, each a name and what it changes of a case."""

from collections.abc import Iterable
from dataclasses import dataclass

from ...case.case import Case
from ...errors import UserError
from .truths import Published


class ScoreError(UserError):
    """Raised when a tier or a published case that was asked for does not exist."""


@dataclass(frozen=True)
class Tier:
    """A model with its settings.

    Attributes:
        name: as `--models` names it.
        label: heading of its column.
        settings: `key=value` pairs that it sets in a case.
        reynolds: Reynolds numbers between which it runs; None for any, theory without viscosity included.
    """

    name: str
    label: str
    settings: tuple[str, ...]
    reynolds: tuple[float, float] | None = None

    def case(self, published: Published) -> Case:
        """A published case with this model."""
        return published.case().override(*self.settings, *published.settings.get(self.name, ()))

    def runs(self, published: Published) -> bool:
        """Whether the model is made for the case's Reynolds number."""
        if self.reynolds is None:
            return True
        return published.reynolds is not None and self.reynolds[0] <= published.reynolds <= self.reynolds[1]


PAPER = (
    "dbet.coefficients=reade_jankauski", "dbet.frame=chord", "dbet.added_mass=strip", "dbet.attached=false",
    "dbet.rotation=0.0", "dbet.friction=none",
)  # fmt: skip
"""The blade elements as Reade & Jankauski (2020) have them."""
TIERS = (
    Tier("dbet-paper", "DBET, paper", ("solver=dbet", *PAPER)),
    Tier("dbet", "DBET", ("solver=dbet",)),
    Tier("uvlm", "UVLM", ("solver=uvlm",)),
    Tier("uvlm-suction", "UVLM, suction", ("solver=uvlm", "uvlm.suction=true")),
    Tier("uvlm-sheds", "UVLM, sheds", ("solver=uvlm", "uvlm.leading_edge=sheds")),
    Tier("navier-stokes", "Navier-Stokes", ("solver=navier_stokes",), reynolds=(20.0, 5000.0)),
)
"""In the order of the columns."""


def chosen(names: Iterable[str]) -> tuple[Tier, ...]:
    """Tiers by their names; all if none is named.

    Raises:
        ScoreError: for a name that is none.
    """
    known = {tier.name: tier for tier in TIERS}
    wanted = list(names)
    for name in wanted:
        if name not in known:
            raise ScoreError(f"--models {name}: no such model; there are {', '.join(known)}")
    return tuple(known[name] for name in wanted) or TIERS
