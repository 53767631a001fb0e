"""What a worker does in one tick: the protocol, and drivers with one call per tick."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Protocol

from aioduco._wire import codec, idl
from aioduco.streaming.shared.block import StatusWord
from aioduco.streaming.shared.state import Reason, StreamState
from aioduco.streaming.worker.directions import Directions
from aioduco.streaming.worker.encoding import Point
from aioduco.streaming.worker.setpoints import SetpointFeed
from aioduco.streaming.worker.watch import ControllerWatch

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared.block import Block
    from aioduco.streaming.shared.config import Calls

__all__ = ["CallDriver", "Driver", "ProbeDriver"]


class Driver(Protocol):
    """One way to bring set-points to the controller."""

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        ...

    @property
    def reason(self) -> Reason:
        """Why it ends."""
        ...

    def tick(self, hurry: bool) -> bool:
        """Do the work of one tick; returns whether there is another one.

        Args:
            hurry: the next tick is due before an answer can be here.
        """
        ...

    def close(self) -> None:
        """The program sends nothing more."""

    def brake(self, reason: Reason) -> None:
        """Come to rest at once, then end."""

    def end(self, reason: Reason) -> None:
        """Send nothing more."""

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""


class CallDriver:
    """One call per tick: servoj, servoj_pose, servo_tcp, servol, speedj, speedl."""

    def __init__(self, calls: Calls, connection: Connection, block: Block) -> None:
        self._feed = SetpointFeed(connection, block)
        self._block = block
        options, sent = block.config.options, block.config.sent

        def args(values: list[float]) -> tuple[Any, ...]:
            return (values, *calls.arguments)

        self._name = calls.function
        # Steps are turned once, where they are added up; velocities as each is sent.
        turning = None if sent.meaning == "step" else sent.turning
        self._directions = Directions(connection, turning, options.timeout)
        self._point = Point(connection, self._name, args, options.timeout)
        self._watch = ControllerWatch(connection, options.watch, options.timeout)
        self._round_trip = block.histograms["round_trip"].record
        self._ahead: tuple[float, ...] | None = None
        self._task = 0
        self._sent = 0

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        return self._feed.source.state

    @property
    def reason(self) -> Reason:
        """Why it ends."""
        return self._feed.source.reason

    def tick(self, hurry: bool) -> bool:
        """Do the work of one tick; returns whether there is another one.

        In a hurry the next set-point is reckoned while the controller answers. Otherwise that is
        left for its own tick, in which it may be fresher.
        """
        feed = self._feed
        values, self._ahead = self._ahead, None
        if values is None:
            feed.begin()
            values = feed.step()
        if values is not None:
            values = self._directions.turned(values)
            start = time.monotonic_ns()
            self._task = self._point.send(values, self._look_ahead if hurry else None)
            self._round_trip(time.monotonic_ns() - start)
            self._sent += 1
            if self._task < 0:
                return self._finish(Reason.REFUSED, f"{self._name} answered {self._task}")
        if self.state is StreamState.ENDED and self._ahead is None:
            return False
        reason, text = self._watch.look(self._task)
        return not reason or self._finish(reason, text)

    def _look_ahead(self) -> None:
        self._ahead = self._feed.step()

    def _finish(self, reason: Reason, text: str) -> bool:
        # The controller does not follow any more: there is nothing left to decelerate.
        self._feed.source.end(reason)
        self._block.text = text
        return False

    def close(self) -> None:
        """The program sends nothing more."""
        self._feed.source.close()

    def brake(self, reason: Reason) -> None:
        """Come to rest at once, then end."""
        self._feed.source.brake(reason)

    def end(self, reason: Reason) -> None:
        """Send nothing more."""
        self._ahead = None
        self._feed.source.end(reason)

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        self._block.status[StatusWord.SENT] = self._sent
        self._feed.publish()


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
        self.state: StreamState = StreamState.FOLLOWING
        self.reason: Reason = Reason.NONE

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - of the protocol
        """Ask once; returns whether there is another tick."""
        if self.state is StreamState.ENDED:
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
        self.state, self.reason = StreamState.ENDED, self.reason or reason

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        # Nothing that was sent moves anything, so there is nothing to stop: SENT stays zero.
        self._block.status[StatusWord.TAKEN] = self._asked
