"""The best case of a range: SciPy's differential evolution, a whole generation marched at a time."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..case.case import Case
from ..errors import UserError
from ..maps.design import Axis, Design, DesignError, Spread, Value
from ..metrics.names import QUANTITIES, choose, shown
from ..notation import fraction, short
from ..run.warnings import too_bent
from .expression import Expression, read_constraint, read_expression
from .ledger import Ledger

GENERATIONS, POPULATION = 40, 32
FEWEST = 5
"""Differential evolution mixes three others into each member of a population."""

Told = Callable[[int, "Optimum | None"], None]
"""Called after each generation with its number and the best case so far."""


@dataclass(frozen=True)
class Optimum:
    """The best case found.

    Attributes:
        point: its values, by key.
        value: of the objective.
        metrics: all of its metrics.
        holds: whether it meets every condition.
        evaluations: how many cases the search looked at.
        doubts: what is implausible about it, a sentence each.
        at_edge: the keys whose value is at an edge of its range, so that a better case may lie beyond.
        converged: whether the population came together before the last generation.
    """

    point: dict[str, Value]
    value: float
    metrics: dict[str, float]
    holds: bool
    evaluations: int
    doubts: list[str]
    at_edge: list[str]
    converged: bool = False

    @property
    def settings(self) -> list[str]:
        """What makes the base case into it, as `--set` takes it."""
        return [f"{key}={value}" for key, value in self.point.items()]


class _NoValueError(Exception):
    """An objective that is defined nowhere. SciPy takes a ValueError, as a UserError is, for one of its own."""


class _Search:
    """Points of the unit cube to objective and conditions, by way of the ledger."""

    def __init__(self, ledger: Ledger, spreads: Mapping[str, Spread], objective: Expression, sign: float) -> None:
        self.ledger, self.spreads, self.objective, self.sign = ledger, spreads, objective, sign
        self.conditions: list[Expression] = []
        self.seen: dict[tuple[Value, ...], tuple[float, float, dict[str, float]]] = {}

    def points(self, unit: np.ndarray) -> list[tuple[Value, ...]]:
        columns = [spread.at(row) for spread, row in zip(self.spreads.values(), unit, strict=True)]
        return list(zip(*columns, strict=True))

    def look(self, unit: np.ndarray) -> list[tuple[float, float, dict[str, float]]]:
        """Cost, least margin of the conditions, and metrics at points, shape (keys, points), or at one."""
        points = self.points(unit.reshape(len(self.spreads), -1))
        for point, outcome in zip(points, self.ledger.outcomes(points), strict=True):
            if point not in self.seen:
                value = self.objective.of(outcome.metrics) if outcome.metrics else np.nan
                margins = [one.of(outcome.metrics) if outcome.metrics else -1.0 for one in self.conditions]
                cost = self.sign * value if np.isfinite(value) else np.inf
                self.seen[point] = cost, float(np.min(np.nan_to_num(margins, nan=-1.0), initial=1.0)), outcome.metrics
        return [self.seen[point] for point in points]

    def cost(self, unit: np.ndarray) -> np.ndarray:
        looked = self.look(unit)
        measured = [metrics for _, _, metrics in looked if metrics]
        if measured and not any(np.isfinite(cost) for cost, *_ in self.seen.values()):
            raise _NoValueError(_why_none(self.objective, measured))
        return np.array([cost for cost, *_ in looked])

    def margin(self, unit: np.ndarray) -> np.ndarray:
        margins = np.array([margin for _, margin, _ in self.look(unit)])
        return margins if unit.ndim == 1 else margins[None, :]

    def best(self) -> Optimum | None:
        """The best case so far that meets the conditions; the one that comes closest if none does."""
        ranked = sorted(self.seen.items(), key=lambda item: (-min(item[1][1], 0.0), item[1][0]))
        for point, (cost, margin, metrics) in ranked:
            if np.isfinite(cost):
                values = dict(zip(self.spreads, point, strict=True))
                edge = [key for key, value in values.items() if self.spreads[key].at_edge(value)]
                chord = float(values.get("wing.chord", self.ledger.sheet.case.wing.chord))
                doubts = list(too_bent(metrics["tip_peak_mean"], chord))
                return Optimum(values, self.sign * cost, metrics, margin >= 0.0, len(self.seen), doubts, edge)
        return None


def optimise(
    case: Case,
    vary: Mapping[str, Any],
    maximise: str | None = None,
    minimise: str | None = None,
    subject_to: Sequence[str] = (),
    output: str | Path | None = None,
    *,
    generations: int = GENERATIONS,
    population: int = POPULATION,
    seed: int = 0,
    cluster: str | None = None,
    threads: int | None = None,
    told: Told | None = None,
    overwrite: bool = False,
) -> Optimum | None:
    """Search ranges of keys for the case that maximises, or minimises, an expression of metrics.

    Every case that the search looks at stands in the map `output`, in the order of the search; a case that stands
    there already, from a search that was interrupted or had another aim, is not run again.

    Args:
        vary: for each key a range `"a:b"` or `"a:b:log"`, or a list of values to choose from.
        maximise, minimise: one of them, such as `"vertical_force_mean / power_mean"`.
        subject_to: conditions such as `"vertical_force_mean >= 2.5e-3"`.
        generations, population: at most so many generations, of so many cases each.
        seed: of the random choices; the same seed gives the same search.
        cluster, threads: as `sweep` takes them.

    Returns:
        The best case, or None if every case failed.

    Raises:
        UserError: for a range, an expression, a file or a cluster that cannot be, in one sentence.
    """
    from scipy.optimize import NonlinearConstraint, differential_evolution  # noqa: PLC0415 - half a second
    from scipy.stats import qmc  # noqa: PLC0415

    aim = _aim(maximise, minimise)
    if population < FEWEST or generations < 1:
        raise DesignError(f"a search has at least {FEWEST} cases a generation, and one generation")
    spreads = _spreads(case, vary)
    conditions = [read_constraint(text) for text in subject_to]
    examples = list(_ends(spreads).examples(case))
    for one in (aim, *conditions):
        choose(one.names, examples)
    # The first generation fills the cube evenly.
    unit = qmc.LatinHypercube(len(spreads), seed=seed).random(population)
    first = {key: spread.at(unit[:1, k])[0] for k, (key, spread) in enumerate(spreads.items())}
    path = None if output is None else Path(output)
    kept = choose((), examples)
    with Ledger(case, first, kept, path, cluster=cluster, threads=threads, overwrite=overwrite) as ledger:
        ledger.sheet.note({"objective": aim.text, "conditions": "; ".join(subject_to)})
        search = _Search(ledger, spreads, aim, -1.0 if maximise else 1.0)
        search.conditions = conditions
        generation = 1  # the first fills the cube, and is not told

        def tell(intermediate_result: Any) -> None:
            nonlocal generation
            generation += 1
            if told:
                told(generation, search.best())

        try:
            found = _unwrapped(
                differential_evolution,
                search.cost,
                [(0.0, 1.0)] * len(spreads),
                init=unit,
                maxiter=generations - 1,
                seed=seed,
                polish=False,
                updating="deferred",
                vectorized=True,
                callback=tell,
                constraints=[NonlinearConstraint(search.margin, 0.0, np.inf)] if conditions else (),
            )
        except _NoValueError as error:
            raise DesignError(str(error)) from None
        best = search.best()
        return best and Optimum(**{**vars(best), "converged": bool(found.success)})


def _why_none(objective: Expression, measured: Sequence[Mapping[str, float]]) -> str:
    """Why an objective has no finite value in any of the cases."""
    columns = {name: np.array([metrics[name] for metrics in measured]) for name in objective.names}
    found = [f"{name} has no value" for name, values in columns.items() if np.isnan(values).all()]
    found += [f"{name} is 0" for name, values in columns.items() if not values.any()]
    reason = " and ".join(found) or "it divides by zero, or takes a root of what is negative"
    return f"{objective.text!r}: has no finite value in any of the first {len(measured)} cases: {reason}"


def _unwrapped(search: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """What a search of SciPy's gives; of an error of ours it makes one of its own."""
    try:
        return search(*arguments, **options)
    except RuntimeError as error:
        if isinstance(error.__cause__, UserError):
            raise error.__cause__ from None
        raise


def _aim(maximise: str | None, minimise: str | None) -> Expression:
    if (maximise is None) == (minimise is None):
        raise DesignError("say what to look for: --maximise EXPRESSION, or --minimise EXPRESSION")
    return read_expression(maximise if maximise is not None else str(minimise))


def _spreads(case: Case, vary: Mapping[str, Any]) -> dict[str, Spread]:
    if not vary:
        raise DesignError("nothing varies: give --vary KEY=a:b at least once")
    document = case.to_dict()
    spreads = {key: Spread.read(key, spec, document) for key, spec in vary.items()}
    _ends(spreads).check(case)
    return spreads


def _ends(spreads: Mapping[str, Spread]) -> Design:
    """The ends of all ranges, and all values of lists."""
    several = np.linspace(0.0, 1.0, max(2, *(len(spread.listed) for spread in spreads.values())))
    return Design(tuple(Axis(key, spread.at(several)) for key, spread in spreads.items()), grid=False)


def line(best: Optimum | None) -> str:
    """The best case so far, in a line."""
    if best is None:
        return "no case came to its end"
    where = ", ".join(f"{key} = {short(value)}" for key, value in best.point.items())
    return f"{best.value:.6g}{'' if best.holds else ' (conditions not met)'} at {where}"


def verdict(best: Optimum | None, path: Path) -> list[str]:
    """What the search found, in lines."""
    if best is None:
        return ["no case came to its end: there is no best one"]
    units = {name: fraction(QUANTITIES[name].units) for name in shown(best.metrics)}
    lines = [f"  {name:<24}{best.metrics[name]:.6g} {unit}".rstrip() for name, unit in units.items()]
    stopped = "the population came together" if best.converged else "the last generation was reached"
    return [
        f"{best.evaluations} cases looked at, {stopped}; all of them are in {path}",
        f"{'best case' if best.holds else 'NO CASE MEETS THE CONDITIONS; the closest'}: {best.value:.6g}",
        *lines,
        *(f"warning: {doubt}" for doubt in best.doubts),
        *(
            f"{key} = {short(best.point[key])} is at the edge of its range: better may lie beyond"
            for key in best.at_edge
        ),
        _options(best),
    ]


def _options(best: Optimum) -> str:
    return " ".join(f"--set {setting}" for setting in best.settings)
