"""Pair sums: the velocity that vortices induce at each other, ours against the C loop and numba, at every size."""

import functools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from taichiflap.kernels.runtime import available_threads
from taichiflap.vortex.sum import induced_velocity

from .clock import Work, alternate
from .peers import c_loop, numba_loop
from .peers.c_loop import Sum
from .rows import Row

SECTION = "Pair sums"
SIZES = (250, 1000, 2000, 4000, 16000)
PAIRS = 1e8
"""About so many pair interactions a clocking: a tenth of a second."""
CORE = 1e-4
SHARED = "C loop of shared divisions"


@dataclass
class PairRates:
    """Pair interactions a second of processor time on one thread, by contestant and number of vortices.

    `both` is the speed-up of all threads over one: on the wall, and with a processor for every thread.
    """

    rate: dict[str, dict[int, float]] = field(default_factory=dict)
    both: dict[int, tuple[float, float]] = field(default_factory=dict)

    def limit(self, size: int = 250) -> float:
        """Pair interactions a second that the hardware can do, one thread: the C loop's, ours where there is none."""
        return (self.rate.get("C loop") or self.rate["ours"])[size]


def contestants() -> dict[str, Sum]:
    """Everybody who is here to sum."""

    def ours(points: np.ndarray, vortices: np.ndarray, core: float) -> np.ndarray:
        return induced_velocity(points, vortices, core, threads=1)

    present: dict[str, Sum | None] = {
        "ours": ours, "C loop": c_loop.load(), SHARED: c_loop.load("induce_shared"), "numba": numba_loop.load(),
    }  # fmt: skip
    return {name: loop for name, loop in present.items() if loop}


def measure(sizes: Sequence[int] = SIZES) -> PairRates:
    """Clock all contestants at all sizes; they must agree on the velocities."""
    found = PairRates()
    threads = available_threads()
    for size in sizes:
        cloud = np.random.default_rng(size).normal(size=(3, size))
        points = np.tile(cloud[:2], (1, max(1, round(PAIRS / size**2))))
        works: dict[str, Work] = {}
        expected = induced_velocity(cloud[:2], cloud, CORE)
        for name, loop in contestants().items():
            np.testing.assert_allclose(loop(cloud[:2], cloud, CORE), expected, rtol=1e-9, atol=1e-9)
            works[name] = functools.partial(functools.partial, loop, points, cloud, CORE)
        if threads > 1:
            works["all threads"] = functools.partial(functools.partial, induced_velocity, points, cloud, CORE)
        clocked = alternate(works)
        pairs = points.shape[1] * size
        for name in contestants():
            found.rate.setdefault(name, {})[size] = pairs / clocked[name].cpu
        if threads > 1:
            one, both = clocked["ours"], clocked["all threads"]
            found.both[size] = (one.wall / both.wall, threads * one.cpu / both.cpu)
    return found


def rows(found: PairRates) -> Iterator[Row]:
    """The table's lines."""
    for name, rates in found.rate.items():
        for size, rate in rates.items():
            yield Row(SECTION, f"{name}, {size} vortices, one thread", rate / 1e9, "Gpair/s")
    ours = found.rate["ours"]
    peers = ("C loop", 0.9, c_loop.MISSING), (SHARED, 0.85, c_loop.MISSING), ("numba", 1.0, numba_loop.MISSING)
    for peer, target, missing in peers:
        if peer not in found.rate:
            yield Row(SECTION, f"ours over {peer}", None, "x", target, note=missing)
            continue
        for size in ours:
            ratio = ours[size] / found.rate[peer][size]
            yield Row(SECTION, f"ours over {peer}, {size} vortices", ratio, "x", target)
    threads = available_threads()
    for size, (wall, ideal) in found.both.items():
        aim = 1.85 if size >= 2000 and threads == 2 else None
        name = f"{threads} threads over one, {size} vortices"
        yield Row(SECTION, f"{name}, on the wall", wall, "x", aim)
        yield Row(SECTION, f"{name}, in processor time", ideal, "x", aim, note="with a processor to each thread")
