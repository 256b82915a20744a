"""Playback: where a browser is in a run, and where it goes next. No browser in here, only arithmetic."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field

from .frames import Run

LAST_BEAT, THIS_BEAT, ALL, RANGE = LOOPS = ("last beat", "this beat", "whole run", "range")
SPEEDS = {"1/16 beat a second": 0.0625, "1/8 beat a second": 0.125, "1/4 beat a second": 0.25,
          "1/2 beat a second": 0.5, "1 beat a second": 1.0, "2 beats a second": 2.0}  # fmt: skip


@dataclass
class Playback:
    """What a browser keeps when its connection drops.

    Attributes:
        position: in frames, with the fraction that has passed of the next.
        speed: beats a second.
        range: first and last frame of the loop named so.
        follow: stay at the newest frame of a run that is still being computed.
        layers: names of the layers that are hidden or shown against their default.
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
    layers: dict[str, bool] = field(default_factory=dict)

    @property
    def frame(self) -> int:
        """The frame to show."""
        return int(self.position)


def beat_span(run: Run, number: int) -> tuple[int, int]:
    """First and last frame of a beat, numbered from 1, both ends included."""
    return run.index_at(number - 1), run.index_at(number)


def span(run: Run, playback: Playback) -> tuple[int, int]:
    """First and last frame of what the loop goes round."""
    if playback.loop == ALL:
        return 0, run.frames - 1
    if playback.loop == RANGE and playback.range[0] < playback.range[1] < run.frames:
        return playback.range
    number = run.beats if playback.loop == LAST_BEAT else run.beat_of(playback.frame)[0]
    return beat_span(run, number)


def advance(run: Run, playback: Playback, seconds: float) -> None:
    """Play on for some seconds of the clock on the wall, round and round."""
    first, last = span(run, playback)
    length = max(1, last - first)
    position = playback.position + seconds * playback.speed * run.frames_per_beat
    # Both ends of a beat look alike: the loop shows its first frame, not its last.
    playback.position = first + (position - first) % length


def coming(run: Run, playback: Playback, stride: int, count: int) -> list[int]:
    """The next frames, so far apart, that playing comes to, round the loop."""
    first, last = span(run, playback)
    length = max(1, last - first)
    return [first + (playback.frame - first + stride * number) % length for number in range(1, count + 1)]


def step(run: Run, playback: Playback, frames: int) -> None:
    """Stop, some frames on or back."""
    seek(run, playback, playback.frame + frames)


def seek(run: Run, playback: Playback, frame: int) -> None:
    """Stop at a frame, or at the nearest that there is."""
    playback.playing = playback.follow = False
    playback.position = float(min(max(frame, 0), run.frames - 1))


def speed_name(playback: Playback) -> str:
    """What the menu calls the speed."""
    return next(name for name, value in SPEEDS.items() if value == playback.speed)


def next_reversal(run: Run, playback: Playback, forward: bool) -> int | None:
    """The frame of the next or last stroke reversal, if there is one."""
    reversals = run.reversals()
    place = bisect_right(reversals, playback.frame) if forward else bisect_left(reversals, playback.frame) - 1
    return reversals[place] if 0 <= place < len(reversals) else None
