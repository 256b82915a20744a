"""The timeline at the bottom of a page: drawn by a script in the page, updated through viser elements."""

from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from . import channel, wire
from .channel import hidden
from .frames import Run
from .timeline import LOOPS, SPEEDS, Playback, span, speed_name

_STYLE, _SCRIPT, _CAMERA = (
    Path(__file__).with_name(name).read_text("utf-8") for name in ("bar.css", "bar.js", "camera.js")
)
_LINE = resources.files("taichiflap.drawing").joinpath("timeline.js").read_text("utf-8")
HEAD = f"<style>{_STYLE}</style><script>{channel.SCRIPT}{_LINE}{_SCRIPT}{_CAMERA}</script>"
"""HTML for the head of viser's page."""

POINTS = 600
"""Number of points of the overview curve."""
OUTLYING = 1.0
"""Percentage of that curve that may be cut off at either end, so that a spike at the start does not flatten the rest.
"""
MOST_REVERSALS = 400


class Bar:
    """The timeline of one browser.

    Args:
        client: the browser.
        run: the result whose frames it shows.
    """

    def __init__(self, client: Any, run: Run) -> None:
        self._run, self._state = client.gui.add_html(""), client.gui.add_html("")
        self.tell(run)

    def tell(self, run: Run) -> None:
        """Send the run's properties; repeated when it grows or changes."""
        name = "lift" if run.case.fluid.streams else "force_vertical"
        _, values = run.curve(name, 0, run.steps - 1, POINTS)
        known = values[np.isfinite(values)]
        low, high = np.percentile(known, (OUTLYING, 100.0 - OUTLYING)) if len(known) else (0.0, 1.0)
        curve = np.clip((np.nan_to_num(values, nan=low) - low) / max(high - low, 1e-300), 0.0, 1.0)
        reversals = run.reversals()
        told = {
            "frames": run.frames, "perBeat": run.frames_per_beat, "milliseconds": 1e3 * run.case.beat,
            "periodic": run.case.periodic, "speeds": list(SPEEDS), "loops": list(LOOPS),
            "curve": np.round(curve, 3).tolist(),
            "reversals": reversals if len(reversals) <= MOST_REVERSALS else [],
        }  # fmt: skip
        self._run.content = hidden("tf-run", told)

    def show(self, run: Run, playback: Playback, frame: int, text: str) -> None:
        """Send the current frame."""
        now = {
            "frame": frame, "playing": playback.playing, "speed": speed_name(playback), "loopName": playback.loop,
            "loop": span(run, playback), "dark": playback.dark, "text": text,
        }  # fmt: skip
        wire.send(self._state, content=hidden("tf-state", now))
