"""What every viewer's server does: listens at a free port, keeps time for its browsers, and forgives one that left."""

import contextlib
import http.client
import io
import socket
import threading
import time
import warnings
from collections.abc import Callable
from typing import Any

import viser

from taichiflap.errors import UserError

UPDATES = 30
"""Frames a second that a playing browser gets at most."""
PORTS = 100


class ViewError(UserError):
    """The viewer cannot start: one sentence."""


class Server:
    """A viser server with a session for each browser.

    Args:
        host: the address to listen at.
        port: the port to listen at, or the first free one above it.

    Raises:
        ViewError: when there is no such port or address.
    """

    def __init__(self, host: str, port: int) -> None:
        self.host = host
        self._sessions: dict[int, Any] = {}
        self._gone: set[int] = set()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []
        # A browser may leave while its next frame is being drawn.
        warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
        with contextlib.redirect_stdout(io.StringIO()):
            self.server = viser.ViserServer(host=host, port=free_port(host, port), label="taichiflap", verbose=False)
        self.port = self.server.get_port()
        self.server.gui.configure_theme(show_logo=False, show_share_button=False)

    def serve(self, *works: Callable[[], None]) -> None:
        """Keep time for the browsers, and do this besides, until stopped."""
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._play, self._pack_page, *works)]
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
    def sessions(self) -> list[Any]:
        """Those of the browsers that are connected."""
        with self._lock:
            return list(self._sessions.values())

    def _welcome(self, client: Any, session: Any) -> bool:
        """Count a browser in; not one that left while its session was made."""
        with self._lock:
            if client.client_id in self._gone:
                self._gone.remove(client.client_id)
                return False
            self._sessions[client.client_id] = session
            return True

    def _take_leave(self, client: Any) -> Any:
        """Count a browser out; its session, if it had one already."""
        with self._lock:
            session = self._sessions.pop(client.client_id, None)
            if session is None:
                self._gone.add(client.client_id)
            return session

    def stop(self) -> None:
        """Stop serving."""
        self._stop.set()
        for thread in self._threads:
            thread.join()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

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

    @staticmethod
    def _guard(call: Any, *arguments: Any) -> None:
        """A browser may leave, and a file may be in the middle of a write: the next tick will do."""
        try:
            call(*arguments)
        except (RuntimeError, OSError):
            return


def free_port(host: str, port: int) -> int:
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
