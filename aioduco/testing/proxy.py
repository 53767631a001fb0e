"""A TCP proxy between a client and a controller that applies faults chosen by a test."""

from __future__ import annotations

import random
import socket
from contextlib import ExitStack
from typing import TYPE_CHECKING, Self

import anyio
from anyio.from_thread import start_blocking_portal

from aioduco.models.ranges import PORT
from aioduco.testing.faults import Ending, Script
from aioduco.testing.records import CallRecord, ConnectionRecord, ProxyStatistics, Records
from aioduco.testing.relay import AwaitedSocket, Relay, Valve

if TYPE_CHECKING:
    from anyio.abc import TaskGroup, TaskStatus

_HOST = "127.0.0.1"
#: seconds in which no client is accepted after descriptors or memory ran out
_REST = 0.1


class FaultProxy(Script):
    """Stands between a client and a controller, and applies prepared faults to its calls.

        with FaultProxy("127.0.0.1", simulator.port) as proxy:
            proxy.on("movej2", Cut(Place.BEFORE_REPLY))
            ...                                  # connect to proxy.host, proxy.port
            assert proxy.calls("movej2")[0].forwarded is not None

    It runs on an event loop in a thread of its own. So the same proxy serves tests of plain
    threads and of coroutines, and it continues while the event loop under test is blocked, which
    is one of the cases to be tested. All methods may be called from any thread; those that must
    wait for the proxy's thread wait for less than a thread switch takes.

    Attributes:
        host: address on which it listens; always loopback.
        port: free port on which it listens; it stays the same while connections are refused.
    """

    def __init__(self, upstream_host: str, upstream_port: int, *, seed: int = 0) -> None:
        """Make a proxy; `with` starts it.

        Args:
            upstream_host: numeric address of the controller.
            upstream_port: its TCP port.
            seed: seed of the jitter of delays.
        """
        super().__init__()
        self.host = _HOST
        self.port: int = 0
        self._upstream = (upstream_host, PORT("upstream_port", upstream_port))
        self._records = Records()
        self._random = random.Random(seed)
        self._relays: set[Relay] = set()
        self._stack = ExitStack()
        self._running = False

    def __enter__(self) -> Self:
        if self._running:
            raise RuntimeError("this proxy is running already")
        with ExitStack() as stack:
            # A socket that is bound but does not listen keeps the port while new connections
            # are refused: no other program can take the port before the listener comes back.
            self._reserve = stack.enter_context(_bound(0))
            self.port = self._reserve.getsockname()[1]
            self._portal = stack.enter_context(start_blocking_portal("asyncio"))
            future, _ = self._portal.start_task(self._serve)
            stack.callback(future.result)
            stack.callback(self._portal.call, self._stop)
            self._portal.call(self._accept)
            self._stack = stack.pop_all()
        self._running = True
        return self

    def __exit__(self, *_: object) -> None:
        self._running = False
        self._stack.close()

    async def __aenter__(self) -> Self:
        return self.__enter__()

    async def __aexit__(self, *_: object) -> None:
        self.__exit__()

    def clear(self) -> None:
        """Remove all faults of calls, forward again, and accept connections again."""
        super().clear()
        self.thaw()
        self.accept()

    # Faults of connections

    def cut(self, how: Ending = Ending.RESET) -> None:
        """End all connections; when this returns, their sockets are closed."""
        self._portal.call(self._cut, how)

    def freeze(self) -> None:
        """Forward nothing in either direction, but keep all sockets open, until `thaw`."""
        self._portal.call(self._valve.close)

    def thaw(self) -> None:
        """Forward again, beginning with what `freeze` has held back."""
        self._portal.call(self._valve.open)

    def refuse(self) -> None:
        """Refuse new connections; open ones stay open."""
        self._portal.call(self._refuse)

    def accept(self) -> None:
        """Accept new connections again."""
        self._portal.call(self._accept)

    # Records

    def calls(self, method: str | None = None) -> tuple[CallRecord, ...]:
        """The calls received so far, oldest first.

        Args:
            method: only calls of this function of the wire.
        """
        calls = tuple(self._records.calls)
        return calls if method is None else tuple(c for c in calls if c.method == method)

    def connections(self) -> tuple[ConnectionRecord, ...]:
        """The connections accepted so far, oldest first."""
        return tuple(self._records.connections)

    def statistics(self) -> ProxyStatistics:
        """Counts so far."""
        return self._records.statistics()

    def forget(self) -> None:
        """Drop the records of the calls received so far; for long runs."""
        self._portal.call(self._records.forget)

    # On the proxy's own loop

    async def _serve(self, *, task_status: TaskStatus[None]) -> None:
        self._valve = Valve()
        self._listening: anyio.CancelScope | None = None
        async with anyio.create_task_group() as self._group:
            task_status.started()
            await anyio.sleep_forever()

    def _stop(self) -> None:
        self._group.cancel_scope.cancel()

    async def _accept(self) -> None:
        if self._listening is None:
            await self._group.start(self._listen)

    async def _refuse(self) -> None:
        if self._listening is not None:
            self._listening.cancel()
            await self._listener_closed.wait()

    async def _cut(self, how: Ending) -> None:
        relays = list(self._relays)
        for relay in relays:
            relay.cut(how)
        for relay in relays:
            await relay.wait()

    async def _listen(self, *, task_status: TaskStatus[None]) -> None:
        self._listener_closed = anyio.Event()
        try:
            with _bound(self.port) as listener, anyio.CancelScope() as self._listening:
                listener.setblocking(False)
                listener.listen(128)
                task_status.started()
                await self._accept_from(listener, self._group)
        finally:
            self._listening = None
            self._listener_closed.set()

    async def _accept_from(self, listener: socket.socket, group: TaskGroup) -> None:
        while True:
            await anyio.wait_readable(listener)
            try:
                client, _ = listener.accept()
            except ConnectionAbortedError:
                continue  # the client closed it before it was accepted
            except OSError:
                await anyio.sleep(_REST)  # no descriptor: the client waits
                continue
            relay = Relay(
                AwaitedSocket(client),
                self._upstream,
                script=self,
                records=self._records,
                valve=self._valve,
                jitter=self._random,
            )
            self._relays.add(relay)
            group.start_soon(self._run, relay)

    async def _run(self, relay: Relay) -> None:
        try:
            await relay.run()
        finally:
            self._relays.discard(relay)


def _bound(port: int) -> socket.socket:
    sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        shared = getattr(socket, "SO_REUSEPORT", socket.SO_REUSEADDR)
        sock.setsockopt(socket.SOL_SOCKET, shared, 1)
        sock.bind((_HOST, port))
    except BaseException:
        sock.close()
        raise
    return sock
