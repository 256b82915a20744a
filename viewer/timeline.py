"""Playback: the current and the next frame of a browser. Independent of the browser itself."""

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .frames import Run

LAST_BEAT, THIS_BEAT, ALL, RANGE = LOOPS = ("last beat", "this beat", "whole run", "range")
SPEEDS = {"1/16 beat a second": 0.0625, "1/8 beat a second": 0.125, "1/4 beat a second": 0.25,
          "1/2 beat a second": 0.5, "1 beat a second": 1.0, "2 beats a second": 2.0}  # fmt: skip


@dataclass
class Playback:
    """State of playback that survives a reconnection.

    Attributes:
        position: position in frames, including the fraction to the next frame.
        speed: beats per second.
        range: first and last frame of the user-defined loop.
        follow: stay at the newest frame of a run that is still being computed.
        charts: names of the variables in the charts; none for the usual ones.
        points: positions on the page, chords, whose streak lines are shown.
        layers: names of the layers that differ from their default visibility.
    """

    position: float = 0.0
    playing: bool = False
    speed: float = 0.25
    loop: str = LAST_BEAT
    range: tuple[int, int] = (0, 0)
    follow: bool = False
    dark: bool = False
    background: str = "none"
    window: str = LAST_BEAT
    charts: tuple[str, ...] = ()
    layers: dict[str, bool] = field(default_factory=dict)
    points: tuple[tuple[float, float], ...] = ()

    @property
    def frame(self) -> int:
        """Current frame."""
        return int(self.position)


def beat_span(run: Run, number: int) -> tuple[int, int]:
    """First and last frame of a beat, numbered from 1, both ends included."""
    return run.index_at(number - 1), run.index_at(number)


def span(run: Run, playback: Playback) -> tuple[int, int]:
    """First and last frame of the loop."""
    if playback.loop == ALL:
        return 0, run.frames - 1
    if playback.loop == RANGE and playback.range[0] < playback.range[1] < run.frames:
        return playback.range
    number = run.beats if playback.loop == LAST_BEAT else run.beat_of(playback.frame)[0]
    return beat_span(run, number)


def advance(run: Run, playback: Playback, seconds: float) -> None:
    """Advance playback by some seconds of real time, in a loop."""
    first, last = span(run, playback)
    length = max(1, last - first)
    position = playback.position + seconds * playback.speed * run.frames_per_beat
    # Both ends of a beat are equal, so that the loop omits its last frame.
    playback.position = first + (position - first) % length


def coming(run: Run, playback: Playback, stride: int, count: int) -> list[int]:
    """The next frames of playback at a given spacing, around the loop."""
    first, last = span(run, playback)
    length = max(1, last - first)
    return [first + (playback.frame - first + stride * number) % length for number in range(1, count + 1)]


def step(run: Run, playback: Playback, frames: int) -> None:
    """Stop, and move by some frames."""
    seek(run, playback, playback.frame + frames)


def seek(run: Run, playback: Playback, frame: int) -> None:
    """Stop at a frame, or at the nearest existing one."""
    playback.playing = playback.follow = False
    playback.position = float(min(max(frame, 0), run.frames - 1))


def speed_name(playback: Playback) -> str:
    """Name of the speed in the menu."""
    return next(name for name, value in SPEEDS.items() if value == playback.speed)


def next_reversal(run: Run, playback: Playback, forward: bool) -> int | None:
    """Frame of the next or last stroke reversal, if any."""
    reversals = run.reversals()
    place = bisect_right(reversals, playback.frame) if forward else bisect_left(reversals, playback.frame) - 1
    return reversals[place] if 0 <= place < len(reversals) else None


def _toggle(_: Run, playback: Playback, __: Any) -> None:
    playback.playing = not playback.playing
    playback.follow = False


def _go_to_reversal(run: Run, playback: Playback, way: float) -> None:
    frame = next_reversal(run, playback, way > 0)
    if frame is not None:
        seek(run, playback, frame)


def _set_range(run: Run, playback: Playback, ends: tuple[float, float]) -> None:
    first, last = (min(max(round(end), 0), run.frames - 1) for end in sorted(ends))
    if first < last:
        playback.range, playback.loop = (first, last), RANGE


def _set_speed(_: Run, playback: Playback, name: str) -> None:
    playback.speed = SPEEDS[name]


def _set_follow(run: Run, playback: Playback, follow: bool) -> None:
    playback.follow = bool(follow)
    if follow:
        playback.playing = False
        playback.position = float(run.frames - 1)


CONTROLS: dict[str, Callable[[Run, Playback, Any], None]] = {
    "play": _toggle,
    "frame": lambda run, playback, frame: seek(run, playback, round(frame)),
    "skip": lambda run, playback, frames: step(run, playback, round(frames)),
    "edge": lambda run, playback, edge: seek(run, playback, run.frames - 1 if edge else 0),
    "reversal": _go_to_reversal,
    "beat": lambda run, playback, beats: seek(run, playback, run.index_at(run.turns(playback.frame) + beats)),
    "beats": lambda run, playback, beats: seek(run, playback, run.index_at(beats)),
    "range": _set_range,
    "speed": _set_speed,
    "follow": _set_follow,
}
"""What the controls of the timeline do: to playback of a run, with the value of the control."""
