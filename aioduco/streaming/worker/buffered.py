"""The work of one tick, for streams through a buffer of the controller.

`Depth` and `PoolStates` decide when to fill the realtime queue and the track pool, and when the
stream ends. They are pure: no clock, no calls.
"""

from __future__ import annotations

import json
import time
from enum import Enum, auto
from typing import TYPE_CHECKING, Any

from aioduco._wire.rpc import Op, PointOp, RealTimeControlData
from aioduco.errors import ControllerError
from aioduco.models.enums import SafetyState, TaskState
from aioduco.streaming.shared.space import read_six, too_far
from aioduco.streaming.shared.words import ControlWord, Reason, StatusWord, StreamState
from aioduco.streaming.worker.driver import Driver
from aioduco.streaming.worker.encoding import Batch
from aioduco.streaming.worker.life import Life
from aioduco.streaming.worker.setpoints import SetpointFeed
from aioduco.streaming.worker.watch import disabled, ended, refused

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.connection import Connection
    from aioduco.envelope.limits import Crossing
    from aioduco.streaming.shared.block import Block
    from aioduco.streaming.shared.ring import SetPoint
    from aioduco.streaming.worker.checked import EnvelopeCheck
    from aioduco.streaming.worker.permit import StreamPermit


_MOST = 100  # points in one call: about 6 kB
_RUNNING = (0, 1, 2)  # not yet begun, running, paused


class Depth:
    """Decides how many points to add to the realtime queue, and whether the controller takes any.

    Args:
        depth: points to keep in the queue.
        patience: time for which the queue may stay full before the controller counts as stuck [s].

    Attributes:
        drained: polls at which the queue was empty.
        stuck: whether the controller takes no more points.
    """

    def __init__(self, depth: int, patience: float) -> None:
        self._depth = depth
        self._patience = patience
        self._full_since: float | None = None
        self._resting = 0
        self.drained: int = 0
        self.stuck: bool = False

    def look(self, left: int, asked: float, answered: float) -> int:
        """Process the result of a poll of the queue.

        It was polled at some time between `asked` and `answered`, so a slow answer alone does not
        make the controller count as stuck.

        Args:
            left: points in the queue.
            asked: time before the poll [s].
            answered: time after the poll [s].

        Returns:
            Number of points to add.
        """
        self.drained += left == 0
        wanted = min(self._depth - left, _MOST)
        if wanted > 0:
            self._full_since = None
            return wanted
        if self._full_since is None:
            self._full_since = answered
        self.stuck = asked - self._full_since > self._patience
        return 0

    def rest(self, count: int) -> None:
        """Count points that were added to hold the arm at rest, because there were no others."""
        self._resting += count

    def at_rest(self, settling: int = 0) -> bool:
        """Whether the queue contains only points at which the arm rests.

        Args:
            settling: number of such points that the controller must have taken, too.
        """
        return self._resting >= self._depth + settling


class PoolAction(Enum):
    """The next action after a poll of the track pool."""

    FOLLOW = auto()
    """Nothing: the arm follows."""
    RESUME = auto()
    """Start the motion again if the controller has come to rest at its last point."""
    WAIT = auto()
    """Nothing: the pool is empty, and the program sends nothing."""
    FINISH = auto()
    """End the stream when the arm has come to rest at the last point."""
    EMPTY = auto()
    """Clear the pool, so that the arm comes to rest: the program has sent nothing for too long."""


class PoolStates(Life):
    """The states of a stream through the track pool.

    WAITING until there are enough points to begin; HOLDING while the pool is empty, where the
    controller comes to rest by itself; DECELERATING after the stream has cleared the pool.

    Args:
        low: fill the pool when it has fewer points than this.
        high: number of points to which to fill it.
        hold: time with an empty pool after which the stream ends [s].

    Attributes:
        drained: how often the pool was found empty before the program had closed the stream.
        starved: polls at which it was empty then, and the program had no points for it.
    """

    def __init__(self, low: int, high: int, hold: float) -> None:
        super().__init__()
        self._low = low
        self._high = high
        self._hold = hold
        self._dry_since: float | None = None
        self._filled = 0  # points that were in the pool after the last poll
        self.drained: int = 0
        self.starved: int = 0

    def may_begin(self, waiting: int, capacity: int, *, awaited: bool = False) -> bool:
        """Whether there are enough points to begin.

        The controller follows best with enough points in its pool, so the worker waits for them.

        Args:
            waiting: points that the program has sent.
            capacity: number of points that fit into the ring.
            awaited: whether the program sends no more until these are taken.
        """
        if self.closing and not waiting:
            self.end(Reason.CLOSED)
        enough = waiting >= min(self._low, capacity)
        return waiting > 0 and (enough or awaited or self.closing)

    def begin(self) -> None:
        """Note that the controller follows the pool."""
        self.following()

    def wanted(self, left: int) -> int:
        """Number of points to add to a pool that has `left` points."""
        return self._high - left if left < self._low else 0

    def look(self, left: int, added: int, now: float) -> PoolAction:
        """Process the result of a poll of the pool.

        Args:
            left: points that were in the pool.
            added: points that were then added to it.
            now: the time [s].
        """
        # The pool can also run empty between two polls, and even between a poll and the points that
        # it adds. Then the controller rests and takes none of the new points, which shows here.
        untaken = 0 < self._filled <= left
        self._filled = left + added
        if not left and self._dry_since is None:
            self.drained += not self.closing
        if left or added:
            self._dry_since = None
            self.following()
            return PoolAction.RESUME if not left or untaken else PoolAction.FOLLOW
        if self._dry_since is None:
            self._dry_since = now
        if self.closing:
            return PoolAction.FINISH
        self.starved += 1
        self.holding()
        if now - self._dry_since > self._hold:
            self.brake(Reason.STARVED)
            return PoolAction.EMPTY
        return PoolAction.WAIT


class RealtimeQueueDriver(Driver):
    """The realtime queue (实时控制, manual 1.3.15), kept at a depth.

    The controller takes a point every cycle of its own clock. So the worker does not count time: in
    each tick it polls how many points are left and fills the queue to its depth.
    """

    def __init__(self, connection: Connection, block: Block, permit: StreamPermit) -> None:
        self._feed = SetpointFeed(connection, block, permit.begin)
        super().__init__(self._feed.source, connection, block)
        self._permit = permit.require
        self._queue = queue = block.config.sent
        self._depth = Depth(queue.high, max(self._timeout, 20 * queue.period))
        self._settling = queue.settling

        def element(values: list[float]) -> RealTimeControlData:
            data = RealTimeControlData(status=True)
            setattr(data, queue.field, values)
            return data

        name = "realtime_data_enqueue"
        self._batch = Batch(connection, name, element, self._timeout, self._permit)
        self._depths = block.histograms["depth"].record
        self._running = False
        self._last = b""
        #: the controller's error list before realtime mode; None: it does not report one
        self._errors: list[str] | None = None

    @property
    def state(self) -> StreamState:
        """State of the stream; it ends when the queue contains only points at rest."""
        state = self.life.state
        if state is StreamState.ENDED and self._running:
            return StreamState.DECELERATING
        return state

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - the queue compensates lateness
        """Do the work of one tick; returns whether there is another one."""
        if self._running:
            return self._fill()
        if self.life.state is not StreamState.ENDED and self._feed.begin(self._may_begin):
            return self._start()
        self._feed.step()
        return self.life.state < StreamState.ENDED

    def _start(self) -> bool:
        """Fill the empty queue, and start realtime mode.

        The first points are the arm's position, as the manual requires. Nothing is sent if the
        program's first set-point is too far from there.
        """
        rest = self._batch.element(self._feed.wire(self._feed.resting()))
        first = self._feed.step()
        if first is None:
            return self.life.state < StreamState.ENDED
        self._last = self._batch.element(self._feed.wire(first))
        self._errors = self._read_errors()
        if not self._accepted("clear_realtime_data_queue", ()):
            return False
        if not self._enqueue([rest] * (self._queue.high - 1) + [self._last]):
            return False
        self._block.status[StatusWord.MODE] = 1  # before the call, since its answer may be lost
        name, args = self._queue.function, tuple(self._queue.arguments)
        self._running = self._accepted(name, args, self._permit)
        self._block.status[StatusWord.MODE] = self._running
        return self._running

    def _fill(self) -> bool:
        start = time.monotonic_ns()
        left = self._connection.call("get_realtime_data_queue_size", (), self._timeout)
        self._depths(left)
        self._block.status[StatusWord.DEPTH] = max(left, 0)
        wanted = self._depth.look(left, start * 1e-9, time.monotonic_ns() * 1e-9)
        if wanted and not self._enqueue(self._more(wanted)):
            return False
        self._round_trip(time.monotonic_ns() - start)
        if self._depth.at_rest(self._settling):
            return self._over()
        if self._depth.stuck:
            return self._stuck()
        return self._follows(0)

    def _stuck(self) -> bool:
        """End: the controller has left realtime mode by itself.

        A stop is no error. If the state and the error list say that there is none, it was a stop.
        """
        text = "the controller takes no points from its queue any more"
        states = self._connection.call("get_robot_state", (), self._timeout)
        reason, why = disabled(states)
        if reason:
            return self._finish(reason, f"{text}: {why}")
        safe = states[2:3] in ([SafetyState.RUN], [SafetyState.REDUCE])
        if safe and self._errors is not None and self._errors == self._read_errors():
            return self._finish(
                Reason.STOPPED,
                f"{text}, and reports no error: another program, or a person, has probably stopped "
                "the arm",
            )
        return self._refuse(
            f"{text}: the arm was stopped by another program, or an error has ended realtime mode"
        )

    def _read_errors(self) -> list[str] | None:
        """Read the controller's error list; None if it does not report one."""
        try:
            found: list[str] = self._connection.call("get_last_error", (), self._timeout)
        except ControllerError:
            return None
        return found

    def _more(self, count: int) -> list[bytes]:
        """The next points; after the last one, points at which the arm rests."""
        elements: list[bytes] = []
        for _ in range(count):
            values = self._feed.step()
            if values is None:
                break
            self._last = self._batch.element(self._feed.wire(values))
            elements.append(self._last)
        lacking = count - len(elements)
        self._depth.rest(lacking)
        return elements + [self._last] * lacking

    def _enqueue(self, elements: list[bytes]) -> bool:
        answer = self._batch.send(elements)
        self._sent += len(elements)
        return not refused(answer) or self._refuse(f"realtime_data_enqueue answered {answer}")

    def _accepted(
        self, name: str, args: tuple[Any, ...], permit: Callable[[], object] | None = None
    ) -> bool:
        answer = self._connection.call(name, args, self._timeout, permit)
        return not refused(answer) or self._refuse(f"{name} answered {answer}")

    def _refuse(self, text: str) -> bool:
        return self._finish(Reason.REFUSED, text)

    def _over(self) -> bool:
        """Add no more points; the worker then ends the mode."""
        self._running = False
        return False

    def brake(self, reason: Reason, text: str = "") -> None:
        """Come to rest at once, then end."""
        super().brake(reason, text)
        self._settling = 0  # the arm need not arrive where the points lead, also if they all came

    def end(self, reason: Reason, text: str = "") -> None:
        """Send nothing more."""
        super().end(reason, text)
        self._over()

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""
        super().publish()
        self._block.status[StatusWord.DRAINED] = self._depth.drained
        self._feed.publish()


class TrackPoolDriver(Driver):
    """The track pool (轨迹池, manual 1.3.12), kept between a low and a high mark.

    The controller itself plans the motion through the points, and comes to rest by itself when the
    pool is empty, so the worker neither interpolates nor limits.
    """

    def __init__(self, connection: Connection, block: Block, permit: StreamPermit) -> None:
        self._pool = pool = block.config.sent
        self._states = PoolStates(pool.low, pool.high, block.config.feeding.hold)
        super().__init__(self._states, connection, block)
        self._permit = permit
        name, element = ("trackEnqueueOp", _plain) if pool.extra else ("trackEnqueue", list)
        self._batch = Batch(connection, name, element, self._timeout, permit.require)
        self._depths = block.histograms["depth"].record
        self._age = block.histograms["age"].record
        self._checked: EnvelopeCheck | None = None

    def tick(self, hurry: bool) -> bool:  # noqa: ARG002 - the pool compensates lateness
        """Do the work of one tick; returns whether there is another one."""
        match self.state:
            case StreamState.WAITING:
                return self._start()
            case StreamState.FOLLOWING | StreamState.HOLDING:
                return self._serve()
            case StreamState.DECELERATING:
                return self._brakes() or self._finish(self.life.reason)
            case StreamState.ENDED:
                return False

    def _start(self) -> bool:
        ring = self._block.ring
        awaited = bool(self._block.control[ControlWord.WAKE_BELOW])
        if not self._states.may_begin(ring.level, ring.capacity, awaited=awaited):
            return self.state < StreamState.ENDED
        if not self._may_begin():
            return self.state < StreamState.ENDED
        first = ring.take()
        if first is None:
            return True
        actual = read_six(self._connection.call, self._pool.read, self._timeout)
        space = self._pool.space
        reach = tuple(self._block.config.feeding.reach)
        found = too_far(space, space.decode(actual), space.decode(first.values), reach)
        if found:
            return self._finish(Reason.TOO_FAR, found)
        if self._block.config.envelope is not None:
            # imported here: only a stream with an envelope needs it
            from aioduco.streaming.worker.checked import envelope_check  # noqa: PLC0415

            self._checked = envelope_check(
                self._block.config, self._connection, space.decode(actual), self._crossed
            )
        self._permit.begin()
        if refused(self._connection.call("trackClearQueue", (), self._timeout)):
            return self._finish(Reason.REFUSED, "trackClearQueue was refused")
        self._block.status[StatusWord.MODE] = 1  # before the points, since an answer may be lost
        return self._add(self._pool.high, first) >= 0 and self._go()

    def _serve(self) -> bool:
        start = time.monotonic_ns()
        left = max(0, self._connection.call("getQueueSize", (), self._timeout))
        self._depths(left)
        self._block.status[StatusWord.DEPTH] = left
        added = self._add(self._states.wanted(left))
        if added < 0:
            return False
        self._round_trip(time.monotonic_ns() - start)
        match self._states.look(left, added, start * 1e-9):
            case PoolAction.FINISH:
                return self._task_runs() or self._all_followed()
            case PoolAction.RESUME:
                if not self._resume():
                    return False
            case PoolAction.EMPTY:
                self._empty()
                return True
            case PoolAction.WAIT | PoolAction.FOLLOW:
                pass
        return self._follows(self.task if left else 0, waits=True)

    def _go(self) -> bool:
        """Start the controller's motion through the pool."""
        name, args = self._pool.function, tuple(self._pool.arguments)
        self.task: int = self._connection.call(name, args, self._timeout, self._permit.require)
        if refused(self.task):
            return self._finish(Reason.REFUSED, f"{name} answered {self.task}")
        self._states.begin()
        return True

    def _resume(self) -> bool:
        """Restart the motion if the controller has come to rest by itself, for no other reason."""
        state = self._state()
        if state in _RUNNING:
            return True
        reason, text = ended(self.task, state)
        if reason:
            return self._finish(reason, text)
        # The controller may have taken the last point in the meantime.
        return self._connection.call("getQueueSize", (), self._timeout) <= 0 or self._go()

    def _add(self, room: int, first: SetPoint | None = None) -> int:
        """Add points of the program to the pool.

        Returns:
            Number of points added; -1: the stream ends, because the controller refused points or a
            point crosses the envelope.
        """
        point = first
        elements: list[bytes] = []
        while len(elements) < room:
            point = point or self._block.ring.take()
            if point is None:
                break
            if self._checked is not None and (
                found := self._checked.line_to(self._pool.space.decode(point.values))
            ):
                self._crossed(found)
                return -1
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

    def _crossed(self, found: Crossing) -> None:
        self.brake(Reason.ENVELOPE, json.dumps(found))

    def _all_followed(self) -> bool:
        self._block.status[StatusWord.MODE] = 0
        return self._finish(Reason.CLOSED)

    def _empty(self) -> None:
        """Empty the pool, so that the controller comes to rest; again at the end, if refused."""
        if not refused(self._connection.call("trackClearQueue", (), self._timeout)):
            self._block.status[StatusWord.MODE] = 0

    def _brakes(self) -> bool:
        """Whether the arm still comes to rest: by itself, since the pool was emptied.

        A motion that somebody paused is stopped: it would not end before somebody resumes it.
        """
        if not self.task or (state := self._state()) not in _RUNNING:
            return False
        if state == TaskState.PAUSED:
            self._connection.call("stop", (True,), self._timeout)
            return False
        return True

    def _task_runs(self) -> bool:
        return bool(self.task) and self._state() in _RUNNING

    def _state(self) -> int:
        """State of the motion through the pool."""
        state: int = self._connection.call("get_noneblock_taskstate", (self.task,), self._timeout)
        return state

    def brake(self, reason: Reason, text: str = "") -> None:
        """Come to rest at once, then end."""
        if self._states.brake(reason, text):
            self._empty()

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""
        super().publish()
        status = self._block.status
        status[StatusWord.DRAINED] = self._states.drained
        status[StatusWord.STARVED] = self._states.starved
        status[StatusWord.TAKEN] = self._block.ring.read


def _plain(values: list[float]) -> PointOp:
    return PointOp(values, Op())
