"""Whole cases: a run against the pair interactions that it needs, many cases against one, and the parts of a step."""

import functools
import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import taichiflap
from taichiflap import fluids
from taichiflap.case.case import Case
from taichiflap.fluids.uvlm import wake
from taichiflap.kernels.runtime import available_threads
from taichiflap.march.march import March
from taichiflap.run.blocks import BLOCK_STEPS

from .clock import Clocked, alternate
from .machine import ROOT
from .parts import AGAIN, PARTS, Repeated
from .rows import Row

CASES, SWEEPS, STEP = "One case", "Sweeps", "Parts of a step"
SWEEP, SWEEP_BEATS = 256, 3
CASE_FILES = ROOT / "cases"


def hawkmoth(*settings: str) -> Case:
    """The paper's case with UVLM."""
    return taichiflap.load_case(CASE_FILES / "hawkmoth.toml", settings)


def hawkmoth_dbet(*settings: str) -> Case:
    """The paper's case with DBET."""
    return taichiflap.load_case(CASE_FILES / "hawkmoth_dbet.toml", settings)


def pairs(case: Case) -> float:
    """Pair interactions of a whole run: every wake vortex with all vortices, every control point with the wake."""
    held = np.minimum(np.arange(1, case.steps + 1), wake.ring_size(case)).astype(float)
    panels = case.uvlm.panels
    return float(np.sum(held * (held + panels) + panels * held))


def marching(cases: list[Case], threads: int | None = 1, fluid: Any = None) -> Callable[[], Callable[[], list[Any]]]:
    """Work for `alternate`: the march of a batch from rest to its end, its frames handed out."""

    def prepare() -> Callable[[], list[Any]]:
        marched = March(cases, fluid or fluids.load(cases[0].solver), threads)
        marched.advance(0)
        return functools.partial(_to_the_end, marched)

    return prepare


def _to_the_end(marched: March) -> list[Any]:
    frames: list[Any] = []
    while not marched.done:
        frames = marched.advance(BLOCK_STEPS)
    return frames


def alone(limit: float) -> Iterator[Row]:
    """One case at a time against `limit`, the pair interactions a second that a thread can do."""
    cases = {"flexible": hawkmoth(), "rigid": hawkmoth("wing.modes=0")}
    works = {name: marching([case]) for name, case in cases.items()}
    works |= {"single": marching([hawkmoth("uvlm.precision=single")]), "blades": marching([hawkmoth_dbet()])}
    clocked = alternate(works, 5)
    for name, case in cases.items():
        needed = pairs(case) / limit
        yield Row(CASES, f"UVLM {name}, 15 beats", 1e3 * clocked[name].cpu, "ms")
        ratio = clocked[name].cpu / needed
        yield Row(CASES, f"UVLM {name} over its pairs at the C loop's rate", ratio, "x", 2.5, at_least=False)
    saved = clocked["single"].cpu / clocked["flexible"].cpu
    yield Row(CASES, "UVLM flexible with pairs in single precision over double", saved, "x")
    yield Row(CASES, "DBET flexible, 15 beats", 1e3 * clocked["blades"].cpu, "ms", 5.0, at_least=False)


def sweeps() -> Iterator[Row]:
    """Many cases at once on all threads against one case at a time."""
    threads = available_threads()
    case = hawkmoth(f"time.periods={SWEEP_BEATS}")
    clocked = alternate({"one": marching([case]), "all": marching([case] * SWEEP, None)}, 3)
    about = f"{SWEEP} UVLM cases of {SWEEP_BEATS} beats over {threads} x one case's throughput"
    yield from _shares(about, clocked)
    blades = hawkmoth_dbet()
    clocked = alternate({"all": marching([blades] * SWEEP, None)}, 3)
    rate = SWEEP / clocked["all"].wall
    ideal = SWEEP * threads / clocked["all"].cpu
    yield Row(SWEEPS, f"DBET, {SWEEP} cases of 15 beats, on the wall", rate, "cases/s", 400.0)
    yield Row(SWEEPS, f"DBET, {SWEEP} cases of 15 beats, in processor time", ideal, "cases/s", 400.0)


def _shares(about: str, clocked: dict[str, Clocked]) -> Iterator[Row]:
    one, together = clocked["one"], clocked["all"]
    wall = SWEEP * one.wall / (available_threads() * together.wall)
    yield Row(SWEEPS, f"{about}, on the wall", 100.0 * wall, "%", 90.0)
    yield Row(SWEEPS, f"{about}, in processor time", 100.0 * SWEEP * one.cpu / together.cpu, "%", 90.0)


def parts() -> Iterator[Row]:
    """Where the time of a UVLM run goes, each part found from what doing it again adds."""
    case = hawkmoth("output.every=3000")
    repeated = {name: marching([case], fluid=Repeated(name)) for name in PARTS}
    expected = marching([case])()()
    for name, march in repeated.items():
        frames = march()()[0]
        for field, values in expected[0].items():
            np.testing.assert_array_equal(frames[field], values, f"{name} done again changes {field}")
    clocked = alternate({"whole": marching([case]), **repeated, "frames": marching([hawkmoth()])}, 5)
    whole = clocked["whole"].cpu
    taken = {about: (clocked[name].cpu - whole) / AGAIN for name, about in PARTS.items()}
    taken[PARTS["eliminate"]] -= taken[PARTS["assemble"]]
    rest = whole - sum(taken.values())
    shares = itertools.chain(taken.items(), [("the rest: loads, modes, shedding, start", rest)])
    handing = clocked["frames"].cpu - whole
    total = whole + handing
    for about, seconds in (*shares, ("frames handed out, every step", handing)):
        yield Row(STEP, about, 100.0 * seconds / total, "%", note=f"{1e3 * seconds:.0f} ms of {1e3 * total:.0f} ms")
