"""The viewer of results: opens files and gives every browser a session."""

import contextlib
import threading
import time
import uuid
import webbrowser
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from taichiflap import Result, open_result
from taichiflap.case.case import Case
from taichiflap.maps.file import is_map
from taichiflap.notation import printable
from taichiflap.results.reader import PART, ResultError, part

from . import camera, compare
from .colours import theme
from .explore.visit import Visit
from .explore.worker import Worker
from .field import Fields
from .frames import Run
from .server import Server, ViewError, announce
from .session import opening
from .stage import set_up
from .timeline import Playback

LOOK_SECONDS = 0.25
"""Interval at which a growing file is checked, s."""
BEGIN_SECONDS = 15.0
"""Age, s, after which a file without frames is given up."""
FORGET_SECONDS = 600.0
"""Time for which the state of a disconnected browser is kept, s."""
BROWSER = "taichiflap-browser"


class Viewer(Server):
    """Serves one result, or a comparison of two, to any number of browsers.

    Args:
        paths: result files, complete or still being written.
        host: the address to listen at; the default is this machine only.
        port: the port to listen at, or the first free one above it.
        token: whether the address contains a token that is required for access.

    Raises:
        ViewError: if the port or address is not available, or for too many files.
        ResultError: if a file cannot be read.
    """

    def __init__(
        self, paths: Sequence[str | Path], host: str = "127.0.0.1", port: int = 8080, token: bool = True
    ) -> None:
        if not 1 <= len(paths) <= 2:
            raise ViewError(f"view shows one result, or two compared, not {len(paths)}")
        files = [Path(path) for path in paths]
        self.runs = [Run(_open(path), label) for path, label in zip(files, _labels(files), strict=True)]
        super().__init__(host, port, token)
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="field")
        self._fields = Fields(self.runs[0], self._pool)
        self._worker: Worker | None = None
        self._dropped: dict[str, list[tuple[float, Playback]]] = {}
        self._browsers: dict[int, str] = {}
        camera.start(self.server, self.runs[0].box)
        # Shown by a page until its own session starts.
        self._set_backdrop()
        self.serve(self._connect, self._disconnect, self._follow)

    def stop(self) -> None:
        """Stop serving and close the files."""
        super().stop()
        for session in self.sessions:
            session.close()
        if self._worker:
            self._worker.close()
        self._pool.shutdown(wait=True, cancel_futures=True)
        for run in self.runs:
            run.close()

    def _set_backdrop(self) -> None:
        self.server.scene.reset()
        _, actors = set_up(self.server.scene, self.runs, theme(False))
        for actor in actors:
            actor.show(actor.run.frames - 1, opening(self.runs).layers)

    def _connect(self, client: Any) -> None:
        session = Visit(client, self.runs, self._fields, self._explorer, self._pool)
        if not self._welcome(client, session):
            return
        # The answer arrives when the page has processed all messages sent so far.
        browser = _browser(client)
        with self._lock:
            if client.client_id not in self._sessions:
                return
            self._browsers[client.client_id] = browser
            self._forget()
            recent = self._dropped.pop(browser, [])
            playback = recent.pop()[1] if recent else session.playback
            if recent:
                self._dropped[browser] = recent
        self._guard(session.start, playback)

    def _explorer(self, case: Case) -> Worker:
        """The process that computes explored cases; it starts with the first browser that explores."""
        with self._lock:
            if self._worker is None or not self._worker.alive:
                self._worker = Worker(case)
            return self._worker

    def _forget(self) -> None:
        """Delete the states of browsers that have been disconnected for too long."""
        now = time.monotonic()
        for browser, places in list(self._dropped.items()):
            recent = [place for place in places if now - place[0] < FORGET_SECONDS]
            if recent:
                self._dropped[browser] = recent
            else:
                del self._dropped[browser]

    def _disconnect(self, client: Any) -> None:
        session = self._take_leave(client)
        if session:
            session.close()
        with self._lock:
            browser = self._browsers.pop(client.client_id, None)
            if session and browser:
                self._dropped.setdefault(browser, []).append((time.monotonic(), session.playback))

    def _follow(self) -> None:
        while not self._stop.wait(LOOK_SECONDS):
            surveys = [run.surveys for run in self.runs]
            grown = [run.refresh() for run in self.runs]
            if surveys != [run.surveys for run in self.runs]:
                self._guard(self._set_backdrop)
            if any(grown):
                for session in self.sessions:
                    self._guard(session.grow)


def _browser(client: Any) -> str:
    """Identifier that a browser stores, to recognise it when it reconnects."""
    try:
        known = client.local_storage.get_item(BROWSER, timeout=2.0)
        if not known:
            known = uuid.uuid4().hex
            client.local_storage.set_item(BROWSER, known)
    except (RuntimeError, TimeoutError):
        return uuid.uuid4().hex
    return str(known)[:32]


def _open(path: Path) -> Result:
    """Open a file, waiting for its first frame if the run has just started."""
    while True:
        try:
            result = open_result(path)
            if result.frames or result.status != "running":
                return result
            result.close()
            problem = ResultError(f"{path}: has no frame yet")
        except ResultError as error:
            problem = error
        begun = path if path.name.endswith(PART) else part(path)
        final = path.with_name(path.name.removesuffix(PART))
        age = _age(begun)
        if age is None and final != path and _age(final) is not None:
            path = final
        elif age is None or age > BEGIN_SECONDS:
            raise problem
        time.sleep(0.1)


def _age(path: Path) -> float | None:
    """Time since a file's last change, s; None without one, which may be renamed at any moment."""
    with contextlib.suppress(OSError, ValueError):
        return time.time() - path.stat().st_mtime
    return None


def _labels(paths: Sequence[Path]) -> list[str]:
    names = [printable(path.name.removesuffix(PART).removesuffix(".h5")) for path in paths]
    return names if len(set(names)) == len(names) else [printable(str(path)) for path in paths]


def view(
    paths: Sequence[str | Path],
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    browser: bool = True,
    token: bool = True,
    trust: bool = False,
) -> None:  # pragma: no cover
    """Show one result, a comparison of two, or a map, until interrupted.

    Args:
        host: the address to listen at; the default is this machine only.
        port: the port to listen at, or the first free one above it.
        browser: open the system's browser, if any.
        token: whether the address contains a token that is required for access.
        trust: allow cases of a map to run an external fluid model.
    """
    viewer: Server
    if len(paths) == 1 and is_map(Path(paths[0])):
        from .maps.viewer import MapViewer  # noqa: PLC0415 - a result does without

        viewer = MapViewer(paths[0], host, port, token=token, trust=trust)
    else:
        viewer = Viewer(paths, host, port, token)
    try:
        if isinstance(viewer, Viewer) and len(viewer.runs) == 2:
            print("\n".join(compare.text(*viewer.runs)))
        announce(viewer, port)
        if browser:
            webbrowser.open(viewer.invitation)
        threading.Event().wait()
    except KeyboardInterrupt:
        print()
    finally:
        viewer.stop()
