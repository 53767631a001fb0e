"""Serve the panel's page and transport its messages: HTTP and WebSocket on one port.

Guarantees:
- A page of another site gets no connection: its browser names that site, and the server refuses it.
- A message of a page is passed on as soon as it arrives. It waits neither for messages of other
  pages nor for anything that is awaited. The server never waits for a page: messages that a slow
  page does not read are skipped, and a page that reads nothing is disconnected.
"""

from __future__ import annotations

import http
import ipaddress
import itertools
import json
import logging
from contextlib import asynccontextmanager
from importlib import resources
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from websockets.asyncio.server import broadcast, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Response

from aioduco.integrations.panel.page_requests import LONGEST

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request

__all__ = ["PageServer"]

_log = logging.getLogger("aioduco.integrations.panel")

#: logger for websockets: browsers open connections that they do not use, and break off others
_SILENT: Final = logging.Logger("aioduco.integrations.panel.pages", logging.CRITICAL)
#: bytes in a page's send buffer above which further messages to it are skipped
_FULL: Final = 65_536
#: number of skipped messages in a row after which a page is disconnected
_MOST_SKIPPED: Final = 200
_KINDS: Final = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
}
_FILES: Final = {"/": "panel.html", "/panel.css": "panel.css", "/panel.js": "panel.js"}
_SCENE: Final = "/scene"
_SOCKET: Final = "/socket"
#: files that are added to viser's page
_ADDED: Final = ("scene.css", "scene.js")
#: names of this computer, at any port
_HERE: Final = "'self' http://127.0.0.1:* http://localhost:*"
#: No other site may show the panel in a frame and redirect clicks to its buttons.
_OWN: Final = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    f"frame-src {_HERE}; frame-ancestors 'self'"
)
#: The panel shows the 3D picture under the other name of this computer; it has no commands.
_SHOWN_BY: Final = f"frame-ancestors {_HERE}"


class PageServer:
    """Serves the pages of one panel.

    Args:
        host: address of this computer to listen on.
        port: the port; 0 for a free one.
        hello: returns the first message to a page, from its number; called on the event loop.
        take: called with a page's number and each of its messages; it must not block.
        left: called with a page's number after it has disconnected.

    Attributes:
        port: the port that it listens on, while it is listening.
    """

    def __init__(
        self,
        host: str,
        port: int,
        hello: Callable[[int], dict[str, Any]],
        take: Callable[[int, str | bytes], object],
        left: Callable[[int], object],
    ) -> None:
        self.host = host
        self.port: int = port
        self._hello = hello
        self._take = take
        self._left = left
        self._pages: dict[int, ServerConnection] = {}
        self._skipped: dict[int, int] = {}
        self._numbers = itertools.count(1)

    @property
    def pages(self) -> int:
        """Number of open pages."""
        return len(self._pages)

    def address_of(self, page: int) -> str:
        """Address of a page, for the log."""
        connection = self._pages.get(page)
        where = None if connection is None else connection.remote_address
        return f"{where[0]}:{where[1]}" if where else "a page that is gone"

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[None]:
        """Listen until the block exits; pages that are still open are closed then.

        Raises:
            OSError: the port is taken, or the address is not one of this computer.
        """
        # Messages go many times a second in both directions, so that no pings are needed.
        # Compression would cost more than it saves.
        async with serve(
            self._page, self.host, self.port, process_request=self._answer, compression=None,
            max_size=LONGEST, max_queue=64, ping_interval=None, close_timeout=0.5, logger=_SILENT,
        ) as server:  # fmt: skip
            address: tuple[str, int] = next(iter(server.sockets)).getsockname()[:2]
            self.port = address[1]
            yield

    def broadcast(self, message: dict[str, Any]) -> None:
        """Send a message to every page, except pages whose send buffer is full."""
        if not self._pages:
            return
        text = _text(message)
        for page, connection in list(self._pages.items()):
            self._send(page, connection, text)

    def send(self, page: int, message: dict[str, Any]) -> None:
        """Send a message to one page."""
        connection = self._pages.get(page)
        if connection is not None:
            self._send(page, connection, _text(message))

    def _send(self, page: int, connection: ServerConnection, text: str) -> None:
        transport = connection.transport
        if transport.is_closing():
            return
        if transport.get_write_buffer_size() > _FULL:
            self._skipped[page] = self._skipped.get(page, 0) + 1
            if self._skipped[page] > _MOST_SKIPPED:
                transport.abort()
            return
        self._skipped.pop(page, None)
        broadcast([connection], text)  # nothing is awaited

    async def _page(self, connection: ServerConnection) -> None:
        page = next(self._numbers)
        self._pages[page] = connection
        try:
            self._send(page, connection, _text(self._hello(page)))
            async for message in connection:
                self._take(page, message)
        except ConnectionClosed:
            pass  # lost instead of closed: the same for this server
        except Exception:  # an error of this program: websockets' own logger is silent
            _log.exception("a page of the panel was cut off")
            raise
        finally:
            del self._pages[page]
            self._skipped.pop(page, None)
            self._left(page)

    # -- HTTP ------------------------------------------------------------------------------------

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request: accept a WebSocket of this page (None), return a file, or refuse it."""
        named = request.headers.get_all("Host")
        asked = named[0] if len(named) == 1 else ""
        if _is_loopback(self.host) and not _names_loopback(asked):
            # A site's name may resolve to this computer, so that the site is taken for this page.
            return _plain(http.HTTPStatus.FORBIDDEN, "this panel is for its own computer")
        path = urlsplit(request.path).path
        if path == _SOCKET:
            origin = request.headers.get("Origin")
            if origin is not None and urlsplit(origin).netloc != asked:
                _log.warning(
                    "the panel refused a page of another site (%s), from %s",
                    origin[:100], (connection.remote_address or ("unknown",))[0],
                )  # fmt: skip
                return _plain(http.HTTPStatus.FORBIDDEN, "this is not the panel's own page")
            return None
        if path == _SCENE:
            return _page_of_viser()
        name = _FILES.get(path)
        if name is None:
            return _plain(http.HTTPStatus.NOT_FOUND, "there is no such page")
        body = (resources.files("aioduco.integrations.panel") / "page" / name).read_bytes()
        return _response(http.HTTPStatus.OK, body, _KINDS[name.rpartition(".")[2]])


def _page_of_viser() -> Response:
    """Viser's page without its control panel, which is empty."""
    client = resources.files("viser") / "client" / "build" / "index.html"
    text = client.read_text(encoding="utf-8")
    folder = resources.files("aioduco.integrations.panel") / "page"
    style, script = ((folder / name).read_text(encoding="utf-8") for name in _ADDED)
    added = f"<style>{style}</style><script>{script}</script>"
    body = text.replace("</head>", f"{added}</head>", 1).encode()
    return _response(http.HTTPStatus.OK, body, _KINDS["html"], policy=_SHOWN_BY)


def _text(message: dict[str, Any]) -> str:
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


def _plain(status: http.HTTPStatus, text: str) -> Response:
    return _response(status, f"{text}\n".encode(), "text/plain; charset=utf-8")


def _response(status: http.HTTPStatus, body: bytes, kind: str, *, policy: str = _OWN) -> Response:
    headers = Headers()
    headers["Content-Type"] = kind
    headers["Content-Length"] = str(len(body))
    headers["Cache-Control"] = "no-store"
    headers["X-Content-Type-Options"] = "nosniff"
    headers["Referrer-Policy"] = "no-referrer"
    headers["Content-Security-Policy"] = policy
    return Response(status.value, status.phrase, headers, body)


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _names_loopback(asked: str) -> bool:
    try:
        name = urlsplit(f"//{asked}").hostname or ""
    except ValueError:
        return False
    return _is_loopback(name)
