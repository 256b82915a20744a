"""A result as the scene needs it: one frame at a time, in chords, with sideways to the right and lift upwards.

Nothing else of the viewer touches the file. Frames are kept in a small cache that all browsers share.
"""

import threading
from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taichiflap import Result
from taichiflap.drawing.scene import when
from taichiflap.metrics.summary import Summary, reversals, summarise
from taichiflap.motion import sampling
from taichiflap.results.reader import ResultError

from .survey import Ranges, survey

Array = NDArray[np.floating]

UNREADABLE = (OSError, RuntimeError, KeyError, ValueError)
"""What HDF5 says of a file that changes under its reader, or that is closed until the next look."""

CACHE_BYTES = 2**25
PATH_SAMPLES = 401
SURVEYED = 12
"""Frames looked at to choose the ranges of colours and the first view."""


@dataclass(frozen=True)
class Frame:
    """One frame. Positions in chords on the screen: (right, up) = (Z, -Y) / chord.

    Attributes:
        index: number of the frame.
        text: its time in words.
        nodes: the deformed wing, leading to trailing edge, shape (node, 2).
        chord: both ends of the undeformed chord, shape (2, 2).
        axes: unit vectors of the wing frame: chordwise and normal, shape (2, 2).
        pressure, shear: force of the fluid per area along e_z and along e_y, Pa, shape (panel,).
        force: force of the fluid on the wing, N, shape (2,).
        velocity: velocity of the nodes relative to the free stream, m/s, shape (node, 2).
        wake: positions of the wake vortices, oldest first, shape (vortex, 2).
        circulation: of the wake vortices, m2/s.
        bound: circulation of the bound vortices, m2/s; empty without a vortex model.
        drawn: what has been drawn of the frame, by style and layer, for all browsers of that style.
    """

    index: int
    text: str
    nodes: Array
    chord: Array
    axes: Array
    pressure: Array
    shear: Array
    force: Array
    velocity: Array
    wake: Array
    circulation: Array
    bound: Array
    drawn: dict[Hashable, dict[str, Any]] = field(default_factory=dict, compare=False, repr=False)

    @property
    def size(self) -> int:
        """Bytes held, about: what will be drawn of the frame takes as much again."""
        return 2 * sum(value.nbytes for value in vars(self).values() if isinstance(value, np.ndarray))


class Run:
    """A result file, complete or growing, that many browsers look at.

    Args:
        result: the open result; the run closes it.
        label: what to call it beside another.

    Attributes:
        path: how far the pivot goes to either side, chords.
        ranges, box: what colours and arrows are scaled by, and the box (left, bottom, right, top; chords) of the
            first view. A growing run looks at itself again each time that it has doubled, and when it is complete.
        surveys: how often it has done so.
    """

    def __init__(self, result: Result, label: str) -> None:
        self.result = result
        self.label = label
        self.case = result.case
        self.chord = self.case.wing.chord
        self.title = self.case.title or label
        self.frames_per_beat = self.case.steps_per_beat / self.case.output.every
        self.steps_per_beat = self.case.steps_per_beat
        moments = self.case.motion.growth + self.case.beat * np.linspace(0.0, 1.0, PATH_SAMPLES)
        plunge = sampling.sample(self.case.motion, moments)[:, sampling.PLUNGE] / self.chord
        self.path = float(plunge.min()), float(plunge.max())
        self._turns = len(reversals(self.case, 0.0, 1.0 + self.case.motion.growth / self.case.beat)) > 0
        self._lock = threading.RLock()
        self._cache: OrderedDict[int, Frame] = OrderedDict()
        self._held = 0
        self.surveys = self._surveyed = 0
        if not result.frames:
            raise ResultError(f"{result.path}: holds no frame yet")
        self._load()

    def _load(self) -> None:
        self.frames = self.result.frames
        self.steps = self.result.steps
        self.status = self.result.status
        self.has_wake = self.result.has_wake
        self.variables = self.result.variables
        self.station = self.result.stations
        self.shape = self.result.modes.get("shape", np.zeros((0, len(self.station))))
        if not self.surveys or self.frames >= 2 * self._surveyed or not self.live:
            self.ranges, self.box = self._survey()
            self.surveys, self._surveyed = self.surveys + 1, self.frames

    @property
    def live(self) -> bool:
        """Whether more frames may come."""
        return self.status == "running"

    @property
    def beats(self) -> int:
        """Number of whole beats; at least one."""
        return max(1, int(round((self.steps - 1) / self.steps_per_beat, 9)))

    def refresh(self) -> bool:
        """Look for new frames; whether there is any news. A file in the middle of a write is left for later."""
        with self._lock:
            before = self.steps, self.status
            try:
                self.result.refresh()
                # What was read from the file's end while it was being written is not to be trusted.
                self._cache.clear()
                self._held = 0
                if (self.result.steps, self.result.status) == before:
                    return False
                self._load()
            except (ResultError, *UNREADABLE):
                return False
            return True

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self.result.close()

    def turns(self, index: int) -> float:
        """The time of a frame, in beats."""
        return float(self.case.step_of(index)) / self.steps_per_beat

    def beat_of(self, index: int) -> tuple[int, float]:
        """Number of the beat of a frame, from 1, and t/T within it; a run's very end belongs to its last beat."""
        passed = round(self.turns(index), 9)
        number = int(passed)
        if 0 < passed == number and index == self.frames - 1:
            number -= 1
        return number + 1, passed - number

    def index_at(self, beats: float) -> int:
        """The frame nearest to a time in beats."""
        last = self.frames - 1
        found = min(max(round(beats * self.frames_per_beat), 0), last)
        # The last frame of a run may be nearer to the one before it than the others are.
        return last if abs(self.turns(last) - beats) < abs(self.turns(found) - beats) else found

    def step_at(self, beats: float) -> int:
        """The step nearest to a time in beats."""
        return min(max(round(beats * self.steps_per_beat), 0), self.steps - 1)

    def reversals(self) -> list[int]:
        """Frames of the stroke reversals, in order; none if the wing does not plunge."""
        found = reversals(self.case, 0.0, self.turns(self.frames - 1))
        return [self.index_at(float(beats)) for beats in found]

    def half_stroke(self, index: int) -> str:
        """Which way the wing moves at a frame; nothing where it does not plunge back and forth."""
        if not self._turns:
            return ""
        # A reversal belongs to the half-stroke that it begins.
        moment = (self.turns(index) + 1e-6) * self.case.beat
        rate = sampling.sample(self.case.motion, np.array([moment]))[0, sampling.PLUNGE_RATE]
        return "half-stroke to the right" if rate > 0.0 else "half-stroke to the left"

    def when(self, index: int) -> str:
        """The time of a frame in words."""
        if not self.case.periodic:
            return when(self.case, self.turns(index))
        number, part = self.beat_of(index)
        return f"beat {number}   t/T = {part:.3f}"

    def frame(self, index: int) -> Frame:
        """A frame, from the cache if it was shown lately.

        Raises:
            OSError: when a file that is being written cannot be read just now.
        """
        with self._lock:
            index = min(max(index, 0), self.frames - 1)
            if index in self._cache:
                self._cache.move_to_end(index)
                return self._cache[index]
            try:
                frame = self._read(index)
            except UNREADABLE as error:
                raise OSError(f"frame {index} cannot be read: {error}") from None
            self._cache[index] = frame
            self._held += frame.size
            while self._held > CACHE_BYTES and len(self._cache) > 1:
                self._held -= self._cache.popitem(last=False)[1].size
            return frame

    def series(self, name: str, first: int, last: int, most: int) -> tuple[Array, Array]:
        """Times (beats) and values, in SI units, of a series at `most` steps at most, evenly from `first` to `last`.

        What a file does not hold, or not just now, is not a number.
        """
        stride = max(1, -(-(last - first) // (most - 1)))
        picked = np.array([*range(first, last, stride), last])
        with self._lock:
            try:
                values = np.concatenate(
                    (self.result.between(name, first, last - 1, stride), self.result.between(name, last, last))
                )
            except UNREADABLE:
                values = np.full((len(picked), len(self.shape)) if name == "q" else len(picked), np.nan)
        return picked / self.steps_per_beat, values

    def summary(self) -> Summary | None:
        """Means, peaks and phases over the settled beats; None while there is no whole beat."""
        with self._lock:
            return summarise(self.result)

    def _read(self, index: int) -> Frame:
        result, scale = self.result, 1.0 / self.chord
        now = sampling.sample(self.case.motion, np.array([self.case.step * float(self.case.step_of(index))]))[0]
        plunge, plunge_rate, pitch, pitch_rate = now[
            [sampling.PLUNGE, sampling.PLUNGE_RATE, sampling.PITCH, sampling.PITCH_RATE]
        ]
        along = np.array([np.sin(pitch), -np.cos(pitch)])
        across = np.array([np.cos(pitch), np.sin(pitch)])
        pivot = np.array([plunge * scale, 0.0])
        deflection = result.frame("q", index) @ self.shape if len(self.shape) else np.zeros(len(self.station))
        rate = result.frame("q_rate", index) @ self.shape if len(self.shape) else np.zeros(len(self.station))
        stream_y, stream_z = self.case.fluid.velocity
        velocity = (
            np.array([plunge_rate - stream_z, stream_y])
            - np.outer(deflection * pitch_rate, along)
            + np.outer(self.station * pitch_rate + rate, across)
        )
        nodes = result.frame("node_position", index)
        wake = result.wake(index)
        return Frame(
            index=index,
            text="   ".join(filter(None, (self.when(index), self.half_stroke(index)))),
            nodes=_on_screen(nodes[:, 0], nodes[:, 1], scale),
            chord=pivot + np.outer((-self.case.wing.pivot, 1.0 - self.case.wing.pivot), along),
            axes=np.stack((along, across)),
            pressure=result.frame("pressure_jump", index),
            shear=self._field("shear", index),
            force=np.array([result.frame("force_z", index), -result.frame("force_y", index)]),
            velocity=velocity,
            wake=_on_screen(wake["y"], wake["z"], scale),
            circulation=wake["circulation"],
            bound=self._field("panel_circulation", index),
        )

    def _field(self, name: str, index: int) -> Array:
        return self.result.frame(name, index) if name in self.variables else np.zeros(0, dtype=np.float32)

    def _survey(self) -> tuple[Ranges, Array]:
        """Ranges and first view, from frames of the last beat."""
        first = max(0, round(self.frames - 1 - self.frames_per_beat))
        picked = np.unique(np.linspace(first, self.frames - 1, SURVEYED).astype(int))
        return survey([self._read(int(index)) for index in picked], round(self.case.steps_per_beat))


def _on_screen(y: Array, z: Array, scale: float) -> Array:
    return np.stack((z * scale, -y * scale), axis=1)
