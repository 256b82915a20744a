"""The controls of one browser. They only call the session and show its state."""

from collections.abc import Callable
from typing import Any

from . import camera
from .charts import WINDOWS
from .field import BACKGROUNDS
from .frames import Run
from .motion import Motion
from .scene import LAYERS
from .timeline import Playback

WIDTH = 250
CHART_WIDTH = 290
LEGEND_WIDTH = 224


class Panel:
    """The controls.

    Args:
        client: the browser.
        runs: one result, or two to compare; playback follows the first.
        playback: initial state of the controls.
        act: callback of the name of a control and its new value.
    """

    def __init__(self, client: Any, runs: list[Run], playback: Playback, act: Callable[[str, Any], None]) -> None:
        self._act = act
        run = self._run = runs[0]
        gui = client.gui
        gui.main_panel.dock_left()
        gui.main_panel.set_width(WIDTH)
        gui.add_html(camera.narrow())
        self.head = gui.add_html("")
        self.follow = gui.add_checkbox(
            "Follow the computation", playback.follow, visible=run.live, hint="always show the newest frame"
        )
        self._listen(self.follow, "follow")
        with gui.add_folder("Scene", expand_by_default=not camera.is_narrow(client)):
            reset = gui.add_button("Reset view")
            reset.on_click(lambda _: act("reset", None))
            self.motion = Motion(client, run.case)
            self.background = gui.add_dropdown("Background", BACKGROUNDS, initial_value=playback.background)
            self._listen(self.background, "background")
            self.layers = {}
            for name, (title, hint) in LAYERS.items():
                self.layers[name] = gui.add_checkbox(title, playback.layers[name], hint=hint)
                self._listen(self.layers[name], name)
            self.suit(runs)
            self.dark = gui.add_checkbox("Dark", playback.dark)
            self._listen(self.dark, "dark")
        self._legend_panel = gui.add_panel()
        with self._legend_panel.add_tab("Legend"):
            self.legend = gui.add_html("")
        self._legend_panel.float(x=12, y=-12, width=LEGEND_WIDTH)
        chart_panel = gui.add_panel()
        self.chart_tab = chart_panel.add_tab("Charts")
        with self.chart_tab:
            self.window = gui.add_dropdown("Show", WINDOWS, initial_value=playback.window)
            self._listen(self.window, "window")
            self.differences = gui.add_html("", visible=False)
            self.caption = gui.add_html("")
        chart_panel.dock_right()
        chart_panel.set_width(CHART_WIDTH)

    def _listen(self, handle: Any, name: str) -> None:
        @handle.on_update
        def _(event: Any) -> None:
            # Values set by the server return without a client.
            if event.client is not None:
                self._act(name, event.target.value)

    def suit(self, runs: list[Run]) -> None:
        """Offer the layers and backgrounds that these results have."""
        run = self._run = runs[0]
        without = "" if run.draws_flow else f"{run.case.model} does not provide the flow around the wing"
        for handle, missing in (
            (self.background, bool(without)),
            *((handle, _is_missing(runs, name)) for name, handle in self.layers.items()),
        ):
            if handle.disabled != missing:
                handle.disabled = missing
        if (self.background.hint or "") != without:
            self.background.hint = without or None

    def take(self, playback: Playback) -> None:
        """Restore the controls after a reconnection."""
        choices: list[tuple[Any, Any]] = [
            (self.background, playback.background), (self.window, playback.window), (self.dark, playback.dark),
            *((self.layers[name], shown) for name, shown in playback.layers.items()),
        ]  # fmt: skip
        for handle, choice in choices:
            if handle.value != choice:
                handle.value = choice

    def show(self, playback: Playback, headline: str) -> None:
        """Show where playback is."""
        self.head.content = headline
        if self.follow.value != playback.follow:
            self.follow.value = playback.follow
        if self.follow.visible != self._run.live:
            self.follow.visible = self._run.live


def _is_missing(runs: list[Run], layer: str) -> bool:
    """Whether there is nothing to show in a layer; the flow and the stroke plane are those of the first result."""
    run = runs[0]
    return (
        (layer == "wake" and not any(one.has_wake for one in runs))
        or (layer == "sheets" and not any(one.has_sheets for one in runs))
        or (layer == "stroke" and run.path is None)
        or (layer in ("arrows", "streamlines", "streaks") and not run.draws_flow)
        or (layer == "streamlines" and not run.has_streamlines)
    )
