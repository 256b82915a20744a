"""One instant of a result, as needed by the scene."""

from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Frame:
    """One frame. Positions in chords, to the right and up, rotated as in `taichiflap.drawing.orientation`.

    Attributes:
        index: number of the frame.
        text: its time as text.
        nodes: the deformed wing, leading to trailing edge, shape (node, 2).
        chord: both ends of the undeformed chord, shape (2, 2).
        pivot: shape (2,).
        axes: unit vectors of the wing frame: chordwise and normal, shape (2, 2).
        pressure, shear: force of the fluid per area along e_z and along e_y, Pa, shape (panel,).
        force: force of the fluid on the wing, N, shape (2,).
        velocity: velocity of the nodes relative to the free stream, m/s, shape (node, 2).
        wake: positions of the wake vortices, oldest first, shape (vortex, 2).
        circulation: circulation of the wake vortices, m2/s.
        age: time since shedding, beats.
        edge: edge that shed them, 0 for trailing and 1 for leading edge.
        drawn: cached drawings of the frame by style and layer, shared by all browsers.
    """

    index: int
    text: str
    nodes: Array
    chord: Array
    pivot: Array
    axes: Array
    pressure: Array
    shear: Array
    force: Array
    velocity: Array
    wake: Array
    circulation: Array
    age: Array
    edge: NDArray[np.int64]
    drawn: dict[Hashable, dict[str, Any]] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def from_wing(self) -> "Frame":
        """The frame as seen from the wing: the pivot is fixed and the undeformed chord horizontal."""

        def turned(vectors: Array) -> Array:
            return vectors @ self.axes.T

        def placed(points: Array) -> Array:
            return turned(points - self.pivot)

        return replace(
            self, nodes=placed(self.nodes), chord=placed(self.chord), axes=np.eye(2), force=turned(self.force),
            velocity=turned(self.velocity), wake=placed(self.wake), pivot=np.zeros(2), drawn={},
        )  # fmt: skip

    @property
    def size(self) -> int:
        """Approximate memory, bytes; drawings of the frame need about the same again."""
        return 2 * sum(value.nbytes for value in vars(self).values() if isinstance(value, np.ndarray))
