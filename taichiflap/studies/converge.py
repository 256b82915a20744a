"""Convergence study: refine one key after the other until the chosen metrics converge.

Starting from its value in the case, a key is doubled (modes: one more). A value is accepted if its next two refinements
both change every chosen metric by less than the tolerance. The accepted value is kept while the next keys are refined.
The number of wake vortices is refined together with the time step, so that the length of the wake stays the same. At
the end model settings and time step are refined once more together, to check the method of one key at a time.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .. import fluids
from ..case.case import Case
from ..errors import UserError
from ..metrics.names import METRICS, choose
from ..notation import fraction
from .ledger import Ledger, Point

IN_HOVER = ("force_vertical_mean", "power_mean", "tip_peak_mean")
IN_STREAM = ("lift_mean", "thrust_mean", "power_mean", "tip_peak_mean")
"""Default metrics."""
PEAK, LEAST = "force_normal_peak_mean", 0.01
"""Minimum scale of a mean force as a share of the peak force, since a mean that cancels over a beat is no suitable
scale.
"""
REFINEMENTS = 5
"""Maximum number of refinements of a key: 32 times finer, or 5 more modes."""
STEPS, MODES, PERIODS = "time.steps_per_period", "wing.modes", "time.periods"

Told = Callable[["Trial"], None]


class ConvergeError(UserError):
    """Raised for an invalid convergence study; one sentence."""


@dataclass(frozen=True)
class Trial:
    """One value of a key, its metrics, and their largest relative change from the previous value."""

    key: str
    value: int
    metrics: dict[str, float]
    change: float = float("nan")


@dataclass
class Convergence:
    """Result of a convergence study.

    Attributes:
        tolerance: relative tolerance.
        trials: all trials in order, with the largest change of a metric from the previous value.
        accepted: accepted value of each key.
        open: keys that did not converge.
        scales: size of each metric below which its changes are taken relative to this instead of to its value.
        together: largest change if model settings and time step are refined once more together.
    """

    tolerance: float
    trials: list[Trial] = field(default_factory=list)
    accepted: dict[str, int] = field(default_factory=dict)
    open: list[str] = field(default_factory=list)
    scales: dict[str, float] = field(default_factory=dict)
    together: float = float("nan")

    @property
    def settings(self) -> list[str]:
        """The accepted values as settings for `--set`."""
        return [f"{key}={value}" for key, value in self.accepted.items()]


def read_tolerance(text: str) -> float:
    """Parse a tolerance such as `1%` or `0.01`.

    Raises:
        ConvergeError: if it is invalid, or not between 0 and 1.
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
    """Find panels or elements, time steps, wake length, beats and modes for which metrics are converged to a tolerance.

    Args:
        case: starting case.
        tolerance: relative tolerance, such as 0.01.
        output: map file that stores every case, so that none is run twice; in memory if None.
        metrics: metrics to converge; if empty, vertical force (in a stream lift and thrust), power and tip deflection.
        told: callback of every trial.

    Raises:
        UserError: for an invalid metric, file or cluster, or if a case fails.
    """
    case = case.resolved()
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
        search.found.scales = {name: search.scale(name) for name in chosen}
        search.found.together = search.change(search.metrics([start, finer]))
        return search.found


def _start(case: Case) -> dict[str, int]:
    found = fluids.load(case.solver).refinements(case)
    steps, periods = case.time.steps_per_period, case.time.periods
    if not isinstance(steps, int) or periods is None:
        raise ConvergeError(
            f"{STEPS} and {PERIODS}: give both as numbers, with --set or in the case file, so that they can be refined"
        )
    start = {one.key: one.value for one in found if not one.per_step}
    start |= {STEPS: steps} | {one.key: one.value for one in found if one.per_step} | {PERIODS: periods}
    return start | ({MODES: case.wing.modes} if case.wing.modes else {})


def _per_step(case: Case) -> dict[str, int]:
    """Keys that count what steps produce, and the maximum number per step."""
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
        """Coarsest value of a key whose next two refinements change little."""
        points = [start]
        while len(points) <= REFINEMENTS:
            finer = _refined(points[-1], key, self.case)
            if finer == points[-1]:
                break  # it already covers the whole run, so that it cannot be refined
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
        """Chosen metrics at several points, computed together."""
        tuples: list[Point] = [tuple(point.values()) for point in points]
        found = []
        for point, outcome in zip(points, self.ledger.outcomes(tuples), strict=True):
            if outcome.reason:
                where = ", ".join(f"{key}={value}" for key, value in point.items())
                raise ConvergeError(f"the case with {where} failed: {outcome.reason}")
            found.append({name: outcome.metrics[name] for name in self.chosen})
            for name, value in found[-1].items():
                if math.isnan(value):
                    raise ConvergeError(f"metric {name}: undefined in this case; choose another")
            self.peak = max(self.peak, outcome.metrics[PEAK])
        return found

    def change(self, pair: Sequence[dict[str, float]]) -> float:
        """Largest change of a chosen metric, relative to the larger value or to its scale."""
        first, second = pair
        return max(_share(first[name], second[name], self.scale(name)) for name in self.chosen)

    def scale(self, name: str) -> float:
        """Minimum scale of a metric."""
        return LEAST * self.peak if name.endswith("_mean") and METRICS[name].units == "N" else 0.0

    def _tell(self, trial: Trial) -> None:
        self.found.trials.append(trial)
        if self.told:
            self.told(trial)


def _share(first: float, second: float, least: float) -> float:
    size = max(abs(first), abs(second), least)
    return abs(first - second) / size if size else 0.0


def line(trial: Trial) -> str:
    """A trial as a line of the table."""
    units = {name: fraction(METRICS[name].units) for name in trial.metrics}
    values = "".join(f"  {name} {value:.6g} {units[name]}".rstrip() for name, value in trial.metrics.items())
    change = "" if trial.change != trial.change else f"  changed by {100.0 * trial.change:.3g} %"
    return f"{trial.key:<22}{trial.value:>8}{values}{change}"


def verdict(found: Convergence) -> list[str]:
    """The result as lines of text."""
    tolerance = f"{100.0 * found.tolerance:g} %"
    lines = [f"NOT converged to {tolerance} at the finest value: {key}" for key in found.open]
    lines.append(f"model settings and time step refined once more together: change of {100.0 * found.together:.3g} %")
    lines.append(f"converged to {tolerance}{', except for the keys named above' if found.open else ' in every key'}:")
    return [*lines, " ".join(f"--set {setting}" for setting in found.settings)]
