"""From what the program sends to one set-point per tick: the states of a stream. Pure.

WAITING     nothing has been sent yet.
FOLLOWING   the program sends, and the arm follows.
HOLDING     the program is late. The arm goes to the last target and stands there; a stream of
            speeds keeps its speed. A new set-point leads back to FOLLOWING.
DECELERATING  the end is decided and its reason known. Nothing more is taken; the arm comes to
            rest within the limits.
ENDED       nothing more is sent.

There is no way back from DECELERATING or ENDED, and the first reason stays.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.streaming.ring import SetPoint
    from aioduco.streaming.space import Config, Space

__all__ = ["Follows", "Reason", "Source", "State", "within"]

_LONGEST = 0.5  # seconds between two targets beyond which their slope says nothing
_FIRST = 0.05  # taken for the interval before there is one
_LATE = 1.2  # share of the interval in which a target is met: the next one may be a bit late
_DUE = 1.5  # share of the interval after which an unpaced set-point counts as late
_ROUNDING = 1 - 1e-9


class State(IntEnum):
    """State of a stream."""

    WAITING = 0
    FOLLOWING = 1
    HOLDING = 2
    DECELERATING = 3
    ENDED = 4


class Reason(IntEnum):
    """Why a stream ended."""

    NONE = 0
    #: the program closed it
    CLOSED = 1
    #: the program left the stream by an error or a cancellation
    ABORTED = 2
    #: the program sent nothing for longer than the hold time
    STARVED = 3
    #: the program died
    PROGRAM_DIED = 4
    #: the robot was stopped
    STOPPED = 5
    #: the first set-point was too far from where the arm is
    TOO_FAR = 6
    #: the controller refused a set-point, or left the state in which it takes any
    REFUSED = 7
    #: the connection to the controller broke, or an answer did not come in time
    CONNECTION = 8
    #: the lane ended by an error of its own
    FAILED = 9
    #: the lane's process is gone
    LANE_DIED = 10
    #: the program's event loop hung, or the robot's heartbeat was lost
    HUNG = 11


class Follows(Protocol):
    """What a source needs of a `Follower` or of `Rates`."""

    @property
    def config(self) -> Config: ...  # noqa: D102
    @property
    def ready(self) -> bool: ...  # noqa: D102
    @property
    def at_rest(self) -> bool: ...  # noqa: D102
    def aim(self, target: Config, interval: float, duration: float) -> None: ...  # noqa: D102
    def step(self) -> Config: ...  # noqa: D102
    def brake(self) -> Config: ...  # noqa: D102


class Source:
    """One set-point per tick, until a defined end.

    Args:
        space: the space of the set-points.
        period: time between two ticks [s].
        hold: time without a set-point after which the stream ends [s].
        interval: time between two targets of the program [s]; None: measured by their stamps.
        paced: whether each target has its whole interval before the next one is taken (first
            in, first out); otherwise the next one is taken as soon as it is there.
        reach: how far the first target may be from where the arm is, per group [rad, m].
        rates: whether the set-points are speeds, which end at zero.

    Attributes:
        state: the state.
        reason: why it ends; NONE before.
        starved: ticks in which the arm moved, a set-point was due and none was there.
    """

    def __init__(
        self,
        space: Space,
        period: float,
        *,
        hold: float,
        interval: float | None = None,
        paced: bool = False,
        reach: tuple[float, ...] = (),
        rates: bool = False,
    ) -> None:
        self._space = space
        self._period = period
        self._hold = hold
        self._fixed = interval
        self._interval = _FIRST if interval is None else interval
        self._paced = paced
        self._reach = reach
        self._rates = rates
        self._follower: Follows | None = None
        self._closing = False
        self._stamp = 0
        self._idle = 0
        self.state: State = State.WAITING
        self.reason: Reason = Reason.NONE
        self.starved: int = 0

    def begin(self, follower: Follows) -> None:
        """Take what follows the targets; it stands where the arm is."""
        self._follower = follower

    def close(self) -> None:
        """The program sends nothing more: follow to the last target, then end."""
        self._closing = True

    def brake(self, reason: Reason) -> None:
        """Come to rest at once, then end."""
        if self.state is State.WAITING:
            self.end(reason)
        if self.state < State.DECELERATING:
            self.state, self.reason = State.DECELERATING, reason

    def end(self, reason: Reason) -> None:
        """Send nothing more: the arm is stopped by others, or cannot be reached."""
        if self.state < State.ENDED:
            self.state = State.ENDED
            self.reason = self.reason or reason

    def step(self, take: Callable[[], SetPoint | None]) -> Config | None:
        """Go on by one tick.

        Args:
            take: returns the program's next set-point, if there is one.

        Returns:
            What to send; None: nothing.
        """
        follower = self._follower
        if follower is None or self.state is State.ENDED:
            if self._closing:
                self.end(Reason.CLOSED)
            return None
        if self.state is not State.DECELERATING:
            self._follow(follower, take)
        match self.state:
            case State.WAITING | State.ENDED:
                return None
            case State.DECELERATING:
                config = follower.brake()
                if follower.at_rest:
                    self.state = State.ENDED
            case _:
                config = follower.step()
        return config

    def _follow(self, follower: Follows, take: Callable[[], SetPoint | None]) -> None:
        point = take() if follower.ready or not self._paced else None
        if point is not None:
            self._aim(follower, point)
        elif self.state is State.WAITING:
            if self._closing:
                self.end(Reason.CLOSED)
        elif self._closing and follower.ready:
            self._finish(follower)
        else:
            self._wait(follower)

    def _aim(self, follower: Follows, point: SetPoint) -> None:
        target = point.values if self._rates else self._space.decode(point.values)
        if self.state is State.WAITING:
            if not self._rates and not within(self._space, follower.config, target, self._reach):
                self.end(Reason.TOO_FAR)
                return
        elif self._fixed is None:
            since = (point.stamp - self._stamp) * 1e-9
            self._interval = max(self._period, min(since, _LONGEST))
        self._stamp = point.stamp
        self._idle = 0
        self.state = State.FOLLOWING
        duration = self._interval if self._paced else self._interval * _LATE
        follower.aim(target, self._interval, duration)

    def _finish(self, follower: Follows) -> None:
        """All was taken: stay until the last target is met."""
        if self._rates:
            self.brake(Reason.CLOSED)
        elif follower.at_rest:
            self.end(Reason.CLOSED)

    def _wait(self, follower: Follows) -> None:
        """A tick without a set-point of its own; it matters only while the arm moves."""
        self._idle += 1
        idle = self._idle * self._period
        due = self._interval if self._paced else self._interval * _DUE
        if idle < due * _ROUNDING:
            return
        self.starved += not follower.at_rest
        self.state = State.HOLDING
        if idle > self._hold:
            self.brake(Reason.STARVED)


def within(space: Space, start: Config, end: Config, reach: tuple[float, ...]) -> bool:
    """Whether a point is no further from another one than a distance for each group."""
    gap = space.difference(start, end)
    lengths = (sum(g * g for g in gap[group]) ** 0.5 for group in space.groups)
    return all(length <= most for length, most in zip(lengths, reach, strict=True))
