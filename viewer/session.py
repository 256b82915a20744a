"""The session of one browser: playback, scene, controls and charts."""

import contextlib
import threading
import time
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from taichiflap.errors import UserError

from . import address, camera, compare, timeline
from .background import AHEAD, Background
from .bar import Bar
from .channel import Channel
from .charts import Charts, caption
from .colours import theme
from .field import NONE, VORTICITY, Fields, Wanted
from .frames import Run
from .legend import legend
from .paint import paint
from .panel import Panel
from .scene import Actor, default_layers
from .server import notice
from .stage import Stage, set_up
from .streak_lines import StreakLines
from .timeline import Playback

BESIDE_SECONDS = 0.12
"""Minimum interval between updates of the charts' dots during playback, s."""
FLUSH_SECONDS = 0.1
"""What was said goes out within this time."""

NOT_LOCKED = "This version of viser allows rotation of the view; “Reset view” undoes it."


def opening(runs: Sequence[Run]) -> Playback:
    """Initial playback: at the newest frame of a run in progress, or playing the last beat of a complete one."""
    run = runs[0]
    playback = Playback(position=float(max(run.frames - 1, 0)), playing=not run.live, follow=run.live)
    shown = [default_layers(one) for one in runs]
    playback.layers = {name: any(layers[name] for layers in shown) for name in shown[0]}
    if len(runs) > 1:
        playback.layers |= {"velocity": False, "load": False}
    elif run.stores_vorticity:
        playback.background = VORTICITY
    return playback


class Session:
    """Everything that one browser shows, until it disconnects.

    Args:
        client: viser's handle of the browser.
        runs: one result, or two to compare; playback follows the first.
        playback: initial state of playback.
        fields: the flow around the first result.
    """

    def __init__(self, client: Any, runs: Sequence[Run], playback: Playback, fields: Fields) -> None:
        self.client, self.runs, self.playback = client, list(runs), playback
        self.run = runs[0]
        self._lock = threading.RLock()
        self._follow_flow(fields)
        self._beside = 0.0
        self._started = False
        self._cursor: tuple[float, float] | None = None
        self._usual = address.chosen(playback)
        with client.atomic():
            self._set_theme()
            self.panel = Panel(client, self.runs, playback, self.act)
            self.channel = Channel(client, self.act)
            self.bar = Bar(client, self.run)
            self.charts = self._make_charts(playback)
            self._build()
            self.view = camera.View(client, self.run.box)
        if not camera.lock_rotation(client):
            with contextlib.suppress(Exception):
                client.add_notification("The view can rotate", NOT_LOCKED)

    def _follow_flow(self, fields: Fields) -> None:
        """Show the flow of another result."""
        self.fields = fields
        self.background = Background(self.client, fields, self._lock, self._tell_legend)
        self.streak_lines = StreakLines(self.client, fields.streaks, self._lock)

    def start(self, playback: Playback) -> None:
        """Start updates of the page when it is ready; earlier updates would only delay it."""
        with self._lock, self.client.atomic():
            dark = self.playback.dark
            self.playback = playback
            self._started = True
            self.panel.take(playback)
            if playback.dark != dark:
                self._darken(playback.dark)
            if playback.charts:
                self.charts.choose(playback)
            self.charts.show(playback, playback.frame)
            self.show()
            self._tell_address()

    def leave(self) -> None:
        """Say no more: what the page is told of a control that is gone, it complains of."""
        with self._lock:
            self._started = False
            # What is still being computed is not drawn into another page of this browser.
            with contextlib.suppress(RuntimeError):
                self.background.show(Wanted(), 0, self.theme)
                self.streak_lines.hide()
        self.view.leave()
        time.sleep(FLUSH_SECONDS)

    def tick(self, seconds: float) -> None:
        """Advance playback, if playing."""
        with self._lock:
            if self._started and self.playback.playing:
                timeline.advance(self.run, self.playback, seconds)
                self.show()

    def grow(self) -> None:
        """React to new frames, or to a deleted file."""
        with self._lock, self.client.atomic():
            self._beside = 0.0
            self.bar.tell(self.run)
            if self.playback.follow:
                self.playback.position = float(self._newest())
                self.playback.follow = self.run.live
            if self._surveys != [run.surveys for run in self.runs]:
                self._build()
                self.view.fit(self.run.first_view(self.playback.layers["riding"]))
            self.charts.read_again(self.playback)
            self.show()

    def _newest(self) -> int:
        """The frame to follow a run to: while it computes, the newest whose picture the page has."""
        newest = self.run.frames - 1
        if not self.run.live or self._look().kind == NONE:
            return newest
        return max(self.playback.frame, self.background.newest)

    def show(self) -> None:
        """Show the current frame; a frame that is being written is shown later."""
        with self._lock, self.client.atomic():
            try:
                self._show(self.playback.frame)
            except (OSError, UserError):
                if any(run.trouble for run in self.runs):
                    self.panel.head.content = self._headline()

    def _show(self, index: int) -> None:
        wanted, coming = self._look(), []
        streaks = self.run.draws_flow and self.playback.layers["streaks"]
        if self.playback.playing and (wanted.kind != NONE or streaks):
            step, stride = self.background.step, self.background.stride
            index, coming = step(index), [step(one) for one in timeline.coming(self.run, self.playback, stride, AHEAD)]
        elif self.playback.follow:
            coming = [self.run.frames - 1]
        for actor in self.actors:
            run = actor.run
            here = index if run is self.run else run.index_at(run.beats_at(self.run, self.run.turns(index)))
            actor.show(here, self._layers(actor))
        self.background.show(wanted, index, self.theme, coming)
        if streaks:
            self.streak_lines.show(index, self.playback.points, wanted.riding, self.theme, coming)
        else:
            self.streak_lines.hide()
        self._tell_cursor()
        text = self.run.frame(index).text
        self.stage.show(text, self.playback.layers["stroke"] and not wanted.riding)
        self.bar.show(self.run, self.playback, index, f"{text}   {self._milliseconds(index)}".rstrip())
        now = time.monotonic()
        if not self.playback.playing or now - self._beside > BESIDE_SECONDS:
            self._beside = now
            self.charts.show(self.playback, index)
            self.panel.show(self.playback, self._headline())

    def act(self, name: str, value: Any) -> None:
        """Handle a control."""
        with self._lock:
            playback = self.playback
            if name in playback.layers:
                playback.layers[name] = bool(value)
                if name == "riding":
                    self._change_frame()
                elif name == "streaks":
                    playback.points = ()
            elif name in ("loop", "window", "background"):
                setattr(playback, name, value)
            elif name in timeline.CONTROLS:
                timeline.CONTROLS[name](self.run, playback, value)
            else:
                getattr(self, self._deeds[name])(value)
            if name in ("background", "arrows", "riding"):
                self._tell_legend()
            self.show()
            self._tell_address()

    def _choose_charts(self, names: Sequence[str]) -> None:
        self.playback.charts = tuple(names)
        with self.client.atomic():
            self.charts.choose(self.playback)

    def _reset_view(self, _: Any) -> None:
        self.view.reset()

    def _look_at(self, seen: tuple[float, float, float]) -> None:
        self.view.look_at(*seen)

    def _point_at(self, place: tuple[float, float]) -> None:
        self._cursor = place

    def _release_at(self, place: tuple[float, float]) -> None:
        """Release fluid at a point of the scene, and show its streak line."""
        if not self.run.draws_flow:
            return
        playback, run = self.playback, self.run
        point = run.standpoint(playback.frame, playback.layers["riding"]).points(run.chord * np.array(place))
        right, up = np.round(run.page.on_page(*point) / run.chord, 3)
        playback.points = (*playback.points, (float(right), float(up)))[-address.MOST :]
        playback.layers["streaks"] = True
        self.panel.take(playback)

    def _take_address(self, texts: dict[str, str]) -> None:
        """Go where the address says."""
        before, self.playback = self.playback, address.taken(texts, self.playback, self.run)
        if self.playback.layers["riding"] != before.layers["riding"]:
            self._change_frame()
        if self.playback.background != before.background:
            self._tell_legend()
        if self.playback.charts != before.charts:
            self._choose_charts(self.playback.charts)
        if self.playback.dark != before.dark:
            self._darken(self.playback.dark)
        self.panel.take(self.playback)

    def _tell_address(self) -> None:
        if self._started:
            self.channel.tell_address(self._address())

    def _address(self) -> dict[str, str | None]:
        return address.held(self.playback, self._usual)

    def _tell_cursor(self) -> None:
        if self._cursor is not None and self.playback.background != NONE:
            self.channel.tell_cursor(self.background.at(*self._cursor))

    def _change_frame(self) -> None:
        """See the scene from the wing, or no longer."""
        self._build()
        self.view.box = self.run.first_view(self.playback.layers["riding"])
        self.view.reset()

    def _darken(self, dark: bool) -> None:
        self.playback.dark = bool(dark)
        with self.client.atomic():
            self._set_theme()
            self._build()

    _deeds = {  # noqa: RUF012 - the same for all
        "charts": "_choose_charts",
        "reset": "_reset_view",
        "view": "_look_at",
        "cursor": "_point_at",
        "release": "_release_at",
        "address": "_take_address",
        "dark": "_darken",
    }
    """The methods for the other controls, by name: some kinds of sessions have their own."""

    def _set_theme(self) -> None:
        self.theme = theme(self.playback.dark)
        self.client.gui.configure_theme(
            dark_mode=self.playback.dark, show_logo=False, show_share_button=False, control_width="medium"
        )
        paint(self.client, self.theme)

    def _build(self) -> None:
        """Rebuild the scene, for another theme or for new ranges of a growing run."""
        scene = self.client.scene
        scene.reset()
        self._surveys = [run.surveys for run in self.runs]
        self.background.forget()
        self.streak_lines.forget()
        self.stage, self.actors = self._set_up()
        self.panel.caption.content = self._caption()
        if len(self.runs) > 1:
            self.panel.differences.content = compare.table(self.runs[0], self.runs[1])
            self.panel.differences.visible = True
        self._tell_legend()
        self.show()

    def _make_charts(self, playback: Playback) -> Charts:
        return Charts(self.client.gui, self.panel.chart_tab, self.runs, playback, **self._chart_options())

    def _chart_options(self) -> dict[str, Any]:
        return {"choose": lambda names: self.act("charts", names), "narrow": camera.is_narrow(self.client)}

    def _caption(self) -> str:
        return caption(self.runs)

    def _set_up(self) -> tuple[Stage, list[Actor]]:
        return set_up(self.client.scene, self.runs, self.theme, self.playback.layers["riding"])

    def _layers(self, _: Actor) -> dict[str, bool]:
        return self.playback.layers

    def _tell_legend(self) -> None:
        shown = self.background.bar(self._look(), self.theme)
        self.panel.legend.content = legend(self.runs, self.theme, shown)

    def _look(self) -> Wanted:
        """What of the flow is shown."""
        layers = self.playback.layers
        kind = self.playback.background if self.run.draws_flow else NONE
        return Wanted(kind, layers["arrows"], layers["streamlines"], layers["riding"])

    def _milliseconds(self, frame: int) -> str:
        """The time of a frame besides t/T; nothing for a run without a period, whose text has it."""
        if not self.run.case.periodic:
            return ""
        return f"{1e3 * self.run.case.step * float(self.run.case.step_of(frame)):.2f} ms"

    def _headline(self) -> str:
        failed = f"failed: {escape(self.run.reason)}"
        state = {"running": f"running, {self.run.progress}", "failed": failed}.get(self.run.status, "")
        trouble = "".join(notice(run.trouble) for run in self.runs)
        several = len(self.runs) > 1
        title = " against ".join(escape(run.label if several else run.title) for run in self.runs)
        model = " against ".join(run.case.model for run in self.runs)
        return (
            f'<div data-head style="padding:2px 12px 6px 4px;line-height:1.45"><b>{title}</b><br>'
            f"{model}{', ' + state if state else ''}</div>{trouble}"
        )
