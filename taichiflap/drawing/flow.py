"""The flow behind a wing on a plain grid of the page: its vorticity, and what of it a picture shows."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import fluids
from ..case.case import Case
from ..fluids.interface import FlowField
from ..motion.sampling import PITCH_RATE, PLUNGE, PLUNGE_RATE, SURGE, SURGE_RATE, sample
from ..results.reader import Result
from .orientation import INERTIAL, Standpoint
from .palette import LEVELS, Theme, rounded_up, table
from .scene import Frame

Array = NDArray[np.float64]
Colours = NDArray[np.uint8]
Box = tuple[float, float, float, float]
"""Left, bottom, right, top on the page, m."""

FAR, FAR_IN_STREAM = 4.5, 9.0
"""What lies so many chords from the wing is not looked at."""
COARSE = 112
"""Points along the longer side of the grid that tells how far the flow reaches."""
LOOKED_AT = 8
"""Frames that are looked at."""
SATURATED = 0.03
"""Share of the stirred part of a picture whose colours may be at their ends."""
FAINT, STIRRED = 0.1, 0.02
"""Share of the limit from which on vorticity is worth the room on a page; and counts as stirred at all."""
EVENED = 12
"""Times that pixels of a hole become the mean of their neighbours: no step stays between both sides of a wing."""
ROOM = 0.15
"""Free around the wing, chords."""
OUTLYING = 0.004
"""Share of what is worth it that may lie beyond either edge."""


def stored(result: Result) -> bool:
    """Whether a result holds the vorticity of the fluid, so that pictures show it behind the wing."""
    model = fluids.known(result.case.solver)
    return model is not None and model.stores_vorticity


def field(result: Result, index: int) -> FlowField | None:
    """The flow of a frame, as the fluid model has it; None of a model that knows none."""
    model = fluids.known(result.case.solver)
    return model.field(result, index) if model else None


def middles(box: Box, shape: tuple[int, int]) -> tuple[Array, Array]:
    """Middles of the columns and of the rows of a grid of `shape` (rows, columns) that fills a box."""
    left, bottom, right, top = box
    rows, columns = shape
    return (
        left + (np.arange(columns) + 0.5) * (right - left) / columns,
        bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows,
    )


def shape_of(box: Box, across: int) -> tuple[int, int]:
    """Rows and columns of a grid of square cells over a box, `across` of them along its longer side."""
    width, height = box[2] - box[0], box[3] - box[1]
    finest = max(width, height) / across
    return max(2, round(height / finest)), max(2, round(width / finest))


def points(stand: Standpoint, box: Box, shape: tuple[int, int]) -> Array:
    """Y and Z of the middles of a grid's cells, bottom row first, (2, rows, columns)."""
    right, up = np.meshgrid(*middles(box, shape))
    return stand.points(np.stack((right, up), axis=-1))


def vorticity(found: FlowField, places: Array) -> Array:
    """Vorticity (1/s) at a grid of points, (rows, columns): inside the section that of the nearest point outside."""
    assert found.vorticity is not None
    return filled(found.vorticity(places))


def filled(values: NDArray[Any]) -> Array:
    """A picture (..., rows, columns) whose holes take the value of the nearest pixel that has one, evened out."""
    from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - slow to import

    holes = np.any(np.isnan(values).reshape(-1, *values.shape[-2:]), axis=0)
    if not holes.any() or holes.all():
        return np.nan_to_num(values)
    rows, columns = np.flatnonzero(np.any(holes, axis=1)), np.flatnonzero(np.any(holes, axis=0))
    near = np.s_[max(rows[0] - 1, 0) : rows[-1] + 2, max(columns[0] - 1, 0) : columns[-1] + 2]
    _, (row, column) = distance_transform_edt(holes[near], return_indices=True)
    values = values.copy()
    part, hole = values[(..., *near)][..., row, column], holes[near]
    for _ in range(EVENED):
        around = np.pad(part, [(0, 0)] * (part.ndim - 2) + [(1, 1), (1, 1)], mode="edge")
        mean = 0.25 * (around[..., 2:, 1:-1] + around[..., :-2, 1:-1] + around[..., 1:-1, 2:] + around[..., 1:-1, :-2])
        part = np.where(hole, mean, part)
    values[(..., *near)] = part
    return np.nan_to_num(values)


@dataclass(frozen=True)
class Extent:
    """What pictures of the vorticity of some frames share: their box (m), and the limit of their colours (1/s)."""

    box: Box
    limit: float


def extent(result: Result, indices: Sequence[int] | NDArray[np.intp], frame: str = INERTIAL) -> Extent:
    """How far the vorticity of some frames reaches around the wing, and how strong it is, from a few of them."""
    picked = np.unique(np.linspace(0, len(indices) - 1, LOOKED_AT).round().astype(int))
    stands = [Standpoint.of(result, int(indices[one]), frame) for one in picked]
    wings = []
    for one, stand in zip(picked, stands, strict=True):
        nodes = result.frame("node_position", int(indices[one]))
        wings.append(stand.places(nodes[:, 0], nodes[:, 1]))
    wing = np.concatenate(wings)
    far = result.case.wing.chord * (FAR_IN_STREAM if result.case.fluid.streams else FAR)
    low, high = wing.min(axis=0) - far, wing.max(axis=0) + far
    box = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    shape = shape_of(box, COARSE)
    sizes = []
    for one, stand in zip(picked, stands, strict=True):
        found = field(result, int(indices[one]))
        assert found is not None
        sizes.append(np.abs(vorticity(found, points(stand, box, shape))))
    limit = colour_limit(sizes)
    right, up = np.meshgrid(*middles(box, shape))
    seen = np.max(sizes, axis=0) > FAINT * limit
    if not seen.any():
        seen[:] = True
    ends = np.quantile(np.stack((right[seen], up[seen])), (OUTLYING, 1.0 - OUTLYING), axis=1)
    room = ROOM * result.case.wing.chord
    low, high = np.minimum(ends[0], wing.min(axis=0) - room), np.maximum(ends[1], wing.max(axis=0) + room)
    return Extent((float(low[0]), float(low[1]), float(high[0]), float(high[1])), limit)


def colour_limit(pictures: Iterable[Array]) -> float:
    """Limit of colours symmetric about zero: the few strongest pixels of what is stirred lie beyond."""
    sizes = np.concatenate([np.abs(one).ravel() for one in pictures])
    whole = float(np.quantile(sizes, 1.0 - SATURATED)) or float(sizes.max(initial=0.0))
    stirred = sizes[sizes > STIRRED * whole]
    found = float(np.quantile(stirred, 1.0 - SATURATED)) if len(stirred) else 0.0
    return rounded_up(found) if found > 0.0 and math.isfinite(found) else 1.0


@dataclass(frozen=True)
class Carried:
    """How points that move with the wing move.

    Attributes:
        y, z: the pivot's place, m.
        velocity: the pivot's, along Y and Z, m/s.
        rate: of the pitch angle, rad/s.
    """

    y: float
    z: float
    velocity: tuple[float, float]
    rate: float

    @classmethod
    def at(cls, case: Case, time: float) -> "Carried":
        """At a time (s) of the run."""
        moved = sample(case.motion, np.array([min(time, case.duration)]))[0]
        return cls(moved[SURGE], moved[PLUNGE], (moved[SURGE_RATE], moved[PLUNGE_RATE]), moved[PITCH_RATE])

    def velocities(self, places: Array) -> Array:
        """Velocities (m/s) along Y and Z of points Y and Z, (2, ...)."""
        return np.stack(
            (self.velocity[0] - self.rate * (places[1] - self.z), self.velocity[1] + self.rate * (places[0] - self.y))
        )

    def streamfunction(self, places: Array) -> Array:
        """Their streamfunction, m2/s: what is left of the fluid's has streamlines as one sees them from the wing."""
        y, z = places[0] - self.y, places[1] - self.z
        return self.velocity[0] * z - self.velocity[1] * y - 0.5 * self.rate * (y * y + z * z)


def lines(streamfunction: NDArray[Any], spacing: float, width: float = 1.3) -> Array:
    """Opacity (rows, columns) of the streamlines so far apart in psi, `width` pixels wide and smooth at their edges."""
    phase = streamfunction / spacing
    slope = np.hypot(*np.gradient(phase))
    away = np.abs(phase - np.rint(phase)) / np.maximum(slope, 1e-12)
    drawn = np.clip(0.5 * width + 0.5 - away, 0.0, 1.0)
    # None where they are dense, or the fluid is at rest.
    return drawn * np.clip((0.4 - slope) / 0.15, 0.0, 1.0) * np.clip((slope - 1e-3) / 1e-3, 0.0, 1.0)


@dataclass(frozen=True)
class Backdrop:
    """The pictures of the vorticity behind the wing that belong to some frames of a result.

    Attributes:
        box: that they fill, m.
        limit: of the colours, 1/s.
    """

    result: Result
    box: Box
    limit: float

    @classmethod
    def of(
        cls, result: Result, indices: Sequence[int] | NDArray[np.intp], reference: str = INERTIAL
    ) -> "Backdrop | None":
        """That of some frames, drawn in a frame of reference; None of a result that holds no vorticity."""
        if not stored(result):
            return None
        shared = extent(result, indices, reference)
        return cls(result, shared.box, shared.limit)

    def vorticity(self, frame: Frame, page: tuple[float, float, float, float], across: int) -> Array:
        """Vorticity (1/s) on a page (left, right, bottom, top, m), bottom row first.

        Args:
            across: points along the longer side.
        """
        left, right, bottom, top = page
        box = left, bottom, right, top
        found = field(self.result, frame.index)
        assert found is not None
        return vorticity(found, points(frame.stand, box, shape_of(box, across)))

    def picture(self, frame: Frame, page: tuple[float, float, float, float], across: int, theme: Theme) -> Colours:
        """It in colours, sRGB, (rows, columns, 3), bottom row first."""
        level = np.clip(self.vorticity(frame, page, across) / self.limit, -1.0, 1.0)
        found: Colours = table(theme.flow)[np.rint((level + 1.0) * (LEVELS // 2)).astype(int)]
        return found
