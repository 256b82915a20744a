"""Long wakes: the time of one step of the march against the number of wake vortices."""

import functools
import math
from collections.abc import Callable, Iterator

import numpy as np

from taichiflap import fluids
from taichiflap.march import March
from taichiflap.runtime import available_threads, view
from taichiflap.wake import COUNT

from .clock import alternate
from .rows import Row
from .runs import hawkmoth

SECTION = "Long wakes"
SIZES = (200, 800, 3200, 12_800, 50_000)
SECONDS = 0.2
"""About so long is a clocking, where one step is not longer."""


def step_times(limit: float) -> dict[int, float]:
    """Seconds of a step on all threads, by number of vortices; `limit` is a thread's pair interactions a second."""
    taken = {}
    for size in SIZES:
        steps = max(1, math.ceil(SECONDS * limit / size**2))
        work = functools.partial(_laid, size, steps)
        taken[size] = alternate({"step": work}, 3)["step"].wall / steps
    return taken


def _laid(size: int, steps: int) -> Callable[[], object]:
    """A march whose wake holds `size` vortices already, strewn over some chords, and its next steps."""
    beats = -(-(size + steps + 2) // 200)
    case = hawkmoth(f"uvlm.wake={size}", "uvlm.core=0.02", f"time.periods={beats}", "output.every=1000", "wing.modes=0")
    march = March([case], fluids.load("uvlm"))
    march.advance(2)
    ring, vortices = view(march.groups["wake"].ring), view(march.groups["wake"].vortex)
    rng = np.random.default_rng(size)
    newest = vortices[0, :, :2].copy()
    vortices[0, :3, :size] = rng.normal(size=(3, size)) * np.array([[0.04], [0.04], [1e-3 / size]])
    vortices[0, 3, :size] = newest[3, 0]
    vortices[0, :, :2] = newest
    ring[0, COUNT] = size
    return functools.partial(march.advance, steps)


def rows(taken: dict[int, float], limit: float) -> Iterator[Row]:
    """The table's lines, the measured exponent among them."""
    threads = available_threads()
    for size, seconds in taken.items():
        bound = size**2 / (limit * threads)
        note = f"{seconds / bound:.2f} x the direct sum at the C loop's rate on {threads} threads"
        yield Row(SECTION, f"step of {size} vortices", 1e3 * seconds, "ms", note=note)
    yield Row(SECTION, "exponent of the cost from 3,200 vortices up", exponent(taken), "")


def exponent(taken: dict[int, float], smallest: int = 3200) -> float:
    """Slope of log(time) over log(vortices) among the larger wakes."""
    sizes = [size for size in taken if size >= smallest]
    return float(np.polyfit(np.log(sizes), np.log([taken[size] for size in sizes]), 1)[0])
