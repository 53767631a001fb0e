"""Factory for the threads and connections of one lane."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco._wire.connection import Connection
from aioduco._wire.host import Route
from aioduco._wire.worker import Worker
from aioduco.trace import ConnectionEnded, ConnectionOpened, emit

if TYPE_CHECKING:
    from aioduco.trace import Trace


class ConnectionFactory:
    """Makes the workers of a lane and their connections, counts them and calls the trace hook.

    Workers refer to this factory and not to the lane, so that the garbage collector can find a
    lane that was not closed.
    """

    def __init__(
        self,
        lane: str,
        host: str,
        port: int,
        connect_timeout: float,
        trace: Trace | None,
        route: Route | None = None,
    ) -> None:
        self.lane = lane
        self.host = host
        self.port = port
        self.connect_timeout = connect_timeout
        self.trace = trace
        self.route = Route() if route is None else route
        self.count = 0
        self._workers = 0

    def worker(self) -> Worker:
        """Make a worker; its thread starts with its first call."""
        self._workers += 1
        return Worker(f"aioduco-{self.lane}-{self._workers}", self)

    def make(self) -> Connection:
        """Make a connection that is not open yet."""
        return Connection(
            self.host, self.port, connect_timeout=self.connect_timeout, route=self.route
        )

    def opened(self, connection: Connection, duration: float) -> None:
        """Record that a connection was opened, within `duration` [s]; on the worker's thread."""
        self.count += 1
        if self.trace is not None:
            peer = (connection.host, connection.port)
            emit(self.trace, ConnectionOpened(time.monotonic(), self.lane, peer, duration))

    def ended(self, connection: Connection) -> None:
        """Record that a connection is no longer used; on the worker's thread."""
        if self.trace is not None:
            peer = (connection.host, connection.port)
            event = ConnectionEnded(time.monotonic(), self.lane, peer, connection.reason)
            emit(self.trace, event)
