"""Run published cases in every model, and store the outcomes, so that the next call continues."""

import hashlib
import itertools
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from ... import files
from ..._version import __version__
from ...case.case import Case
from ...run.blocks import simulate
from .measures import Trace, measure
from .tiers import ScoreError, Tier
from .truths import Published, Truth

DRAWN = 300
"""Approximate number of points of a stored time history."""
BATCH = 8
"""Number of cases per batch."""


@dataclass(frozen=True)
class Outcome:
    """Outcome of a model for a published case.

    Attributes:
        case, tier: names.
        key: hash of the case files and the version; identifies the runs.
        values: by quantity; empty if a run failed, without quantities that do not occur in the model.
        seconds: solve time, s.
        reason: why the run failed, or an empty text.
        trace: time, lift and drag coefficient of a case whose time histories are drawn.
    """

    case: str
    tier: str
    key: str
    values: dict[str, float]
    seconds: float
    reason: str = ""
    trace: dict[str, list[float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Row:
    """A published value, and the outcome of each tier."""

    published: Published
    truth: Truth
    outcomes: dict[str, Outcome]

    def value(self, tier: str) -> float | None:
        """A tier's value; None if it was not run or failed."""
        outcome = self.outcomes.get(tier)
        return outcome.values.get(self.truth.quantity) if outcome else None


class Store:
    """Outcomes in a JSON file, or in memory without a path.

    Raises:
        ScoreError: if the file is not a file of scores.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._found: dict[tuple[str, str], Outcome] = {}
        if path is not None and path.exists():
            try:
                rows = json.loads(path.read_text(encoding="utf-8"))["outcomes"]
                self._found = {(row["case"], row["tier"]): Outcome(**row) for row in rows}
            except (OSError, ValueError, KeyError, TypeError):
                raise ScoreError(f"{path}: not a file of scores; name another with -o") from None

    def get(self, case: str, tier: str, key: str) -> Outcome | None:
        """The stored outcome of a run, if it matches."""
        found = self._found.get((case, tier))
        return found if found and found.key == key else None

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Store outcomes, and write them to the disk at once."""
        self._found |= {(one.case, one.tier): one for one in outcomes}
        if self.path is not None:
            text = json.dumps({"outcomes": [asdict(one) for one in self._found.values()]}, indent=1)
            with files.replacing(self.path) as file:
                file.write(text.encode())


def key_of(cases: Sequence[Case]) -> str:
    """Key of an outcome: its cases and the version of the solver."""
    return hashlib.sha256(f"{__version__}\n{''.join(case.to_toml() for case in cases)}".encode()).hexdigest()[:16]


def score(
    cases: Sequence[Published],
    tiers: Sequence[Tier],
    store: Store | None = None,
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Row]:
    """Compare models with published values.

    Args:
        cases: published cases.
        tiers: models with their settings.
        store: storage of outcomes, which is checked before a run.
        threads: number of threads; None for all. It does not affect results.
        progress: callback of (runs done, all runs).

    Returns:
        A row for each published figure of a case that some model was run for, in the order of the cases.
    """
    store = store or Store(None)
    found: dict[tuple[str, str], Outcome] = {}
    done, total = 0, len(cases) * len(tiers)
    for tier in tiers:
        missing = []
        for one in cases:
            if not tier.runs(one):
                done += 1
                continue
            own = tier.cases(one)
            known = store.get(one.name, tier.name, key_of(own))
            if known:
                found[one.name, tier.name] = known
                done += 1
            else:
                missing.append((one, own))
        for first in range(0, len(missing), BATCH):
            group = missing[first : first + BATCH]
            outcomes = list(_run(group, tier, threads))
            store.add(outcomes)
            found |= {(one.case, one.tier): one for one in outcomes}
            done += len(group)
            if progress:
                progress(done, total)
    ran = {name for name, _ in found}
    return [
        Row(one, truth, {tier.name: found[one.name, tier.name] for tier in tiers if (one.name, tier.name) in found})
        for one in cases
        if one.name in ran
        for truth in one.truths
    ]


def _run(group: Sequence[tuple[Published, Sequence[Case]]], tier: Tier, threads: int | None) -> Iterator[Outcome]:
    # Only series, since storing the wake in every frame needs too much memory.
    cases = [case.override(f"output.every={case.steps}") for _, own in group for case in own]
    results = iter(simulate(cases, threads=threads))
    for one, own in group:
        traces, seconds, reason = [], 0.0, ""
        for result in itertools.islice(results, len(own)):
            with result:
                seconds += float(result.attributes["solve_time"])
                reason = reason or result.attributes.get("reason", "")
                if result.status == "complete":
                    traces.append(Trace.of(result, one.speed))
        found = {}
        if len(traces) == len(own):
            found = {truth.quantity: measure(traces, truth.quantity, truth.window, [*one.family])
                     for truth in one.truths}  # fmt: skip
        values = {name: value for name, value in found.items() if math.isfinite(value)}
        drawn = _thinned(traces[0]) if found and one.drawn else {}
        yield Outcome(one.name, tier.name, key_of(own), values, seconds, reason, drawn)


def _thinned(trace: Trace) -> dict[str, list[float]]:
    every = max(1, len(trace.time) // DRAWN)
    rows = {"time": trace.time, "C_L": trace.lift, "C_D": trace.drag}
    return {name: [round(float(value), 5) for value in row[::every]] for name, row in rows.items()}
