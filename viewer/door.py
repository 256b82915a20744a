"""Access control: viser serves any client of its port, so that its call of `websockets.serve` is wrapped here.

As with Jupyter, the address holds a random token, and requests that name another host or come from another site's page
are refused. Other pages in the user's browser cannot connect, even with DNS rebinding.

It relies on private parts of viser: `viser.infra._infra.websockets`, which opens the port, and the file of its page.
With a viser without them the viewer does not start, so that it is never unprotected.
"""

import contextlib
import functools
import gzip
import hmac
import http
import ipaddress
import logging
import secrets
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit

import viser
from viser.infra import _infra
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from .messages import Connection

LOCAL = frozenset({"localhost", "127.0.0.1", "::1"})
"""Names of this machine."""
EVERYWHERE = frozenset({"", "0.0.0.0", "::"})
"""Addresses that listen on every network of the machine."""
LARGEST = 2**20
"""Maximum size of a message from a page, bytes."""
MOST = 24
"""Maximum number of connected pages."""
OPENING_SECONDS = 10.0
"""Time limit for the first request of a connection, s."""
INVITATION_SECONDS = 60.0
"""Lifetime of the address with which a browser is started, s."""

PROTOCOL = f"viser-v{viser.__version__}"
PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
TITLE = "<title>Viser</title>"
# viser appends the address of its socket, including the token, to that of the page.
HEAD = """<title>taichiflap</title><script>
const replaceState = history.replaceState.bind(history);
history.replaceState = (data, title, url) => {
  const to = new URL(url || location.href, location.href);
  if (to.searchParams.has("websocket")) to.searchParams.delete("websocket");
  replaceState(data, title, to.href);
};
</script>"""

_lock = threading.Lock()
_log = logging.getLogger(__name__)
# Invalid requests are refused without logging.
_log.addHandler(logging.NullHandler())
_log.propagate = False


class Door:
    """Checks every request before viser receives it.

    Args:
        host: address of the server.
        token: whether the address contains a token that is required for access.
        head: HTML for the head of the page.

    Attributes:
        refused: number of refused requests.
    """

    def __init__(self, host: str, token: bool = True, head: str = "") -> None:
        self.host = host
        self.token = secrets.token_urlsafe(24) if token else ""
        self.refused = 0
        self._invitations: dict[str, float] = {}
        self._page = _page(head)

    @property
    def path(self) -> str:
        """Path of the page, with the token if any."""
        return f"/{self.token}/" if self.token else "/"

    def invite(self) -> str:
        """A short-lived path that works only once, since other users can read the command line of a browser."""
        if not self.token:
            return self.path
        word = secrets.token_urlsafe(24)
        self._invitations[word] = time.monotonic() + INVITATION_SECONDS
        return f"/open/{word}"

    def answer(self, connection: Any, request: Request) -> Response | None:
        """Response to a request: the page, a refusal, or None, which opens a websocket."""
        path = request.path.partition("?")[0].lstrip("/")
        given, _, rest = path.partition("/") if self.token else ("", "", path)
        stranger = self._is_foreign(request.headers)
        if not stranger and self._redeem(given, rest):
            return _say(http.HTTPStatus.SEE_OTHER, "come in", Location=self.path)
        if not stranger and not hmac.compare_digest(given.encode(), self.token.encode()):
            stranger = "the address is incomplete: it must end with the token printed when the viewer started"
        if stranger:
            self.refused += 1
            return _say(http.HTTPStatus.FORBIDDEN, stranger)
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return self._open(connection, request.headers)
        if rest.strip("/"):
            return _say(http.HTTPStatus.NOT_FOUND, "no such page")
        kind = {"Content-Type": "text/html; charset=utf-8", "Content-Encoding": "gzip"}
        return Response(200, "OK", Headers(kind | _common(self._page)), self._page)

    def _is_foreign(self, headers: Headers) -> str:
        """Why a request is refused; empty if it is allowed."""
        host, origin = _only(headers.get_all("Host")), headers.get_all("Origin")
        if not self._is_ours(_name(host)):
            return "unknown host name of this viewer; use the printed address"
        return "" if not origin or _place(_only(origin)) == host else "requests from pages of other sites are refused"

    @staticmethod
    def _open(connection: Any, headers: Headers) -> Response | None:
        if PROTOCOL not in headers.get("Sec-WebSocket-Protocol", ""):
            return _say(http.HTTPStatus.BAD_REQUEST, "this page belongs to another version; reload it")
        if len(connection.server.connections) >= MOST:
            return _say(
                http.HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST} pages are connected, which is the limit; close one"
            )
        return None

    @contextlib.contextmanager
    def kept(self) -> Iterator[None]:
        """Context in which the port of a new `ViserServer` gets this access control."""
        real, called = _infra.websockets, []

        def serve(handler: Any, *place: Any, **options: Any) -> Any:
            called.append(place)
            own = {
                "process_request": self.answer, "create_connection": Connection, "max_size": LARGEST,
                "open_timeout": OPENING_SECONDS, "server_header": None, "logger": _log,
            }  # fmt: skip
            return real.asyncio.server.serve(handler, *place, **options | own)

        stand_in = SimpleNamespace(
            asyncio=SimpleNamespace(server=SimpleNamespace(serve=serve, ServerConnection=Connection)),
            exceptions=real.exceptions, datastructures=real.datastructures,
        )  # fmt: skip
        with _lock:
            _infra.websockets = stand_in  # type: ignore[assignment]
            try:
                yield
            finally:
                _infra.websockets = real
        if not called:
            raise RuntimeError(
                "this version of viser opens its port in another way, so that access cannot be controlled; install "
                "the version given in pyproject.toml"
            )

    def _is_ours(self, name: str | None) -> bool:
        """Whether a host name is allowed. Numeric addresses are, since DNS rebinding needs a name."""
        if name is None:
            return False
        if self.host not in EVERYWHERE:
            return name in LOCAL or name == self.host.lower()
        return name in LOCAL or name == socket.gethostname().lower() or _is_address(name)

    def _redeem(self, given: str, word: str) -> bool:
        return given == "open" and self._invitations.pop(word, 0.0) > time.monotonic()


@functools.cache
def _page(head: str) -> bytes:
    """viser's page with our title and head, compressed once."""
    text = PAGE.read_text("utf-8")
    if TITLE not in text:
        raise RuntimeError(
            f"the page of this version of viser has no {TITLE}; install the version given in pyproject.toml"
        )
    return gzip.compress(text.replace(TITLE, HEAD + head, 1).encode(), 6, mtime=0)


def _common(body: bytes) -> dict[str, str]:
    return {
        "Content-Length": str(len(body)), "Cache-Control": "no-store", "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        # Notebooks on this machine may embed the page.
        "Content-Security-Policy": "frame-ancestors 'self' http://localhost:* http://127.0.0.1:*",
    }  # fmt: skip


def _say(status: http.HTTPStatus, text: str, **headers: str) -> Response:
    body = f"{text}\n".encode()
    kind = {"Content-Type": "text/plain; charset=utf-8", "Connection": "close"}
    return Response(int(status), status.phrase, Headers(kind | _common(body) | headers), body)


def _only(values: list[str]) -> str:
    return values[0].lower() if len(values) == 1 else ""


def _name(host: str) -> str | None:
    """The name in a `Host` header, without its port."""
    try:
        return urlsplit(f"//{host}").hostname
    except ValueError:
        return None


def _place(origin: str) -> str:
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return ""


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
