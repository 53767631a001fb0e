"""A lane that moves nothing: it asks for the robot's state at a stream's rate."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco._wire import codec, idl
from aioduco.streaming.shared import Status
from aioduco.streaming.source import Reason, State

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared import Block

__all__ = ["ProbeDriver"]


class ProbeDriver:
    """What a servo stream costs, without a servo: one short call per tick."""

    def __init__(self, connection: Connection, block: Block) -> None:
        self._connection = connection
        self._timeout = block.config.options.timeout
        self._block = block
        self._function = idl.functions()["get_robot_state"]
        self._arguments = codec.encode(self._function, ())
        self._round_trip = block.histograms["round_trip"].record
        self._asked = 0
        self.state: State = State.FOLLOWING
        self.reason: Reason = Reason.NONE

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - of the protocol
        """Ask once; returns whether there is another tick."""
        if self.state is State.ENDED:
            return False
        start = time.monotonic_ns()
        deadline = time.monotonic() + self._timeout
        self._connection.exchange(self._function, self._arguments, deadline)
        self._round_trip(time.monotonic_ns() - start)
        self._asked += 1
        return True

    def close(self) -> None:
        """Ask no more."""
        self.end(Reason.CLOSED)

    def brake(self, reason: Reason) -> None:
        """Ask no more."""
        self.end(reason)

    def end(self, reason: Reason) -> None:
        """Ask no more."""
        self.state, self.reason = State.ENDED, self.reason or reason

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        # Nothing that was sent moves anything, so there is nothing to stop: SENT stays zero.
        self._block.status[Status.TAKEN] = self._asked
