"""Streak lines: where the fluid is that passed an edge of the wing, or a fixed point, in the last beat."""

import threading
from collections import OrderedDict
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from taichiflap.fluids.interface import Velocity

from .frame import Array
from .frames import Run

STEPS = 200
"""Minimum number of steps per beat, each of which releases a particle."""
OFF = 0.02
"""Distance of the released particles from an edge of the wing, chords."""
KEPT = 1024
"""Maximum number of frames whose particles are kept."""

Points = tuple[tuple[float, float], ...]
"""Positions on the page, to the right and up, chords."""


def has_failed(found: "Future[Any]") -> bool:
    """Whether a computation has failed, so that it is tried again: a file may have been in the middle of a write."""
    return found.done() and not found.cancelled() and found.exception() is not None


class Streaks:
    """The streak lines of a result, computed once for all browsers.

    Particles are advected with the velocity of the stored frames, interpolated linearly in time (Heun's method).
    Particles that the wing has passed over stay where they are until they are outside again.

    Args:
        run: the result.
        worker: the thread that evaluates velocities.
    """

    def __init__(self, run: Run, worker: ThreadPoolExecutor) -> None:
        self.run, self._worker = run, worker
        self._steps = max(1, round(STEPS / run.frames_per_beat))
        self._memory = max(1, round(run.frames_per_beat))
        self._lock = threading.Lock()
        self._asked: OrderedDict[tuple[int, Points], Future[Array]] = OrderedDict()
        # Of the worker's thread alone.
        self._found: OrderedDict[tuple[int, Points], Array] = OrderedDict()
        self._flows: OrderedDict[int, Velocity | None] = OrderedDict()

    def ask(self, index: int, points: Points = ()) -> "Future[Array]":
        """Particles of a frame, at once or as soon as they are computed: Y and Z, m, shape (2, line, particle).

        The lines are those of the leading edge, of the trailing edge, and of `points`; the newest particle is the
        first, and those not released yet are NaN.
        """
        with self._lock:
            key = index, points
            if key not in self._asked or has_failed(self._asked[key]):
                self._asked[key] = self._worker.submit(self._compute, index, points)
                while len(self._asked) > KEPT:
                    self._asked.popitem(last=False)
            self._asked.move_to_end(key)
            return self._asked[key]

    def _compute(self, index: int, points: Points) -> Array:
        """Go on from the last frame whose particles are known, or from where the oldest particle was released."""
        start = max(0, index - self._memory)
        first = next((one for one in range(index, start, -1) if (one, points) in self._found), start)
        particles = self._found.get((first, points))
        complete = particles is not None or first == 0
        if particles is None:
            particles = np.full((2, 2 + len(points), self._memory * self._steps), np.nan)
            particles[..., 0] = self._sources(first, points)
        for frame in range(first, index):
            particles = self._advanced(particles, frame, points)
            if complete or frame + 1 == index:
                self._found[frame + 1, points] = particles
        while len(self._found) > KEPT:
            self._found.popitem(last=False)
        return particles

    def _advanced(self, particles: Array, frame: int, points: Points) -> Array:
        """Particles one frame later."""
        run, steps = self.run, self._steps
        step = (run.turns(frame + 1) - run.turns(frame)) * run.case.beat / steps
        before, after = self._sources(frame, points), self._sources(frame + 1, points)
        for number in range(steps):
            share, later = number / steps, (number + 1) / steps
            start = self._velocity(particles, frame, share)
            end = self._velocity(particles + step * start, frame, later)
            moved = particles + 0.5 * step * (start + end)
            released = (1.0 - later) * before + later * after
            particles = np.concatenate((released[..., None], moved[..., :-1]), axis=-1)
        return particles

    def _velocity(self, particles: Array, frame: int, share: float) -> Array:
        """Velocity (m/s) of particles a share of the way from a frame to the next."""
        out, found = np.isfinite(particles[0]), np.full(particles.shape, np.nan)
        places = particles[:, out].astype(np.float64)
        moving = np.zeros_like(places)
        for weight, flow in ((1.0 - share, self._flow(frame)), (share, self._flow(frame + 1))):
            if weight and flow:
                moving += weight * np.nan_to_num(flow(places))
        found[:, out] = moving
        return found

    def _flow(self, frame: int) -> Velocity | None:
        if frame not in self._flows:
            self._flows[frame] = self.run.velocity(frame)
            while len(self._flows) > 2:
                self._flows.popitem(last=False)
        return self._flows[frame]

    def _sources(self, frame: int, points: Points) -> Array:
        """Y and Z (m) where particles are released in a frame, shape (2, line)."""
        seen = self.run.frame(frame)
        along = OFF * seen.axes[0]
        places = np.stack((seen.nodes[0] - along, seen.nodes[-1] + along, *map(np.asarray, points)))
        return self.run.page.off_page(self.run.chord * places)
