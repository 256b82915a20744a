"""Times of a result's frames: beats, strokes, and their names."""

from typing import Any

import numpy as np

from taichiflap.case.case import Case
from taichiflap.drawing import scene
from taichiflap.drawing.orientation import Orientation
from taichiflap.metrics.waves import reversals
from taichiflap.motion import sampling

from .frame import Array


class Clock:
    """The times of a result's frames and steps, of which there may be more later.

    Args:
        case: the case that was computed.

    Attributes:
        page: orientation of the page.
        frames, steps: number of frames, and of steps.
    """

    def __init__(self, case: Case) -> None:
        self.case = case
        self.page = Orientation.of(case)
        self.frames = self.steps = 0
        self.frames_per_beat = case.steps_per_beat / case.output.every
        self.steps_per_beat = case.steps_per_beat
        # A non-periodic motion is undefined beyond its end.
        beats = 1.0 + case.motion.growth / case.beat if case.periodic else 1.0
        self._turns = len(reversals(case, 0.0, beats)) > 0

    @property
    def beats(self) -> int:
        """Number of whole beats; at least one."""
        return max(1, int(round((self.steps - 1) / self.steps_per_beat, 9)))

    def turns(self, index: int) -> float:
        """The time of a frame, in beats."""
        return float(self.case.step_of(index)) / self.steps_per_beat

    def beat_of(self, index: int) -> tuple[int, float]:
        """Beat of a frame, counted from 1, and t/T within it; the end of a run belongs to its last beat."""
        passed = round(self.turns(index), 9)
        number = int(passed)
        if 0 < passed == number and index == self.frames - 1:
            number -= 1
        return number + 1, passed - number

    def index_at(self, beats: float) -> int:
        """The frame nearest to a time in beats."""
        last = self.frames - 1
        found = min(max(round(beats * self.frames_per_beat), 0), last)
        # The last frame of a run may have a shorter interval than the others.
        return last if abs(self.turns(last) - beats) < abs(self.turns(found) - beats) else found

    def beats_at(self, other: "Clock", beats: Any) -> Any:
        """The time, in beats of this result, that is compared with a time of another one, in beats of that.

        Both have the same t/T; if one of them has no period, both have the same time in s.
        """
        alike = self.case.periodic and other.case.periodic
        return beats if alike else beats * (other.case.beat / self.case.beat)

    def step_at(self, beats: float) -> int:
        """The step nearest to a time in beats."""
        return min(max(round(beats * self.steps_per_beat), 0), self.steps - 1)

    def reversals(self) -> list[int]:
        """Frames of the stroke reversals, in order; empty without plunge."""
        found = reversals(self.case, 0.0, self.turns(self.frames - 1))
        return [self.index_at(float(beats)) for beats in found]

    def half_stroke(self, index: int) -> str:
        """Direction of the half-stroke at a frame; empty without a periodic plunge."""
        if not self._turns:
            return ""
        # A reversal belongs to the half-stroke that follows it.
        rate = self.moving(self.time(index) + 1e-6 * self.case.beat)[sampling.PLUNGE_RATE]
        right, up = self.page.on_page(0.0, rate)
        if abs(up) > abs(right):
            return "upstroke" if up > 0.0 else "downstroke"
        return "half-stroke to the right" if right > 0.0 else "half-stroke to the left"

    def when(self, index: int) -> str:
        """The time of a frame as text."""
        if not self.case.periodic:
            return scene.when(self.case, self.turns(index))
        number, part = self.beat_of(index)
        return f"beat {number}   t/T = {part:.3f}"

    def time(self, index: int) -> float:
        """The time of a frame, s."""
        return self.turns(index) * self.case.beat

    def moving(self, moment: float) -> Array:
        """The prescribed motion at a time (s) of the run."""
        return sampling.sample(self.case.motion, np.array([min(moment, self.case.duration)]))[0]
