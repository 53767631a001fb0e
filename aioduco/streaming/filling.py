"""When to fill the controller's queues, and when their end has come. Pure: no clock, no calls."""

from __future__ import annotations

from enum import Enum, auto

from aioduco.streaming.source import Reason, State

__all__ = ["Depth", "Pooled", "Todo"]

_MOST = 100  # points in one call: about 6 kB


class Depth:
    """How many points the realtime queue wants, and whether the controller takes any.

    Args:
        depth: points to keep in the queue.
        patience: time for which a full queue may stay so, before the controller counts as one
            that takes nothing any more [s].

    Attributes:
        drained: looks at which the queue was empty.
        stuck: whether the controller takes nothing any more.
    """

    def __init__(self, depth: int, patience: float) -> None:
        self._depth = depth
        self._patience = patience
        self._full_since: float | None = None
        self._resting = 0
        self.drained: int = 0
        self.stuck: bool = False

    def look(self, left: int, now: float) -> int:
        """Take account of a look at the queue.

        Args:
            left: points in it.
            now: the time [s].

        Returns:
            How many points to add.
        """
        self.drained += left == 0
        wanted = min(self._depth - left, _MOST)
        if wanted > 0:
            self._full_since = None
            return wanted
        if self._full_since is None:
            self._full_since = now
        self.stuck = now - self._full_since > self._patience
        return 0

    def rest(self, count: int) -> None:
        """So many points were added at which the arm rests, for lack of others."""
        self._resting += count

    @property
    def at_rest(self) -> bool:
        """Whether the queue holds nothing but rest."""
        return self._resting >= self._depth


class Todo(Enum):
    """What is to be done about the track pool after a look at it."""

    FOLLOW = auto()
    """Nothing: the arm follows."""
    RESUME = auto()
    """The pool had run dry: have the controller begin anew, if it has come to rest."""
    WAIT = auto()
    """Nothing: the pool is dry, and the program sends nothing."""
    FINISH = auto()
    """End, once the arm has come to rest at the last point."""
    EMPTY = auto()
    """Empty the pool, so that the arm comes to rest: the program sends nothing any more."""


class Pooled:
    """The states of a stream through the track pool.

    WAITING until there are enough points to begin with; HOLDING while the pool is dry, where the
    controller comes to rest by itself; DECELERATING once the pool was emptied on purpose.

    Args:
        low: fill the pool up when it has fewer points.
        high: fill it up to so many.
        hold: time with a dry pool after which the stream ends [s].

    Attributes:
        state: the state.
        reason: why it ends; NONE before.
        drained: times at which the pool ran dry though the program was not done.
        starved: looks at which it was dry then.
    """

    def __init__(self, low: int, high: int, hold: float) -> None:
        self._low = low
        self._high = high
        self._hold = hold
        self._closing = False
        self._dry_since: float | None = None
        self.state: State = State.WAITING
        self.reason: Reason = Reason.NONE
        self.drained: int = 0
        self.starved: int = 0

    def may_begin(self, waiting: int, capacity: int) -> bool:
        """Whether there are enough points to begin with.

        The controller follows at its best with enough points in its pool, so they are waited for.

        Args:
            waiting: points that the program has sent.
            capacity: how many of them fit before they are taken.
        """
        if self._closing and not waiting:
            self.end(Reason.CLOSED)
        return waiting > 0 and (self._closing or waiting >= min(self._low, capacity))

    def begin(self) -> None:
        """The controller follows the pool."""
        self.state = State.FOLLOWING

    def wanted(self, left: int) -> int:
        """How many points to add to a pool that has so many left."""
        return self._high - left if left < self._low else 0

    def look(self, left: int, added: int, now: float) -> Todo:
        """Take account of a look at the pool.

        Args:
            left: points that were in it.
            added: points that were added to it.
            now: the time [s].
        """
        was_dry = self._dry_since is not None
        if left or added:
            self._dry_since = None
            self.state = State.FOLLOWING
            return Todo.RESUME if was_dry and added else Todo.FOLLOW
        if self._dry_since is None:
            self._dry_since = now
            self.drained += not self._closing
        if self._closing:
            return Todo.FINISH
        self.starved += 1
        self.state = State.HOLDING
        if now - self._dry_since > self._hold:
            self.brake(Reason.STARVED)
            return Todo.EMPTY
        return Todo.WAIT

    def close(self) -> None:
        """The program sends nothing more."""
        self._closing = True

    def brake(self, reason: Reason) -> bool:
        """Come to rest at once, then end.

        Returns:
            Whether the pool is to be emptied for that.
        """
        if self.state is State.WAITING:
            self.end(reason)
        if self.state >= State.DECELERATING:
            return False
        self.state, self.reason = State.DECELERATING, reason
        return True

    def end(self, reason: Reason) -> None:
        """Send nothing more."""
        if self.state is not State.ENDED:
            self.state, self.reason = State.ENDED, self.reason or reason
