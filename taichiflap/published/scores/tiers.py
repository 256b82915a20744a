"""The scored models with their settings."""

from collections.abc import Iterable
from dataclasses import dataclass

from ...case.case import Case
from ...errors import UserError
from .truths import Published


class ScoreError(UserError):
    """Raised if a requested tier or published case does not exist."""


@dataclass(frozen=True)
class Tier:
    """A model with its settings.

    Attributes:
        name: name for `--models`.
        label: heading of its column.
        settings: `key=value` settings of the case.
        reynolds: range of Reynolds numbers; None for any, including inviscid theory.
    """

    name: str
    label: str
    settings: tuple[str, ...]
    reynolds: tuple[float, float] | None = None

    def case(self, published: Published) -> Case:
        """A published case with this model."""
        return published.case().override(*self.settings, *published.settings.get(self.name, ()))

    def runs(self, published: Published) -> bool:
        """Whether the model applies at the case's Reynolds number."""
        if self.reynolds is None:
            return True
        return published.reynolds is not None and self.reynolds[0] <= published.reynolds <= self.reynolds[1]


PAPER = (
    "dbet.coefficients=reade_jankauski", "dbet.frame=chord", "dbet.added_mass=strip", "dbet.attached=false",
    "dbet.rotation=0.0", "dbet.friction=none",
)  # fmt: skip
"""The blade elements of Reade & Jankauski (2020)."""
TIERS = (
    Tier("dbet-paper", "DBET, paper", ("solver=dbet", *PAPER)),
    Tier("dbet", "DBET", ("solver=dbet",)),
    Tier("uvlm", "UVLM", ("solver=uvlm",)),
    Tier("uvlm-suction", "UVLM, suction", ("solver=uvlm", "uvlm.suction=true")),
    Tier("uvlm-sheds", "UVLM, sheds", ("solver=uvlm", "uvlm.leading_edge=sheds")),
    Tier("navier-stokes", "Navier-Stokes", ("solver=navier_stokes",), reynolds=(20.0, 5000.0)),
)
"""All tiers, in the order of the columns."""


def chosen(names: Iterable[str]) -> tuple[Tier, ...]:
    """Tiers by name; all by default.

    Raises:
        ScoreError: for an unknown name.
    """
    known = {tier.name: tier for tier in TIERS}
    wanted = list(names)
    for name in wanted:
        if name not in known:
            raise ScoreError(f"--models {name}: no such model; the models are {', '.join(known)}")
    return tuple(known[name] for name in wanted) or TIERS
