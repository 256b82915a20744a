"""The controls of a case in one browser: a slider, a menu or a checkbox for each key, most of them behind a search."""

import math
from collections.abc import Callable
from typing import Any

from taichiflap.case.case import Case

from .keys import CHOICE, FIRST, NUMBER, SWITCH, Control, controls, value_of

FOUND = 8
"""Keys that a search shows at most."""


class Sliders:
    """The controls.

    Args:
        client: the browser.
        case: what they show at first.
        order: of their folder.
        change: called with a key and its new value when somebody has touched its control, in the order of the page.
    """

    def __init__(self, client: Any, case: Case, order: float, change: Callable[[str, Any], None]) -> None:
        self._client, self._order, self._change = client, order, change
        self._folder: Any = None
        self._words = ""
        self._build(case)

    @property
    def keys(self) -> list[str]:
        """Keys that have a control."""
        return list(self.handles)

    def show(self, case: Case) -> None:
        """Show a case, whose keys may differ from those of the last one."""
        with self._client.atomic():
            if [one.key for one in controls(case)] != self.keys:
                self._build(case)
                return
            for key, (handle, control) in self.handles.items():
                shown = control.shown(value_of(case, key))
                if control.kind not in (SWITCH, CHOICE):
                    shown = min(max(shown, handle.min), handle.max)
                # What a drag has set is the same but for round-off.
                if not (handle.value == shown or (control.kind == NUMBER and math.isclose(handle.value, shown))):
                    handle.value = shown

    def blame(self, key: str, text: str) -> None:
        """Show at its control why a value is rejected; an empty text removes the message."""
        if key in self.handles:
            handle, control = self.handles[key]
            if handle.hint != (text or control.text):
                handle.hint = text or control.text

    def find(self, words: str) -> None:
        """Show the keys whose name or description contains all these words, in addition to the main keys."""
        self._words = words
        wanted, found = words.lower().split(), 0
        with self._client.atomic():
            for key, (handle, control) in self.handles.items():
                text = f"{key} {control.text}".lower().replace("_", " ")
                hit = bool(wanted) and all(word in text for word in wanted) and found < FOUND
                found += hit and key not in FIRST
                visible = key in FIRST or hit
                if handle.visible != visible:
                    handle.visible = visible

    def _build(self, case: Case) -> None:
        gui = self._client.gui
        if self._folder is not None:
            self._folder.remove()
        self.handles: dict[str, tuple[Any, Control]] = {}
        self._folder = gui.add_folder("Case", order=self._order)
        with self._folder:
            for control in controls(case):
                self._add(control)
            search = gui.add_text("Search", self._words, hint="find other keys by name or description")
            search.on_update(lambda _: self.find(search.value))
        self.find(self._words)

    def _add(self, control: Control) -> None:
        gui, value, visible = self._client.gui, control.shown(control.value), control.key in FIRST
        if control.kind == SWITCH:
            handle: Any = gui.add_checkbox(control.label, value, hint=control.text, visible=visible)
        elif control.kind == CHOICE:
            handle = gui.add_dropdown(
                control.label, control.options, initial_value=value, hint=control.text, visible=visible
            )
        else:
            low, high, step = control.slider()
            value = min(max(value, low), high)
            handle = gui.add_slider(control.label, low, high, step, value, hint=control.text, visible=visible)
        self.handles[control.key] = handle, control

        @handle.on_update
        async def _(event: Any) -> None:
            # On viser's event loop: in the order of the page.
            if event.client is not None:
                self._change(control.key, control.meant(handle.value))
