"""Serve the panel's page and transport its messages: HTTP and WebSocket on one port.

Guarantees:
- A page of another site gets no connection: its browser names that site, and the server refuses it.
  The picture, a plain stop and the page's own messages are behind the same check, on one port.
- Messages of one page wait for at most one of each other page, and for nothing that is awaited. A
  page that sends more than `page_connection` allows is cut off. The server never waits for a page:
  messages that a slow page does not read are skipped, and one that reads nothing is disconnected.
"""

from __future__ import annotations

import asyncio
import functools
import http
import itertools
import json
import logging
from contextlib import asynccontextmanager
from importlib import resources
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from aioduco.integrations.panel.page_connection import PageConnection, Waiting, origin_of
from aioduco.integrations.panel.page_requests import LONGEST
from aioduco.models.host_port import host_port, is_loopback
from aioduco.models.ranges import LISTEN_PORT

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from websockets.typing import Subprotocol


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
_PICTURE: Final = "/picture"
#: number of pages and pictures that are open at a time
_MOST_OPEN: Final = 200
#: number of connections that are accepted before the loop serves those that are open
_AT_ONCE: Final = 16
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
        stop: stops the arm for a request without a page; returns the reason if that failed.
        picture: transports the picture to a page, until it is closed.

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
        stop: Callable[[], Awaitable[str]],
        picture: Callable[[ServerConnection], Awaitable[None]],
    ) -> None:
        self.host = host
        self.port: int = LISTEN_PORT("listen", port)
        self._hello = hello
        self._take = take
        self._left = left
        self._stop = stop
        self._picture = picture
        self._pictures = 0
        self._opening = asyncio.Lock()
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
        return host_port(*where[:2]) if where else "a page that is gone"

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[None]:
        """Listen until the block exits; pages that are still open are closed then.

        Raises:
            OSError: the port is taken, or the address is not one of this computer.
        """
        waiting = Waiting()
        connection: Any = functools.partial(
            PageConnection, waiting=waiting, stop=self._stop, refusal=self._refusal
        )
        # Messages go many times a second in both directions, so that no pings are needed.
        # Compression would cost more than it saves.
        async with serve(
            self._serve, self.host, self.port, process_request=self._answer, compression=None,
            max_size=LONGEST, max_queue=16, ping_interval=None, close_timeout=0.5, logger=_SILENT,
            create_connection=connection, select_subprotocol=_spoken, backlog=_AT_ONCE,
        ) as server:  # fmt: skip
            address: tuple[str, int] = next(iter(server.sockets)).getsockname()[:2]
            self.port = address[1]
            try:
                yield
            finally:
                waiting.cut_off()

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

    async def _serve(self, connection: ServerConnection) -> None:
        assert connection.request is not None, "the handshake is over"
        if urlsplit(connection.request.path).path != _PICTURE:
            await self._page(connection)
            return
        self._pictures += 1
        try:
            await self._picture(connection)
        finally:
            self._pictures -= 1

    async def _page(self, connection: ServerConnection) -> None:
        page = next(self._numbers)
        async with self._opening:  # one greeting, which is long, a round of the loop
            await asyncio.sleep(0)
        self._pages[page] = connection
        try:
            self._send(page, connection, _text(self._hello(page)))
            async for message in connection:
                if isinstance(connection, PageConnection) and not connection.takes_message():
                    return
                self._take(page, message)
                await asyncio.sleep(0)  # then those of the other pages
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
        path = urlsplit(request.path).path
        upgrade = path in {_SOCKET, _PICTURE}
        origins = request.headers.get_all("Origin")
        refused = self._refusal(request.headers.get_all("Host"), origins)
        if refused:
            _log.warning(
                "the panel refused a request from %s (origin %s): %s",
                (connection.remote_address or ("unknown",))[0], str(origins)[:100], refused,
            )  # fmt: skip
            return _plain(http.HTTPStatus.FORBIDDEN, refused)
        if upgrade and len(self._pages) + self._pictures >= _MOST_OPEN:
            return _plain(http.HTTPStatus.SERVICE_UNAVAILABLE, "too many pages are open")
        if upgrade:
            return None
        if path == _SCENE:
            return _page_of_viser()
        name = _FILES.get(path)
        if name is None:
            return _plain(http.HTTPStatus.NOT_FOUND, "there is no such page")
        return _response(http.HTTPStatus.OK, _file(name), _KINDS[name.rpartition(".")[2]])

    def _refusal(self, hosts: list[str], origins: list[str]) -> str:
        """Why a request from these `Host` and `Origin` headers is refused; empty if it is not."""
        asked = hosts[0] if len(hosts) == 1 else ""
        if is_loopback(self.host) and not _names_loopback(asked):
            # A site's name may resolve to this computer, so that the site is taken for this page.
            return "this panel is for its own computer"
        if len(hosts) != 1 or any(origin_of(origin) != asked for origin in origins):
            return "this is not the panel's own page"
        return ""


def _spoken(connection: ServerConnection, offered: Sequence[Subprotocol]) -> Subprotocol | None:
    """The protocol of the picture's page, which checks that both are of one version."""
    request = connection.request
    if request is None or urlsplit(request.path).path != _PICTURE:
        return None
    return next((each for each in offered if each.startswith("viser-v")), None)


@functools.cache
def _file(name: str) -> bytes:
    return (resources.files("aioduco.integrations.panel") / "page" / name).read_bytes()


def _page_of_viser() -> Response:
    return _response(http.HTTPStatus.OK, _picture_page(), _KINDS["html"], policy=_SHOWN_BY)


@functools.cache
def _picture_page() -> bytes:
    """Viser's page without its control panel, which is empty."""
    client = resources.files("viser") / "client" / "build" / "index.html"
    text = client.read_text(encoding="utf-8")
    folder = resources.files("aioduco.integrations.panel") / "page"
    style, script = ((folder / name).read_text(encoding="utf-8") for name in _ADDED)
    added = f"<style>{style}</style><script>{script}</script>"
    return text.replace("</head>", f"{added}</head>", 1).encode()


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


def _names_loopback(asked: str) -> bool:
    try:
        name = urlsplit(f"//{asked}").hostname or ""
    except ValueError:
        return False
    return is_loopback(name)
