"""Series and fields of a result from the march's state."""

import functools
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..motion.sampling import PLUNGE, SURGE
from ..structure.beam import Modes
from .series import Series
from .state import ACCEL, AMPLITUDE, COSINE, RATE, SINE

Array = NDArray[np.float64]


TOGETHER = 128
"""Frames whose nodes are placed together."""

OWN = ("step", "field_step", "q", "force")
"""Variables that are renamed from the arrays of a block of steps."""


class Derived(MutableMapping[str, Any]):
    """Arrays by name: those that are there, and those that are made when they are first read."""

    def __init__(self, there: Mapping[str, Any], made: Mapping[str, Callable[[], Any]]) -> None:
        self._there, self._made = dict(there), dict(made)

    def __getitem__(self, name: str) -> Any:
        if name not in self._there:
            self[name] = self._made[name]()
        return self._there[name]

    def __setitem__(self, name: str, values: Any) -> None:
        self._there[name] = values

    def __delitem__(self, name: str) -> None:
        self._made.pop(name, None)
        self._there.pop(name, None)

    def __iter__(self) -> Iterator[str]:
        return iter(self._made | self._there)

    def __len__(self) -> int:
        return len(self._made | self._there)

    def __contains__(self, name: object) -> bool:
        return name in self._made or name in self._there


def derive(case: Case, section: Modes, nodes: Array, motion: Array, frames: dict[str, np.ndarray]) -> Derived:
    """Variables of the result file for some steps of a case, and for the frames among them.

    Args:
        nodes: positions of the nodes along the chord, from the pivot, m.
        motion: sampled motion at every step, shape (steps + 1, COLUMNS).
        frames: arrays that `March.advance` returned for the case.
    """
    state = frames["q"]
    series = Series.of(case, section, motion, frames)
    moved = series.moved[:, 0]
    at = frames["field_step"]
    # The steps of a block follow each other.
    rows = at - (frames["step"][0] if len(at) else 0)
    made: dict[str, Callable[[], Any]] = {name: functools.partial(series.alone, name) for name in series.variables}
    made |= {
        "q": lambda: state[:, AMPLITUDE],
        "q_rate": lambda: state[:, RATE],
        "q_acceleration": lambda: state[:, ACCEL],
        "field_time": lambda: case.step * at,
        "node_position": lambda: positions(section.shape(nodes), nodes, moved.T[rows], state[rows, AMPLITUDE]),
    }
    return Derived({name: values for name, values in frames.items() if name not in OWN}, made)


def positions(shape: Array, nodes: Array, motion: Array, q: Array) -> NDArray[np.float32]:
    """Where the nodes are along Y and Z, m, shape (frames, nodes, 2).

    Args:
        shape: mode shapes at the nodes, shape (modes, nodes).
        nodes: their positions along the chord, from the pivot, m.
        motion: as a march samples it, shape (frames, COLUMNS).
        q: modal amplitudes, shape (frames, modes).
    """
    placed = np.empty((len(q), len(nodes), 2), np.float32)
    # Some frames at a time stay in the cache, which takes a fifth of the time.
    for first in range(0, len(q), TOGETHER):
        some = slice(first, first + TOGETHER)
        cosine, sine, surge, plunge = (motion[some, column, None] for column in (COSINE, SINE, SURGE, PLUNGE))
        deflection = _superpose(shape, q[some])
        placed[some, :, 0] = surge + (cosine * nodes - sine * deflection)
        placed[some, :, 1] = plunge + (sine * nodes + cosine * deflection)
    return placed


def _superpose(shape: Array, q: Array) -> Array:
    """`sum_k phi_k(y) q_k`, shape (frames, points), added in order."""
    total = np.zeros((len(q), shape.shape[1]))
    for k, phi in enumerate(shape):
        total += q[:, k, None] * phi
    return total
