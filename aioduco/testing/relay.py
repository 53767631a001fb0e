"""One connection through a proxy: requests one way, replies the other, faults in between."""

from __future__ import annotations

import contextlib
import errno
import math
import os
import socket
import struct
from collections import deque
from typing import TYPE_CHECKING

import anyio

from aioduco._wire.framing import Malformed
from aioduco._wire.messages import Inbox, Message, application_error
from aioduco.testing.faults import (
    ApplicationError,
    Cut,
    Delay,
    DropReply,
    DropRequest,
    Ending,
    Fault,
    HalfOpen,
    HoldReply,
    Place,
    Script,
    Throttle,
    rewritten,
)

if TYPE_CHECKING:
    import random
    from collections.abc import Awaitable, Callable

    from aioduco.testing.records import Records


_CHUNK = 1 << 16


class AwaitedSocket:
    """A non-blocking socket with asynchronous methods.

    It uses a plain socket and not anyio's streams, since those send a FIN before they close: the
    other side would never see a reset.
    """

    def __init__(self, sock: socket.socket) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket = sock
        self._sending = anyio.Lock(fast_acquire=True)

    @classmethod
    async def connect(cls, host: str, port: int) -> AwaitedSocket:
        """Connect to a host given by its address.

        Raises:
            OSError: no server listens there.
        """
        with contextlib.ExitStack() as stack:
            sock = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_STREAM))
            endpoint = cls(sock)
            code = sock.connect_ex((host, port))
            if code == errno.EINPROGRESS:
                await anyio.wait_writable(sock)
                code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
            if code:
                raise OSError(code, os.strerror(code))
            stack.pop_all()
        return endpoint

    async def receive(self) -> bytes:
        """Receive the next bytes; empty when the other side has sent its FIN or a reset."""
        while True:
            try:
                return self._socket.recv(_CHUNK)
            except BlockingIOError:
                await anyio.wait_readable(self._socket)
            except OSError:
                return b""

    async def send(self, data: bytes) -> None:
        """Send all data in one piece, even if several tasks send at the same time.

        Raises:
            OSError: the other side has closed.
        """
        rest = memoryview(data)
        async with self._sending:
            while rest:
                try:
                    rest = rest[self._socket.send(rest) :]
                except BlockingIOError:
                    await anyio.wait_writable(self._socket)

    def end_sending(self) -> None:
        """Send a FIN: no more will come."""
        with contextlib.suppress(OSError):  # it has ended already
            self._socket.shutdown(socket.SHUT_WR)

    def close(self, how: Ending) -> None:
        """Close the socket. No task may be waiting on it any more."""
        if how is Ending.RESET:
            linger = struct.pack("ii", 1, 0)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        self._socket.close()


#: time between two slices of a throttled sender [s]
_SLICE = 0.002


class Valve:
    """A valve, open or closed; while it is closed, nothing passes."""

    def __init__(self) -> None:
        self._opened = anyio.Event()
        self._opened.set()

    def open(self) -> None:
        """Open it; what waits passes."""
        self._opened.set()

    def close(self) -> None:
        """Close it; nothing passes."""
        if self._opened.is_set():
            self._opened = anyio.Event()

    async def passed(self) -> None:
        """Wait until it is open."""
        await self._opened.wait()


class Relay:
    """Forwards the messages of one connection, with the faults of the script.

    Each direction is a task, so that a reply does not wait for a request that is held back.
    Answers of the proxy itself keep the order of the calls, which a client may send ahead.

    Invariants: whatever ends the relay, both sockets are closed in `run`, after both tasks have
    ended, and nowhere else; a call is added to `_waiting` before its request is sent to the
    server, so a reply always finds its call.
    """

    def __init__(
        self,
        client: AwaitedSocket,
        upstream: tuple[str, int],
        *,
        script: Script,
        records: Records,
        valve: Valve,
        jitter: random.Random,
    ) -> None:
        self._client = client
        self._upstream = upstream
        self._script = script
        self._records = records
        self._valve = valve
        self._own_valve = Valve()
        self._jitter = jitter
        self._index = records.connected()
        self._scope = anyio.CancelScope()
        self._how = Ending.CLOSE
        self._ended_by: str | None = None
        #: calls that are not answered yet, oldest first
        self._waiting: deque[tuple[int, Fault | None]] = deque()
        #: answers of the proxy itself to some of them
        self._own: dict[int, bytes] = {}
        self._held: list[bytes] = []
        self._ended = anyio.Event()

    async def wait(self) -> None:
        """Wait until the connection has ended."""
        await self._ended.wait()

    def cut(self, how: Ending, ended_by: str = "proxy") -> None:
        """End the connection on both sides at once, whatever state it is in."""
        if self._ended_by is None:
            self._ended_by = ended_by
        self._how = how
        self._scope.cancel()

    async def run(self) -> None:
        """Forward messages until the connection has ended."""
        server: AwaitedSocket | None = None
        try:
            with self._scope:
                server = await AwaitedSocket.connect(*self._upstream)
                self._server = server
                async with anyio.create_task_group() as group:
                    group.start_soon(self._pump, self._client, self._request, server, "client")
                    group.start_soon(self._pump, server, self._reply, self._client, "server")
        except OSError:
            self._how, self._ended_by = Ending.RESET, "server"
        finally:
            for endpoint in (self._client, server):
                if endpoint is not None:
                    endpoint.close(self._how)
            self._records.disconnected(self._index, self._ended_by or "proxy")
            self._ended.set()

    async def _pump(
        self,
        source: AwaitedSocket,
        handle: Callable[[Message], Awaitable[None]],
        sink: AwaitedSocket,
        name: str,
    ) -> None:
        """Handle one side's messages until it sends no more; then send a FIN to the other side."""
        inbox = Inbox()
        readable = True
        try:
            while data := await source.receive():
                if not readable:
                    await self._send(sink, data)
                    continue
                try:
                    for message in inbox.messages(data):
                        await handle(message)
                except Malformed:
                    # the proxy does not reject it: it forwards this and all that follows unchanged
                    readable = False
                    await self._send(sink, inbox.pending)
            await self._valve.passed()
            await self._own_valve.passed()
        except OSError:
            # the sink has closed: data from the source are lost
            self.cut(Ending.CLOSE, "server" if name == "client" else "client")
            return
        if self._ended_by is None:
            self._ended_by = name
        sink.end_sending()

    async def _request(self, request: Message) -> None:
        fault = self._script.decide(request.name)
        call = self._records.called(self._index, request, fault)
        data = request.encode()
        if self._held:
            held, self._held = b"".join(self._held), []
            await self._send(self._client, held)
        match fault:
            case DropRequest():
                return
            case Delay(request=seconds, jitter=jitter) if seconds:
                await anyio.sleep(seconds + jitter * self._jitter.random())
            case HalfOpen(seconds):
                self._own_valve.close()
                await anyio.sleep(math.inf if seconds is None else seconds)
                await self._cut(Ending.RESET)
            case ApplicationError(code, message, forward=False):
                self._own[call] = application_error(request, code, message).encode()
                self._waiting.append((call, fault))
                await self._answer()
                return
            case Cut(Place.BEFORE_REQUEST, how):
                await self._cut(how)
            case Cut(Place.IN_REQUEST, how, fraction):
                await self._send(self._server, _part(data, fraction))
                await self._cut(how)
            case _:
                pass
        self._waiting.append((call, fault))
        await self._send(self._server, data, fault.rate if isinstance(fault, Throttle) else None)
        self._records.note(call, "forwarded")
        if isinstance(fault, Cut) and fault.at is Place.AFTER_REQUEST:
            await self._cut(fault.how)

    async def _answer(self) -> None:
        """Send the proxy's own answers to the calls that are now the oldest."""
        while self._waiting and (data := self._own.pop(self._waiting[0][0], None)) is not None:
            call, _ = self._waiting.popleft()
            await self._send(self._client, data)
            self._records.note(call, "answered")

    async def _reply(self, reply: Message) -> None:
        await self._pass(reply)
        await self._answer()

    async def _pass(self, reply: Message) -> None:
        if not self._waiting:  # no call waits for it: forward it
            await self._send(self._client, reply.encode())
            return
        call, fault = self._waiting.popleft()
        self._records.note(call, "replied")
        data = rewritten(fault, reply)
        match fault:
            case DropReply():
                return
            case HoldReply():
                self._held.append(data)
                return
            case Delay(reply=seconds, jitter=jitter) if seconds:
                await anyio.sleep(seconds + jitter * self._jitter.random())
            case Cut(Place.BEFORE_REPLY, how):
                await self._cut(how)
            case Cut(Place.IN_REPLY, how, fraction):
                await self._send(self._client, _part(data, fraction))
                await self._cut(how)
            case _:
                pass
        await self._send(self._client, data, fault.rate if isinstance(fault, Throttle) else None)
        self._records.note(call, "answered")
        if isinstance(fault, Cut) and fault.at is Place.AFTER_REPLY:
            await self._cut(fault.how)

    async def _send(self, sink: AwaitedSocket, data: bytes, rate: float | None = None) -> None:
        await self._valve.passed()
        await self._own_valve.passed()
        if rate is None:
            await sink.send(data)
            return
        step = max(1, int(rate * _SLICE))
        start = anyio.current_time()
        for at in range(0, len(data), step):
            await anyio.sleep_until(start + min(at + step, len(data)) / rate)
            await sink.send(data[at : at + step])

    async def _cut(self, how: Ending) -> None:
        """End the connection; does not return."""
        self.cut(how, "fault")
        await anyio.sleep_forever()


def _part(data: bytes, fraction: float) -> bytes:
    """A share of the message: at least one byte, but never all of it."""
    return data[: min(max(1, int(len(data) * fraction)), len(data) - 1)]
