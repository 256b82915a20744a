"""The timeline along the foot of a page: drawn by a script of the page's, told and heard by elements of viser's."""

import asyncio
import contextlib
import json
import math
import threading
from collections import deque
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from . import wire
from .frames import Run
from .timeline import LOOPS, SPEEDS, Playback, span, speed_name

_STYLE, _SCRIPT = (Path(__file__).with_name(name).read_text("utf-8") for name in ("bar.css", "bar.js"))
HEAD = f"<style>{_STYLE}</style><script>{_SCRIPT}</script>"
"""For the head of viser's page."""

POINTS = 600
"""Points of the overview curve."""
OUTLYING = 1.0
"""Percent of that curve that may lie above or below the bar: a spike at the start would flatten all the rest."""
MOST_REVERSALS = 400
NUMBERS = ("frame", "skip", "edge", "reversal", "beats")
"""What a page asks for with a number."""


class Bar:
    """The timeline of one browser.

    Args:
        client: the browser.
        run: the result whose frames it counts.
        act: called with the name of what was touched and its new value, in the order of the page.
    """

    def __init__(self, client: Any, run: Run, act: Callable[[str, Any], None]) -> None:
        self._act = act
        self._asked: deque[tuple[str, Any]] = deque()
        self._lock = threading.Lock()
        gui = client.gui
        self._heard = gui.add_text("timeline", "", visible=False)
        self._run, self._state = gui.add_html(""), gui.add_html("")

        @self._heard.on_update
        async def _(event: Any) -> None:
            # On viser's event loop, where all come in order; the work is done elsewhere.
            if event.client is not None and (wish := understood(self._heard.value)):
                self._asked.append(wish)
                asyncio.get_running_loop().run_in_executor(None, self._answer)

        self.tell(run)

    def _answer(self) -> None:
        """Do what was asked for: of several frames the last."""
        with self._lock:
            while self._asked:
                what, value = self._asked.popleft()
                if what != "frame" or not self._asked or self._asked[0][0] != "frame":
                    # The browser may have left since.
                    with contextlib.suppress(RuntimeError):
                        self._act(what, value)

    def tell(self, run: Run) -> None:
        """Say what the run is; again when it has grown, or is another."""
        name = "lift" if any(run.case.fluid.velocity) else "force_vertical"
        _, values = run.curve(name, 0, run.steps - 1, POINTS)
        known = values[np.isfinite(values)]
        low, high = np.percentile(known, (OUTLYING, 100.0 - OUTLYING)) if len(known) else (0.0, 1.0)
        curve = np.clip((np.nan_to_num(values, nan=low) - low) / max(high - low, 1e-300), 0.0, 1.0)
        reversals = run.reversals()
        told = {
            "to": self._heard._impl.uuid, "frames": run.frames, "perBeat": run.frames_per_beat,
            "periodic": run.case.periodic, "speeds": list(SPEEDS), "loops": list(LOOPS),
            "curve": np.round(curve, 3).tolist(),
            "reversals": reversals if len(reversals) <= MOST_REVERSALS else [],
        }  # fmt: skip
        self._run.content = _hidden("tf-run", told)

    def show(self, run: Run, playback: Playback, frame: int, text: str) -> None:
        """Say where the page is."""
        now = {
            "frame": frame, "playing": playback.playing, "speed": speed_name(playback), "loopName": playback.loop,
            "loop": span(run, playback), "dark": playback.dark, "text": text,
        }  # fmt: skip
        wire.send(self._state, content=_hidden("tf-state", now))


def understood(text: str) -> tuple[str, Any] | None:
    """What a page asks for, and with which value; None for what no page would."""
    try:
        _, what, value = json.loads(text)
    except (ValueError, TypeError, RecursionError):
        return None
    if what == "play":
        return what, None
    if what in NUMBERS and _is_number(value):
        return what, float(value)
    if (what == "speed" and value in list(SPEEDS)) or (what == "loop" and value in LOOPS):
        return what, value
    if what == "range" and isinstance(value, list) and len(value) == 2 and all(map(_is_number, value)):
        return what, (min(value), max(value))
    return None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and abs(value) < 1e9


def _hidden(name: str, value: Any) -> str:
    return f'<i id="{name}" hidden data-is="{escape(json.dumps(value))}"></i>'
