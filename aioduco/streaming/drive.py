"""What a lane does in one tick, for streams with one call per tick: servo and speeds."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Protocol

from aioduco.streaming.calls import Point
from aioduco.streaming.limits import Limits
from aioduco.streaming.rates import Rates
from aioduco.streaming.shared import Status
from aioduco.streaming.source import Reason, Source, State
from aioduco.streaming.space import JOINT_SPACE, POSE_SPACE
from aioduco.streaming.upsample import Follower

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.ring import Ring, SetPoint
    from aioduco.streaming.shared import Block
    from aioduco.streaming.space import Config, Space

__all__ = ["Driver", "Each", "Feed", "Watch"]

_ENABLED = 6  # robot state (manual 1.2)
_TASK_STOPPED = 3
_TASK_FAILED = (6, 7, 8)  # error, illegal, parameter mismatch (manual 1.2)


class Driver(Protocol):
    """One way to bring set-points to the controller."""

    @property
    def state(self) -> State:
        """State of the stream."""
        raise NotImplementedError

    @property
    def reason(self) -> Reason:
        """Why it ends."""
        raise NotImplementedError

    def tick(self, hurry: bool) -> bool:
        """Do the work of one tick; returns whether there is another one.

        Args:
            hurry: the next tick is due before an answer can be here.
        """
        raise NotImplementedError

    def close(self) -> None:
        """The program sends nothing more."""

    def brake(self, reason: Reason) -> None:
        """Come to rest at once, then end."""

    def end(self, reason: Reason) -> None:
        """Send nothing more."""

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""


class Feed:
    """Set-points from the shared ring through limits: what servo, speed and realtime share.

    Args:
        config: the lane's configuration.
        connection: the lane's connection, open.
        block: the shared block.
    """

    def __init__(self, config: dict[str, Any], connection: Connection, block: Block) -> None:
        self.config = config
        self.connection = connection
        self.block = block
        self.ring: Ring = block.ring
        self.timeout: float = float(config["timeout"])
        self.space: Space = JOINT_SPACE if config["space"] == "joints" else POSE_SPACE
        self.rates: bool = bool(config["rates"])
        #: whether each call carries the step from the set-point before, in the tool's frame
        self.offsets: bool = bool(config["offsets"])
        self._before = POSE_SPACE.decode((0.0,) * 6)
        self.period: float = float(config["point_period"])
        self.limits: Limits = Limits(*(tuple(values) for values in config["limits"]))
        self.source: Source = Source(
            self.space,
            self.period,
            hold=config["hold"],
            interval=config["interval"],
            paced=not config["latest"],
            reach=tuple(config["reach"]),
            rates=self.rates,
        )
        self._follower: Follower | Rates | None = None
        self._sent: tuple[float, ...] | None = None
        self._next = self.ring.newest if config["latest"] else self.ring.take
        self._age = block.histograms["age"].record

    def begin(self) -> bool:
        """Find out where the arm is, once there is a first set-point.

        Returns:
            Whether the stream has begun.
        """
        if self._follower is not None:
            return True
        if not self.ring.level:
            return False
        if self.rates:
            self._follower = Rates(self.space, self.limits, self.period)
        else:
            actual = self._actual()
            self._follower = Follower(
                self.config["upsample"],
                self.space,
                self.limits,
                self.period,
                self.space.decode(actual),
            )
        self.source.begin(self._follower)
        return True

    def _actual(self) -> list[float]:
        """Where the arm is; offsets count from there, so for them that is zero."""
        if self.offsets:
            return [0.0] * 6
        name, *args = self.config["read"]
        actual: list[float] = self.connection.call(name, tuple(args), self.timeout)
        return actual

    def step(self) -> tuple[float, ...] | None:
        """The next set-point for the controller; None when there is nothing to send."""
        config = self.source.step(self._take)
        if config is None:
            return None
        self._sent = self.values(config)
        return self._sent

    def resting(self) -> tuple[float, ...]:
        """The set-point at which the arm stays as it is; only after `begin`."""
        assert self._follower is not None
        return self.values(self._follower.config)

    def values(self, config: Config) -> tuple[float, ...]:
        """The six numbers of the wire."""
        if self.rates:
            return config
        if not self.offsets:
            return self.space.encode(config)
        before, self._before = self._before, config
        return POSE_SPACE.encode(POSE_SPACE.offset(before, config))

    def _take(self) -> SetPoint | None:
        point = self._next()
        if point is not None:
            self._age(time.monotonic_ns() - point.stamp)
        return point

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        status = self.block.status
        status[Status.STARVED] = self.source.starved
        status[Status.TAKEN] = self.ring.read
        status[Status.OVERWRITTEN] = self.ring.overwritten
        if self._follower is not None:
            status[Status.LIMITED] = self._follower.limited
        if self._sent is not None:
            self.block.report.overwrite(self._sent, time.monotonic_ns())


class Watch:
    """Looks, now and then, at whether the controller still follows.

    Args:
        connection: the lane's connection.
        every: time between two looks [s]; 0: never.
        timeout: time for each call [s].
    """

    def __init__(self, connection: Connection, every: float, timeout: float) -> None:
        self._connection = connection
        self._every = int(every * 1e9)
        self._timeout = timeout
        self._due = time.monotonic_ns() + self._every
        self._task_next = False

    def look(self, task: int) -> tuple[Reason, str]:
        """Look, if it is time to.

        Args:
            task: the id that the controller gave for the last set-point; 0: none.

        Returns:
            Why the stream must end, and in words; NONE if it need not.
        """
        now = time.monotonic_ns()
        if not self._every or now < self._due:
            return Reason.NONE, ""
        self._due = now + self._every
        self._task_next = not self._task_next
        if self._task_next and task > 0:
            state = self._connection.call("get_noneblock_taskstate", (task,), self._timeout)
            if state == _TASK_STOPPED:
                return Reason.STOPPED, f"the controller stopped task {task}"
            if state in _TASK_FAILED:
                return Reason.REFUSED, f"task {task} ended in state {state} (manual 1.2)"
            return Reason.NONE, ""
        robot, *_ = self._connection.call("get_robot_state", (), self._timeout) or [_ENABLED]
        if robot != _ENABLED:
            return Reason.REFUSED, f"the robot is in state {robot}, not enabled (manual 1.2)"
        return Reason.NONE, ""


class Each:
    """One call per tick: servoj, servoj_pose, servo_tcp, servol, speedj, speedl."""

    def __init__(self, config: dict[str, Any], connection: Connection, block: Block) -> None:
        self._feed = Feed(config, connection, block)
        self._block = block
        arguments, slot = config["arguments"], int(config["slot"])

        def args(values: list[float]) -> tuple[Any, ...]:
            return (*arguments[:slot], values, *arguments[slot + 1 :])

        self._name = config["function"]
        self._point = Point(connection, self._name, args, self._feed.timeout)
        self._watch = Watch(connection, config["watch"], self._feed.timeout)
        self._round_trip = block.histograms["round_trip"].record
        self._ahead: tuple[float, ...] | None = None
        self._task = 0
        self._sent = 0

    @property
    def state(self) -> State:
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
            start = time.monotonic_ns()
            self._task = self._point.send(values, self._look_ahead if hurry else None)
            self._round_trip(time.monotonic_ns() - start)
            self._sent += 1
            if self._task < 0:
                return self._finish(Reason.REFUSED, f"{self._name} answered {self._task}")
        if self.state is State.ENDED and self._ahead is None:
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
        self._block.status[Status.SENT] = self._sent
        self._feed.publish()
