"""Content of a page's address: the frame of a paused run, and the choices that differ from the defaults."""

import math
from collections.abc import Mapping
from dataclasses import replace

from . import timeline
from .field import BACKGROUNDS
from .frames import Run
from .timeline import Playback

MOST = 6
"""Maximum number of points whose streak lines are shown."""


def chosen(playback: Playback) -> dict[str, str]:
    """The choices by name, as text."""
    return {
        "layers": ",".join(name for name, shown in playback.layers.items() if shown),
        "background": playback.background, "dark": str(int(playback.dark)), "charts": ",".join(playback.charts),
        "points": ",".join(f"{part:g}" for point in playback.points for part in point),
    }  # fmt: skip


def held(playback: Playback, usual: Mapping[str, str]) -> dict[str, str | None]:
    """Values for the address: the frame and choices that differ from the defaults; None for those to remove."""
    moving = playback.playing or playback.follow
    texts = {name: None if value == usual[name] else value for name, value in chosen(playback).items()}
    return texts | {"frame": None if moving else str(playback.frame)}


def taken(texts: Mapping[str, str], playback: Playback, run: Run) -> Playback:
    """Set playback as in an address; choices that the run does not have are ignored."""
    found = replace(playback, dark=texts.get("dark") == "1")
    if "layers" in texts:
        names = texts["layers"].split(",")
        found.layers = {name: name in names for name in playback.layers}
    if texts.get("background") in BACKGROUNDS and run.draws_flow:
        found.background = texts["background"]
    if "charts" in texts:
        found.charts = tuple(texts["charts"].split(","))
    if "points" in texts:
        found.points = _pairs(texts["points"])
    if texts.get("frame", "").isdecimal():
        timeline.seek(run, found, int(texts["frame"]))
    return found


def _pairs(text: str) -> tuple[tuple[float, float], ...]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return ()
    if len(numbers) % 2 or not all(map(math.isfinite, numbers)):
        return ()
    return tuple(zip(numbers[::2], numbers[1::2], strict=True))[:MOST]
