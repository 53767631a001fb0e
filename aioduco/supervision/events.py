"""The stream of events: what happens to the robot, as it is seen."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

import anyio

from aioduco.errors import DucoError, RobotStateError
from aioduco.supervision.buffer import Buffer, Policy
from aioduco.supervision.changes import (
    ConnectionBack,
    ConnectionGone,
    ErrorsChanged,
    Event,
    HeartbeatChanged,
    changes,
    suspicious,
)
from aioduco.supervision.feed import Subscription

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco._wire.lane import Lane
    from aioduco.supervision.background import Background
    from aioduco.supervision.feed import Feed, Snapshot
    from aioduco.supervision.pulse import HeartbeatState

__all__ = ["Events"]

#: seconds without a sample after which the connection counts as gone
_GONE_AFTER = 0.5
#: seconds between two looks at the error list while nothing else points to it
_ERRORS_EVERY = 1.0
#: seconds between two looks at the heartbeat and at the age of the newest sample
_LOOK_EVERY = 0.02


class Events:
    """Sees what happens to one robot, and tells every subscriber.

    Args:
        feed: where samples come from.
        lane: where to ask for the error list.
        background: what runs this.
        heartbeat: the heartbeat's state.
    """

    def __init__(
        self,
        feed: Feed,
        lane: Lane,
        background: Background,
        heartbeat: Callable[[], HeartbeatState],
    ) -> None:
        self._feed = feed
        self._lane = lane
        self._background = background
        self._heartbeat = heartbeat
        self._subscriptions: list[Subscription[Event]] = []
        self._errors: tuple[str, ...] | None = None
        self._running = False
        self._closed = False

    def tell(self, event: Event) -> None:
        """Give an event to every subscriber; on the event loop."""
        for subscription in self._subscriptions:
            subscription.give(event)

    @contextmanager
    def subscribe(
        self, policy: Policy = "every", *, size: int = 1024
    ) -> Iterator[Subscription[Event]]:
        """Hear of every event from now on.

        Args:
            policy: what happens to events that are not taken in time; as for samples.
            size: most events that wait.

        Yields:
            The subscription, for `async for`. It raises `RobotStateError` when the robot closes.
        """
        if self._closed:
            raise RobotStateError("the robot is closed: no more events come")
        if not self._running:
            self._running = True
            self._background.start(self._watch_feed(), "aioduco events of the state")
            self._background.start(self._watch_lines(), "aioduco events of the lines")
        subscription = Subscription[Event](Buffer(policy, size))
        self._subscriptions.append(subscription)
        try:
            yield subscription
        finally:
            self._subscriptions.remove(subscription)

    def close(self) -> None:
        """End: no more events come."""
        self._closed = True
        for subscription in self._subscriptions:
            subscription.end(RobotStateError("the robot is closed: no more events come"))

    async def _watch_feed(self) -> None:
        before: Snapshot | None = None
        asked = -_ERRORS_EVERY
        with self._feed.subscribe() as samples:
            async for sample in samples:
                doubt = sample.received_at - asked >= _ERRORS_EVERY
                if before is not None:
                    for event in changes(before, sample):
                        self.tell(event)
                    doubt = doubt or suspicious(before, sample)
                if doubt:
                    asked = sample.received_at
                    await self._look_at_errors()
                before = sample

    async def _look_at_errors(self) -> None:
        try:
            errors = tuple(await self._lane.rpc.get_last_error())
        except DucoError:
            # The connection is watched elsewhere; the list is asked for again.
            return
        before, self._errors = self._errors, errors
        if before is not None and errors != before:
            added = tuple(error for error in errors if error not in before)
            self.tell(ErrorsChanged(time.monotonic(), errors, added))

    async def _watch_lines(self) -> None:
        heartbeat = self._heartbeat()
        gone_since: float | None = None
        due = time.monotonic()
        while True:
            now = time.monotonic()
            state = self._heartbeat()
            if state is not heartbeat:
                self.tell(HeartbeatChanged(now, heartbeat, state))
                heartbeat = state
            heard = self._feed.heard_at
            limit = max(_GONE_AFTER, 3.0 / self._feed.rate)
            if gone_since is None and now - heard > limit and self._feed.error is not None:
                gone_since = heard
                self.tell(ConnectionGone(now, str(self._feed.error)))
            elif gone_since is not None and heard > gone_since:
                self.tell(ConnectionBack(now, heard - gone_since))
                gone_since = None
            due = max(due + _LOOK_EVERY, now)
            await anyio.sleep(due - now)
