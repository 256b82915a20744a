"""The cases of the reproduction by key: solver and differences from the paper's case."""

from collections.abc import Callable, Iterator

from ...case.case import Case
from . import measured, paper
from .measured import Measured
from .paper import AIR, DENSITY_OF_THE_ROW, Settings

Key = tuple[str, ...]
Runs = dict[Key, Measured]

RIGID = "wing.modes=0"
NO_ADDED_MASS = "dbet.added_mass=false"
UNDAMPED = "wing.damping_ratio=0"
TRUNCATED = "dbet.speed=truncated"
ROW = (NO_ADDED_MASS, f"fluid.density={DENSITY_OF_THE_ROW}")
"""DBET without added mass, at the density that gives the paper's mean forces."""
TRIALS = 3
BATCH = 12
"""Number of cases per batch, so that their results fit in memory."""
LONG = 300
"""Number of wake vortices from which only every fourth step is stored."""
PAPERS = {"wing.modes=1", f"fluid.density={AIR}", "dbet.elements=50", "uvlm.panels=50", "uvlm.wake=200"}
"""Overrides that change nothing."""


def key(solver: str, *overrides: str) -> Key:
    """The key of a case: the solver and those overrides that change the paper's case."""
    return solver, *(override for override in overrides if override not in PAPERS)


def with_rigid(*overrides: str) -> tuple[Key, Key]:
    """The overrides for the flexible wing and for the rigid one."""
    return overrides, (*overrides, RIGID)


def halved(settings: Settings, wake: int | None = None) -> Key:
    """The overrides for half the time step, and for UVLM the vortices kept, of which a beat is now twice as many."""
    step = f"time.steps_per_period={2 * settings.steps_per_period}"
    return (step,) if wake is None else (step, f"uvlm.wake={wake}")


def keys(settings: Settings) -> list[Key]:
    """Every case once."""
    found: dict[Key, None] = {}

    def add(solver: str, *variants: Key) -> None:
        found.update(dict.fromkeys(key(solver, *variant) for variant in variants))

    for solver in ("dbet", "uvlm"):
        add(solver, *with_rigid(), (UNDAMPED,))
        add(solver, *((f"wing.modes={count}",) for count in settings.modes))
        for density in settings.densities:
            add(solver, *with_rigid(f"fluid.density={density}"))
    add("dbet", *(variant for count in settings.elements for variant in with_rigid(f"dbet.elements={count}")))
    add("dbet", *with_rigid(NO_ADDED_MASS), *with_rigid(*ROW), (*ROW, UNDAMPED), (TRUNCATED,), (TRUNCATED, UNDAMPED))
    add("dbet", *with_rigid(*halved(settings)))
    add("uvlm", *with_rigid(*halved(settings, 200)), *with_rigid(*halved(settings, 400)))
    add("uvlm", *(variant for count in settings.panels for variant in with_rigid(f"uvlm.panels={count}")))
    for wake in (*settings.wakes, *settings.long_wakes):
        add("uvlm", *with_rigid(f"uvlm.wake={wake}"))
    return list(found)


def case(settings: Settings, wanted: Key) -> Case:
    """The case of a key. Studies of wakes store every second or fourth step, since results are kept in memory."""
    planned = paper.case(settings, *wanted)
    if planned.solver == "dbet" or set(wanted[1:]) <= {RIGID}:
        return planned
    vortices = planned.steps if planned.uvlm.wake == "all" else planned.uvlm.wake
    long = vortices > LONG * planned.steps_per_beat // settings.steps_per_period
    return planned.override(f"output.every={4 if long else 2}")


def batches(settings: Settings) -> Iterator[list[tuple[Key, Case]]]:
    """The cases of one solver at a time, the costly ones last, so that those of a batch take about as long."""
    planned = [(wanted, case(settings, wanted)) for wanted in keys(settings)]
    for solver in ("dbet", "uvlm"):
        mine = sorted((pair for pair in planned if pair[0][0] == solver), key=lambda pair: measured.work([pair[1]]))
        while mine:
            count = 2 if mine[0][1].output.every > 2 else BATCH
            yield mine[:count]
            mine = mine[count:]


def compute(settings: Settings, progress: Callable[[float], None] | None = None) -> Runs:
    """Run every case.

    Raises:
        StudyError: if one of them failed.
    """
    runs: Runs = {}
    parts = list(batches(settings))
    costs = [measured.work([one for _, one in part]) for part in parts]
    for number, part in enumerate(parts):

        def tell(share: float, done: float = sum(costs[:number]), cost: float = costs[number]) -> None:
            if progress is not None:
                progress((done + share * cost) / sum(costs))

        found = measured.run([one for _, one in part], tell)
        runs.update(zip((wanted for wanted, _ in part), found, strict=True))
    return runs


def timings(settings: Settings) -> dict[str, float]:
    """Seconds that the flexible wing takes with each solver, alone and on one thread: the best of `TRIALS`."""
    return {
        solver: min(measured.run([paper.case(settings, solver)], threads=1)[0].solve_time for _ in range(TRIALS))
        for solver in ("dbet", "uvlm")
    }
