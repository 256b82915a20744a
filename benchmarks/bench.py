"""Speed, as ratios to what the arithmetic costs in the same run: `make bench`.

The yardstick is a plain C loop over vortex pairs (`gcc -O3 -march=native -ffast-math`, one thread). Where no
compiler is found, the solver's own pair sum stands in for it, and the table says so.
"""

import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import taichiflap
from taichiflap import fluids, wake
from taichiflap.case import Case
from taichiflap.march import March
from taichiflap.run import BLOCK_STEPS
from taichiflap.runtime import available_threads
from taichiflap.vortex import induced_velocity

ROOT = Path(__file__).parent.parent
REPEATS = 7

C_LOOP = r"""
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
__attribute__((noinline))
static void induce(int n, const double *y, const double *z, const double *g, double *u, double *v) {
    for (int i = 0; i < n; i++) {
        double a = 0, b = 0;
        for (int j = 0; j < n; j++) {
            double dy = y[i] - y[j], dz = z[i] - z[j], s = g[j] / (dy * dy + dz * dz + 1e-8);
            a -= dz * s; b += dy * s;
        }
        u[i] = a; v[i] = b;
    }
}
int main(int argc, char **argv) {
    int n = atoi(argv[1]), repeats = 1 + (int)(2e8 / ((double)n * n));
    double *x = malloc(5 * n * sizeof *x);
    for (int i = 0; i < 5 * n; i++) x[i] = rand() / (double)RAND_MAX;
    double t = now();
    for (int k = 0; k < repeats; k++) induce(n, x, x + n, x + 2 * n, x + 3 * n, x + 4 * n);
    printf("%.17g\n", (double)repeats * n * n / (now() - t));
    return 0;
}
"""


def median(measure: Callable[[], float], repeats: int = REPEATS) -> float:
    return statistics.median(measure() for _ in range(repeats))


def c_pair_rate(vortices: int) -> float | None:
    """Pair interactions a second of the C loop on one thread; None without a compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if not compiler:
        return None
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder, "pairs.c"), Path(folder, "pairs")
        source.write_text(C_LOOP)
        subprocess.run([compiler, "-O3", "-march=native", "-ffast-math", source, "-o", program], check=True)
        return median(lambda: float(subprocess.run([program, str(vortices)], capture_output=True, check=True).stdout))


def our_pair_rate(vortices: int) -> float:
    """Pair interactions a second of the solver's sum, on all threads."""
    cloud = np.random.default_rng(0).normal(size=(3, vortices))
    targets = np.tile(cloud[:2], (1, max(1, int(4e8 / vortices**2))))

    def measure() -> float:
        began = time.perf_counter()
        induced_velocity(targets, cloud, 1e-4)
        return targets.shape[1] * vortices / (time.perf_counter() - began)

    return median(measure)


def pairs(case: Case) -> float:
    """Pair interactions of a whole run: every wake vortex with all vortices, every control point with the wake."""
    held = np.minimum(np.arange(1, case.steps + 1), wake.ring_size(case)).astype(float)
    panels = case.uvlm.panels
    return float(np.sum(held * (held + panels) + panels * held))


def solve_time(case: Case, threads: int | None = None, copies: int = 1) -> float:
    """Seconds that the march of a case (or of copies of it) takes, frames included, compilation not."""

    def measure() -> float:
        march = March([case] * copies, fluids.load(case.solver), threads)
        march.advance(0)
        began = time.perf_counter()
        while not march.done:
            march.advance(BLOCK_STEPS)
        return time.perf_counter() - began

    return median(measure, 5 if copies == 1 else 3)


def command_time(*settings: str, cache: str | None = None) -> float:
    """Seconds of the whole command, the start of Python included."""
    environment = {**os.environ, **({"TI_OFFLINE_CACHE_FILE_PATH": cache} if cache else {})}
    with tempfile.TemporaryDirectory() as folder:
        case = str(ROOT / "cases" / "hawkmoth.toml")
        command = [sys.executable, "-m", "taichiflap", "simulate", case, *settings]
        began = time.perf_counter()
        subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=True)
        return time.perf_counter() - began


def rows() -> list[tuple[str, str, str]]:
    """Name, figure and target of every measurement."""
    flexible = taichiflap.load_case(ROOT / "cases" / "hawkmoth.toml")
    blades = taichiflap.load_case(ROOT / "cases" / "hawkmoth_dbet.toml")
    in_c = c_pair_rate(250)
    ours = our_pair_rate(250)
    rate = in_c or ours / available_threads()
    found = [
        ("pair rate, C loop, 1 thread", f"{in_c / 1e9:.2f} Gpair/s" if in_c else "no compiler", ""),
        ("pair rate, ours, all threads", f"{ours / 1e9:.2f} Gpair/s", ""),
    ]
    for name, case in (("flexible", flexible), ("rigid", flexible.override("wing.modes=0"))):
        seconds, needed = solve_time(case), pairs(case) / rate
        found.append((f"UVLM {name}, 15 beats", f"{seconds:.3f} s = {seconds / needed:.2f} x its pairs", "<= 5 x"))
    found.append(("DBET flexible, 15 beats", f"{1e3 * solve_time(blades):.1f} ms", "<= 20 ms"))
    one = solve_time(flexible, threads=1, copies=8)
    both = solve_time(flexible, copies=8)
    found.append((f"8 cases, {available_threads()} threads against 1", f"{one / both:.2f} x faster", ""))
    warm = median(command_time, 5)
    found.append(("whole command, warm", f"{warm:.2f} s", "<= 2.5 s"))
    with tempfile.TemporaryDirectory() as cache:
        found.append(("whole command, cold", f"{command_time(cache=cache):.2f} s", "<= 15 s"))
    return found


def machine() -> str:
    """What ran this, for the record."""
    cpu = platform.processor() or "unknown processor"
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{named[0] if named else cpu}, {available_threads()} threads, Python {platform.python_version()}"


def main() -> None:
    print(machine())
    for name, figure, target in rows():
        print(f"{name:<34}{figure:<32}{target}", flush=True)


if __name__ == "__main__":
    main()
