"""What a lane does in one tick, for streams through the realtime queue."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from aioduco._wire.rpc import RealTimeControlData
from aioduco.streaming.calls import Batch
from aioduco.streaming.feed import Feed
from aioduco.streaming.filling import Depth
from aioduco.streaming.shared import Status
from aioduco.streaming.source import Reason, State
from aioduco.streaming.watch import Watch, refused

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.config import Queue
    from aioduco.streaming.shared import Block

__all__ = ["QueueDriver"]

_PATIENCE = 0.25  # seconds for which the controller may take no point before it counts as gone


class QueueDriver:
    """The realtime queue (实时控制, manual 1.3.15), kept at a depth.

    The controller takes a point every cycle, by its own clock. So the lane does not count time:
    each tick it asks how many points are left and adds what is missing to the depth.
    """

    def __init__(self, queue: Queue, connection: Connection, block: Block) -> None:
        options = block.config.options
        self._feed = Feed(connection, block)
        self._connection = connection
        self._timeout = options.timeout
        self._block = block
        self._queue = queue
        self._depth = Depth(queue.depth, max(_PATIENCE, 20 * queue.period))

        def element(values: list[float]) -> RealTimeControlData:
            data = RealTimeControlData(status=True)
            setattr(data, queue.field, values)
            return data

        self._batch = Batch(connection, "realtime_data_enqueue", element, (True,), self._timeout)
        self._watch = Watch(connection, options.watch, self._timeout)
        self._round_trip = block.histograms["round_trip"].record
        self._depths = block.histograms["depth"].record
        self._running = False
        self._sent = 0
        self._last = b""

    @property
    def state(self) -> State:
        """State of the stream; it ends once the queue holds nothing but rest."""
        state = self._feed.source.state
        if state is State.ENDED and self._running:
            return State.DECELERATING
        return state

    @property
    def reason(self) -> Reason:
        """Why it ends."""
        return self._feed.source.reason

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - what is late is made up by the queue
        """Do the work of one tick; returns whether there is another one."""
        if self._running:
            return self._fill()
        source = self._feed.source
        if source.state is not State.ENDED and self._feed.begin():
            return self._start()
        self._feed.step()
        return source.state < State.ENDED

    def _start(self) -> bool:
        """Fill the empty queue, and have the controller begin with it.

        The first points are where the arm is, as the manual asks for.
        """
        if not self._accepted("clear_realtime_data_queue", ()):
            return False
        rest = self._batch.element(self._feed.resting())
        if not self._enqueue([rest] * self._queue.depth):
            return False
        self._running = self._accepted("start_realtime_mode", tuple(self._queue.mode))
        return self._running

    def _fill(self) -> bool:
        start = time.monotonic_ns()
        left = self._connection.call("get_realtime_data_queue_size", (), self._timeout)
        self._depths(left)
        self._block.status[Status.DEPTH] = max(left, 0)
        wanted = self._depth.look(left, start * 1e-9)
        if wanted and not self._enqueue(self._more(wanted)):
            return False
        self._round_trip(time.monotonic_ns() - start)
        if self._depth.at_rest:
            return self._stop()
        if self._depth.stuck:
            return self._refuse("the controller takes no points from its queue any more")
        reason, text = self._watch.look(0)
        return not reason or self._refuse(text)

    def _more(self, count: int) -> list[bytes]:
        """The next points; after the end those at which the arm rests."""
        elements: list[bytes] = []
        for _ in range(count):
            values = self._feed.step()
            if values is None:
                break
            self._last = self._batch.element(values)
            elements.append(self._last)
        lacking = count - len(elements)
        self._depth.rest(lacking)
        return elements + [self._last] * lacking

    def _enqueue(self, elements: list[bytes]) -> bool:
        answer = self._batch.send(elements)
        self._sent += len(elements)
        return not refused(answer) or self._refuse(f"realtime_data_enqueue answered {answer}")

    def _accepted(self, name: str, args: tuple[Any, ...]) -> bool:
        answer = self._connection.call(name, args, self._timeout)
        return not refused(answer) or self._refuse(f"{name} answered {answer}")

    def _refuse(self, text: str) -> bool:
        self._feed.source.end(Reason.REFUSED)
        self._block.text = text
        if self._running:
            self._stop()
        return False

    def _stop(self) -> bool:
        self._running = False
        self._connection.call("end_realtime_mode", (), self._timeout)
        return False

    def close(self) -> None:
        """The program sends nothing more."""
        self._feed.source.close()

    def brake(self, reason: Reason) -> None:
        """Come to rest at once, then end."""
        self._feed.source.brake(reason)

    def end(self, reason: Reason) -> None:
        """Send nothing more: the robot was stopped, and realtime mode is left."""
        self._feed.source.end(reason)
        if self._running:
            self._stop()

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        self._block.status[Status.SENT] = self._sent
        self._block.status[Status.DRAINED] = self._depth.drained
        self._feed.publish()
