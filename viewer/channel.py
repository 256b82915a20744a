"""Messages between a page's script and the server, through hidden viser elements.

The page asks through a hidden text control, whose values are numbered because viser drops one that is equal to the
last. The server answers with hidden elements that replace one another: what the address should hold, and the values
under the cursor.
"""

import asyncio
import contextlib
import json
import math
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from html import escape
from pathlib import Path
from typing import Any

from . import wire
from .timeline import LOOPS, SPEEDS

SCRIPT = Path(__file__).with_name("page.js").read_text("utf-8")
"""The page's own, of which `bar.js` makes use."""

LATEST = ("frame", "cursor")
"""Of several of these in a row only the last counts."""
LONGEST = 4096
"""Characters of what a page asks for."""

Act = Callable[[str, Any], None]


class Channel:
    """The page of one browser.

    Args:
        client: the browser.
        act: called with the name of what was touched and its new value, in the order of the page.
    """

    def __init__(self, client: Any, act: Act) -> None:
        self._act = act
        self._asked: deque[tuple[str, Any]] = deque()
        self._lock = threading.Lock()
        gui = client.gui
        self._heard = gui.add_text("page", "", visible=False)
        gui.add_html(hidden("tf-to", self._heard._impl.uuid))
        self._address, self._cursor = gui.add_html(""), gui.add_html("")
        self._told: dict[str, str | None] = {}

        @self._heard.on_update
        async def _(event: Any) -> None:
            # On viser's event loop, where all come in order; the work is done elsewhere.
            if event.client is not None and (wish := understood(self._heard.value)):
                self._asked.append(wish)
                asyncio.get_running_loop().run_in_executor(None, self._answer)

    def tell_address(self, held: Mapping[str, str | None]) -> None:
        """Set values of the page's address by name; None removes one."""
        if held != self._told:
            self._told = dict(held)
            wire.send(self._address, content=hidden("tf-address", self._told))

    def tell_cursor(self, text: str) -> None:
        """Set the text for the point under the cursor; empty for none."""
        wire.send(self._cursor, content=hidden("tf-cursor", text))

    def _answer(self) -> None:
        """Process requests; of several frames or cursor positions only the last counts."""
        with self._lock:
            while self._asked:
                what, value = self._asked.popleft()
                if what not in LATEST or all(later != what for later, _ in self._asked):
                    # The browser may have left since.
                    with contextlib.suppress(RuntimeError):
                        self._act(what, value)


def understood(text: str) -> tuple[str, Any] | None:
    """The request of a page and its value; None if it is invalid."""
    try:
        _, what, value = json.loads(text)
    except (ValueError, TypeError, RecursionError):
        return None
    take = KINDS.get(what) if isinstance(what, str) else None
    taken = take(value) if take and len(text) <= LONGEST else None
    return None if taken is None else (what, taken)


def hidden(name: str, value: Any) -> str:
    """A hidden element that passes a value to the page's script."""
    return f'<i id="{name}" hidden data-is="{escape(json.dumps(value))}"></i>'


def _number(value: Any) -> float | None:
    return float(value) if _is_number(value) else None


def _numbers(count: int) -> Callable[[Any], tuple[float, ...] | None]:
    def take(value: Any) -> tuple[float, ...] | None:
        fits = isinstance(value, list) and len(value) == count and all(map(_is_number, value))
        return tuple(map(float, value)) if fits else None

    return take


def _one_of(names: Iterable[str]) -> Callable[[Any], str | None]:
    allowed = list(names)
    return lambda value: value if value in allowed else None


def _texts(value: Any) -> dict[str, str] | None:
    plain = isinstance(value, dict) and all(isinstance(part, str) for part in value.values())
    return value if plain else None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and abs(value) < 1e9


KINDS: dict[str, Callable[[Any], Any]] = {
    **dict.fromkeys(("frame", "skip", "edge", "reversal", "beat", "beats"), _number),
    "play": lambda _: True, "speed": _one_of(SPEEDS), "loop": _one_of(LOOPS), "range": _numbers(2),
    "cursor": _numbers(2), "release": _numbers(2), "view": _numbers(3), "address": _texts,
}  # fmt: skip
"""What a page may ask for, and what takes the value: None for one that no page would send."""
