"""The beats of a run: their frames, means and peaks, and which beats are free of the starting transient."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..results.reader import Result

BLUR = 1e-6
"""Share of the root-mean-square force below which differences between beats count as zero."""
SAME_TIME = 5e-10
"""Difference, in beats, below which two times count as equal."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Beats:
    """Successive beats of a run, each with at least one frame; empty with fewer than two edges.

    Attributes:
        edges: first frame of each beat, and the first frame after the last beat.
    """

    edges: NDArray[np.intp]

    def __len__(self) -> int:
        return max(0, len(self.edges) - 1)

    @property
    def frames(self) -> slice:
        """Frames of all beats."""
        return slice(int(self.edges[0]), int(self.edges[-1]))

    @property
    def last(self) -> slice:
        """Frames of the last beat."""
        return slice(int(self.edges[-2]), int(self.edges[-1]))

    def after(self, count: int) -> "Beats":
        """The beats without the first ones."""
        return Beats(self.edges[count:])

    def sums(self, values: Array) -> Array:
        """Sum over each beat, along the last axis; shape (..., beats)."""
        found: Array = np.add.reduceat(values[..., : self.edges[-1]], self.edges[:-1], axis=-1)
        return found

    def means(self, values: Array) -> Array:
        """Mean over each beat, along the last axis; shape (..., beats)."""
        return self.sums(values) / np.diff(self.edges)

    def peaks(self, values: Array) -> Array:
        """Largest magnitude in each beat, along the last axis; shape (..., beats)."""
        return np.maximum.reduceat(np.abs(values[..., : self.edges[-1]]), self.edges[:-1], axis=-1)

    def mean_forces(self, force_y: Array, force_z: Array) -> Array:
        """Mean force vector of each beat, N, shape (..., 2, beats)."""
        return np.stack((self.means(force_y), self.means(force_z)), axis=-2)

    def squares(self, force_y: Array, force_z: Array) -> Array:
        """Sum over each beat of the squared force, N^2, shape (..., beats)."""
        found = force_y**2
        found += force_z**2
        return self.sums(found)

    def force_size(self, squares: Array) -> Array:
        """Root-mean-square force over the second half of the beats, N, shape (...); of what `squares` gives."""
        half = len(self) // 2
        return np.sqrt(squares[..., half:].sum(axis=-1) / (self.edges[-1] - self.edges[half]))


def whole_beats(case: Case, time: Array) -> Beats:
    """The whole beats of a run. The frames of a beat are those after its start, up to and including its end."""
    count = int(time[-1] / case.beat + SAME_TIME) if len(time) else 0
    ends = case.beat * (np.arange(count + 1) + SAME_TIME)
    edges = np.searchsorted(time, ends)
    # NumPy's `unique` would load its masked arrays.
    return Beats(edges[np.diff(edges, prepend=-1) > 0])


def settled_beats(result: Result) -> Beats:
    """The whole beats after the starting transient, see `transient`."""
    beats = whole_beats(result.case, result.time)
    if len(beats) < 2:
        return beats
    forces = result.force_y, result.force_z
    return beats.after(int(transient(beats.mean_forces(*forces), beats.force_size(beats.squares(*forces)))))


def transient(forces: Array, size: Array) -> NDArray[np.intp]:
    """Number of beats that belong to the starting transient, at most half of them; shape (...).

    The standard error of the mean force of the others is then smallest: the marginal standard error rule (White,
    Simulation 69, 1997), which balances the bias of the transient against the loss of samples.

    Args:
        forces: mean force vector of each beat, N, shape (..., 2, beats).
        size: root-mean-square force, N, shape (...).
    """
    most = forces.shape[-1] // 2
    # Sums of differences from the mean of the second half, to avoid cancellation.
    apart = (forces - forces[..., most:].mean(axis=-1, keepdims=True))[..., ::-1]
    count = np.arange(1, forces.shape[-1] + 1)
    scatter = np.sum(np.cumsum(apart**2, axis=-1) - np.cumsum(apart, axis=-1) ** 2 / count, axis=-2)
    errors = ((scatter + count * (BLUR * size[..., None]) ** 2) / count**2)[..., ::-1]
    return np.argmin(errors[..., : most + 1], axis=-1)
