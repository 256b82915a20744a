"""One browser of a result, which can switch to exploring the case of that result and back."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

from taichiflap.case.case import Case
from taichiflap.fluids import known

from ..field import Fields
from ..frames import Run
from ..session import Session, opening
from ..timeline import Playback
from .change import brief
from .session import COMMAND, ExploreSession
from .worker import Worker

EXPLORE, BACK = "Explore this case", "Back to the result"


class Visit:
    """The current view of one browser: the result, or its case with sliders.

    Args:
        client: viser's handle of the browser.
        runs: one result, or two to compare, which have no sliders.
        fields: the flow around the first.
        worker: gives the process that computes what is explored.
        pool: the thread for the flow's pictures.
    """

    def __init__(
        self, client: Any, runs: Sequence[Run], fields: Fields, worker: Callable[[Case], Worker],
        pool: ThreadPoolExecutor,
    ) -> None:  # fmt: skip
        self.client, self.runs, self.fields = client, runs, fields
        self._worker, self._pool = worker, pool
        self._explored: ExploreSession | None = None
        self._turning, self._closed = threading.Lock(), False
        self._result = self._show_result(opening(runs))

    @property
    def session(self) -> Session:
        """What is shown."""
        return self._explored or self._result

    @property
    def playback(self) -> Playback:
        """The browser's position in the result."""
        return self._result.playback

    def start(self, playback: Playback) -> None:
        """Continue the page from here."""
        self.session.start(playback)

    def tick(self, seconds: float) -> None:
        """Play on."""
        self.session.tick(seconds)

    def grow(self) -> None:
        """Check for new frames of the result, or its completion."""
        if self._explored is None:
            self._result.grow()
            self._door.visible = self.may_explore(self.runs)

    def close(self) -> None:
        """Release the resources of this browser."""
        with self._turning:
            self._closed = True
            if self._explored:
                self._explored.close()

    @staticmethod
    def may_explore(runs: Sequence[Run]) -> bool:
        """Whether there are sliders: for one finished result, not for the code of an external model in its file."""
        return len(runs) == 1 and not runs[0].live and known(runs[0].case.solver) is not None

    def _show_result(self, playback: Playback) -> Session:
        shown = Session(self.client, self.runs, playback, self.fields)
        self._door = self.client.gui.add_button(
            EXPLORE,
            order=-20.0,
            visible=self.may_explore(self.runs),
            hint="change the case with sliders, and see the result at once",
        )
        self._door.on_click(lambda _: self._turn(self._explore))
        return shown

    def _turn(self, way: Callable[[], None]) -> None:
        """Go one way, once for all clicks on its button, unless the browser has left."""
        with self._turning:
            if not self._closed and (self._explored is None) == (way == self._explore):
                way()

    def _explore(self) -> None:
        run, dark = self.runs[0], self._result.playback.dark
        case = brief(run.case)
        worker = self._worker(case)
        self._result.leave()
        with self.client.atomic():
            self.client.gui.reset()
            self.client.scene.reset()
            self._explored = ExploreSession(self.client, case, COMMAND, run, worker, self._pool)
            self.client.gui.add_button(BACK, order=-20.0).on_click(lambda _: self._turn(self._return))
        self._explored.start(replace(self._explored.playback, dark=dark))

    def _return(self) -> None:
        assert self._explored is not None
        playback = replace(self._result.playback, dark=self._explored.playback.dark)
        left, self._explored = self._explored, None
        left.close()
        with self.client.atomic():
            self.client.gui.reset()
            self.client.scene.reset()
            self._result = self._show_result(playback)
        self._result.start(playback)
