"""State machine of a connection, without socket, thread or clock."""

from __future__ import annotations

import enum


class ConnectionState(enum.Enum):
    """State of a connection.

    NEW: not open yet.
    IDLE: open, no call under way.
    ACTIVE: a call is under way.
    POISONED: a call ended without its answer, so the next bytes could belong to any call: the
    connection is never used again.
    CLOSED: closed by its owner.
    """

    NEW = "new"
    IDLE = "idle"
    ACTIVE = "active"
    POISONED = "poisoned"
    CLOSED = "closed"


class Progress(enum.IntEnum):
    """Progress of the last call. It decides whether a failed call may be repeated."""

    NOTHING_SENT = 0
    SENT = 1
    ANSWERING = 2


class Lifecycle:
    """State machine of one connection.

    Invariants: only CLOSED follows POISONED, and no state follows CLOSED. A call that was under
    way when the connection was poisoned cannot complete. Only the first reason is kept.
    """

    __slots__ = ("progress", "reason", "state")

    def __init__(self) -> None:
        self.state = ConnectionState.NEW
        self.progress = Progress.NOTHING_SENT
        #: why the connection was poisoned or closed
        self.reason = ""

    def opened(self) -> bool:
        """Record that the socket is connected; return whether the connection may be used."""
        return self._move(ConnectionState.NEW, ConnectionState.IDLE)

    def begin(self) -> bool:
        """Start a call; return whether that is allowed."""
        if not self._move(ConnectionState.IDLE, ConnectionState.ACTIVE):
            return False
        self.progress = Progress.NOTHING_SENT
        return True

    def sent(self) -> None:
        """Record that the first bytes of the call were passed to the operating system."""
        self.progress = Progress.SENT

    def answering(self) -> None:
        """Record that the first bytes of the answer have arrived."""
        self.progress = Progress.ANSWERING

    def complete(self) -> bool:
        """Record that the answer is complete and valid; return whether the caller may get it."""
        return self._move(ConnectionState.ACTIVE, ConnectionState.IDLE)

    def poison(self, reason: str) -> bool:
        """Mark the connection as unusable; return whether the state changed."""
        if self.state in (ConnectionState.POISONED, ConnectionState.CLOSED):
            return False
        self.state = ConnectionState.POISONED
        self.reason = reason
        return True

    def close(self) -> bool:
        """Record that the owner closed the connection; return whether the state changed."""
        if self.state is ConnectionState.CLOSED:
            return False
        self.state = ConnectionState.CLOSED
        self.reason = self.reason or "it was closed"
        return True

    def _move(self, old: ConnectionState, new: ConnectionState) -> bool:
        if self.state is not old:
            return False
        self.state = new
        return True
