"""A map in the browser: a metric over two keys or over another metric; a click opens a case, which is run first if
necessary.
"""

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

from taichiflap.case.case import Case
from taichiflap.errors import UserError
from taichiflap.maps.file import Map, MapError, open_map
from taichiflap.maps.labels import grouped, named

from .. import camera
from ..channel import Channel
from ..colours import METRIC, theme
from ..explore.change import brief
from ..explore.session import COMMAND, ExploreSession
from ..explore.worker import Worker
from ..frames import UNREADABLE, Run
from ..legend import Bar, bar_html
from ..paint import paint
from ..server import notice
from . import picture, scene, words
from .profiles import Profiles

PANEL_WIDTH = 320
BACK = "Back to the map"
OpenCase = Callable[[int, Callable[[int, int], None]], Run]


class MapSession:
    """What one browser sees: the map, or one of its cases.

    Args:
        client: viser's handle of the browser.
        path: the map file.
        run: computes or opens a case, by its number, telling the steps done and all steps.
        worker: the thread to do that in.
        explorer: gives the process that computes what is explored from there.
    """

    def __init__(
        self, client: Any, path: Path, run: OpenCase, worker: ThreadPoolExecutor, explorer: Callable[[Case], Worker]
    ) -> None:
        self.client, self.path, self.run, self.worker, self.explorer = client, path, run, worker, explorer
        self._lock = threading.RLock()
        self._dark = False
        self._wanted: int | None = None
        self._case: ExploreSession | None = None
        self._menus: dict[str, tuple[Any, dict[str, str]]] = {}
        self._pointed: int | None = None
        with open_map(self.path) as sheet:
            self._is_of = _identity(sheet)
            self.choice = self._opening = picture.opening(sheet)
        self._show_map()
        self.client.scene.on_click()(lambda event: self._try(self._click, event))

    def tick(self, seconds: float) -> None:
        """Let the case play on, if one is shown."""
        with self._lock:
            if self._case:
                self._case.tick(seconds)

    def close(self) -> None:
        """Let go of the case that is shown."""
        with self._lock:
            if self._case:
                self._case.close()
                self._case.base.close()
            self._case = self._wanted = None

    def warn(self, trouble: str) -> None:
        """Say what has become of the file; nothing if all is well again."""
        with self._lock, contextlib.suppress(RuntimeError):
            if self._trouble.content != notice(trouble):
                self._trouble.content = notice(trouble)

    def _try(self, deed: Callable[..., None], *arguments: Any) -> None:
        """Do what a control asks for; of a map that is gone, or another by now, say so."""
        try:
            deed(*arguments)
        except (UserError, *UNREADABLE) as error:
            self.warn(str(error) if isinstance(error, UserError) else f"{self.path}: can no longer be read: {error}")

    def _open(self) -> Map:
        """The map.

        Raises:
            MapError: when it is gone, or another than the one that this page was opened with.
        """
        sheet = open_map(self.path)
        if _identity(sheet) != self._is_of:
            sheet.close()
            raise MapError(f"{self.path.name} has been replaced by another map; reload this page to see it.")
        return sheet

    def _show_map(self) -> None:
        """Build the page of the map."""
        client, gui = self.client, self.client.gui
        with self._lock, client.atomic(), self._open() as sheet:
            self.close()
            client.scene.reset()
            gui.reset()
            gui.main_panel.dock_left()
            gui.main_panel.set_width(PANEL_WIDTH)
            gui.add_html(camera.narrow())
            self.channel = Channel(client, lambda what, value: self._try(self._act, what, value))
            self._headline = gui.add_html(words.headline(sheet))
            self._trouble = gui.add_html("")
            keys = [axis.key for axis in sheet.design.axes]
            for title, of, names in (
                ("Across", "across", keys + sheet.metrics),
                ("Up", "up", keys + sheet.metrics),
                ("Colour", "colour", sheet.metrics),
            ):
                self._add_dropdown(title, of, grouped(names, sheet))
            self._fixed = [self._add_held(axis) for axis in sheet.design.axes if sheet.design.grid]
            self._dark_box = gui.add_checkbox("Dark", self._dark)
            self._dark_box.on_update(lambda event: self._try(self._darken, bool(event.target.value)))
            self._legend = gui.add_html("")
            self._message = gui.add_html("")
            self._profiles = Profiles(gui)
            self._draw(sheet)
            self.view = camera.View(client, scene.BOX, aside=0.0)
        camera.lock_rotation(client)

    def _add_dropdown(self, title: str, of: str, names: dict[str, str]) -> None:
        shown = next(text for text, name in names.items() if name == getattr(self.choice, of))
        handle = self.client.gui.add_dropdown(title, tuple(names), initial_value=shown, hint="type to search")
        self._menus[of] = handle, names

        @handle.on_update
        def _(event: Any) -> None:
            self._try(self._choose, {of: names[event.target.value]})

    def _add_held(self, axis: Any) -> tuple[str, Any]:
        names = list(map(str, axis.values))
        chosen = names[self.choice.fixed.get(axis.key, 0)]
        handle = self.client.gui.add_dropdown(
            axis.key, tuple(dict.fromkeys(names)), initial_value=chosen, visible=False
        )

        @handle.on_update
        def _(event: Any) -> None:
            place = names.index(event.target.value)
            self._try(self._choose, {"fixed": dict(self.choice.fixed) | {axis.key: place}})

        return axis.key, handle

    def _choose(self, chosen: dict[str, Any]) -> None:
        with self._lock, self.client.atomic(), self._open() as sheet:
            self.choice = replace(self.choice, **chosen)
            self._draw(sheet)

    def _darken(self, dark: bool) -> None:
        self._dark = dark
        self._choose({})

    def _act(self, what: str, value: Any) -> None:
        """Do what the page asks for."""
        with self._lock:
            if self._case:
                return
            if what == "cursor":
                self._point(value)
            elif what == "view":
                self.view.look_at(*value)
            elif what == "address":
                self._take_address(value)

    def _point(self, spot: tuple[float, float]) -> None:
        """Say which case is under the cursor, and draw the metric through it."""
        number = self.picture.at(*scene.shares(*spot))
        if number == self._pointed:
            return
        self._pointed = number
        if number is None:
            self.channel.tell_cursor("")
            return
        with self.client.atomic(), self._open() as sheet:
            self.channel.tell_cursor("\n".join(words.of_case(sheet, number, self.choice.colour, self.picture)))
            self._draw_profiles(sheet, number)

    def _draw_profiles(self, sheet: Map, number: int | None) -> None:
        choice = self.choice
        found = [] if number is None else picture.profiles(sheet, choice, self.picture, number)
        names = {name: named(name, sheet) for name in (choice.across, choice.up)}
        metric = named(choice.colour, sheet)
        self._profiles.show(found, names, metric, f"<b>Case {number}</b>: {escape(metric)}" if found else "")

    def _take_address(self, chosen: dict[str, str]) -> None:
        """Show what the address says, as far as this map has it."""
        known = {of: chosen[of] for of, (_, names) in self._menus.items() if chosen.get(of) in names.values()}
        self._dark = chosen.get("dark") == "1"
        self._dark_box.value = self._dark
        for of, name in known.items():
            handle, names = self._menus[of]
            handle.value = next(text for text, one in names.items() if one == name)
        self._choose(known)

    def _tell_address(self) -> None:
        held = {of: getattr(self.choice, of) for of in self._menus}
        usual = {of: getattr(self._opening, of) for of in self._menus}
        changed = {of: None if held[of] == usual[of] else held[of] for of in held}
        self.channel.tell_address(changed | {"dark": "1" if self._dark else None})

    def _draw(self, sheet: Map) -> None:
        """Draw the map as chosen."""
        client = self.client
        client.gui.configure_theme(
            dark_mode=self._dark, show_logo=False, show_share_button=False, control_width="medium"
        )
        self._theme = theme(self._dark)
        paint(client, self._theme)
        held = {axis.key for axis in picture.held(sheet, self.choice)}
        for key, handle in self._fixed:
            handle.visible = key in held
        self.picture = picture.read(sheet, self.choice)
        names = named(self.choice.across, sheet), named(self.choice.up, sheet)
        scene.draw(client.scene, self.picture, *names, self._theme)
        self._pointed = None
        self._draw_profiles(sheet, None)
        self._tell_address()
        low, high = self.picture.limits
        title, unit = words.title_and_unit(self.choice.colour, sheet)
        bar = bar_html(Bar(title, METRIC, words.digits(low), words.digits(high), unit or "no unit"))
        self._legend.content = (
            f'<div data-legend style="padding:4px;line-height:1.45;font-size:12px">{bar}'
            f"{words.remarks(self.picture)}A click on a case opens it.</div>"
        )

    def _click(self, event: Any) -> None:
        spot = scene.hit(event)
        with self._lock:
            if self._case or self._wanted is not None or spot is None:
                return
            number = self.picture.at(*spot)
            if number is None:
                return
            with self._open() as sheet:
                told = words.case_lines(sheet, number, self.choice.colour, self.picture)
            self._wanted = number
            self._message.content = words.as_html([*told, "opening"])

        def progress(done: int, total: int) -> None:
            if self._wanted == number:
                self._message.content = words.as_html([*told, f"computing: {100 * done // total} %"])

        future = self.worker.submit(self.run, number, progress)
        future.add_done_callback(lambda found: self._arrive(number, told, found))

    def _arrive(self, number: int, told: list[str], found: "Future[Run]") -> None:
        """Show the case that was clicked on, unless the browser has left."""
        with self._lock, contextlib.suppress(RuntimeError):
            if found.cancelled() or self._wanted != number:
                if not found.cancelled() and not found.exception():
                    found.result().close()
                return
            self._wanted = None
            error = found.exception()
            if error:
                self._message.content = words.as_html([*told, escape(str(error))])
                return
            self._show_case(found.result(), told)

    def _show_case(self, run: Run, told: list[str]) -> None:
        client = self.client
        self.view.leave()
        with client.atomic():
            client.gui.reset()
            client.scene.reset()
            self._case = ExploreSession(
                client, brief(run.case), COMMAND, run, self.explorer(brief(run.case)), self.worker
            )
            back = client.gui.add_button(BACK, order=-20.0)
            self._trouble = client.gui.add_html("", order=-19.0)
            client.gui.add_html(words.as_html(told), order=-18.0)
            back.on_click(lambda _: self._try(self._show_map))
        self._case.start(replace(self._case.playback, dark=self._dark))


def _identity(sheet: Map) -> tuple[Any, ...]:
    """What makes a map the one that it is; a study adds outcomes, and may add samples."""
    return sheet.case, [axis.key for axis in sheet.design.axes], sheet.design.grid, sheet.metrics
