"""Comparison with other programs: the same UVLM in NumPy, and PteraSoftware's free-wake flapping wing."""

import functools
from collections.abc import Iterator

import numpy as np

from .clock import Work, alternate
from .peers import numpy_march, ptera
from .rows import Row
from .runs import hawkmoth, marching, pairs

SECTION = "Peers"


def rows() -> Iterator[Row]:
    """The table's lines."""
    yield from _in_numpy()
    yield from _ptera()


def _in_numpy() -> Iterator[Row]:
    # One beat: longer, and the rounding of the two sums grows in the wake of points as any disturbance does.
    case = hawkmoth("time.periods=1")
    slow = numpy_march.march(case)
    np.testing.assert_allclose(slow, marching([case])()()[0]["q"][:, 0], rtol=0.0, atol=1e-9 * abs(slow).max())
    works: dict[str, Work] = {
        "ours": marching([case]),
        "numpy": functools.partial(functools.partial, numpy_march.march, case),
    }
    clocked = alternate(works, 3)
    note = "the same numbers to 9 digits"
    yield Row(SECTION, "UVLM hawkmoth, 1 beat, vectorised NumPy", 1e3 * clocked["numpy"].cpu, "ms", note=note)
    yield Row(SECTION, "UVLM hawkmoth, 1 beat, ours", 1e3 * clocked["ours"].cpu, "ms")
    yield Row(SECTION, "NumPy over ours", clocked["numpy"].cpu / clocked["ours"].cpu, "x")


def _ptera() -> Iterator[Row]:
    name = "PteraSoftware, flapping wing with a free wake"
    answer = ptera.ask("flap", {})
    if answer is None:
        yield Row(SECTION, name, None, "s", note=ptera.MISSING)
        return
    found = answer[0]
    note = f"{found['panels']} panels, {found['time steps']} steps; other work: line vortices in three dimensions"
    yield Row(SECTION, f"{name}, on the wall", found["wall"], "s", note=note)
    yield Row(SECTION, f"{name}, in processor time", found["cpu"], "s")
    rate = found["pairs"] / found["in sums"] / 1e6
    yield Row(SECTION, "PteraSoftware: point and line vortex, a core", rate, "Mpair/s", note="within its sums alone")
    whole = found["pairs"] / found["cpu"] / 1e6
    yield Row(SECTION, "PteraSoftware: point and line vortex, a core, over the run", whole, "Mpair/s")
    case = hawkmoth("uvlm.wake=all", "time.periods=3")
    clocked = alternate({"ours": marching([case])}, 3)["ours"]
    note = "point vortices in two dimensions"
    yield Row(SECTION, "ours: hawkmoth, 3 beats, whole wake, in processor time", clocked.cpu, "s", note=note)
    yield Row(SECTION, "ours: point and vortex, a core, over the run", pairs(case) / clocked.cpu / 1e6, "Mpair/s")
