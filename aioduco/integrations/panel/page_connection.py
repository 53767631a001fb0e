"""One connection to the panel's port: how much it may send, and a stop by plain HTTP.

Guarantees:
- A connection that sends more than a page ever does is cut off before its bytes are parsed. Others
  wait for no more of them than one piece of `Allowance`.
- A connection that has not sent its request yet takes a place of which there are few; the oldest
  one makes room. So connections that never ask leave places and descriptors to those that do.
- `POST /stop` is answered on a connection of its own, whatever pages do.
"""

from __future__ import annotations

import asyncio
import http
import json
import logging
import time
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from websockets.asyncio.server import ServerConnection

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable


_log = logging.getLogger("aioduco.integrations.panel")

#: bytes per second that a connection may send, and bytes at once: a page sends 12 kB/s at most
_BYTES: Final = (32_768.0, 65_536.0)
#: messages per second, and at once: a page sends 120/s at most
_MESSAGES: Final = (400.0, 800.0)
#: length of the longest head of a request [bytes]
_LONGEST_HEAD: Final = 16_384
#: number of connections that have not sent their request yet
_MOST_WAITING: Final = 64


class Allowance:
    """How much may come, by a steady rate and at once: a state machine without a clock.

    Args:
        rate: amount per second.
        most: amount at once.
    """

    def __init__(self, rate: float, most: float) -> None:
        self._rate = rate
        self._most = most
        self._left = most
        self._at = 0.0

    def takes(self, amount: float, now: float) -> bool:
        """Whether `amount` may come now [s]; it is deducted then."""
        grown = max(0.0, now - self._at) * self._rate
        self._left, self._at = min(self._most, self._left + grown), max(self._at, now)
        if amount > self._left:
            return False
        self._left -= amount
        return True


class Waiting:
    """The connections that have not sent their request yet."""

    def __init__(self) -> None:
        self._connections: dict[PageConnection, None] = {}  # in the order of their arrival

    def add(self, connection: PageConnection) -> None:
        """Take one more; the oldest one makes room."""
        self._connections[connection] = None
        if len(self._connections) > _MOST_WAITING:
            oldest = next(iter(self._connections))
            self.remove(oldest)
            oldest.transport.abort()

    def remove(self, connection: PageConnection) -> None:
        """It has sent its request, or is gone."""
        self._connections.pop(connection, None)

    def cut_off(self) -> None:
        """End all of them: the server ends, which would wait for their requests."""
        for connection in self._connections:
            connection.transport.abort()


class PlainRequest:
    """The head of a request that opens no WebSocket.

    Args:
        head: its bytes, up to the empty line.

    Attributes:
        method: such as "POST"; empty if the head is none.
        path: the path, without a query.
    """

    def __init__(self, head: bytes) -> None:
        first, *lines = head.decode("latin-1").split("\r\n")
        words = first.split(" ")
        self.method: str = words[0] if len(words) == 3 else ""
        self.path: str = words[1].partition("?")[0] if len(words) == 3 else ""
        self._headers = [line.partition(":")[::2] for line in lines if line]

    def all(self, name: str) -> list[str]:
        """The values of a header."""
        wanted = name.lower()
        return [value.strip() for key, value in self._headers if key.strip().lower() == wanted]


class PageConnection(ServerConnection):
    """A connection to the panel's port.

    Args:
        waiting: the connections without a request; shared by all of a server.
        stop: stops the arm; returns the reason if that failed, else an empty text.
        refusal: the reason why a request from this `Host` and `Origin` is refused; empty if it is
            not.
        options: those of `ServerConnection`.
    """

    def __init__(
        self,
        *args: Any,
        waiting: Waiting,
        stop: Callable[[], Awaitable[str]],
        refusal: Callable[[list[str], list[str]], str],
        **options: Any,
    ) -> None:
        super().__init__(*args, **options)
        self._waiting = waiting
        self._stop_arm = stop
        self._refusal = refusal
        self._bytes = Allowance(*_BYTES)
        self._messages = Allowance(*_MESSAGES)
        self._head: bytearray | None = bytearray()
        self._answering: asyncio.Task[None] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """It is open: it waits for its request."""
        super().connection_made(transport)
        self._waiting.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """It is closed; a stop that it asked for goes on."""
        self._waiting.remove(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Bytes have arrived: those of a WebSocket's client go on, others are answered here."""
        if self._answering is not None:
            return
        if not self._bytes.takes(len(data), time.monotonic()):
            self.cut_off()
            return
        if self._head is None:
            super().data_received(data)
            return
        self._head += data
        head, found, _ = bytes(self._head).partition(b"\r\n\r\n")
        if len(head) > _LONGEST_HEAD:
            self.cut_off()
        elif found:
            self._waiting.remove(self)
            given, self._head = bytes(self._head), None
            if given.startswith(b"GET "):
                super().data_received(given)
            else:
                self._answering = self.loop.create_task(self._answer(PlainRequest(head)))

    def takes_message(self) -> bool:
        """Whether one more message may come now; if not, it is cut off."""
        if self._messages.takes(1.0, time.monotonic()):
            return True
        self.cut_off()
        return False

    def cut_off(self) -> None:
        """End it at once: it sends more than a page does."""
        where = (self.remote_address or ("unknown",))[0]
        _log.info("the panel cut off a connection from %s that sent too much", where)
        self.transport.abort()

    async def _answer(self, request: PlainRequest) -> None:
        """Carry out a request that is not GET."""
        answer = http.HTTPStatus
        refused = self._refusal(request.all("Host"), request.all("Origin"))
        if request.path != "/stop" or request.method != "POST":
            known = request.method and request.method.isalpha()
            status, said = (
                (answer.METHOD_NOT_ALLOWED, "POST /stop stops the arm; all else is GET")
                if known else (answer.BAD_REQUEST, "this is no request of HTTP")
            )  # fmt: skip
        elif refused:
            status, said = answer.FORBIDDEN, refused
        else:
            failed = await asyncio.shield(asyncio.ensure_future(self._stop_arm()))
            status = answer.SERVICE_UNAVAILABLE if failed else answer.OK
            said = failed or "stopped: the arm stands"
        body = json.dumps({"stopped": status is answer.OK, "said": said}).encode() + b"\n"
        head = (
            f"HTTP/1.1 {status.value} {status.phrase}\r\nContent-Type: application/json\r\n"
            f"Content-Length: {len(body)}\r\nAllow: GET, POST\r\nCache-Control: no-store\r\n"
            "X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n"
        )
        if not self.transport.is_closing():
            self.transport.write(head.encode() + body)
            self.transport.close()


def origin_of(text: str) -> str:
    """Host and port of an `Origin`; empty if it is none, such as "null"."""
    try:
        return urlsplit(text).netloc
    except ValueError:
        return ""
