"""The viewer's server: opens the files, gives every browser a session, and keeps time for all of them."""

import contextlib
import http.client
import io
import socket
import threading
import time
import uuid
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import viser

from taichiflap import Result, open_result
from taichiflap.errors import UserError
from taichiflap.results import PART, ResultError, part

from . import camera, compare
from .colours import theme
from .field import Fields
from .frames import Run
from .scene import set_up
from .session import Session, opening
from .timeline import Playback

UPDATES = 30
"""Frames a second that a playing browser gets at most."""
LOOK_SECONDS = 0.25
"""How often a file that is being written is looked at."""
BEGIN_SECONDS = 15.0
"""A file that holds no frame so long after it was last touched will hold none."""
FORGET_SECONDS = 600.0
"""How long the place of a browser whose connection dropped is kept."""
BROWSER = "taichiflap-browser"
PORTS = 100


class ViewError(UserError):
    """The viewer cannot start: one sentence."""


class Viewer:
    """Serves one result, or two compared, to any number of browsers.

    Args:
        paths: result files, complete or still being written.
        host: the address to listen at; the default is this machine only.
        port: the port to listen at, or the first free one above it.

    Raises:
        ViewError: when there is no such port or address, or too many files.
        ResultError: when a file cannot be read.
    """

    def __init__(self, paths: Sequence[str | Path], host: str = "127.0.0.1", port: int = 8080) -> None:
        if not 1 <= len(paths) <= 2:
            raise ViewError(f"view shows one result, or two compared, not {len(paths)}")
        files = [Path(path) for path in paths]
        self.port = _free_port(host, port)
        self.host = host
        self.runs = [Run(_open(path), label) for path, label in zip(files, _labels(files), strict=True)]
        self._fields = Fields(self.runs[0])
        self._sessions: dict[int, Session] = {}
        self._dropped: dict[str, list[tuple[float, Playback]]] = {}
        self._browsers: dict[int, str] = {}
        self._lock = threading.Lock()
        self._stop = threading.Event()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server = viser.ViserServer(host=host, port=self.port, label="taichiflap", verbose=False)
        self.port = self.server.get_port()
        self.server.gui.configure_theme(show_logo=False, show_share_button=False)
        camera.start(self.server, self.runs[0].box)
        # A page shows this from the start, until its own session takes over.
        self._set_backdrop()
        self.server.on_client_connect(self._connect)
        self.server.on_client_disconnect(self._disconnect)
        works = self._play, self._follow, self._pack_page
        self._threads = [threading.Thread(target=work, daemon=True) for work in works]
        for thread in self._threads:
            thread.start()

    @property
    def address(self) -> str:
        """Where to point a browser."""
        return f"http://{self._near_host}:{self.port}"

    @property
    def _near_host(self) -> str:
        """The host as this machine calls it."""
        return "localhost" if self.host in ("0.0.0.0", "::") else self.host

    @property
    def sessions(self) -> list[Session]:
        """Those of the browsers that are connected."""
        with self._lock:
            return list(self._sessions.values())

    def stop(self) -> None:
        """Stop serving and close the files."""
        self._stop.set()
        for thread in self._threads:
            thread.join()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()
        self._fields.close()
        for run in self.runs:
            run.close()

    def _set_backdrop(self) -> None:
        self.server.scene.reset()
        _, actors = set_up(self.server.scene, self.runs, theme(False))
        for actor in actors:
            actor.show(actor.run.frames - 1, opening(self.runs).layers)

    def _connect(self, client: Any) -> None:
        session = Session(client, self.runs, opening(self.runs), self._fields)
        with self._lock:
            self._sessions[client.client_id] = session
        # The answer comes when the page has worked its way through what was sent until now.
        browser = _browser(client)
        with self._lock:
            self._browsers[client.client_id] = browser
            places = self._dropped.pop(browser, [])
            recent = [place for place in places if time.monotonic() - place[0] < FORGET_SECONDS]
            playback = recent.pop()[1] if recent else session.playback
            if recent:
                self._dropped[browser] = recent
        self._guard(session.start, playback)

    def _disconnect(self, client: Any) -> None:
        with self._lock:
            session = self._sessions.pop(client.client_id, None)
            browser = self._browsers.pop(client.client_id, None)
            if session and browser:
                self._dropped.setdefault(browser, []).append((time.monotonic(), session.playback))

    def _pack_page(self) -> None:
        """Have viser compress its page now: it does that for the first who asks, who then waits."""
        page = http.client.HTTPConnection(self._near_host, self.port)
        with contextlib.suppress(OSError, http.client.HTTPException), contextlib.closing(page):
            page.request("GET", "/", headers={"Accept-Encoding": "gzip"})
            page.getresponse().read()

    def _play(self) -> None:
        before = time.monotonic()
        while not self._stop.wait(max(0.0, before + 1.0 / UPDATES - time.monotonic())):
            now = time.monotonic()
            for session in self.sessions:
                self._guard(session.tick, now - before)
            before = now

    def _follow(self) -> None:
        while any(run.live for run in self.runs) and not self._stop.wait(LOOK_SECONDS):
            surveys = [run.surveys for run in self.runs]
            grown = [run.refresh() for run in self.runs if run.live]
            if surveys != [run.surveys for run in self.runs]:
                self._guard(self._set_backdrop)
            if any(grown):
                for session in self.sessions:
                    self._guard(session.grow)

    @staticmethod
    def _guard(call: Any, *arguments: Any) -> None:
        """A browser may leave, and a file may be in the middle of a write: the next tick will do."""
        try:
            call(*arguments)
        except (RuntimeError, OSError):
            return


def _browser(client: Any) -> str:
    """What tells one browser from another when it comes back: a name that it keeps for us."""
    try:
        known = client.local_storage.get_item(BROWSER, timeout=2.0)
        if not known:
            known = uuid.uuid4().hex
            client.local_storage.set_item(BROWSER, known)
    except (RuntimeError, TimeoutError):
        return uuid.uuid4().hex
    return str(known)


def _open(path: Path) -> Result:
    """Open a file, waiting for its first frame if it has just been begun."""
    while True:
        try:
            result = open_result(path)
            if result.frames or result.status != "running":
                return result
            result.close()
            problem = ResultError(f"{path}: holds no frame yet")
        except ResultError as error:
            problem = error
        begun = path if path.name.endswith(PART) else part(path)
        final = path.with_name(path.name.removesuffix(PART))
        if not begun.exists() and final != path and final.exists():
            path = final
        elif not begun.exists() or time.time() - begun.stat().st_mtime > BEGIN_SECONDS:
            raise problem
        time.sleep(0.1)


def _labels(paths: Sequence[Path]) -> list[str]:
    names = [path.name.removesuffix(PART).removesuffix(".h5") for path in paths]
    return names if len(set(names)) == len(names) else [str(path) for path in paths]


def _free_port(host: str, port: int) -> int:
    """The first port from `port` on that nobody listens at."""
    if not 1 <= port <= 65535:
        raise ViewError(f"no such port: {port}")
    problem = ""
    for candidate in range(port, min(port + PORTS, 65536)):
        try:
            with socket.create_server((host, candidate)):
                return candidate
        except OSError as error:
            problem = str(error.strerror)
    raise ViewError(f"cannot listen at {host}, port {port} or the next {PORTS}: {problem}")


def view(
    paths: Sequence[str | Path], *, host: str = "127.0.0.1", port: int = 8080, browser: bool = True
) -> None:  # pragma: no cover
    """Show one result, or two compared, until interrupted.

    Args:
        host: the address to listen at; the default is this machine only.
        port: the port to listen at, or the first free one above it.
        browser: open the system's browser, where there is one.
    """
    viewer = Viewer(paths, host, port)
    try:
        if len(viewer.runs) == 2:
            print("\n".join(compare.text(*viewer.runs)))
        if viewer.port != port:
            print(f"port {port} is taken")
        print(f"{viewer.address}  (Ctrl-C stops)", flush=True)
        if browser:
            webbrowser.open(viewer.address)
        threading.Event().wait()
    except KeyboardInterrupt:
        print()
    finally:
        viewer.stop()
