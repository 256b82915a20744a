"""Whole cases: a run against the pair interactions that it needs, many cases against one, and the parts of a step."""

import functools
import itertools
import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import taichiflap
from taichiflap import fluids
from taichiflap.case.case import Case
from taichiflap.fluids.uvlm import wake
from taichiflap.kernels.runtime import available_threads
from taichiflap.march.march import March
from taichiflap.metrics.names import choose
from taichiflap.run.blocks import BLOCK_STEPS
from taichiflap.studies.batch import compute

from .clock import Clocked, Work, alternate
from .machine import ROOT
from .parts import AGAIN, PARTS, Repeated
from .rows import Row

CASES, SWEEPS, STEP = "One case", "Sweeps", "Parts of a step"
SWEEP, SWEEP_BEATS, STUDY = 256, 3, 10_000
CASE_FILES = ROOT / "cases"


def hawkmoth(*settings: str) -> Case:
    """The paper's case with UVLM."""
    return taichiflap.load_case(CASE_FILES / "hawkmoth.toml", settings)


def hawkmoth_dbet(*settings: str) -> Case:
    """The paper's case with DBET."""
    return taichiflap.load_case(CASE_FILES / "hawkmoth_dbet.toml", settings)


def hawkmoth_ns(*settings: str) -> Case:
    """The paper's wing in a viscous fluid."""
    return taichiflap.load_case(CASE_FILES / "hawkmoth_ns.toml", settings)


def pairs(case: Case) -> float:
    """Pair interactions of a whole run: every wake vortex with all vortices, every control point with the wake."""
    held = np.minimum(np.arange(1, case.steps + 1), wake.ring_size(case)).astype(float)
    panels = case.uvlm.panels
    return float(np.sum(held * (held + panels) + panels * held))


def marching(
    cases: list[Case], threads: int | None = 1, fluid: Any = None, store_outputs: bool = True
) -> Callable[[], Callable[[], list[Any]]]:
    """Work for `alternate`: the march of a batch from rest to its end, its frames handed out if they are stored."""

    def prepare() -> Callable[[], list[Any]]:
        marched = March(cases, fluid or fluids.load(cases[0].solver), threads, store_outputs)
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


def in_memory() -> Iterator[Row]:
    """A run from Python without a path, statistics included, over its march alone."""

    def run(case: Case) -> None:
        taichiflap.simulate(case, threads=1).close()

    for name, case, target in (("UVLM", hawkmoth(), 1.08), ("DBET", hawkmoth_dbet(), None)):
        works: dict[str, Work] = {"run": functools.partial(functools.partial, run, case), "march": marching([case])}
        clocked = alternate(works, 7)
        ratio = clocked["run"].cpu / clocked["march"].cpu
        yield Row(CASES, f"`simulate` without a path, {name}, over its march", ratio, "x", target, at_least=False)
        limit = 12.0 if name == "DBET" else None
        whole = 1e3 * clocked["run"].cpu
        yield Row(CASES, f"`simulate` without a path, {name}, 15 beats", whole, "ms", limit, at_least=False)


def sweeps() -> Iterator[Row]:
    """Many cases at once on all threads against one case at a time."""
    threads = available_threads()
    case = hawkmoth(f"time.periods={SWEEP_BEATS}")
    clocked = alternate({"one": marching([case]), "all": marching([case] * SWEEP, None)}, 3)
    about = f"{SWEEP} UVLM cases of {SWEEP_BEATS} beats over {threads} x one case's throughput"
    yield from _shares(about, clocked)
    yield from _studies()


def _studies() -> Iterator[Row]:
    """A study of blade elements with all metrics, in a batch here and as a user runs it, in several processes."""
    blades, threads = hawkmoth_dbet(), available_threads()
    names = choose((), [blades])
    cases = [blades.override(f"wing.youngs_modulus={24.5e9 * (1.0 + 0.001 * i)}") for i in range(SWEEP)]
    works: dict[str, Work] = {
        "march": marching(cases, 1, None, False),
        "whole": functools.partial(functools.partial, compute, cases, names, False, 1),
    }
    clocked = alternate(works, 3)
    march, whole = (1e3 * clocked[name].cpu / SWEEP for name in works)
    yield Row(SWEEPS, f"DBET, a case of 15 beats with {len(names)} metrics", whole, "ms", note="processor time")
    yield Row(SWEEPS, "DBET, a case over its march", whole / march, "x")
    ideal = 1e3 * threads / whole
    yield Row(SWEEPS, f"DBET, cases of 15 beats with {len(names)} metrics", ideal, "cases/s", 1200.0, note="likewise")
    side = math.isqrt(STUDY)
    vary = {"wing.youngs_modulus": f"15e9:60e9:{side}", "motion.pitch.amplitude_deg": f"5:45:{side}"}
    began = time.perf_counter()
    taichiflap.sweep(blades, vary)
    seconds = time.perf_counter() - began
    note = "start and map included, on the wall"
    yield Row(SWEEPS, f"DBET, a study of {side * side:,} cases", seconds, "s", 0.001 * STUDY, at_least=False, note=note)


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
