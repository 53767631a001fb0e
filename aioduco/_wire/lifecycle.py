"""The states of a connection, without socket, thread or clock."""

from __future__ import annotations

import enum


class ConnectionState(enum.Enum):
    """State of a connection.

    NEW: not open yet.
    IDLE: open, no call under way.
    ACTIVE: a call is under way.
    POISONED: a call ended without its answer, so the next bytes could be an answer to
    anything: never used again.
    CLOSED: closed by its owner.
    """

    NEW = "new"
    IDLE = "idle"
    ACTIVE = "active"
    POISONED = "poisoned"
    CLOSED = "closed"


class Progress(enum.IntEnum):
    """How far the last call came. It decides what may be done when the call fails."""

    NOTHING_SENT = 0
    SENT = 1
    ANSWERING = 2


class Lifecycle:
    """State machine of one connection.

    Invariants: from POISONED only CLOSED follows, and from CLOSED nothing. A call that was
    under way when the connection was poisoned cannot complete. The first reason stays.
    """

    __slots__ = ("progress", "reason", "state")

    def __init__(self) -> None:
        self.state = ConnectionState.NEW
        self.progress = Progress.NOTHING_SENT
        #: why the connection was poisoned or closed
        self.reason = ""

    def opened(self) -> bool:
        """The socket is connected; whether the connection may be used."""
        return self._move(ConnectionState.NEW, ConnectionState.IDLE)

    def begin(self) -> bool:
        """A call begins; whether it may."""
        if not self._move(ConnectionState.IDLE, ConnectionState.ACTIVE):
            return False
        self.progress = Progress.NOTHING_SENT
        return True

    def sent(self) -> None:
        """The first bytes of the call have been handed to the system."""
        self.progress = Progress.SENT

    def answering(self) -> None:
        """The first bytes of the answer have come."""
        self.progress = Progress.ANSWERING

    def complete(self) -> bool:
        """The answer is there and checked; whether it may be given to the caller."""
        return self._move(ConnectionState.ACTIVE, ConnectionState.IDLE)

    def poison(self, reason: str) -> bool:
        """Never use the connection again; whether that is new."""
        if self.state in (ConnectionState.POISONED, ConnectionState.CLOSED):
            return False
        self.state = ConnectionState.POISONED
        self.reason = reason
        return True

    def close(self) -> bool:
        """The owner is done with the connection; whether that is new."""
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
