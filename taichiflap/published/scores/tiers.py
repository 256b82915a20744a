"""The scored models with their settings."""

from collections.abc import Iterable
from dataclasses import dataclass

from ...case.case import Case
from ...errors import UserError
from ...scored.settings import SETTINGS
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

    def own(self, case: Case) -> tuple[str, ...]:
        """Keys that a case itself sets for this tier's model, and the tier does not."""
        changed = case.override(*self.settings)
        table = getattr(changed, changed.solver)
        known = {setting.partition("=")[0] for setting in self.settings}
        keys = (f"{changed.solver}.{key}" for key in sorted(table.model_fields_set))
        return tuple(key for key in keys if key not in known)

    def cases(self, published: Published) -> tuple[Case, ...]:
        """A published case with the settings of this tier, or the cases of its family."""
        one = published.case().override(*self.settings, *published.settings.get(self.name, ()))
        return tuple(one.override(*settings) for settings in published.family.values()) or (one,)

    def runs(self, published: Published) -> bool:
        """Whether the model applies to a published case, and at its Reynolds number."""
        if published.models is not None and self.name not in published.models:
            return False
        return self.takes(published.reynolds)

    def takes(self, reynolds: float | None) -> bool:
        """Whether the model applies at a Reynolds number; None is that of a fluid without viscosity."""
        if self.reynolds is None:
            return True
        return reynolds is not None and self.reynolds[0] <= reynolds <= self.reynolds[1]


LABELS = {
    "dbet-paper": "DBET, paper", "dbet": "DBET", "uvlm": "UVLM", "uvlm-suction": "UVLM, suction",
    "uvlm-sheds": "UVLM, sheds", "navier-stokes": "Navier-Stokes",
}  # fmt: skip
LIMITS = {"navier-stokes": (20.0, 5000.0)}
TIERS = tuple(Tier(name, LABELS[name], settings, LIMITS.get(name)) for name, settings in SETTINGS.items())
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
