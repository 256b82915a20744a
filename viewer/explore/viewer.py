"""The server of `explore`: one initial case, and one process that computes for all browsers."""

import sys
import threading
import webbrowser
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from taichiflap.case.case import load_case

from .. import camera
from ..frames import Run
from ..server import Server, ViewError, announce
from .change import brief
from .session import ExploreSession
from .worker import BEGUN, ENDED, Found, Worker, received


class Explorer(Server):
    """Serves one case to any number of browsers, each of which changes its own copy.

    Args:
        path: the case file.
        settings: overrides such as `"wing.modes=0"`.
        threads: how many threads to compute with; all if None.
        host, port, token: as of `Viewer`.

    Raises:
        CaseError: when there is no such case.
        ViewError: when there is no such port or address, or the case cannot be computed.
    """

    def __init__(
        self, path: str | Path, settings: Sequence[str] = (), threads: int | None = None,
        host: str = "127.0.0.1", port: int = 8080, token: bool = True,
    ) -> None:  # fmt: skip
        self.case = brief(load_case(path, settings))
        self.command = ["taichiflap", "simulate", str(path), *(f"--set={one}" for one in settings)]
        super().__init__(host, port, token)
        self.worker = Worker(self.case, threads)
        try:
            self.run = self._first_run()
        except BaseException:
            self.worker.close()
            super().stop()
            raise
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="field")
        camera.start(self.server, self.run.box)
        self.serve(self._connect, self._disconnect)

    def stop(self) -> None:
        """Stop the server and the computing process."""
        super().stop()
        for session in self.sessions:
            session.close()
        self.worker.close()
        self._pool.shutdown(wait=True, cancel_futures=True)
        self.run.close()

    def _first_run(self) -> Run:
        """The case as it was opened."""
        there, answers = threading.Event(), []

        def answer(_: int, found: Found, reason: str, __: float) -> None:
            if reason != BEGUN:
                answers.append((found, reason))
                there.set()

        place = self.worker.enlist(answer)
        self.worker.ask(place, self.case)
        while not there.wait(0.2):
            pass
        self.worker.release(place)
        found, reason = answers[0]
        if reason == ENDED:
            raise ViewError("the solver process has ended; run taichiflap simulate to see why")
        if found is None:
            raise ViewError(reason)
        return Run(received(found), "pinned")

    def _connect(self, client: Any) -> None:
        session = ExploreSession(client, self.case, self.command, self.run, self.worker, self._pool)
        if not self._welcome(client, session):
            session.close()
            return
        self._guard(session.start, session.playback)

    def _disconnect(self, client: Any) -> None:
        session = self._take_leave(client)
        if session:
            session.close()


def explore(
    path: str | Path, settings: Sequence[str] = (), *, threads: int | None = None, host: str = "127.0.0.1",
    port: int = 8080, browser: bool = True, token: bool = True,
) -> None:  # pragma: no cover # fmt: skip
    """Explore a case in the browser until interrupted."""
    print("computing the initial case", file=sys.stderr)
    explorer = Explorer(path, settings, threads, host, port, token)
    try:
        announce(explorer, port)
        if browser:
            webbrowser.open(explorer.invitation)
        threading.Event().wait()
    except KeyboardInterrupt:
        print()
    finally:
        explorer.stop()
