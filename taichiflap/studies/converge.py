"""How fine is fine enough: refine one key after the other until the chosen metrics hold still.

The rule: a key is doubled (modes: one more) from where the case has it. A value is fine enough when its next two
refinements both leave every chosen metric within the tolerance of it; the keys after it are refined from there. With
the time step the number of wake vortices is refined too, so that the wake stays as long. At the end the lattice and
the time step are refined once more together, which tells whether one key at a time was good enough.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .. import fluids
from ..case.case import Case
from ..errors import UserError
from ..metrics.names import QUANTITIES, choose
from ..notation import fraction
from .ledger import Ledger, Point

IN_HOVER = ("force_vertical_mean", "power_mean", "tip_peak_mean")
IN_STREAM = ("lift_mean", "thrust_mean", "power_mean", "tip_peak_mean")
"""Metrics that are held if none are named."""
PEAK, LEAST = "force_normal_peak_mean", 0.01
"""A mean force counts as at least this share of the peak force: one that cancels out over a beat is no scale."""
REFINEMENTS = 5
"""A key is refined at most so often: 32 times finer, or 5 modes more."""
STEPS, MODES, PERIODS = "time.steps_per_period", "wing.modes", "time.periods"

Told = Callable[["Trial"], None]


class ConvergeError(UserError):
    """A study of convergence that cannot be: one sentence."""


@dataclass(frozen=True)
class Trial:
    """One value of a key, the metrics there, and their largest change from the value before, as a share."""

    key: str
    value: int
    metrics: dict[str, float]
    change: float = float("nan")


@dataclass
class Convergence:
    """The path of the search.

    Attributes:
        tolerance: as a share.
        trials: every value of every key, in order, with the largest change of a metric from the value before.
        accepted: the value of each key that is fine enough.
        open: keys that were not yet fine enough at their finest.
        together: the largest change when lattice and time step are refined once more together.
    """

    tolerance: float
    trials: list[Trial] = field(default_factory=list)
    accepted: dict[str, int] = field(default_factory=dict)
    open: list[str] = field(default_factory=list)
    together: float = float("nan")

    @property
    def settings(self) -> list[str]:
        """The accepted values as `--set` takes them."""
        return [f"{key}={value}" for key, value in self.accepted.items()]


def read_tolerance(text: str) -> float:
    """A share from `1%` or `0.01`.

    Raises:
        ConvergeError: when it is neither, or not between 0 and 1.
    """
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1.0:
        raise ConvergeError(f"--tolerance {text}: write a share such as 1% or 0.01, between 0 and 1")
    return value


def converge(
    case: Case,
    tolerance: float = 0.01,
    output: str | Path | None = None,
    *,
    metrics: Sequence[str] = (),
    cluster: str | None = None,
    threads: int | None = None,
    told: Told | None = None,
    overwrite: bool = False,
) -> Convergence:
    """Find panels or elements, time steps, wake length, beats and modes that hold metrics within a tolerance.

    Args:
        case: where to start from.
        tolerance: as a share, such as 0.01.
        output: the file that keeps every case, so that none is run twice; in memory if None.
        metrics: which are to hold; vertical force (in a stream lift and thrust), power and tip deflection if empty.
        told: called with every trial.

    Raises:
        UserError: for a metric, a file or a cluster that cannot be; for a case that fails.
    """
    chosen = choose(metrics or (IN_STREAM if case.fluid.streams else IN_HOVER), [case])
    start = _start(case)
    path = None if output is None else Path(output)
    with Ledger(case, start, choose((), [case]), path, cluster=cluster, threads=threads, overwrite=overwrite) as ledger:
        search = _Search(case, ledger, chosen, Convergence(tolerance), told)
        for key in start:
            start = search.refine(key, start)
        search.found.accepted = dict(start)
        finer = {**start}
        for key in start:
            if key not in (PERIODS, MODES, *_per_step(case)):
                finer = _refined(finer, key, case)
        search.found.together = search.change(search.metrics([start, finer]))
        return search.found


def _start(case: Case) -> dict[str, int]:
    found = fluids.load(case.solver).refinements(case)
    steps, periods = case.time.steps_per_period, case.time.periods
    if not isinstance(steps, int) or periods is None:
        raise ConvergeError(f"{STEPS} and {PERIODS}: give them as numbers to refine, with --set or in the case file")
    start = {one.key: one.value for one in found if not one.per_step}
    start |= {STEPS: steps} | {one.key: one.value for one in found if one.per_step} | {PERIODS: periods}
    return start | ({MODES: case.wing.modes} if case.wing.modes else {})


def _per_step(case: Case) -> dict[str, int]:
    """The keys that count what the steps leave behind, and how much a step leaves."""
    return {one.key: one.per_step for one in fluids.load(case.solver).refinements(case) if one.per_step}


def _refined(point: dict[str, int], key: str, case: Case) -> dict[str, int]:
    finer = {**point, key: point[key] + 1 if key == MODES else 2 * point[key]}
    for counted, each in _per_step(case).items():
        if key == STEPS:
            finer[counted] = 2 * point[counted]
        finer[counted] = min(finer[counted], each * (finer[STEPS] * finer[PERIODS] + 1))
    return finer


@dataclass
class _Search:
    case: Case
    ledger: Ledger
    chosen: list[str]
    found: Convergence
    told: Told | None
    peak: float = 0.0

    def refine(self, key: str, start: dict[str, int]) -> dict[str, int]:
        """The coarsest point along a key whose next two refinements change little."""
        points = [start]
        while len(points) <= REFINEMENTS:
            finer = _refined(points[-1], key, self.case)
            if finer == points[-1]:
                break  # it holds all that the run leaves: there is none finer
            points.append(finer)
        whole = len(points) <= REFINEMENTS
        metrics = self.metrics(points[:3])
        for i in range(len(points)):
            if i + 3 > len(metrics) < len(points):
                metrics += self.metrics([points[len(metrics)]])
            ahead = metrics[i + 1 : i + 3]
            still = all(self.change([metrics[i], one]) <= self.found.tolerance for one in ahead)
            if still and (len(ahead) == 2 or whole):
                break
        else:
            self.found.open.append(key)
        for n, one in enumerate(metrics):
            change = self.change(metrics[n - 1 : n + 1]) if n else float("nan")
            self._tell(Trial(key, points[n][key], one, change))
        return points[i]

    def metrics(self, points: Sequence[dict[str, int]]) -> list[dict[str, float]]:
        """Chosen metrics at some points, computed together."""
        tuples: list[Point] = [tuple(point.values()) for point in points]
        found = []
        for point, outcome in zip(points, self.ledger.outcomes(tuples), strict=True):
            if outcome.reason:
                where = ", ".join(f"{key}={value}" for key, value in point.items())
                raise ConvergeError(f"the case with {where} failed: {outcome.reason}")
            found.append({name: outcome.metrics[name] for name in self.chosen})
            for name, value in found[-1].items():
                if math.isnan(value):
                    raise ConvergeError(f"metric {name}: has no value in this case, so that there is nothing to refine")
            self.peak = max(self.peak, outcome.metrics[PEAK])
        return found

    def change(self, pair: Sequence[dict[str, float]]) -> float:
        """Largest change of a chosen metric, as a share of the larger value, or of its scale."""
        first, second = pair
        return max(_share(first[name], second[name], self._scale(name)) for name in self.chosen)

    def _scale(self, name: str) -> float:
        """What a change of a metric is at least a share of."""
        return LEAST * self.peak if name.endswith("_mean") and QUANTITIES[name].units == "N" else 0.0

    def _tell(self, trial: Trial) -> None:
        self.found.trials.append(trial)
        if self.told:
            self.told(trial)


def _share(first: float, second: float, least: float) -> float:
    size = max(abs(first), abs(second), least)
    return abs(first - second) / size if size else 0.0


def line(trial: Trial) -> str:
    """A trial as a row of the table."""
    units = {name: fraction(QUANTITIES[name].units) for name in trial.metrics}
    values = "".join(f"  {name} {value:.6g} {units[name]}".rstrip() for name, value in trial.metrics.items())
    change = "" if trial.change != trial.change else f"  changed by {100.0 * trial.change:.3g} %"
    return f"{trial.key:<22}{trial.value:>8}{values}{change}"


def verdict(found: Convergence) -> list[str]:
    """What was found, in lines."""
    tolerance = f"{100.0 * found.tolerance:g} %"
    lines = [f"NOT within {tolerance} at its finest: {key}" for key in found.open]
    lines.append(f"lattice and time step refined once more together: changed by {100.0 * found.together:.3g} %")
    lines.append(f"fine enough for {tolerance}, {'but for what is named above' if found.open else 'in every key'}:")
    return [*lines, " ".join(f"--set {setting}" for setting in found.settings)]
