"""Who may come in: viser serves whoever reaches its port, so its call of `websockets.serve` gets a door.

As with Jupyter, the address holds a random token, and requests that name another host or come from the page of another
site are refused: a page elsewhere in the user's browser cannot connect, with DNS rebinding or without.

Private to viser: `viser.infra._infra.websockets`, through which it opens its port, and its page's file. A viser without
them does not start, instead of starting open.
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
"""What this machine calls itself."""
EVERYWHERE = frozenset({"", "0.0.0.0", "::"})
"""Addresses that listen on every network of the machine."""
LARGEST = 2**20
"""Bytes of one message from a page."""
MOST = 24
"""Pages connected at a time."""
OPENING_SECONDS = 10.0
"""A connection has so long to ask for something."""
INVITATION_SECONDS = 60.0
"""How long the address that a browser is started with is good for."""

PROTOCOL = f"viser-v{viser.__version__}"
PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
TITLE = "<title>Viser</title>"
# viser shows the address of its socket, token and all, behind that of the page.
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
# What strangers send is no error of ours: it is refused, not printed.
_log.addHandler(logging.NullHandler())
_log.propagate = False


class Door:
    """Decides about every request before viser sees it.

    Args:
        host: the address that the server listens at.
        token: whether the address holds a token, without which nobody comes in.
        head: HTML for the head of the page.

    Attributes:
        refused: how many requests were turned away.
    """

    def __init__(self, host: str, token: bool = True, head: str = "") -> None:
        self.host = host
        self.token = secrets.token_urlsafe(24) if token else ""
        self.refused = 0
        self._invitations: dict[str, float] = {}
        self._page = _page(head)

    @property
    def path(self) -> str:
        """The path of the page: with the token, if there is one."""
        return f"/{self.token}/" if self.token else "/"

    def invite(self) -> str:
        """A path that leads to the page once, soon: the command line of a browser can be read by other users."""
        if not self.token:
            return self.path
        word = secrets.token_urlsafe(24)
        self._invitations[word] = time.monotonic() + INVITATION_SECONDS
        return f"/open/{word}"

    def answer(self, connection: Any, request: Request) -> Response | None:
        """What a request gets: the page, a refusal, or None, which opens a websocket."""
        path = request.path.partition("?")[0].lstrip("/")
        given, _, rest = path.partition("/") if self.token else ("", "", path)
        stranger = self._is_foreign(request.headers)
        if not stranger and self._redeem(given, rest):
            return _say(http.HTTPStatus.SEE_OTHER, "come in", Location=self.path)
        if not stranger and not hmac.compare_digest(given.encode(), self.token.encode()):
            stranger = "the address is not complete: it ends in a token, as printed where the viewer was started"
        if stranger:
            self.refused += 1
            return _say(http.HTTPStatus.FORBIDDEN, stranger)
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return self._open(connection, request.headers)
        if rest.strip("/"):
            return _say(http.HTTPStatus.NOT_FOUND, "there is nothing here")
        kind = {"Content-Type": "text/html; charset=utf-8", "Content-Encoding": "gzip"}
        return Response(200, "OK", Headers(kind | _common(self._page)), self._page)

    def _is_foreign(self, headers: Headers) -> str:
        """Why a request is none of this machine's, if it is not."""
        host, origin = _only(headers.get_all("Host")), headers.get_all("Origin")
        if not self._is_ours(_name(host)):
            return "this viewer is not called that"
        return "" if not origin or _place(_only(origin)) == host else "a page of another site may not look in here"

    @staticmethod
    def _open(connection: Any, headers: Headers) -> Response | None:
        if PROTOCOL not in headers.get("Sec-WebSocket-Protocol", ""):
            return _say(http.HTTPStatus.BAD_REQUEST, "this page is of another version: reload it")
        if len(connection.server.connections) >= MOST:
            return _say(http.HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST} pages look at this already: close one")
        return None

    @contextlib.contextmanager
    def kept(self) -> Iterator[None]:
        """While a `ViserServer` is made in this context, its port gets this door."""
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
            raise RuntimeError("this version of viser opens its port in another way: it would be open to all")

    def _is_ours(self, name: str | None) -> bool:
        """Whether a host is one by which this machine may be called. An address is: what DNS may forge is a name."""
        if name is None:
            return False
        if self.host not in EVERYWHERE:
            return name in LOCAL or name == self.host.lower()
        return name in LOCAL or name == socket.gethostname().lower() or _is_address(name)

    def _redeem(self, given: str, word: str) -> bool:
        return given == "open" and self._invitations.pop(word, 0.0) > time.monotonic()


@functools.cache
def _page(head: str) -> bytes:
    """viser's page, with our title and head, packed once for all."""
    text = PAGE.read_text("utf-8")
    if TITLE not in text:
        raise RuntimeError(f"this version of viser has another page: no {TITLE} in it")
    return gzip.compress(text.replace(TITLE, HEAD + head, 1).encode(), 6, mtime=0)


def _common(body: bytes) -> dict[str, str]:
    return {
        "Content-Length": str(len(body)), "Cache-Control": "no-store", "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        # A notebook on this machine may show the page.
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
