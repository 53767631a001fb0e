"""Records of the calls and connections that passed through a proxy."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

if TYPE_CHECKING:
    from aioduco._wire.messages import Message
    from aioduco.testing.faults import Fault


@dataclass(frozen=True, slots=True)
class CallRecord:
    """One call that reached the proxy.

    Times are those of `time.monotonic`, in s; None if the event has not happened.

    Attributes:
        connection: number of the connection, from 0 in the order of acceptance.
        request: the request, as it was received.
        fault: the fault that was applied to the call.
        received: when the whole request had been received.
        forwarded: when the last byte of the request was sent to the server.
        replied: when the server's whole reply had been received.
        answered: when the last byte of an answer, genuine or forged, was sent to the caller.
    """

    connection: int
    request: Message
    fault: Fault | None
    received: float
    forwarded: float | None = None
    replied: float | None = None
    answered: float | None = None

    @property
    def method(self) -> str:
        """The function on the wire."""
        return self.request.name

    @property
    def seqid(self) -> int:
        """The sequence id that the caller chose."""
        return self.request.seqid


@dataclass(frozen=True, slots=True)
class ConnectionRecord:
    """One connection that the proxy accepted.

    Attributes:
        index: its number, from 0 in the order of acceptance.
        opened: when it was accepted, in s of `time.monotonic`.
        closed: when it ended; None while it is open.
        ended_by: "client", "server", "fault" or "proxy"; None while it is open.
    """

    index: int
    opened: float
    closed: float | None = None
    ended_by: str | None = None


class ProxyStatistics(NamedTuple):
    """Counts of a proxy.

    Attributes:
        connections: connections accepted.
        open: connections open now.
        calls: requests received.
        faults: calls to which a fault was applied.
    """

    connections: int
    open: int
    calls: int
    faults: int


class Records:
    """Keeps the records. One thread writes; any may read, since a record is replaced whole."""

    def __init__(self) -> None:
        self.connections: list[ConnectionRecord] = []
        self.calls: list[CallRecord] = []
        self._faults = 0
        self._closed = 0
        self._forgotten = 0

    def statistics(self) -> ProxyStatistics:
        """The counts now."""
        opened = len(self.connections)
        calls = self._forgotten + len(self.calls)
        return ProxyStatistics(opened, opened - self._closed, calls, self._faults)

    def connected(self) -> int:
        """Record that a connection was accepted; return its number."""
        self.connections.append(ConnectionRecord(len(self.connections), time.monotonic()))
        return len(self.connections) - 1

    def disconnected(self, index: int, ended_by: str) -> None:
        """Record that a connection has ended."""
        self._closed += 1
        self.connections[index] = replace(
            self.connections[index], closed=time.monotonic(), ended_by=ended_by
        )

    def called(self, connection: int, request: Message, fault: Fault | None) -> int:
        """Record a request; return the number of its record."""
        self._faults += fault is not None
        self.calls.append(CallRecord(connection, request, fault, time.monotonic()))
        return self._forgotten + len(self.calls) - 1

    def note(self, call: int, step: Literal["forwarded", "replied", "answered"]) -> None:
        """Record that a step of a call was done now."""
        index = call - self._forgotten
        if index >= 0:
            now: dict[str, Any] = {step: time.monotonic()}
            self.calls[index] = replace(self.calls[index], **now)

    def forget(self) -> None:
        """Drop the calls received so far; the counts continue."""
        self._forgotten += len(self.calls)
        self.calls.clear()
