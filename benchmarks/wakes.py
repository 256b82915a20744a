"""Long wakes: the time of one step of the march against the number of wake vortices, by pairs and by the tree.

A wake shorter than `long_wake.WIDE` is computed by one thread.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from taichiflap import fluids
from taichiflap.fluids.uvlm import long_wake
from taichiflap.fluids.uvlm.long_wake import WIDE
from taichiflap.fluids.uvlm.wake import COUNT
from taichiflap.kernels.runtime import available_threads, view
from taichiflap.march.march import March

from .clock import alternate
from .rows import Row
from .runs import hawkmoth

SECTION = "Long wakes"
SIZES = (200, 800, 3200, 12_800, 50_000)
SHEDDING = ("uvlm.leading_edge=sheds", "uvlm.suction_limit=0.0", "uvlm.spacing=cosine", "uvlm.loads=vortices")
WAYS = {
    "direct": ("uvlm.far_error=0.0",),
    "direct, single precision": ("uvlm.precision=single",),
    "tree, error 1e-3": ("uvlm.far_error=1e-3",),
    "direct, two vortices a step": ("uvlm.far_error=0.0", *SHEDDING),
    "tree, error 1e-3, two vortices a step": ("uvlm.far_error=1e-3", *SHEDDING),
}
LARGEST = {"direct, two vortices a step": 12_800}
"""Vortices up to which a way is clocked, if not up to the last of `SIZES`."""
CROSSOVER = (1700, 2400, 3400, 4800)
"""Vortices between which the tree becomes faster than the pair sums."""
SECONDS = 0.2
"""About so long is a clocking, where one step is not longer."""


StepTimes = dict[str, dict[int, float]]
"""Seconds of a step on all threads, by the way of summing and by number of vortices."""


def step_times(limit: float) -> StepTimes:
    """Clock the steps; `limit` is a thread's pair interactions a second."""
    taken: StepTimes = {name: {} for name in WAYS}
    for size in SIZES:
        steps = max(1, math.ceil(SECONDS * limit / size**2))
        ways = {name: way for name, way in WAYS.items() if size <= LARGEST.get(name, size)}
        works = {name: functools.partial(_laid, size, steps, way) for name, way in ways.items()}
        for name, clocked in alternate(works, 3).items():
            # Processor time shared out among the threads: what passes where nobody else works.
            taken[name][size] = clocked.cpu / steps / (available_threads() if size >= WIDE else 1)
    return taken


def _laid(size: int, steps: int, way: Sequence[str]) -> Callable[[], object]:
    """A march whose wake holds `size` vortices already, strewn over some chords, and its next steps."""
    beats = -(-(size + steps + 2) // 200)
    case = hawkmoth(
        f"uvlm.wake={size}", "uvlm.core=0.02", f"time.periods={beats}", "output.every=1000", *way, "wing.modes=0"
    )
    march = March([case], fluids.load("uvlm"))
    march.advance(2)
    ring, vortices = view(march.groups["wake"].ring), view(march.groups["wake"].vortex)
    rng = np.random.default_rng(size)
    shed = int(ring[0, COUNT])
    newest = vortices[0, :, :shed].copy()
    vortices[0, :3, :size] = rng.normal(size=(3, size)) * np.array([[0.04], [0.04], [1e-3 / size]])
    vortices[0, 3, :size] = newest[3, 0]
    vortices[0, :, :shed] = newest
    ring[0, COUNT] = size
    march.next_step = size
    return functools.partial(march.advance, steps)


def rows(taken: StepTimes, limit: float) -> Iterator[Row]:
    """The table's lines, the measured exponent among them."""
    threads = available_threads()
    for name, times in taken.items():
        for size, seconds in times.items():
            used = threads if size >= WIDE else 1
            note = f"{seconds * limit * used / size**2:.2f} x all pairs at the C loop's rate on {used} thread(s)"
            yield Row(SECTION, f"{name}: step of {size} vortices", 1e3 * seconds, "ms", note=note)
        yield Row(SECTION, f"{name}: exponent of the cost from 3,200 vortices up", exponent(times), "")


def crossover(limit: float) -> Iterator[Row]:
    """Where the tree becomes faster than the pair sums, with one and two vortices a step, in processor time."""
    pairs = {"one vortex a step": "", "two vortices a step": ", two vortices a step"}
    ways = {f"{sums}{ending}" for sums in ("direct", "tree, error 1e-3") for ending in pairs.values()}
    taken: StepTimes = {name: {} for name in WAYS if name in ways}
    least, long_wake.FAR = long_wake.FAR, CROSSOVER[0]
    try:
        for size in CROSSOVER:
            steps = max(1, math.ceil(0.5 * SECONDS * limit / size**2))
            works = {name: functools.partial(_laid, size, steps, WAYS[name]) for name in taken}
            for name, clocked in alternate(works, 2).items():
                taken[name][size] = clocked.cpu / steps
    finally:
        long_wake.FAR = least
    for about, ending in pairs.items():
        direct, tree = taken[f"direct{ending}"], taken[f"tree, error 1e-3{ending}"]
        ratios = {size: tree[size] / direct[size] for size in CROSSOVER}
        for size, ratio in ratios.items():
            note = f"{1e3 * tree[size]:.3g} ms of {1e3 * direct[size]:.3g} ms a step"
            yield Row(SECTION, f"{about}: tree over direct, {size} vortices", ratio, "x", note=note)
        found, note = _crossing(ratios)
        yield Row(SECTION, f"{about}: vortices from which the tree is faster", found, "", note=note)
        slopes = f"{exponent(direct, 0):.2f} and {exponent(tree, 0):.2f}"
        slope = exponent(ratios, 0)
        yield Row(
            SECTION, f"{about}: exponent of the ratio", slope, "", note=f"direct and tree in this range: {slopes}"
        )


def _crossing(ratios: dict[int, float]) -> tuple[float, str]:
    """Where a ratio falls below one, interpolated, and between which sizes."""
    sizes = list(ratios)
    for few, many in itertools.pairwise(sizes):
        if ratios[few] > 1.0 >= ratios[many]:
            share = math.log(ratios[few]) / math.log(ratios[few] / ratios[many])
            return few * (many / few) ** share, f"between {few} and {many}; used from {long_wake.FAR}"
    return math.nan, f"not between {sizes[0]} and {sizes[-1]}"


def exponent(taken: dict[int, float], smallest: int = 3200) -> float:
    """Slope of log(time) over log(vortices) among the larger wakes."""
    sizes = [size for size in taken if size >= smallest]
    return float(np.polyfit(np.log(sizes), np.log([taken[size] for size in sizes]), 1)[0])
