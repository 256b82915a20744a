"""The Navier-Stokes model: a step against the memory that it moves, and many cases against one."""

import functools
from collections.abc import Callable, Iterator

import numpy as np

from taichiflap import fluids
from taichiflap.case.case import Case
from taichiflap.fluids.navier_stokes.settings import settings
from taichiflap.kernels.runtime import available_threads
from taichiflap.march.march import March

from .clock import Work, alternate
from .rows import Row
from .runs import hawkmoth_ns

SECTION = "Navier-Stokes"
STEPS = 300
CASES = 8
PASSES = 21
"""Arrays of one number a cell that a rigid step reads or writes: 7 for the right-hand side and its two factors, 7 on
the way inwards and 7 on the way outwards."""
STATE = 9
"""Arrays of this kind that a rigid step touches."""
COPIES = 50


def case(*settings: str) -> Case:
    """The hawkmoth's rigid wing."""
    common = ("wing.modes=0", "time.periods=1", "time.steps_per_period=1000")
    return hawkmoth_ns(*common, *settings)


def rows() -> Iterator[Row]:
    """The table's lines."""
    kinds = {
        "rigid, Re 100": case("fluid.viscosity=4e-4"),
        "rigid, Re 1,000": case("fluid.viscosity=4e-5"),
        "rigid, Re 2,000": case("fluid.viscosity=2e-5"),
    }
    works: dict[str, Work] = {name: _stepping([one]) for name, one in kinds.items()}
    works["one mode, Re 1,000"] = _stepping([case("fluid.viscosity=4e-5", "wing.modes=1")])
    works["several"] = _stepping([kinds["rigid, Re 100"]] * CASES, None)
    works |= {f"memory of {name}": functools.partial(_copying, cells(one)) for name, one in kinds.items()}
    clocked = alternate(works, 3)
    for name, one in kinds.items():
        step, count = clocked[name].cpu / STEPS, cells(one)
        note = f"{1e9 * step / count:.0f} ns a cell"
        yield Row(SECTION, f"a step, {name}, {count:,} cells", 1e3 * step, "ms", note=note)
        moved = PASSES / 2.0 * clocked[f"memory of {name}"].cpu / COPIES
        note = f"{PASSES} arrays of it, at the rate of a copy within as much memory"
        yield Row(SECTION, f"a step, {name}, over the memory that it moves", step / moved, "x", note=note)
    bent = clocked["one mode, Re 1,000"].cpu / clocked["rigid, Re 1,000"].cpu
    yield Row(SECTION, "one mode over rigid, Re 1,000", bent, "x")
    together = 100.0 * CASES * clocked["rigid, Re 100"].cpu / clocked["several"].cpu
    yield Row(SECTION, f"{CASES} cases of Re 100 side by side over one, in processor time", together, "%", 90.0)
    busy = clocked["several"].cpu / clocked["several"].wall
    threads = available_threads()
    note = "less beside other programs"
    yield Row(SECTION, f"{CASES} cases of Re 100 on {threads} threads, processor time over wall", busy, "x", note=note)


def cells(one: Case) -> int:
    """Cells of a case's grid."""
    grid = settings(one).grid(one.wing.pivot)
    return grid.rows * grid.points


def _stepping(cases: list[Case], threads: int | None = 1) -> Work:
    """The first steps of a batch."""

    def prepare() -> Callable[[], object]:
        march = March(cases, fluids.load(cases[0].solver), threads, store_outputs=False)
        march.advance(0)
        return functools.partial(march.advance, STEPS)

    return prepare


def _copying(count: int) -> Callable[[], None]:
    """Copies of an array of so many numbers, each to the next of as many as a case has."""
    arrays = np.zeros((STATE, count))

    def copy() -> None:
        for n in range(COPIES):
            np.copyto(arrays[(n + 1) % STATE], arrays[n % STATE])

    return copy
