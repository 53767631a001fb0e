"""The state feed and the events for blocking programs."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Generic, TypeVar

import anyio

from aioduco.models.ranges import WAIT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager
    from typing import Self

    from aioduco.errors import DucoError
    from aioduco.supervision import events as aio_events
    from aioduco.supervision import state_feed as aio_feed
    from aioduco.supervision.events import Event
    from aioduco.supervision.state_feed import FeedStatistics, Policy, Snapshot
    from aioduco.sync._runner import Runner

__all__ = ["Events", "Feed", "Subscription"]

T = TypeVar("T")


class Subscription(Generic[T]):
    """Items for one reader: `for item in subscription`. It raises when the robot closes."""

    def __init__(self, runner: Runner, subscription: aio_feed.Subscription[T]) -> None:
        self._runner = runner
        self._subscription = subscription

    def __repr__(self) -> str:
        return repr(self._subscription)

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> T:
        return self.next()

    @property
    def dropped(self) -> int:
        """Number of items that were dropped because they were not taken in time."""
        return self._subscription.dropped

    def next(self, timeout: float | None = None) -> T:
        """Wait for the next item.

        Args:
            timeout: seconds for which to wait; 0 for one that waits already; None for no limit.

        Raises:
            ParameterError: the time is below 0.
            TimeoutError: none came in time.
            RobotStateError: the robot was closed.
        """
        if timeout is not None:
            timeout = WAIT("timeout", timeout)
        return self._runner.call(self._next(timeout))

    async def _next(self, timeout: float | None) -> T:
        with anyio.move_on_after(None if self._subscription.ready else timeout):
            return await anext(self._subscription)
        raise TimeoutError(f"nothing came within {timeout:g} s")


@contextmanager
def _reading(
    runner: Runner, opened: AbstractContextManager[aio_feed.Subscription[T]]
) -> Iterator[Subscription[T]]:
    subscription = runner.call_sync(opened.__enter__)
    try:
        yield Subscription(runner, subscription)
    finally:
        runner.call_sync(lambda: opened.__exit__(None, None, None))


class Feed:
    """Samples of the robot's state. The sampling begins at the first use."""

    def __init__(self, runner: Runner, feed: aio_feed.StateFeed) -> None:
        self._runner = runner
        self._feed = feed

    def __repr__(self) -> str:
        return repr(self._feed)

    @property
    def rate(self) -> float:
        """Requested samples per second [Hz]."""
        return self._feed.rate

    @property
    def forces(self) -> bool:
        """Whether samples include forces: two more calls to the controller for each sample."""
        return self._feed.forces

    @forces.setter
    def forces(self, wanted: bool) -> None:
        self._feed.forces = wanted

    @property
    def error(self) -> DucoError | None:
        """Why the last request was not answered; None if it was."""
        return self._feed.error

    @property
    def heard_at(self) -> float:
        """Time of the last sample, or, before the first one, of the feed's begin [s]."""
        return self._feed.heard_at

    def statistics(self) -> FeedStatistics:
        """Figures since the feed began."""
        return self._runner.call_sync(self._feed.statistics)

    def latest(self, *, max_age: float = 0.5) -> Snapshot:
        """Return the newest sample; wait for the first one.

        Args:
            max_age: largest age of the sample [s].

        Raises:
            ParameterError: the age is not above 0.
            StaleState: the sample is older, since the controller does not answer.
        """
        return self._runner.call(self._feed.latest(max_age=max_age))

    def subscribe(
        self, policy: Policy = "drop_oldest", *, size: int = 64
    ) -> AbstractContextManager[Subscription[Snapshot]]:
        """Read every sample from now on: `with robot.feed.subscribe() as samples:`.

        Args:
            policy: what happens to samples that are not taken in time: "latest" keeps the newest
                one, "drop_oldest" the newest `size`, "every" raises when `size` are waiting.
            size: maximum number of waiting samples.

        Returns:
            A context manager that gives the subscription. The subscription raises
            `RobotStateError` when the robot closes.
        """
        return _reading(self._runner, self._feed.subscribe(policy, size=size))

    def wait_for(
        self, predicate: Callable[[Snapshot], bool], *, timeout: float | None = None
    ) -> Snapshot:
        """Wait for a sample for which the predicate is true, and return it.

        Samples that were received before this was called do not count.

        Args:
            predicate: called with each sample, on the thread of the robot's event loop: it
                must not call the robot.
            timeout: seconds for which to wait; None for no limit.

        Raises:
            ParameterError: the time is not above 0.
            TimeoutError: none came in time.
        """
        return self._runner.call(self._feed.wait_for(predicate, timeout=timeout))


class Events:
    """Distributes the events of one robot to every subscriber."""

    def __init__(self, runner: Runner, events: aio_events.Events) -> None:
        self._runner = runner
        self._events = events

    def subscribe(
        self, policy: Policy = "every", *, size: int = 1024
    ) -> AbstractContextManager[Subscription[Event]]:
        """Receive every event from now on: `with robot.events.subscribe() as stream:`.

        Args:
            policy: what happens to events that are not taken in time; as for samples.
            size: maximum number of waiting events.

        Returns:
            A context manager that gives the subscription. The subscription raises
            `RobotStateError` when the robot closes.
        """
        return _reading(self._runner, self._events.subscribe(policy, size=size))
