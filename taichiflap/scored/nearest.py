"""The scored cases nearest to a case, and the errors of its model there."""

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from typing import Any

from ..case.case import Case, read_value
from .regime import Regime
from .settings import SETTINGS

NEAR = 1.0
"""Maximum distance of comparable cases, see `Regime.distance`."""
MOST = 2
"""Number of named cases."""


@dataclass(frozen=True)
class Neighbour:
    """A scored case beside another.

    Attributes:
        name: name of the scored case.
        regime: its regime.
        distance, difference: from the other case, see `Regime`.
        errors: relative errors of the model there, by quantity.
    """

    name: str
    regime: Regime
    distance: float
    difference: float
    errors: Mapping[str, float]


def model_of(case: Case) -> str | None:
    """Name of the scored model of a case: the one with the most settings, all shared with the case; None if none."""
    document = case.to_dict()
    alike = [name for name, settings in SETTINGS.items() if all(_has(document, setting) for setting in settings)]
    return max(alike, key=lambda name: len(SETTINGS[name]), default=None)


def _has(document: Mapping[str, Any], setting: str) -> bool:
    key, _, text = setting.partition("=")
    value: Any = document
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return bool(value == read_value(text))


@functools.cache
def known() -> dict[str, dict[str, Any]]:
    """Regime and relative errors by tier and quantity of each case of the committed page."""
    return json.loads(resources.files(__package__).joinpath("known.json").read_text(encoding="utf-8"))


def nearest(case: Case) -> list[Neighbour]:
    """Nearest scored cases of a case's model, nearest first; empty if none is near."""
    return _near(_alike(case))


def sentence(case: Case) -> str:
    """The nearest scored cases with their first errors as text; if none is near, the least far one."""
    alike = _alike(case)
    near = _near(alike)
    if near or not alike:
        return "; ".join(_told(one, one.name) for one in near) or "none is near"
    kind = "flexible" if alike[0].regime.bends else "rigid"
    return f"none is near; the least far is {_told(alike[0], f'{alike[0].name} ({kind})')}"


def _alike(case: Case) -> list[Neighbour]:
    """Scored cases of a case's model, in hover or in a stream as the case is, those that differ least first."""
    model, here, found = model_of(case), Regime.of(case), []
    for name, one in known().items():
        regime, errors = Regime(**one["regime"]), one["errors"].get(model)
        if errors and regime.hovers == here.hovers:
            found.append(Neighbour(name, regime, here.distance(regime), here.difference(regime), errors))
    return sorted(found, key=lambda neighbour: neighbour.difference)


def _near(alike: list[Neighbour]) -> list[Neighbour]:
    return [one for one in alike if one.distance <= NEAR][:MOST]


def _told(one: Neighbour, name: str) -> str:
    errors = (f"{quantity} {100 * error:+.0f} %" for quantity, error in list(one.errors.items())[:2])
    return f"{name}: {', '.join(errors)}"
