"""Optimisation by SciPy's differential evolution; each generation is marched as a batch."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..case.case import Case
from ..errors import UserError
from ..maps.design import Axis, Design, DesignError, Spread, Value
from ..metrics.names import METRICS, choose, shown
from ..notation import fraction, short
from ..run.warnings import too_bent
from .expression import Expression, read_constraint, read_expression
from .ledger import Ledger

GENERATIONS, POPULATION = 40, 32
FEWEST = 5
"""Minimum population: differential evolution combines each member with three others."""

Told = Callable[[int, "Optimum | None"], None]
"""Callback of the number of a generation and the best case so far."""


@dataclass(frozen=True)
class Optimum:
    """The best case found.

    Attributes:
        point: values by key.
        value: value of the objective.
        metrics: all metrics of the case.
        holds: whether it meets all constraints.
        evaluations: number of evaluated cases.
        doubts: warnings about the case, one sentence each.
        at_edge: keys with a value at an end of the range, so that a better case may lie outside.
        converged: whether the population converged before the last generation.
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
        """Settings that turn the base case into it, as for `--set`."""
        return [f"{key}={value}" for key, value in self.point.items()]


class _NoValueError(Exception):
    """Raised for an objective without a finite value. It is not a ValueError (as UserError is), which SciPy would
    catch.
    """


class _Search:
    """Maps points of the unit cube to objective and constraints, using the ledger."""

    def __init__(self, ledger: Ledger, spreads: Mapping[str, Spread], objective: Expression, sign: float) -> None:
        self.ledger, self.spreads, self.objective, self.sign = ledger, spreads, objective, sign
        self.conditions: list[Expression] = []
        self.seen: dict[tuple[Value, ...], tuple[float, float, dict[str, float]]] = {}

    def points(self, unit: np.ndarray) -> list[tuple[Value, ...]]:
        columns = [spread.at(row) for spread, row in zip(self.spreads.values(), unit, strict=True)]
        return list(zip(*columns, strict=True))

    def look(self, unit: np.ndarray) -> list[tuple[float, float, dict[str, float]]]:
        """Cost, smallest margin of the constraints, and metrics at points, shape (keys, points), or at one point."""
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
        """Best case so far that meets the constraints, or the closest one if none does."""
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
    """Search ranges of keys for the case that maximises or minimises an expression of metrics.

    Every evaluated case is stored in the map `output`, in order. Cases in the map from an interrupted search, or from
    one with another objective, are not run again.

    Args:
        vary: for each key a range `"a:b"` or `"a:b:log"`, or a list of values.
        maximise, minimise: one of both, an expression such as `"vertical_force_mean / power_mean"`.
        subject_to: constraints such as `"vertical_force_mean >= 2.5e-3"`.
        generations, population: maximum number of generations, and number of cases in each.
        seed: seed of the random numbers; the same seed gives the same search.
        cluster, threads: as `sweep` takes them.

    Returns:
        The best case, or None if every case failed.

    Raises:
        UserError: for an invalid range, expression, file or cluster; one sentence.
    """
    from scipy.optimize import NonlinearConstraint, differential_evolution  # noqa: PLC0415 - half a second
    from scipy.stats import qmc  # noqa: PLC0415

    aim = _aim(maximise, minimise)
    if population < FEWEST or generations < 1:
        raise DesignError(f"give at least {FEWEST} cases per generation, and one generation")
    spreads = _spreads(case, vary)
    conditions = [read_constraint(text) for text in subject_to]
    examples = list(_ends(spreads).examples(case))
    for one in (aim, *conditions):
        choose(one.names, examples)
    # The first generation samples the cube evenly.
    unit = qmc.LatinHypercube(len(spreads), seed=seed).random(population)
    first = {key: spread.at(unit[:1, k])[0] for k, (key, spread) in enumerate(spreads.items())}
    path = None if output is None else Path(output)
    kept = choose((), examples)
    with Ledger(case, first, kept, path, cluster=cluster, threads=threads, overwrite=overwrite) as ledger:
        ledger.sheet.note({"objective": aim.text, "conditions": "; ".join(subject_to)})
        search = _Search(ledger, spreads, aim, -1.0 if maximise else 1.0)
        search.conditions = conditions
        generation = 1  # the first generation only samples the cube and is not reported

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
    """Why an objective has no finite value in any case."""
    columns = {name: np.array([metrics[name] for metrics in measured]) for name in objective.names}
    found = [f"{name} has no value" for name, values in columns.items() if np.isnan(values).all()]
    found += [f"{name} is 0" for name, values in columns.items() if not values.any()]
    reason = " and ".join(found) or "it divides by zero, or takes the root of a negative number"
    return f"{objective.text!r}: no finite value in the first {len(measured)} cases: {reason}"


def _unwrapped(search: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Run SciPy's search; our errors pass through it unchanged."""
    try:
        return search(*arguments, **options)
    except RuntimeError as error:
        if isinstance(error.__cause__, UserError):
            raise error.__cause__ from None
        raise


def _aim(maximise: str | None, minimise: str | None) -> Expression:
    if maximise is not None and minimise is not None:
        raise DesignError("two objectives; give either --maximise or --minimise")
    if maximise is None and minimise is None:
        raise DesignError("no objective; give --maximise EXPRESSION or --minimise EXPRESSION")
    return read_expression(maximise if maximise is not None else str(minimise))


def _spreads(case: Case, vary: Mapping[str, Any]) -> dict[str, Spread]:
    if not vary:
        raise DesignError("no key varies; give --vary KEY=a:b at least once")
    document = case.to_dict()
    spreads = {key: Spread.read(key, spec, document) for key, spec in vary.items()}
    _ends(spreads).check(case)
    return spreads


def _ends(spreads: Mapping[str, Spread]) -> Design:
    """Ends of all ranges, and all values of lists."""
    several = np.linspace(0.0, 1.0, max(2, *(len(spread.listed) for spread in spreads.values())))
    return Design(tuple(Axis(key, spread.at(several)) for key, spread in spreads.items()), grid=False)


def line(best: Optimum | None) -> str:
    """The best case so far, as a line of text."""
    if best is None:
        return "no case has completed"
    where = ", ".join(f"{key} = {short(value)}" for key, value in best.point.items())
    return f"{best.value:.6g}{'' if best.holds else ' (constraints not met)'} at {where}"


def verdict(best: Optimum | None, path: Path) -> list[str]:
    """The result of the search as lines of text."""
    if best is None:
        return ["no case completed, so that there is no best case; widen the ranges or reduce the time step"]
    units = {name: fraction(METRICS[name].units) for name in shown(best.metrics)}
    lines = [f"  {name:<24}{best.metrics[name]:.6g} {unit}".rstrip() for name, unit in units.items()]
    stopped = "the population converged" if best.converged else "the last generation was reached"
    return [
        f"{best.evaluations} cases evaluated, {stopped}; all are in {path}",
        f"{'best case' if best.holds else 'NO CASE MEETS THE CONSTRAINTS; the closest'}: {best.value:.6g}",
        *lines,
        *(f"warning: {doubt}" for doubt in best.doubts),
        *(
            f"{key} = {short(best.point[key])} is at the end of its range; a better value may lie outside: widen the "
            "range"
            for key in best.at_edge
        ),
        _options(best),
    ]


def _options(best: Optimum) -> str:
    return " ".join(f"--set {setting}" for setting in best.settings)
