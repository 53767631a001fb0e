"""What one reader gets of the state feed and of the events."""

from __future__ import annotations

from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Generic, Self, TypeVar

import anyio

from aioduco._process import trial
from aioduco.models.ranges import WAIT
from aioduco.sync._blocking import Blocking

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.supervision import state_feed as aio_feed
    from aioduco.sync._runner import Runner


T = TypeVar("T")


class Subscription(Blocking, Generic[T]):
    """Items for one reader: `for item in subscription`. It raises when the robot closes."""

    _made: aio_feed.Subscription[T]

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> T:
        return self.next()

    @property
    def dropped(self) -> int:
        """Number of items that were dropped because they were not taken in time."""
        return self._made.dropped

    def next(self, timeout: float | None = None) -> T:
        """Wait for the next item.

        Args:
            timeout: seconds for which to wait; 0 for one that waits already; None for no limit.

        Raises:
            ParameterError: the time is below 0.
            TimeoutError: none came in time.
            RobotStateError: the robot was closed, or the block of the subscription has ended.
        """
        if timeout is not None:
            timeout = WAIT("timeout", timeout)
        return self._call(self._next(timeout))

    async def _next(self, timeout: float | None) -> T:
        pace = nullcontext() if timeout is None else trial.at_own_pace()
        with pace, anyio.move_on_after(None if self._made.ready else timeout):
            return await anext(self._made)
        raise TimeoutError(f"nothing came within {timeout:g} s")


@contextmanager
def reading(
    runner: Runner, opened: AbstractContextManager[aio_feed.Subscription[T]]
) -> Iterator[Subscription[T]]:
    """Begin a subscription on the robot's event loop, and end it there."""
    subscription = runner.call_sync(opened.__enter__)
    try:
        yield Subscription(runner, subscription)
    finally:
        runner.call_sync(lambda: opened.__exit__(None, None, None))
