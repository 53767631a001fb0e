"""What a lane does in one tick, for streams through the track pool."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco._wire.rpc import Op, PointOp
from aioduco.streaming.calls import Batch
from aioduco.streaming.filling import Pooled, Todo
from aioduco.streaming.shared import Status
from aioduco.streaming.source import Reason, State, within
from aioduco.streaming.watch import Watch, refused

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.config import Pool
    from aioduco.streaming.ring import SetPoint
    from aioduco.streaming.shared import Block

__all__ = ["PoolDriver"]

_RUNNING = (0, 1, 2)  # not yet begun, running, paused
_MOST = 100  # points in one call: about 6 kB


class PoolDriver:
    """The track pool (轨迹池, manual 1.3.12), kept between a low and a high mark.

    The controller plans the motion through the points itself, and comes to rest by itself when
    the pool is empty: nothing is interpolated or limited here.
    """

    def __init__(self, pool: Pool, connection: Connection, block: Block) -> None:
        options = block.config.options
        self._connection = connection
        self._block = block
        self._sent_as = block.config.sent
        self._timeout = options.timeout
        self._pool = pool
        self._states = Pooled(pool.low, pool.high, block.config.feeding.hold)
        if pool.extra:
            self._batch = Batch(connection, "trackEnqueueOp", _plain, (True,), self._timeout)
        else:
            self._batch = Batch(connection, "trackEnqueue", list, (True,), self._timeout)
        self._watch = Watch(connection, options.watch, self._timeout)
        self._round_trip = block.histograms["round_trip"].record
        self._depths = block.histograms["depth"].record
        self._age = block.histograms["age"].record
        self._task = 0
        self._sent = 0

    @property
    def state(self) -> State:
        """State of the stream."""
        return self._states.state

    @property
    def reason(self) -> Reason:
        """Why it ends."""
        return self._states.reason

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - what is late is made up by the pool
        """Do the work of one tick; returns whether there is another one."""
        match self.state:
            case State.WAITING:
                return self._start()
            case State.FOLLOWING | State.HOLDING:
                return self._serve()
            case State.DECELERATING:
                # The pool was emptied, so the controller comes to rest by itself.
                return self._task_runs() or self._finish(self.reason, "")
            case State.ENDED:
                return False

    def _start(self) -> bool:
        ring = self._block.ring
        if not self._states.may_begin(ring.level, ring.capacity):
            return self.state < State.ENDED
        first = ring.take()
        if first is None:
            return True
        name, *args = self._sent_as.read
        actual = self._connection.call(name, tuple(args), self._timeout)
        space = self._sent_as.space
        reach = tuple(self._block.config.feeding.reach)
        if not within(space, space.decode(actual), space.decode(first.values), reach):
            return self._finish(Reason.TOO_FAR, "")
        if refused(self._connection.call("trackClearQueue", (), self._timeout)):
            return self._finish(Reason.REFUSED, "trackClearQueue was refused")
        return self._add(self._pool.high, first) >= 0 and self._go()

    def _serve(self) -> bool:
        start = time.monotonic_ns()
        left = max(0, self._connection.call("getQueueSize", (), self._timeout))
        self._depths(left)
        self._block.status[Status.DEPTH] = left
        added = self._add(self._states.wanted(left))
        if added < 0:
            return False
        self._round_trip(time.monotonic_ns() - start)
        match self._states.look(left, added, start * 1e-9):
            case Todo.FINISH:
                return self._task_runs() or self._finish(Reason.CLOSED, "")
            case Todo.RESUME:
                if not self._task_runs() and not self._go():
                    return False
            case Todo.EMPTY:
                self._empty()
                return True
            case Todo.WAIT | Todo.FOLLOW:
                pass
        reason, text = self._watch.look(self._task if left else 0)
        return not reason or self._finish(reason, text)

    def _go(self) -> bool:
        """Have the controller follow what is in the pool."""
        name, args = self._pool.function, tuple(self._pool.arguments)
        self._task = self._connection.call(name, args, self._timeout)
        if refused(self._task):
            return self._finish(Reason.REFUSED, f"{name} answered {self._task}")
        self._states.begin()
        return True

    def _add(self, room: int, first: SetPoint | None = None) -> int:
        """Add points of the program to the pool.

        Returns:
            How many; -1: they were refused, and this is the end.
        """
        point = first
        elements: list[bytes] = []
        while len(elements) < room:
            point = point or self._block.ring.take()
            if point is None:
                break
            elements.append(self._batch.element(point.values, point.extra))
            self._age(time.monotonic_ns() - point.stamp)
            point = None
        for at in range(0, len(elements), _MOST):
            batch = elements[at : at + _MOST]
            answer = self._batch.send(batch)
            if refused(answer):
                full = "the pool is full" if answer == -1 else f"it answered {answer}"
                self._finish(Reason.REFUSED, f"points were refused: {full}")
                return -1
            self._sent += len(batch)
        return len(elements)

    def _empty(self) -> None:
        self._connection.call("trackClearQueue", (), self._timeout)

    def _task_runs(self) -> bool:
        if not self._task:
            return False
        state = self._connection.call("get_noneblock_taskstate", (self._task,), self._timeout)
        return state in _RUNNING

    def _finish(self, reason: Reason, text: str) -> bool:
        self._states.end(reason)
        if text:
            self._block.text = text
        return False

    def close(self) -> None:
        """The program sends nothing more."""
        self._states.close()

    def brake(self, reason: Reason) -> None:
        """Come to rest at once, then end."""
        if self._states.brake(reason):
            self._empty()

    def end(self, reason: Reason) -> None:
        """Send nothing more."""
        self._states.end(reason)

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        status = self._block.status
        status[Status.SENT] = self._sent
        status[Status.DRAINED] = self._states.drained
        status[Status.STARVED] = self._states.starved
        status[Status.TAKEN] = self._block.ring.read


def _plain(values: list[float]) -> PointOp:
    return PointOp(values, Op())
