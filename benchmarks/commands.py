"""Time besides the solve: start of the command, first compilation, and output."""

import functools
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import taichiflap

from .clock import Clocked, alternate
from .rows import Row
from .runs import CASE_FILES, hawkmoth, hawkmoth_dbet

START, OUTPUT = "Start", "Output"


def command(*words: str, cache: str | None = None) -> tuple[Clocked, float]:
    """The whole command, the start of Python included, and the seconds of its solve."""
    # As a user starts it: modules are compiled once, by the first turn.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment |= {"TI_OFFLINE_CACHE_FILE_PATH": cache} if cache else {}
    with tempfile.TemporaryDirectory() as folder:
        before, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "taichiflap", *words], cwd=folder, env=environment, capture_output=True, check=True
        )
        after, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - wall
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        solve = 0.0
        for path in Path(folder).glob("*.h5"):
            with taichiflap.open_result(path) as result:
                solve = float(result.attributes["solve_time"])
        return Clocked(wall, cpu), solve


def start() -> Iterator[Row]:
    """Start of the commands; the first turn of each is not counted."""
    helped = [command("--help")[0] for _ in range(4)][1:]
    yield Row(START, "`--help`", statistics.median(one.wall for one in helped), "s", 0.3, at_least=False)
    yield Row(START, "`--help`, in processor time", statistics.median(one.cpu for one in helped), "s")
    simulate = ("simulate", str(CASE_FILES / "hawkmoth.toml"))
    taken = [command(*simulate) for _ in range(4)][1:]
    over = statistics.median(clocked.wall - solve for clocked, solve in taken)
    yield Row(START, "`simulate cases/hawkmoth.toml`, warm, over its solve", over, "s", 1.5, at_least=False)
    warm = statistics.median(clocked.wall for clocked, _ in taken)
    yield Row(START, "`simulate cases/hawkmoth.toml`, warm, whole", warm, "s")
    cpu = statistics.median(clocked.cpu for clocked, _ in taken)
    yield Row(START, "`simulate cases/hawkmoth.toml`, warm, whole, in processor time", cpu, "s")
    with tempfile.TemporaryDirectory() as cache:
        cold, _ = command(*simulate, cache=cache)
    yield Row(START, "compilation without a cache, on the wall", cold.wall - warm, "s", 10.0, at_least=False)
    yield Row(START, "compilation without a cache, in processor time", cold.cpu - cpu, "s")


def drawing() -> Iterator[Row]:
    """Figures of one result over the run that made it, in processor time."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")
        simulate = ("simulate", str(CASE_FILES / "hawkmoth.toml"), "-o", str(path), "--overwrite")
        plot = ("plot", str(path), "-o", folder, "--overwrite")
        taken = [(command(*simulate)[0], command(*plot)[0]) for _ in range(4)][1:]
        run, figures = (statistics.median(one.cpu for one in some) for some in zip(*taken, strict=True))
        note = f"{figures:.2g} s of {run:.2g} s"
        yield Row(OUTPUT, "`plot` of one result over a warm `simulate`", figures / run, "x", 1.0, False, note)
        sweep = "sweep", str(CASE_FILES / "hawkmoth_dbet.toml"), "-o", str(Path(folder, "map.h5")), "--overwrite"
        spread = "motion.pitch.amplitude_deg=10:40:12", "wing.youngs_modulus=15e9:60e9:12"
        command(*sweep, "--vary", spread[0], "--vary", spread[1])
        plot = ("plot", str(Path(folder, "map.h5")), "-o", folder, "--overwrite")
        taken_by_map = [command(*plot)[0] for _ in range(4)][1:]
        cpu = statistics.median(one.cpu for one in taken_by_map)
        yield Row(OUTPUT, "`plot` of a map of 144 cases, in processor time", cpu, "s", 2.0, at_least=False)


def output() -> Iterator[Row]:
    """Share of a run that goes into its frames: handed out, derived, written."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")

        def run(case: taichiflap.Case) -> None:
            taichiflap.simulate(case, path, threads=1, overwrite=True).close()

        for name, case in (("UVLM", hawkmoth()), ("DBET", hawkmoth_dbet())):
            bare = case.override(f"output.every={case.steps}")
            works = {
                "full": functools.partial(functools.partial, run, case),
                "bare": functools.partial(functools.partial, run, bare),
            }
            clocked = alternate(works, 5)
            added = clocked["full"].cpu - clocked["bare"].cpu
            target = 15.0 if name == "UVLM" else None
            share = 100.0 * added / clocked["full"].cpu
            note = f"{1e3 * added:.0f} ms of {1e3 * clocked['full'].cpu:.0f} ms of processor time"
            yield Row(OUTPUT, f"{name} hawkmoth, every step stored: share of the run", share, "%", target, False, note)
