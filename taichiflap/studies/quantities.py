"""The numbers that a study keeps of each case, by name: `metrics.Summary` flattened, and what a map asks beyond it.

A name is a quantity of the summary with `_mean` and `_spread` where it varies from beat to beat: `force_vertical_mean`.
The words of a name may come in any order: `vertical_force_mean` is the same.
"""

import difflib
import typing
from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from ..beats import Beats, settled_beats
from ..errors import UserError
from ..metrics import Statistic, Summary, harmonics, summarise
from ..variables import VARIABLES, Variable

ORDERS = 3
"""Harmonics that are measured."""
WITH_HARMONICS = ("force_normal", "force_vertical", "tip_deflection")
ALSO_MEANS = ("force_normal", "force_axial", "force_y", "force_z", "moment", "tip_deflection")
"""Variables whose cycle mean the summary does not hold."""
OF_FILM = ("circulation", "wake_")
"""How the names of series begin that belong to a fluid's film, which a study does not keep."""
SERIES = tuple(name for name, one in VARIABLES.items() if one.dimensions == ("time",) and not name.startswith(OF_FILM))
"""The time series that a study can keep."""


class QuantityError(UserError):
    """A metric that does not exist: one sentence with the nearest that do."""


def _of_summary() -> Iterable[str]:
    for field in fields(Summary):
        if field.name.startswith(OF_FILM):
            continue
        kinds = {field.type, *typing.get_args(field.type)}
        if Statistic in kinds:
            yield from (f"{field.name}_mean", f"{field.name}_spread")
        elif kinds & {int, float, bool}:
            yield field.name


def _beyond_summary() -> Iterable[str]:
    yield from (f"{name}_{part}" for name in ALSO_MEANS for part in ("mean", "spread"))
    yield from (
        f"{name}_harmonic_{n}{part}" for name in WITH_HARMONICS for n in range(1, ORDERS + 1) for part in ("", "_phase")
    )
    yield from ("lift_per_power", "lift_per_positive_power")


def _describe(name: str) -> Variable:
    variable = next((v for v in sorted(VARIABLES, key=len, reverse=True) if name.startswith(v)), "")
    words = name.replace("_", " ")
    if name.startswith("lift_per"):
        return Variable((), "N W-1", f"cycle mean of the vertical force over that of {words.removeprefix('lift per ')}")
    if name.endswith("_phase"):
        return Variable((), "degree", words)
    if name in ("tip_peak_mean", "tip_peak_spread"):
        return Variable((), "m", words)
    return Variable((), VARIABLES[variable].units if variable else "1", words)


QUANTITIES = {name: _describe(name) for name in dict.fromkeys((*_of_summary(), *_beyond_summary()))}
"""Every metric of a case, by name."""


def choose(names: Sequence[str]) -> list[str]:
    """The metrics that some names mean; all of them if none are given.

    Raises:
        QuantityError: for a name that is no metric.
    """
    return list(dict.fromkeys(resolve(name) for name in names)) or list(QUANTITIES)


def resolve(name: str) -> str:
    """The metric that a name means, its words in any order.

    Raises:
        QuantityError: when there is none.
    """
    if name in QUANTITIES:
        return name
    words = sorted(name.split("_"))
    for known in QUANTITIES:
        if sorted(known.split("_")) == words:
            return known
    near = difflib.get_close_matches(name, [*QUANTITIES, *map(_spoken, QUANTITIES)], 1, 0.5)
    hint = f"did you mean {resolve(near[0])}?" if near else f"there are {', '.join(QUANTITIES)}"
    raise QuantityError(f"metric {name}: unknown; {hint}")


def _spoken(name: str) -> str:
    """`force_vertical_mean` as it is said: `vertical_force_mean`."""
    first, _, rest = name.partition("_")
    second, _, rest = rest.partition("_")
    return "_".join(filter(None, (second, first, rest)))


def measure(run: Any, names: Sequence[str]) -> dict[str, float]:
    """Metrics of a run: not-a-number where it has none, such as a phase of a wing at rest.

    Args:
        run: anything with the attributes of a result that `summarise` reads.
        names: metrics, as `choose` gives them.
    """
    found = dict.fromkeys(names, float("nan"))
    beats = settled_beats(run)
    summary = summarise(run, beats)
    if summary is None:
        return found
    values = _flattened(summary)
    values |= _further(run, beats, names)
    lift = values["force_vertical_mean"]
    for name, power in (("lift_per_power", "power_mean"), ("lift_per_positive_power", "power_positive_mean")):
        if values[power]:
            values[name] = lift / values[power]
    return found | {name: values[name] for name in names if name in values}


def _flattened(summary: Summary) -> dict[str, float]:
    values: dict[str, float] = {}
    for name, value in vars(summary).items():
        if isinstance(value, Statistic):
            values |= {f"{name}_mean": value.mean, f"{name}_spread": value.spread}
        elif isinstance(value, int | float):
            values[name] = float(value)
    return values


def _further(run: Any, beats: Beats, names: Sequence[str]) -> dict[str, float]:
    values: dict[str, float] = {}
    for name in ALSO_MEANS:
        if any(one.startswith(name) for one in names):
            each = Statistic.over(beats.means(getattr(run, name)))
            values |= {f"{name}_mean": each.mean, f"{name}_spread": each.spread}
    waving = [name for name in WITH_HARMONICS if any(one.startswith(f"{name}_harmonic") for one in names)]
    if waving and run.case.periodic:
        series = np.stack([getattr(run, name)[beats.frames] for name in waving])
        found = harmonics(run.case, run.time[beats.frames], series, ORDERS)
        for (n, k), amplitude in np.ndenumerate(found):
            values[f"{waving[k]}_harmonic_{n + 1}"] = float(abs(amplitude))
            values[f"{waving[k]}_harmonic_{n + 1}_phase"] = float(np.angle(amplitude, deg=True))
    return values
