"""One exploring browser: its case, its sliders, the last result, and the pinned result."""

import contextlib
import functools
import math
import shlex
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from html import escape
from typing import Any

from taichiflap.case.case import Case, CaseError, load_case
from taichiflap.case.shipped import FOLDER, names
from taichiflap.errors import UserError
from taichiflap.notation import short
from taichiflap.scored import nearest

from .. import compare
from ..charts import Charts
from ..colours import RUNS
from ..field import Fields, Wanted
from ..frames import Run
from ..scene import Actor, Look, common_ranges
from ..server import notice
from ..session import Session, opening
from ..stage import Stage
from ..timeline import Playback
from .change import History, addressed, brief, changed, settings
from .sliders import Sliders
from .worker import BEGUN, ENDED, LONG, Found, Worker, received

GHOST = Look("/pinned", (140, 146, 156), "circle", 3.0, -0.005)
"""How the pinned result's wing looks, behind the other's."""
WIDTH = 320
NO_PRESET, NO_MODEL = "as opened", "none"
SEPARATOR = ";"
"""Between the settings that the address holds."""
COMMAND = ["taichiflap", "simulate", "case.toml"]
"""What computes anew a case that comes from no file, once it is saved."""
LOOK_SECONDS = 0.25
"""How often a run that is shown while it is computed is looked at."""


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
        self._history = History(case)
        self._wishes: dict[int, tuple[Case, str]] = {}
        self._wishing = threading.Lock()
        self.pinned = run
        self._closed = False
        self._looked, self._asked = 0.0, math.inf
        self._second = NO_MODEL
        super().__init__(client, [run], opening([run]), Fields(run, pool))
        self._place = worker.enlist(functools.partial(self._arrive, what="run"))
        self._beside_place = worker.enlist(functools.partial(self._arrive, what="pin"))
        with client.atomic():
            self._add_controls()
            self._tell()

    def close(self) -> None:
        """Release the resources of this browser."""
        for place in (self._place, self._beside_place):
            self._worker.release(place)
        self.leave()
        with self._lock:
            self._closed = True
            for run in {id(one): one for one in (self.run, self.pinned)}.values():
                self._drop(run)

    # What is shown, besides what every session shows.

    def _make_charts(self, playback: Playback) -> Charts:
        return Charts(self.client.gui, self.panel.chart_tab, [self.run, self.pinned], playback, modes=False,
                      **self._chart_options())  # fmt: skip

    def _caption(self) -> str:
        return f'<div style="font-size:11px;padding:2px 4px">Blue: as it is now. Orange: {self._other}.</div>'

    @property
    def _other(self) -> str:
        """The result that the case is compared with."""
        return "pinned" if self._second == NO_MODEL else self.pinned.case.model

    def _set_up(self) -> tuple[Stage, list[Actor]]:
        scene, ranges = self.client.scene, common_ranges([self.run])
        self._shape = self._signature(self.run)
        actors = [Actor(scene, self.run, Look("", None, "circle"), self.theme, ranges)]
        actors.append(Actor(scene, self.pinned, GHOST, self.theme, ranges))
        return Stage(scene, self.run, self.theme, self.playback.layers["riding"]), actors

    def _layers(self, actor: Actor) -> dict[str, bool]:
        layers = self.playback.layers
        return layers if actor is self.actors[0] else dict.fromkeys(layers, False) | {"riding": layers["riding"]}

    @staticmethod
    def _signature(run: Run) -> tuple[Any, ...]:
        """Properties that the scene depends on; if they change, it is built again."""
        return run.has_wake, run.page, run.chord, run.path is None, run.case.model

    def _tell(self) -> None:
        """The metrics and the changed keys as HTML."""
        line = shlex.join([*self._command, *(part for setting in self._settings() for part in ("--set", setting))])
        table = compare.table(self.pinned, self.run, RUNS[::-1], (self._other, "now"))
        scored = f"nearest scored case: {escape(nearest.sentence(self.case))}"
        self._numbers.content = f'{table}<div style="font-size:11px;padding:2px 4px">{scored}</div>'
        self.panel.caption.content = self._caption()
        self._line.content = (
            f'<div style="padding:4px;font-size:11px"><code data-copy title="a click copies it" '
            f'style="cursor:pointer;overflow-wrap:anywhere">{escape(line)}</code></div>'
        )

    def _settings(self) -> list[str]:
        """Settings that change the first case into this one, in the form of `--set`."""
        return settings(self.first, self.case, self.sliders.keys)

    def tick(self, seconds: float) -> None:
        """Advance playback, and check a run that is shown during its computation."""
        if self._wishes and time.monotonic() - self._asked > LONG:
            # Said once.
            self._asked = math.inf
            self._message.content = _took(self.case, 0.0, begun=True)
        if not self.run.live:
            super().tick(seconds)
        elif self._wishes and time.monotonic() - self._looked > LOOK_SECONDS:
            self._looked = time.monotonic()
            if self.run.refresh() and not self.run.trouble:
                self.grow()

    # What the address holds besides.

    def _take_address(self, chosen: dict[str, str]) -> None:
        if "set" in chosen:
            try:
                self._choose(addressed(self.first, chosen["set"].split(SEPARATOR)))
            except CaseError as error:
                self._message.content = notice(str(error.problems[0]))
        super()._take_address(chosen)

    def _address(self) -> dict[str, str | None]:
        return super()._address() | {"set": SEPARATOR.join(self._settings()) or None}

    # The controls.

    def _add_controls(self) -> None:
        gui = self.client.gui
        gui.main_panel.set_width(WIDTH)
        self._message = gui.add_html("", order=-9.0)
        self._numbers = gui.add_html("", order=-8.0)
        self.sliders = Sliders(self.client, self.case, -7.0, lambda key, value: self._change({key: value}, key))
        with gui.add_folder("Keep", order=-6.0):
            preset = gui.add_dropdown("Case", (NO_PRESET, *names()), initial_value=NO_PRESET)
            preset.on_update(lambda event: self._take_preset(event.target.value))
            steps = gui.add_button_group("Change", ("undo", "redo"))
            steps.on_click(lambda event: self._undo() if event.target.value == "undo" else self._redo())
            for label, deed in (
                ("Pin", self._pin), ("Save case", self._save_case), ("Keep result", self._keep_result)
            ):  # fmt: skip
                gui.add_button(label).on_click(functools.partial(self._try, deed))
            second = gui.add_dropdown(
                "Second model", (NO_MODEL, *self.sliders.handles["solver"][1].options),
                hint="compute every change with this model too, and compare with it instead of the pinned result",
            )  # fmt: skip
            second.on_update(lambda event: self._set_second(event.target.value))
            self._line = gui.add_html("")

    # What changes.

    def _change(self, values: dict[str, Any], key: str) -> None:
        try:
            case = changed(self.case, values)
        except CaseError as error:
            self._complain(key, str(error.problems[0]))
            return
        if case != self.case:
            self._complain(key, "")
        self._choose(case)

    def _choose(self, case: Case) -> None:
        """Set the current case; undo returns to the previous one."""
        if case != self.case:
            self._history.add(case)
            self._go_to(case)

    def _go_to(self, case: Case) -> None:
        if case is self.case:
            return
        self.case = case
        self.sliders.show(case)
        self._ask(case, "run")
        self._ask_second()
        self._tell_address()

    def _ask(self, case: Case, what: str) -> None:
        place = self._place if what == "run" else self._beside_place
        try:
            # The answer may come at once.
            with self._wishing:
                self._wishes[self._worker.ask(place, case)] = case, what
        except OSError:
            self._message.content = notice(ENDED)
        self._asked = time.monotonic()

    def _undo(self) -> None:
        self._go_to(self._history.undo())

    def _redo(self) -> None:
        self._go_to(self._history.redo())

    def _take_preset(self, name: str) -> None:
        self._choose(self.first if name == NO_PRESET else brief(load_case(FOLDER / f"{name}.toml")))

    def _complain(self, key: str, text: str) -> None:
        """Show why a value is rejected, next to the keys and at its control."""
        self._message.content = notice(text)
        self.sliders.blame(key, text)

    def _pin(self) -> None:
        """Pin the current result for comparison."""
        with self._lock:
            old, self.pinned = self.pinned, self.run
            self._refresh()
            self._tell()
            if old is not self.run:
                self._drop(old)

    def _set_second(self, model: str) -> None:
        """From now on compare with another model's result for the same case, or with the current result."""
        self._second = model
        self._ask_second()
        if model == NO_MODEL:
            self._pin()

    def _ask_second(self) -> None:
        if self._second == NO_MODEL:
            return
        try:
            self._ask(changed(self.case, {"solver": self._second}), "pin")
        except CaseError as error:
            self._complain("solver", str(error.problems[0]))

    def _save_case(self) -> None:
        self.client.send_file_download("case.toml", self.case.to_toml().encode(), save_immediately=True)

    def _keep_result(self) -> None:
        self.client.send_file_download("result.h5", self.run.content(), save_immediately=True)

    def _try(self, deed: Callable[[], None], _: Any) -> None:
        try:
            deed()
        except (UserError, OSError) as error:
            self._message.content = notice(str(error))

    # What comes of it.

    def _arrive(self, number: int, found: Found, reason: str, seconds: float, *, what: str) -> None:
        """Show a result; called from the worker's listener."""
        begun = reason == BEGUN
        with self._wishing:
            case, _ = self._wishes.get(number, (self.case, what))
            for old in [one for one, (_, kind) in self._wishes.items() if one < number + (not begun) and kind == what]:
                self._wishes.pop(old)
        with contextlib.suppress(RuntimeError):
            if found is None:
                if reason:
                    self._message.content = notice(reason)
                return
            try:
                run = Run(received(found), "now", like=self.run)
            except (UserError, OSError) as error:
                if not begun:
                    self._message.content = notice(str(error))
                return
            failed = notice(f"The run failed: {run.reason}") if run.status == "failed" else ""
            self._message.content = failed + _took(case, seconds, begun)
            self._take(run, what)

    def _take(self, run: Run, what: str) -> None:
        with self._lock, self.client.atomic():
            if self._closed:
                run.close()
                return
            if what == "pin":
                old, self.pinned = self.pinned, run
            else:
                turns = self.run.turns(self.playback.frame)
                old, self.run = self.run, run
                self.runs = [run]
                self.playback.follow = run.live
                self.playback.position = float(run.frames - 1 if run.live else run.index_at(turns))
                self.bar.tell(run)
                self.background.show(Wanted(), 0, self.theme)
                self.streak_lines.hide()
                self._follow_flow(Fields(run, self._pool, warm=False))
            self._refresh()
            if old not in (self.run, self.pinned):
                self._drop(old)
        # The picture goes out at once, and does not wait for the numbers.
        self.client.flush()
        with self._lock:
            self._tell()

    def _refresh(self) -> None:
        """Show new data, in the existing scene if it has the same properties."""
        self.charts.runs = [self.run, self.pinned]
        if self._signature(self.run) != self._shape:
            if self.run.case.model != self._shape[-1]:
                self._suit()
            self._build()
        else:
            for actor, run in zip(self.actors, (self.run, self.pinned), strict=True):
                actor.run = run
        self.charts.read_again(self.playback)
        self._beside = 0.0
        self.show()

    def _suit(self) -> None:
        """Show of another model what its own results show at first."""
        usual, playback = opening([self.run]), self.playback
        playback.layers = usual.layers | {"riding": playback.layers["riding"]}
        playback.background = usual.background
        self.panel.suit(self.runs)
        self.panel.take(playback)

    def _drop(self, run: Run) -> None:
        if run is not self.base:
            run.close()


def _took(case: Case, seconds: float, begun: bool) -> str:
    beats = f", {case.time.periods:g} beats" if case.periodic and case.time.periods else ""
    taken = "being computed" if begun else f"{short(1e3 * seconds)} ms"
    return f'<div data-took style="padding:0 4px;font-size:11px">{case.model}{beats}, {taken}</div>'
