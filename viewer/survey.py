"""Ranges of colours and arrows, and the initial view, from a few frames."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .frame import Array, Frame

ARROW_ROOM = 0.9
"""Margin beside and below a wing without a wake, chords, for its arrows."""
HEADROOM = 0.55
"""Margin above the wing in the initial view, chords, for the time label."""
VIEW_CHORDS = 4.0
"""Maximum distance of the initial view from the wing's path, chords."""


@dataclass(frozen=True)
class Ranges:
    """Scales of colours and arrows: circulation (m2/s), pressure (Pa), force (N) and speed (m/s)."""

    circulation: float
    pressure: float
    force: float
    speed: float


def survey(frames: Sequence[Frame]) -> tuple[Ranges, Array]:
    """Ranges, and the box (left, bottom, right, top; chords) of the initial view.

    Colours of the wake are scaled by the vortices of the last beat, since vortices that have absorbed others are many
    times as strong.
    """
    ranges = Ranges(
        circulation=_nice(_percentile([frame.circulation[frame.age < 1.0] for frame in frames], 97)),
        pressure=_nice(_percentile([frame.pressure for frame in frames], 95)),
        force=_nice(max(float(np.linalg.norm(frame.force)) for frame in frames)),
        speed=_nice(max(float(np.linalg.norm(frame.velocity, axis=1).max()) for frame in frames)),
    )
    wing = np.concatenate([frame.nodes for frame in frames])
    low, high = wing.min(axis=0), wing.max(axis=0)
    wake = np.concatenate([frame.wake for frame in frames])
    if len(wake):
        low = np.minimum(low, np.maximum(np.percentile(wake, 2, axis=0), low - VIEW_CHORDS))
        high = np.maximum(high, np.minimum(np.percentile(wake, 98, axis=0), high + VIEW_CHORDS))
    else:
        low, high = low - ARROW_ROOM, high + ARROW_ROOM * np.array([1.0, 0.0])
    return ranges, np.concatenate((low, high + np.array([0.0, HEADROOM])))


def _percentile(arrays: list[Array], share: float) -> float:
    values = np.abs(np.concatenate(arrays))
    return float(np.percentile(values, share)) if len(values) else 0.0


def _nice(value: float) -> float:
    """The next of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten; 1 for zero."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(power * next(step for step in steps if step >= value / power - 1e-9))
