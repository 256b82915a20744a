"""The scored cases nearest to a case, and the errors of its model there."""

import functools
import json
import math
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
    """A nearby scored case, and the model's relative errors there by quantity."""

    name: str
    distance: float
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
    model = model_of(case)
    if model is None:
        return []
    here, found = Regime.of(case), []
    for name, one in known().items():
        errors, distance = one["errors"].get(model), here.distance(Regime(**one["regime"]))
        if errors and distance <= NEAR:
            found.append(Neighbour(name, distance, errors))
    return sorted(found, key=lambda neighbour: neighbour.distance)[:MOST]


def sentence(case: Case) -> str:
    """The nearest scored cases with their first errors as text; if none is near, the least far one."""
    found = nearest(case)
    return "; ".join(map(_told, found)) or f"none is near{_least_far(case)}"


def _least_far(case: Case) -> str:
    """The scored case in hover, or in a stream, that differs least, rigid or flexible, with its first errors."""
    model, here = model_of(case), Regime.of(case)
    found = []
    for name, one in known().items():
        regime, errors = Regime(**one["regime"]), one["errors"].get(model)
        if errors and regime.hovers == here.hovers:
            kind = "flexible" if regime.bends else "rigid"
            found.append((here.difference(regime), Neighbour(f"{name} ({kind})", math.inf, errors)))
    return f"; the least far is {_told(min(found, key=lambda pair: pair[0])[1])}" if found else ""


def _told(one: Neighbour) -> str:
    errors = (f"{name} {100 * error:+.0f} %" for name, error in list(one.errors.items())[:2])
    return f"{one.name}: {', '.join(errors)}"
