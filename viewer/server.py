"""Common part of all viewer servers: finds a free port, runs the playback of browsers, and handles disconnections."""

import contextlib
import io
import socket
import struct
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable
from html import escape
from typing import Any

import viser
from viser import _messages

from taichiflap.errors import UserError

from . import messages
from .bar import HEAD
from .door import EVERYWHERE, LOCAL, Door

UPDATES = 30
"""Maximum frames per second during playback."""
PORTS = 100
UNBUILT = "This page cannot be shown; the terminal that runs the viewer says why."


class ViewError(UserError):
    """Raised if the viewer cannot start; one sentence."""


class Server:
    """A viser server with a session for each browser.

    Args:
        host: the address to listen at.
        port: the port to listen at, or the first free one above it.
        token: whether the address contains a token that is required for access.

    Raises:
        ViewError: if the port or address is not available.
    """

    def __init__(self, host: str, port: int, token: bool = True) -> None:
        self.host = host
        self.door = Door(host, token, HEAD)
        self._sessions: dict[int, Any] = {}
        self._gone: set[int] = set()
        self._printed: set[str] = set()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []
        # A browser may disconnect while its next frame is drawn.
        warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
        free = free_port(host, port)
        with self.door.kept(), contextlib.redirect_stdout(io.StringIO()):
            self.server = viser.ViserServer(host=host, port=free, label="taichiflap", verbose=False)
        # These messages are refused by the door and have no handler.
        for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
            self.server._websock_server.unregister_handler(kind)
        self.port = self.server.get_port()
        self.server.gui.configure_theme(show_logo=False, show_share_button=False)

    def serve(
        self, connect: Callable[[Any], None], disconnect: Callable[[Any], None], *works: Callable[[], None]
    ) -> None:
        """Serve browsers and run their playback, with other work in between, until stopped."""

        def enter(client: Any) -> None:
            messages.guard(client.gui)
            try:
                connect(client)
            except (UserError, OSError) as error:
                # The file has been deleted.
                with contextlib.suppress(RuntimeError):
                    client.gui.add_html(notice(str(error)))
            except Exception:
                with contextlib.suppress(RuntimeError):
                    client.gui.add_html(notice(UNBUILT))
                raise

        self.server.on_client_connect(enter)
        self.server.on_client_disconnect(disconnect)
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._play, *works)]
        for thread in self._threads:
            thread.start()

    @property
    def address(self) -> str:
        """Address for a browser on this machine."""
        return f"{self._root('127.0.0.1' if self.host in EVERYWHERE else self.host)}{self.door.path}"

    @property
    def invitation(self) -> str:
        """A short-lived address that works only once, since other users can read the command line of a browser."""
        return self.address.removesuffix(self.door.path) + self.door.invite()

    @property
    def far_addresses(self) -> list[str]:
        """Addresses for browsers on other machines; empty if only this machine has access."""
        if self.host in LOCAL:
            return []
        hosts = own_addresses() if self.host in EVERYWHERE else [self.host]
        return [f"{self._root(host)}{self.door.path}" for host in hosts]

    def _root(self, host: str) -> str:
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}"

    @property
    def sessions(self) -> list[Any]:
        """Sessions of connected browsers."""
        with self._lock:
            return list(self._sessions.values())

    def _welcome(self, client: Any, session: Any) -> bool:
        """Add a browser, unless it disconnected while its session was created."""
        with self._lock:
            if client.client_id in self._gone:
                self._gone.remove(client.client_id)
                return False
            self._sessions[client.client_id] = session
            return True

    def _take_leave(self, client: Any) -> Any:
        """Remove a browser; returns its session, if any."""
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

    def _play(self) -> None:
        before = time.monotonic()
        while not self._stop.wait(max(0.0, before + 1.0 / UPDATES - time.monotonic())):
            now = time.monotonic()
            for session in self.sessions:
                self._guard(session.tick, now - before)
            before = now

    def _guard(self, call: Any, *arguments: Any) -> None:
        """Call something for one browser, whose errors are not those of the others.

        Errors of a disconnected browser or of a file in the middle of a write are ignored until the next tick; any
        other is printed once.
        """
        try:
            call(*arguments)
        except (RuntimeError, OSError):
            return
        except Exception:
            text = traceback.format_exc()
            if text not in self._printed:
                self._printed.add(text)
                print(text, file=sys.stderr)


def announce(server: Server, port: int) -> None:
    """Print the address of a server, and warn if other machines can reach it.

    Args:
        port: requested port.
    """
    if server.port != port:
        print(f"port {port} is taken")
    for address in server.far_addresses:
        print(address)
    if server.far_addresses:
        whoever = "everyone with its address" if server.door.token else "anybody"
        print(f"warning: other machines can reach this viewer; {whoever} can see its content", file=sys.stderr)
    print(f"{server.address}  (Ctrl-C stops)", flush=True)


def notice(text: str) -> str:
    """A highlighted sentence, as HTML."""
    style = "margin:4px;padding:6px;border:1px solid #c81e2d;border-radius:4px;font-size:13px;overflow-wrap:anywhere"
    return f'<div data-notice role="alert" style="{style}">{escape(text)}</div>' if text else ""


def own_addresses() -> list[str]:
    """Addresses of this machine's networks, or else its name."""
    found = []
    if sys.platform == "linux":
        import fcntl  # noqa: PLC0415 - not everywhere

        ask = 0x8915  # SIOCGIFADDR
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
            for _, name in socket.if_nameindex():
                with contextlib.suppress(OSError):
                    answer = fcntl.ioctl(any_socket.fileno(), ask, struct.pack("256s", name.encode()[:15]))
                    found.append(socket.inet_ntoa(answer[20:24]))
    return [one for one in found if not one.startswith("127.")] or [socket.gethostname()]


def free_port(host: str, port: int) -> int:
    """The first free port, starting at `port`."""
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
