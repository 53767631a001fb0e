"""The work of one tick: the interface of drivers, and drivers with one call per tick."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Protocol

from aioduco._wire import codec, idl
from aioduco.streaming.shared.state import Reason, StreamState
from aioduco.streaming.shared.words import StatusWord
from aioduco.streaming.worker.directions import Directions
from aioduco.streaming.worker.encoding import Point
from aioduco.streaming.worker.setpoints import SetpointFeed
from aioduco.streaming.worker.watch import ControllerWatch

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared.block import Block
    from aioduco.streaming.shared.config import CallDrive
    from aioduco.streaming.worker.permit import WorkerPermit

__all__ = ["CallDriver", "Driver", "ProbeDriver"]


class Driver(Protocol):
    """One way to send set-points to the controller."""

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        ...

    @property
    def reason(self) -> Reason:
        """Why it ends."""
        ...

    @property
    def text(self) -> str:
        """More about the reason; of several reasons the first one stays, with its text."""
        ...

    def tick(self, hurry: bool) -> bool:
        """Do the work of one tick; returns whether there is another one.

        Args:
            hurry: whether the next tick is due before an answer can arrive.
        """
        ...

    def close(self) -> None:
        """Follow all set-points that were sent, then end: the program sends no more."""

    def brake(self, reason: Reason, text: str = "") -> None:
        """Come to rest at once, then end."""

    def end(self, reason: Reason, text: str = "") -> None:
        """Send nothing more."""

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""


class CallDriver:
    """One call per tick: servoj, servoj_pose, servo_tcp, servol, speedj, speedl."""

    def __init__(
        self, calls: CallDrive, connection: Connection, block: Block, permit: WorkerPermit
    ) -> None:
        self._feed = SetpointFeed(connection, block, permit.begin)
        self._block = block
        options, sent = block.config.options, block.config.sent

        def args(values: list[float]) -> tuple[Any, ...]:
            return (values, *calls.arguments)

        self._name = calls.function
        # Steps are rotated once, where they are added up; each velocity when it is sent.
        turning = None if sent.meaning == "step" else sent.turning
        self._directions = Directions(connection, turning, options.timeout)
        self._point = Point(connection, self._name, args, options.timeout, permit.require)
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

    @property
    def text(self) -> str:
        """More about the reason."""
        return self._feed.source.text

    def tick(self, hurry: bool) -> bool:
        """Do the work of one tick; returns whether there is another one.

        With `hurry` the next set-point is computed while the controller answers. Otherwise it is
        computed in the next tick, from data that may be newer.
        """
        feed = self._feed
        values, self._ahead = self._ahead, None
        if values is None:
            feed.begin()
            values = feed.step()
        if values is not None:
            values = self._directions.turned(values)
            start = time.monotonic_ns()
            ahead = hurry and not feed.reads
            self._task = self._point.send(values, self._look_ahead if ahead else None)
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
        # The controller does not follow any more, so no deceleration is possible.
        self._feed.source.end(reason, text)
        return False

    def close(self) -> None:
        """Follow all set-points that were sent, then end: the program sends no more."""
        self._feed.source.close()

    def brake(self, reason: Reason, text: str = "") -> None:
        """Come to rest at once, then end."""
        self._feed.source.brake(reason, text)

    def end(self, reason: Reason, text: str = "") -> None:
        """Send nothing more."""
        self._ahead = None
        self._feed.source.end(reason, text)

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""
        self._block.status[StatusWord.SENT] = self._sent
        self._feed.publish()


class ProbeDriver:
    """Measures the cost of a servo stream without moving the arm: one short call per tick."""

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
        self.text: str = ""

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - of the protocol
        """Call the controller once; returns whether there is another tick."""
        if self.state is StreamState.ENDED:
            return False
        start = time.monotonic_ns()
        deadline = time.monotonic() + self._timeout
        self._connection.exchange(self._function, self._arguments, deadline)
        self._round_trip(time.monotonic_ns() - start)
        self._asked += 1
        return True

    def close(self) -> None:
        """Make no more calls."""
        self.end(Reason.CLOSED)

    def brake(self, reason: Reason, text: str = "") -> None:
        """Make no more calls."""
        self.end(reason, text)

    def end(self, reason: Reason, text: str = "") -> None:
        """Make no more calls."""
        self.state = StreamState.ENDED
        if not self.reason:
            self.reason, self.text = reason, text

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""
        # These calls do not move the arm, so there is nothing to stop: SENT stays zero.
        self._block.status[StatusWord.TAKEN] = self._asked
