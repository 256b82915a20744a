"""One browser that explores: its case, its sliders, what came of the last change, and what it is compared with."""

import contextlib
import functools
import shlex
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from html import escape
from pathlib import Path
from typing import Any

from taichiflap import open_result
from taichiflap.case.case import Case, CaseError, load_case
from taichiflap.case.shipped import FOLDER, names
from taichiflap.errors import UserError
from taichiflap.notation import short
from taichiflap.scored import nearest

from .. import compare
from ..background import Background
from ..charts import Charts
from ..colours import RUNS
from ..field import Fields
from ..frames import Run
from ..scene import Actor, Look, Stage, common_ranges
from ..server import notice
from ..session import Session, opening
from ..timeline import Playback
from .keys import CHOICE, FIRST, SWITCH, Control, controls, value_of
from .worker import Worker

GHOST = Look("/pinned", (140, 146, 156), "circle", 3.0, -0.005)
"""How the pinned result's wing looks, behind the other's."""
WIDTH = 320
FOUND = 8
"""Keys that a search shows at most."""
NO_PRESET = "as opened"
BEATS = 5
"""Beats that are computed at most."""


class ExploreSession(Session):
    """The session of a browser.

    Args:
        client: viser's handle of the browser.
        case, command: where it starts, and the words that lead there.
        run: the result of that, which stays open for all browsers.
        worker: what computes.
        pool: the thread for the flow's pictures.
    """

    def __init__(
        self, client: Any, case: Case, command: list[str], run: Run, worker: Worker, pool: ThreadPoolExecutor
    ) -> None:
        self.first, self.case, self._command = case, case, command
        self.base, self._worker, self._pool = run, worker, pool
        self._past: list[Case] = []
        self._future: list[Case] = []
        self._wishes: dict[int, tuple[Case, str]] = {}
        self.pinned = run
        self._handles: dict[str, Any] = {}
        self._closed = False
        super().__init__(client, [run], opening([run]), Fields(run, pool))
        self._place = worker.enlist(self._arrive)
        with client.atomic():
            self._add_controls()
            self._tell()

    def close(self) -> None:
        """Let go of what is this browser's alone."""
        self._worker.release(self._place)
        self.view.leave()
        with self._lock:
            self._closed = True
            for run in {id(one): one for one in (self.run, self.pinned)}.values():
                self._drop(run)

    # What is shown, besides what every session shows.

    def _make_charts(self, playback: Playback) -> Charts:
        return Charts(self.client.gui, self.panel.chart_tab, [self.run, self.pinned], playback, modes=False)

    def _caption(self) -> str:
        return '<div style="font-size:11px;padding:2px 4px">Blue: current case. Orange: pinned case.</div>'

    def _set_up(self) -> tuple[Stage, list[Actor]]:
        scene, ranges = self.client.scene, common_ranges([self.run])
        self._shape = self._signature(self.run)
        actors = [Actor(scene, self.run, Look("", None, "circle"), self.theme, ranges)]
        actors.append(Actor(scene, self.pinned, GHOST, self.theme, ranges))
        return Stage(scene, self.run, self.theme), actors

    def _layers(self, actor: Actor) -> dict[str, bool]:
        return self.playback.layers if actor is self.actors[0] else dict.fromkeys(self.playback.layers, False)

    @staticmethod
    def _signature(run: Run) -> tuple[Any, ...]:
        """What the scene is built for: another needs it built anew."""
        return run.has_wake, run.page, run.chord, run.path is None, run.case.model

    def _tell(self) -> None:
        """The numbers, and what was changed."""
        changed = [key for key in self._handles if value_of(self.first, key) != value_of(self.case, key)]
        changed = [key for key in changed if value_of(self.case, key) is not None]
        settings = [f"{key}={short_text(value_of(self.case, key))}" for key in changed]
        line = shlex.join([*self._command, *(part for setting in settings for part in ("--set", setting))])
        table = compare.table(self.pinned, self.run, RUNS[::-1], ("pinned", "now"))
        scored = f"nearest scored case: {escape(nearest.sentence(self.case))}"
        self._numbers.content = f'{table}<div style="font-size:11px;padding:2px 4px">{scored}</div>'
        self._line.content = (
            f'<div style="padding:4px;font-size:11px"><code data-copy title="a click copies it" '
            f'style="cursor:pointer;overflow-wrap:anywhere">{escape(line)}</code></div>'
        )

    # The controls.

    def _add_controls(self) -> None:
        gui = self.client.gui
        gui.main_panel.set_width(WIDTH)
        self._message = gui.add_html("", order=-9.0)
        self._numbers = gui.add_html("", order=-8.0)
        with gui.add_folder("Case", order=-7.0):
            for control in controls(self.case):
                self._add_control(control, visible=control.key in FIRST)
            self._search = gui.add_text("Search", "", hint="search other keys by name or description")
            self._search.on_update(lambda _: self._find(self._search.value))
        with gui.add_folder("Keep", order=-6.0):
            preset = gui.add_dropdown("Case", (NO_PRESET, *names()), initial_value=NO_PRESET)
            preset.on_update(lambda event: self._take_preset(event.target.value))
            steps = gui.add_button_group("Change", ("undo", "redo"))
            steps.on_click(lambda event: self._undo() if event.target.value == "undo" else self._redo())
            for label, deed in (
                ("Pin", self._pin), ("Save case", self._save_case), ("Keep result", self._keep_result)
            ):  # fmt: skip
                gui.add_button(label).on_click(functools.partial(self._try, deed))
            models = gui.add_button_group("Pin a model", self._handles["solver"][1].options)
            models.on_click(lambda event: self._pin_model(event.target.value))
            self._line = gui.add_html("")

    def _add_control(self, control: Control, visible: bool) -> None:
        gui, value = self.client.gui, control.shown(control.value)
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
        self._handles[control.key] = handle, control

        @handle.on_update
        async def _(event: Any) -> None:
            # On viser's event loop: in the order of the page.
            if event.client is not None:
                self._change({control.key: control.meant(handle.value)}, control.key)

    def _find(self, words: str) -> None:
        """Show the keys that have all these words in their name or meaning."""
        wanted, found = words.lower().split(), 0
        with self.client.atomic():
            for key, (handle, control) in self._handles.items():
                text = f"{key} {control.text}".lower().replace("_", " ")
                hit = bool(wanted) and all(word in text for word in wanted) and found < FOUND
                found += hit and key not in FIRST
                visible = key in FIRST or hit
                if handle.visible != visible:
                    handle.visible = visible

    # What changes.

    def _change(self, values: dict[str, Any], key: str) -> None:
        try:
            case = self.case.changed(values)
        except CaseError as error:
            self._complain(key, str(error.problems[0]))
            return
        if case != self.case:
            self._complain(key, "")
            self._past.append(self.case)
            self._future.clear()
            self._go_to(case)

    def _go_to(self, case: Case) -> None:
        self.case = case
        self._ask(case, "run")

    def _ask(self, case: Case, what: str) -> None:
        try:
            self._wishes[self._worker.ask(self._place, case)] = case, what
        except OSError:
            self._message.content = notice("The solver process has ended; restart explore.")

    def _undo(self) -> None:
        if self._past:
            self._future.append(self.case)
            self._go_to(self._past.pop())
            self._set_controls()

    def _redo(self) -> None:
        if self._future:
            self._past.append(self.case)
            self._go_to(self._future.pop())
            self._set_controls()

    def _take_preset(self, name: str) -> None:
        case = self.first if name == NO_PRESET else brief(load_case(FOLDER / f"{name}.toml"))
        self._past.append(self.case)
        self._go_to(case)
        self._set_controls()

    def _set_controls(self) -> None:
        """Have the controls show the case; what it does not have keeps its value."""
        with self.client.atomic():
            for key, (handle, control) in self._handles.items():
                value = value_of(self.case, key)
                if value is None or isinstance(value, tuple):
                    continue
                shown = control.shown(value)
                if control.kind not in (SWITCH, CHOICE):
                    shown = min(max(shown, handle.min), handle.max)
                if handle.value != shown:
                    handle.value = shown

    def _complain(self, key: str, text: str) -> None:
        """Say why a value is refused, beside the keys and at the control."""
        handle, control = self._handles[key]
        self._message.content = notice(text)
        if handle.hint != (text or control.text):
            handle.hint = text or control.text

    def _pin(self) -> None:
        """Compare with what is shown now."""
        with self._lock:
            old, self.pinned = self.pinned, self.run
            self._refresh()
            if old is not self.run:
                self._drop(old)

    def _pin_model(self, solver: str) -> None:
        """Compare with what a model of the fluid makes of the same motion."""
        try:
            self._ask(self.case.changed({"solver": solver}), "pin")
        except CaseError as error:
            self._complain("solver", str(error.problems[0]))

    def _save_case(self) -> None:
        self.client.send_file_download("case.toml", self.case.to_toml().encode(), save_immediately=True)

    def _keep_result(self) -> None:
        self.client.send_file_download("result.h5", self.run.content, save_immediately=True)

    def _try(self, deed: Callable[[], None], _: Any) -> None:
        try:
            deed()
        except (UserError, OSError) as error:
            self._message.content = notice(str(error))

    # What comes of it.

    def _arrive(self, number: int, path: Path | None, reason: str, seconds: float) -> None:
        """Show a result; called from the worker's listener."""
        case, what = self._wishes.pop(number, (self.case, "run"))
        for old in [one for one in self._wishes if one < number]:
            self._wishes.pop(old)
        with contextlib.suppress(RuntimeError):
            if path is None:
                if reason:
                    self._message.content = notice(reason)
                return
            try:
                content = path.read_bytes()
                result = open_result(path)
                path.unlink()
                run = Run(result, "now", like=self.run)
            except (UserError, OSError) as error:
                self._message.content = notice(str(error))
                return
            run.content = content
            failed = notice(f"The run failed: {run.reason}") if run.status == "failed" else ""
            self._message.content = failed + _took(case, seconds)
            self._take(run, what)

    def _take(self, run: Run, what: str) -> None:
        with self._lock, self.client.atomic():
            if self._closed:
                run.close()
                return
            if what == "pin":
                old, self.pinned = self.pinned, run
                run.label = "pinned"
            else:
                turns = self.run.turns(self.playback.frame)
                old, self.run = self.run, run
                self.runs = [run]
                self.playback.position = float(run.index_at(turns))
                self.bar.tell(run)
                if self.playback.background != "none":
                    self.background.show("none", 0, self.theme)
                    self.background = Background(self.client, Fields(run, self._pool), self._lock, self._tell_legend)
            self._refresh()
            if old not in (self.run, self.pinned):
                self._drop(old)

    def _refresh(self) -> None:
        """Show what is new: in the scene as it stands, if it is of the right make."""
        self.charts.runs = [self.run, self.pinned]
        if self._signature(self.run) != self._shape:
            self._build()
        else:
            for actor, run in zip(self.actors, (self.run, self.pinned), strict=True):
                actor.run = run
        self.charts.show(self.playback, self.playback.frame, again=True)
        self.show()
        self._tell()

    def _drop(self, run: Run) -> None:
        if run is not self.base:
            run.close()


def short_text(value: Any) -> str:
    """A value as `--set` takes it."""
    return str(value).lower() if isinstance(value, bool) else repr(value) if isinstance(value, float) else str(value)


def _took(case: Case, seconds: float) -> str:
    beats = f", {case.time.periods:g} beats" if case.periodic and case.time.periods else ""
    return f'<div data-took style="padding:0 4px;font-size:11px">{case.model}{beats}, {short(1e3 * seconds)} ms</div>'


def brief(case: Case) -> Case:
    """A case of a few beats, as many as are explored."""
    if case.periodic and (case.time.periods or 0) > BEATS:
        return case.changed({"time.periods": BEATS})
    return case
