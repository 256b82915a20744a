"""Metrics of a case by name: the values of `metrics.Summary`, and further metrics for maps.

A name is an attribute of the summary, with `_mean`, `_spread` (standard deviation) or `_error` (standard error of the
mean) if it varies from beat to beat: `force_vertical_mean`.
This version also accepts the words in another order, such as `vertical_force_mean`.
"""

import cmath
import difflib
import math
import typing
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from ..case.case import Case
from ..errors import UserError
from ..march.reference import reference
from ..results.variables import VARIABLES, Variable
from .columns import columns
from .reduced import ORDERS, WAVING
from .similarity import Similarity
from .statistic import Statistic, Statistics
from .summary import Summary

OF_FILM = ("circulation", "wake_")
"""Prefixes of series from a fluid model's outputs, which a study does not keep."""
SERIES = tuple(name for name, one in VARIABLES.items() if one.dimensions == ("time",) and not name.startswith(OF_FILM))
"""Time series that a study can keep."""
RATIOS = {"lift_per_power": "power_mean", "lift_per_positive_power": "power_positive_mean"}
"""Denominators of the mean lift, or of the mean vertical force in hover."""
IN_HOVER = ("force_vertical_mean", "power_mean", "lift_per_power", "tip_peak_mean")
IN_STREAM = ("lift_mean", "thrust_mean", "power_mean", "lift_per_power", "propulsive_efficiency", "tip_peak_mean")
"""Metrics shown for a study, where available."""
POWER = "power_mean"
GAINS = {"lift_mean", "thrust_mean", "force_vertical_mean"}
"""Metrics compared with the power in Pareto fronts."""

STREAM, BEAT, SPEED, FLUID, VISCOSITY, MASS, RADIUS, PIVOT = (
    "in hover: it needs a free stream, fluid.velocity; the vertical force is force_vertical_mean",
    "for a non-periodic motion: it needs motion.frequency",
    "without a reference speed: it needs a stream, or a motion of mid-chord",
    "where fluid.density is zero",
    "without a viscosity: it needs fluid.viscosity",
    "without a weight: it needs body.mass",
    "where the section's radius is not known: it needs motion.measured",
    "where the pivot rests in the fluid",
)
"""Conditions under which a metric is undefined."""
OF_STREAM = ("lift_mean", "lift_spread", "lift_error", "thrust_", "drag_", "propulsive_", "strouhal")
OF_BEATS = (
    "settled", "force_drift", "force_normal_phase", "reduced_frequency", "strouhal",
    *(f"{name}_harmonic" for name in WAVING),
)  # fmt: skip
OF_SPEED = ("lift_coefficient", "power_coefficient")
"""Prefixes of metrics that are undefined under each condition."""


class MetricError(UserError):
    """Raised for an unknown metric; one sentence with the nearest names."""


def _metrics() -> Iterator[tuple[str, str, str]]:
    """Name, units and description of every metric."""
    for field, hint in typing.get_type_hints(Summary, include_extras=True).items():
        units = "".join(getattr(hint, "__metadata__", ()))
        if units and not field.startswith(OF_FILM):
            parts = ("_mean", "_spread", "_error") if Statistic in _alternatives(hint.__origin__) else ("",)
            yield from ((f"{field}{part}", units, _said(f"{field}{part}")) for part in parts)
    for name in WAVING:
        for n in range(1, ORDERS + 1):
            wave = f"{name}_harmonic_{n}"
            yield wave, VARIABLES[name].units, wave.replace("_", " ")
            yield f"{wave}_phase", "degree", f"{wave}_phase".replace("_", " ")
    for name, power in RATIOS.items():
        spent = power.removesuffix("_mean").replace("_", " ")
        yield name, "N W-1", f"cycle mean of the lift (in hover: of the vertical force) over that of the {spent}"


def _said(name: str) -> str:
    return name.replace("_", " ").replace(" error", " standard error of the mean")


def _alternatives(hint: Any) -> tuple[Any, ...]:
    return typing.get_args(hint) or (hint,)


QuantityError = MetricError
"""Its name until version 0.3."""

METRICS = {name: Variable((), units, text) for name, units, text in _metrics()}
"""Every metric of a case, by name."""


def choose(names: Sequence[str], cases: Collection[Case] = ()) -> list[str]:
    """Metrics for the given names; all metrics if none are given.

    Args:
        cases: representative cases; metrics undefined for all of them are left out.

    Raises:
        MetricError: for an unknown metric, or one undefined for all cases.
    """
    chosen = list(dict.fromkeys(resolve(name) for name in names))
    lacking = [undefined(case) for case in cases]
    nowhere = {name: why for name, why in lacking[0].items() if all(name in one for one in lacking)} if lacking else {}
    for name in chosen:
        if name in nowhere:
            raise MetricError(f"metric {name}: not defined {nowhere[name]}")
    return chosen or [name for name in METRICS if name not in nowhere]


def undefined(case: Case) -> dict[str, str]:
    """Undefined metrics of a case, by name, each with the condition."""
    scale = reference(case)
    lacking: dict[str, str] = {}
    if not scale.force:
        lacking |= _beginning(OF_SPEED, SPEED if case.fluid.density else FLUID)
    if not case.fluid.streams:
        lacking |= _beginning(OF_STREAM, STREAM)
    if not case.periodic:
        lacking |= _beginning(OF_BEATS, BEAT)
    if not scale.speed:
        lacking.setdefault("reduced_frequency", SPEED)
    alike = Similarity.of(case)
    if alike.reynolds is None:
        lacking["reynolds"] = VISCOSITY
    if case.body.mass is None:
        lacking["lift_over_weight"] = MASS
    if alike.wing_tip_speed is None:
        lacking["wing_tip_speed"] = RADIUS
    if alike.angle_of_attack_mean is None:
        lacking |= _beginning(("angle_of_attack",), PIVOT)
    return lacking


def _beginning(starts: tuple[str, ...], where: str) -> dict[str, str]:
    return {name: where for name in METRICS if name.startswith(starts)}


def shown(kept: Collection[str]) -> list[str]:
    """Metrics to show of those that a study keeps, most important first; others if it keeps none of them."""
    streams = any(name in kept for name in IN_STREAM[:2])
    return [name for name in (IN_STREAM if streams else IN_HOVER) if name in kept] or list(kept)[: len(IN_HOVER)]


def gains(kept: Collection[str]) -> list[str]:
    """Metrics of a study that its Pareto fronts compare with the power."""
    return [name for name in shown(kept) if name in GAINS] if POWER in kept else []


def resolve(name: str) -> str:
    """The metric for a name, with its words in any order.

    Raises:
        MetricError: if there is none.
    """
    if name in METRICS:
        return name
    words = sorted(name.split("_"))
    for known in METRICS:
        if sorted(known.split("_")) == words:
            return known
    near = difflib.get_close_matches(name, [*METRICS, *map(_spoken, METRICS)], 1, 0.5)
    hint = f"did you mean {resolve(near[0])}?" if near else f"the metrics are {', '.join(METRICS)}"
    raise MetricError(f"metric {name}: unknown; {hint}")


def _spoken(name: str) -> str:
    """Spoken form of a name: `vertical_force_mean` for `force_vertical_mean`."""
    first, _, rest = name.partition("_")
    second, _, rest = rest.partition("_")
    return "_".join(filter(None, (second, first, rest)))


def measure(parts: Iterable[Any], names: Sequence[str]) -> list[dict[str, float]]:
    """Metrics of each of several runs; NaN where undefined, such as the phase of a wing at rest.

    Args:
        parts: as of `taichiflap.metrics.columns.columns`.
        names: metrics as returned by `choose`.
    """
    found: dict[int, dict[str, float]] = {}
    for members, of_summary in columns(parts):
        values = _flattened(of_summary) if of_summary else {}
        undefined_here = [math.nan] * len(members)
        rows = zip(*(values.get(name, undefined_here) for name in names), strict=True)
        for b, row in zip(members, rows, strict=True):
            found[b] = dict(zip(names, row, strict=True))
    return [found[b] for b in range(len(found))]


def _flattened(of_summary: Mapping[str, Any]) -> dict[str, list[float]]:
    """Metrics of each run by name, of the columns of a summary."""
    values: dict[str, list[float]] = {}
    for name, column in of_summary.items():
        if isinstance(column, Statistics):
            values[f"{name}_mean"], values[f"{name}_spread"] = column.mean.tolist(), column.spread.tolist()
            values[f"{name}_error"] = column.error.tolist()
        elif isinstance(column, list):
            values[name] = [math.nan if value is None else float(value) for value in column]
    for name, waves in of_summary["harmonics"].items():
        for n, wave in enumerate(zip(*waves, strict=True), 1):
            values[f"{name}_harmonic_{n}"] = [abs(one) for one in wave]
            values[f"{name}_harmonic_{n}_phase"] = [math.degrees(cmath.phase(one)) for one in wave]
    lifts = values.get("lift_mean", values["force_vertical_mean"])
    for name, power in RATIOS.items():
        each = zip(lifts, values[power], strict=True)
        values[name] = [lift / spent if spent else math.nan for lift, spent in each]
    return values
