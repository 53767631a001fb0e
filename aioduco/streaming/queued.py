"""What a lane does in one tick, for streams that keep a queue of the controller filled."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from aioduco._wire.rpc import Op, PointOp, RealTimeControlData
from aioduco.streaming.calls import Batch
from aioduco.streaming.drive import Feed, Watch
from aioduco.streaming.shared import Status
from aioduco.streaming.source import Reason, State
from aioduco.streaming.space import JOINT_SPACE, POSE_SPACE

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.ring import SetPoint
    from aioduco.streaming.shared import Block
    from aioduco.streaming.space import Space

__all__ = ["Pool", "Queue"]

_REFUSALS = (6, 7, 8)  # error, illegal, parameter mismatch (manual 1.2)
_RUNNING = (0, 1, 2)  # not yet begun, running, paused
_MOST = 100  # points in one call: about 6 kB


class Queue:
    """The realtime queue (实时控制, manual 1.3.15), kept at a depth.

    The controller takes a point every cycle, by its own clock. So the lane does not count time:
    each tick it asks how many points are left and adds what is missing to the depth.
    """

    def __init__(self, config: dict[str, Any], connection: Connection, block: Block) -> None:
        self._feed = Feed(config, connection, block)
        self._connection = connection
        self._timeout = self._feed.timeout
        self._block = block
        self._depth = int(config["depth"])
        self._mode = tuple(config["mode"])  # arguments of start_realtime_mode
        field = config["field"]

        def element(values: list[float]) -> RealTimeControlData:
            data = RealTimeControlData(status=True)
            setattr(data, field, values)
            return data

        self._batch = Batch(connection, "realtime_data_enqueue", element, (True,), self._timeout)
        self._watch = Watch(connection, config["watch"], self._timeout)
        self._round_trip = block.histograms["round_trip"].record
        self._depths = block.histograms["depth"].record
        self._running = False
        self._sent = self._drained = self._resting = 0
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
        if not self._enqueue([rest] * self._depth):
            return False
        self._running = self._accepted("start_realtime_mode", self._mode)
        return self._running

    def _fill(self) -> bool:
        start = time.monotonic_ns()
        left = self._connection.call("get_realtime_data_queue_size", (), self._timeout)
        if left == 0:
            self._drained += 1
        self._depths(left)
        self._block.status[Status.DEPTH] = max(left, 0)
        wanted = min(self._depth - left, _MOST)
        if wanted > 0:
            elements = self._more(wanted)
            # After the end the queue is kept filled with rest, until nothing else is in it.
            if len(elements) < wanted:
                self._resting += wanted - len(elements)
                elements += [self._last] * (wanted - len(elements))
            if not self._enqueue(elements):
                return False
        self._round_trip(time.monotonic_ns() - start)
        if self._resting >= self._depth:
            return self._stop()
        reason, text = self._watch.look(0)
        if reason:
            return self._refuse(text)
        return True

    def _more(self, count: int) -> list[bytes]:
        elements: list[bytes] = []
        for _ in range(count):
            values = self._feed.step()
            if values is None:
                break
            elements.append(self._batch.element(values))
        if elements:
            self._last = elements[-1]
        return elements

    def _enqueue(self, elements: list[bytes]) -> bool:
        answer = self._batch.send(elements)
        self._sent += len(elements)
        if answer < 0 or answer in _REFUSALS:
            return self._refuse(f"realtime_data_enqueue answered {answer}")
        return True

    def _accepted(self, name: str, args: tuple[Any, ...]) -> bool:
        answer = self._connection.call(name, args, self._timeout)
        if answer < 0 or answer in _REFUSALS:
            return self._refuse(f"{name} answered {answer}")
        return True

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
        self._block.status[Status.DRAINED] = self._drained
        self._feed.publish()


class Pool:
    """The track pool (轨迹池, manual 1.3.12), kept between a low and a high mark.

    The controller plans the motion through the points itself, and comes to rest by itself when
    the pool is empty: nothing is interpolated or limited here.
    """

    def __init__(self, config: dict[str, Any], connection: Connection, block: Block) -> None:
        self._config = config
        self._connection = connection
        self._block = block
        self._ring = block.ring
        self._timeout = float(config["timeout"])
        self._low, self._high = int(config["low"]), int(config["high"])
        self._follow = (config["function"], tuple(config["arguments"]))
        self._space: Space = JOINT_SPACE if config["space"] == "joints" else POSE_SPACE
        if config["operations"]:
            self._batch = Batch(connection, "trackEnqueueOp", _plain, (True,), self._timeout)
        else:
            self._batch = Batch(connection, "trackEnqueue", list, (True,), self._timeout)
        self._watch = Watch(connection, config["watch"], self._timeout)
        self._round_trip = block.histograms["round_trip"].record
        self._depths = block.histograms["depth"].record
        self._age = block.histograms["age"].record
        self._task = 0
        self._sent = self._drained = self._starved = 0
        self._topped = 0  # points sent in this tick
        self._closing = False
        self._dry_since = 0
        self.state: State = State.WAITING
        self.reason: Reason = Reason.NONE

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - what is late is made up by the queue
        """Do the work of one tick; returns whether there is another one."""
        match self.state:
            case State.WAITING:
                return self._start()
            case State.FOLLOWING | State.HOLDING:
                return self._serve()
            case State.DECELERATING:
                return self._settle()
            case State.ENDED:
                return False

    def _serve(self) -> bool:
        start = time.monotonic_ns()
        left = self._connection.call("getQueueSize", (), self._timeout)
        self._depths(max(left, 0))
        self._block.status[Status.DEPTH] = max(left, 0)
        self._topped = 0
        if left < self._low and not self._top_up(self._high - left):
            return False
        self._round_trip(time.monotonic_ns() - start)
        if left == 0 and not self._topped:
            return self._dry()
        # It may have come to rest at the end of the points, and then it begins anew.
        if self._dry_since and self._topped and not self._task_runs() and not self._go():
            return False
        self._dry_since = 0
        self.state = State.FOLLOWING
        reason, text = self._watch.look(self._task)
        return True if not reason else self._finish(reason, text)

    def _start(self) -> bool:
        if not self._ring.level:
            return not self._closing or self._finish(Reason.CLOSED, "")
        # The pool follows at its best with enough points in it, so wait for them.
        if self._ring.level < min(self._low, self._ring.capacity) and not self._closing:
            return True
        first = self._ring.take()
        if first is None:
            return True
        name, *args = self._config["read"]
        actual = self._connection.call(name, tuple(args), self._timeout)
        gap = self._space.difference(self._space.decode(actual), self._space.decode(first.values))
        lengths = (sum(g * g for g in gap[group]) ** 0.5 for group in self._space.groups)
        if any(n > most for n, most in zip(lengths, self._config["reach"], strict=True)):
            return self._finish(Reason.TOO_FAR, "")
        if not self._accepted(self._connection.call("trackClearQueue", (), self._timeout)):
            return self._finish(Reason.REFUSED, "trackClearQueue was refused")
        return self._top_up(self._high, first) and self._go()

    def _go(self) -> bool:
        """Have the controller follow what is in the pool."""
        name, args = self._follow
        self._task = self._connection.call(name, args, self._timeout)
        if not self._accepted(self._task):
            return self._finish(Reason.REFUSED, f"{name} answered {self._task}")
        self.state = State.FOLLOWING
        return True

    def _top_up(self, room: int, first: SetPoint | None = None) -> bool:
        point, elements = first, []
        while room > 0:
            point = point or self._ring.take()
            if point is None:
                break
            elements.append(self._batch.element(point.values, point.extra))
            self._age(time.monotonic_ns() - point.stamp)
            point = None
            room -= 1
        for at in range(0, len(elements), _MOST):
            batch = elements[at : at + _MOST]
            answer = self._batch.send(batch)
            if not self._accepted(answer):
                full = "the pool is full" if answer == -1 else f"it answered {answer}"
                return self._finish(Reason.REFUSED, f"points were refused: {full}")
            self._sent += len(batch)
            self._topped += len(batch)
        return True

    def _dry(self) -> bool:
        """The pool is empty, and the program has sent nothing more."""
        now = time.monotonic_ns()
        if not self._dry_since:
            self._dry_since = now
            self._drained += not self._closing
        running = self._task_runs()
        if self._closing:
            return running or self._finish(Reason.CLOSED, "")
        self._starved += 1
        self.state = State.HOLDING
        if now - self._dry_since > self._config["hold"] * 1e9:
            self.brake(Reason.STARVED)
        return True

    def _settle(self) -> bool:
        """Decelerating: the pool was emptied, so the controller comes to rest by itself."""
        return self._task_runs() or self._finish(self.reason, "")

    def _task_runs(self) -> bool:
        if not self._task:
            return False
        state = self._connection.call("get_noneblock_taskstate", (self._task,), self._timeout)
        return state in _RUNNING

    @staticmethod
    def _accepted(answer: int) -> bool:
        return answer >= 0 and answer not in _REFUSALS

    def _finish(self, reason: Reason, text: str) -> bool:
        self.state, self.reason = State.ENDED, self.reason or reason
        if text:
            self._block.text = text
        return False

    def close(self) -> None:
        """The program sends nothing more."""
        self._closing = True

    def brake(self, reason: Reason) -> None:
        """Come to rest at once, then end."""
        if self.state is State.WAITING:
            self._finish(reason, "")
        elif self.state < State.DECELERATING:
            self.state, self.reason = State.DECELERATING, reason
            self._connection.call("trackClearQueue", (), self._timeout)

    def end(self, reason: Reason) -> None:
        """Send nothing more."""
        if self.state is not State.ENDED:
            self._finish(reason, "")

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        status = self._block.status
        status[Status.SENT] = self._sent
        status[Status.DRAINED] = self._drained
        status[Status.STARVED] = self._starved
        status[Status.TAKEN] = self._ring.read


def _plain(values: list[float]) -> PointOp:
    return PointOp(values, Op())
