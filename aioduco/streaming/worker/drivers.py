"""Drivers with one call per tick."""

from __future__ import annotations

import time
from collections import deque
from typing import TYPE_CHECKING, Any

from aioduco._wire import codec, idl
from aioduco.errors import ControllerError
from aioduco.streaming.shared.words import Reason, StatusWord, StreamState
from aioduco.streaming.worker.driver import Driver
from aioduco.streaming.worker.encoding import Point
from aioduco.streaming.worker.life import Life
from aioduco.streaming.worker.setpoints import SetpointFeed
from aioduco.streaming.worker.task_numbers import TaskNumbers

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared.block import Block
    from aioduco.streaming.worker.permit import StreamPermit


#: ends after which nobody else stops the arm, if set-points moved it after another caller's stop
_UNSTOPPED = (Reason.CLOSED, Reason.ABORTED)
#: on a slow connection, of so many successive calls all but so many take several ticks; on a busy
#: computer some do
_CALLS, _BUT = 10, 2


class CallDriver(Driver):
    """One call per tick: servoj, servoj_pose, servo_tcp, servol, speedj, speedl."""

    def __init__(self, connection: Connection, block: Block, permit: StreamPermit) -> None:
        sent = block.config.sent
        self._feed = SetpointFeed(connection, block, permit.begin)
        super().__init__(self._feed.source, connection, block)

        def args(values: list[float]) -> tuple[Any, ...]:
            return (values, *sent.arguments)

        self._name = sent.name
        self._point = Point(connection, self._name, args, self._timeout, permit.require)
        self._ahead: tuple[float, ...] | None = None
        self._numbers = TaskNumbers()
        self._period = round(1e9 / block.config.feeding.rate)
        self._stepped = time.monotonic_ns()
        #: number of ticks that passed in each of the last calls
        self._passed: deque[int] = deque(maxlen=_CALLS)

    def tick(self, hurry: bool) -> bool:
        """Do the work of one tick; returns whether there is another one.

        With `hurry` the next set-point is computed while the controller answers. Otherwise it is
        computed in the next tick, from data that may be newer.
        """
        feed = self._feed
        values, self._ahead = self._ahead, None
        if values is None:
            feed.begin(self._may_begin)
            values = self._step()
        if values is not None:
            values = feed.wire(values)
            start = time.monotonic_ns()
            ahead = hurry and not feed.reads
            try:
                self.task: int = self._point.send(values, self._look_ahead if ahead else None)
            except ControllerError:  # it was sent, and the arm may follow it
                self._sent += 1
                raise
            self._round_trip(time.monotonic_ns() - start)
            self._sent += 1
            if self.task < 0:
                return self._finish(Reason.REFUSED, f"{self._name} answered {self.task}")
            self._numbers.sent(self.task, time.monotonic())
        if self._stopped():
            return False
        if self.state is StreamState.ENDED and self._ahead is None:
            return bool(self._numbers.in_question) and self.life.reason in _UNSTOPPED
        return self._follows(self.task)

    def _stopped(self) -> bool:
        """Poll whether another caller stopped a task in question; if so, stop again and end.

        By the task that `_follows` polls a stop would be noticed only by chance.
        """
        call, timeout = self._connection.call, self._timeout
        for task in self._numbers.in_question:
            state = call("get_noneblock_taskstate", (task,), timeout)
            text = self._numbers.polled(task, state, time.monotonic())
            if text:
                call("stop", (True,), timeout)
                self.life.end(Reason.STOPPED, text)
                return True
        return False

    def _look_ahead(self) -> None:
        self._ahead = self._step()

    def _step(self) -> tuple[float, ...] | None:
        before, self._stepped = self._stepped, time.monotonic_ns()
        self._passed.append((self._stepped - before) // self._period)
        each = sorted(self._passed)[_BUT] if len(self._passed) == _CALLS else 1
        return self._feed.step(max(1, each))

    def end(self, reason: Reason, text: str = "") -> None:
        """Send nothing more."""
        self._ahead = None
        super().end(reason, text)

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""
        super().publish()
        self._feed.publish()


class ProbeDriver(Driver):
    """Measures the cost of a servo stream without moving the arm: one short call per tick."""

    def __init__(self, connection: Connection, block: Block, permit: StreamPermit) -> None:  # noqa: ARG002 - it sends nothing
        super().__init__(Life(), connection, block)
        self._function = idl.functions()["get_robot_state"]
        self._arguments = codec.encode(self._function, ())
        self._asked = 0

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - of the protocol
        """Call the controller once; returns whether there is another tick."""
        if self.life.closing:
            self.end(Reason.CLOSED)
        if self.state is StreamState.ENDED:
            return False
        start = time.monotonic_ns()
        deadline = time.monotonic() + self._timeout
        self._connection.exchange(self._function, self._arguments, deadline)
        self._round_trip(time.monotonic_ns() - start)
        self._asked += 1
        return True

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""
        # These calls do not move the arm, so there is nothing to stop: SENT stays zero.
        self._block.status[StatusWord.TAKEN] = self._asked
