"""The feed of the robot's state: samples at a steady rate, for any number of readers.

Guarantees:
- It reads over a separate lane, so neither a stop nor the following of tasks waits for it.
- Each sample has the time when it was received. A sample that is older than a reader allows is
  never returned: `StaleState` is raised instead.
- A slow reader delays no other code: the reader chooses what happens to samples that it does not
  take in time, and dropped samples are counted.
"""

from __future__ import annotations

import time
from collections import deque
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Literal, NamedTuple, Self, TypeAlias, TypeVar, get_args

import anyio

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco.errors import DucoError, FeedOverflow, ParameterError, RobotStateError, StaleState
from aioduco.models.ranges import FLAG, STATE_RATE
from aioduco.models.ranges import TIMEOUT as SECONDS
from aioduco.models.rules import Integer, condition_holds
from aioduco.models.similar import MisspeltRefused
from aioduco.models.state import ForceStatus, IOStatus, RobotStates, RobotStatus, Sample
from aioduco.models.words import one_of
from aioduco.supervision.concurrency import Alarm, BackgroundTasks, every, on_grid

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco._wire.codec import ReadResult
    from aioduco._wire.lane import Question, WireLane
    from aioduco._wire.owner_loop import OwnerLoop
    from aioduco.models.samples import Samples


_SIZE = Integer(1, 2**31 - 1, source="this package")

T = TypeVar("T")

Policy: TypeAlias = Literal["latest", "drop_oldest", "every"]


class Subscription(Uncopied, Generic[T]):
    """Items for one reader: `async for item in subscription`.

    Args:
        policy: what happens to items that are not taken in time. "latest": a new item replaces
            the previous one. "drop_oldest": the oldest item is dropped when `size` are waiting.
            "every": no waiting item is dropped; when `size` are waiting, new items are dropped, and
            `take` raises `FeedOverflow` after the last waiting one, so that no gap is hidden.
        size: maximum number of waiting items; 1 with "latest".
        owner_loop: the event loop to which the robot belongs.

    Attributes:
        dropped: number of items that were dropped because they were not taken in time.
    """

    def __init__(self, policy: Policy, size: int, owner_loop: OwnerLoop) -> None:
        one_of("policy", policy, get_args(Policy))
        self._policy = policy
        size = _SIZE("size", size)
        self._size = 1 if policy == "latest" else size
        self._owner_loop = owner_loop
        self._items: deque[T] = deque()
        self._overflown = False
        self._there = Alarm()
        self._over: DucoError | None = None
        self.dropped: int = 0

    def __repr__(self) -> str:
        return (
            f"<Subscription {self._policy}, {len(self._items)} of {self._size} waiting, "
            f"{self.dropped} dropped>"
        )

    @property
    def ready(self) -> bool:
        """Whether the next item is there already, or an error instead of it."""
        return bool(self._items) or self._overflown or self._over is not None

    def give(self, item: T) -> None:
        """Add an item; on the event loop."""
        self._add(item)
        self._there.ring()

    def _add(self, item: T) -> None:
        if len(self._items) == self._size:
            self.dropped += 1
            if self._policy == "every":
                self._overflown = True
                return
            self._items.popleft()
        elif self._overflown:
            # after a gap no item is added until `take` has raised `FeedOverflow`
            self.dropped += 1
            return
        self._items.append(item)

    def take(self) -> T:
        """Take the oldest item.

        Raises:
            FeedOverflow: items were dropped here. The next call continues after the gap.
            IndexError: no item waits.
        """
        if self._items:
            return self._items.popleft()
        if self._overflown:
            self._overflown = False
            raise FeedOverflow(
                f"more than {self._size} items waited, and {self.dropped} were dropped: take them "
                "faster, ask for a larger size, or choose another policy"
            )
        raise IndexError("nothing waits")

    def end(self, error: DucoError) -> None:
        """End the subscription: the reader gets the first such error after the waiting items."""
        self._over = self._over or error
        try:
            self._there.ring()
        except RuntimeError:
            # the reader's event loop was closed: no reader waits any more
            return

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        """Wait for the next item.

        Raises:
            FeedOverflow: items were dropped here.
            RobotStateError: the robot was closed, the subscription's block has ended, or another
                task waits for the next item.
        """
        self._owner_loop.require("the next item")
        if self._items or self._overflown:
            # else the wait below is a checkpoint
            await anyio.lowlevel.checkpoint()
        while not (self._items or self._overflown):
            if self._over is not None:
                raise self._over
            if self._there.awaited:  # it would not be woken any more
                raise RobotStateError(
                    "another task waits for the next item of this subscription, which is for one "
                    "reader: subscribe once for each"
                )
            await self._there.wait()
        return self.take()


def left() -> RobotStateError:
    """The error for a reader that is in another task, or behind the subscription's block."""
    return RobotStateError("nothing more comes of this subscription: its block has ended")


#: weight of a new interval in the measured rate
_SMOOTHING = 0.1
#: functions that are called for each sample, and further ones if forces are wanted
_STATE = (("get_robot_state", ()), ("getRobotStatus", ()), ("getRobotIOStatus", ()))
_FORCES = (("get_tcp_force", ()), ("get_ext_torque", ()))
#: seconds between two attempts while the controller does not answer
_RETRY_EVERY = 0.1
#: seconds without a sample after which it counts as silent, and how many samples that are, at least
_SILENT_AFTER, _SILENT_SAMPLES = 0.5, 3.0
#: seconds by which a wait is late if the loop was blocked meanwhile
_HELD_UP = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot(Sample):
    """Everything that the feed reads at one moment.

    `received_at` is that of its oldest part.

    Attributes:
        states: states of robot, program, safety and mode.
        status: positions, speeds, faults.
        io: inputs, outputs and registers.
        read_forces: force and external torques; None if the feed does not read them.
    """

    states: RobotStates
    status: RobotStatus
    io: IOStatus
    read_forces: ForceStatus | None = None

    @property
    def forces(self) -> ForceStatus:
        """Force at the tool and external torques of the joints.

        Raises:
            RobotStateError: the feed was not set to read them.
        """
        if self.read_forces is None:
            raise RobotStateError(
                "this sample has no forces: set robot.feed.forces = True, and take a later one"
            )
        return self.read_forces


class FeedStatistics(NamedTuple):
    """Statistics of a feed.

    Attributes:
        rate: requested samples per second [Hz].
        measured_rate: recent samples per second [Hz]; 0.0 before the second sample.
        samples: number of samples.
        failures: number of reads that the controller did not answer.
        subscribers: number of present subscribers.
        dropped: number of samples that the present subscribers did not take in time.
    """

    rate: float
    measured_rate: float
    samples: int
    failures: int
    subscribers: int
    dropped: int


class StateFeed(Uncopied, MisspeltRefused):
    """Samples of the robot's state. It starts on first use.

    Args:
        lane: lane on which it reads; apart from the feed, only `Events` uses it.
        samples: makes samples.
        background: runs the feed.
        rate: samples per second [Hz].
        along: gets the seconds until the next sample; returns what is asked along with this one,
            and what is called with the answer, or None.
    """

    def __init__(
        self,
        lane: WireLane,
        samples: Samples,
        background: BackgroundTasks,
        rate: float,
        along: Callable[[float], tuple[Question, Callable[[ReadResult], object]] | None],
    ) -> None:
        self._lane = lane
        self._samples = samples
        self._background = background
        self._along = along
        self._subscriptions: list[Subscription[Snapshot]] = []
        self._latest: Snapshot | None = None
        self._error: DucoError | None = None
        self._running = False
        self._closed = False
        self._interval: float | None = None
        self._begun = time.monotonic()
        self._count = 0
        self._failures = 0
        self._rate = rate
        self._forces = False
        #: number of recordings and publications that want forces, whatever the program wants
        self.force_readers = 0

    def __repr__(self) -> str:
        figures = self.statistics()
        return f"<StateFeed {figures.rate:g} Hz, {figures.measured_rate:.1f} Hz measured>"

    @property
    def forces(self) -> bool:
        """Whether samples have forces, too: two more reads from the controller for each."""
        return self._forces

    @forces.setter
    def forces(self, forces: bool) -> None:
        self._forces = FLAG("forces", forces)

    @property
    def rate(self) -> float:
        """Requested samples per second, above 0 to 1000 [Hz]; may be set at any time.

        Raises:
            ParameterError: the rate is out of range; the former one stays.
        """
        return self._rate

    @rate.setter
    def rate(self, rate: float) -> None:
        self._rate = STATE_RATE("rate", rate)

    @property
    def error(self) -> DucoError | None:
        """Error of the last read; None if it was answered."""
        return self._error

    @property
    def heard_at(self) -> float:
        """When the last sample came, or, before the first, when the feed began [s]."""
        return self._begun if self._latest is None else trial.wall(self._latest.received_at)

    @property
    def silence_limit(self) -> float:
        """Time without a sample after which nobody knows the state any more [s]."""
        return max(_SILENT_AFTER, _SILENT_SAMPLES / self._rate)

    def statistics(self) -> FeedStatistics:
        """Return statistics since the feed began."""
        return FeedStatistics(
            rate=self.rate,
            measured_rate=1.0 / self._interval if self._interval else 0.0,
            samples=self._count,
            failures=self._failures,
            subscribers=len(self._subscriptions),
            dropped=sum(subscription.dropped for subscription in self._subscriptions),
        )

    async def latest(self, *, max_age: float = 0.5) -> Snapshot:
        """Return the newest sample; wait for the first one.

        Args:
            max_age: maximum age of the sample [s].

        Raises:
            ParameterError: the age is not above 0.
            StaleState: it is older, because the controller does not answer.
        """
        max_age = SECONDS("max_age", max_age)
        self._begin()
        for _ in range(2):
            if self._fresh(max_age):
                break
            # The next sample, or the first: it may come within the allowed time.
            until = time.monotonic() + max_age
            with anyio.move_on_after(max_age), self.subscribe() as subscription:
                while True:
                    sample = await anext(subscription)
                    if self._complete(sample):
                        return sample
            # If the loop was blocked meanwhile, it could not take a sample, although the controller
            # may have answered: try once more.
            if time.monotonic() < until + _HELD_UP:
                break
        snapshot = self._latest
        if snapshot is not None and self._fresh(max_age):
            return snapshot
        age = "there is none yet" if snapshot is None else f"the newest is {snapshot.age:.2f} s old"
        raise StaleState(
            f"no sample of the state within {max_age:g} s: {age}; the controller does not answer"
        ) from self._error

    def _fresh(self, max_age: float) -> bool:
        """Whether the newest sample has all requested parts, and is at most `max_age` [s] old."""
        newest = self._latest
        return newest is not None and newest.age <= max_age and self._complete(newest)

    def _complete(self, sample: Snapshot) -> bool:
        """Whether it has forces, if they are wanted: it may have been on its way before."""
        return sample.read_forces is not None or not self.forces

    @contextmanager
    def subscribe(
        self, policy: Policy = "drop_oldest", *, size: int = 64
    ) -> Iterator[Subscription[Snapshot]]:
        """Read every sample from now on: `with robot.feed.subscribe() as samples:`.

        Args:
            policy: what happens to samples that are not taken in time: "latest" keeps the newest
                one, "drop_oldest" the newest `size`, "every" raises when `size` are waiting.
            size: maximum number of waiting samples.

        Yields:
            The subscription, for `async for`. It raises `RobotStateError` when the robot closes.
        """
        self._begin()
        subscription = Subscription[Snapshot](policy, size, self._lane.owner_loop)
        self._subscriptions.append(subscription)
        try:
            yield subscription
        finally:
            self._subscriptions.remove(subscription)
            subscription.end(left())

    async def wait_for(
        self, predicate: Callable[[Snapshot], bool], *, timeout: float | None = None
    ) -> Snapshot:
        """Wait for a sample for which the predicate is true, and return it.

        Samples that were received before this was called do not count.

        Args:
            predicate: called with each sample, on the event loop.
            timeout: seconds for which to wait; None for no limit.

        Raises:
            ParameterError: the time is not above 0, or the predicate is no function, or none that
                returns at once whether it holds.
            TimeoutError: no such sample came in time.
        """
        if timeout is not None:
            timeout = SECONDS("timeout", timeout)
        if not callable(predicate):
            raise ParameterError("predicate", predicate, "a function of a sample")
        seen, newest = 0, None
        # samples and the time limit are by the wall clock
        pace = nullcontext() if timeout is None else trial.at_own_pace()
        with pace, anyio.move_on_after(timeout), self.subscribe() as subscription:
            async for snapshot in subscription:
                if not self._complete(snapshot):
                    continue
                if condition_holds("predicate", predicate(snapshot)):
                    return snapshot
                seen, newest = seen + 1, snapshot
        raise TimeoutError(self._timeout_message(predicate, timeout, seen, newest))

    def _timeout_message(
        self,
        predicate: Callable[[Snapshot], bool],
        timeout: float | None,
        seen: int,
        newest: Snapshot | None,
    ) -> str:
        """Describe what was waited for, and what came instead."""
        code = getattr(predicate, "__code__", None)
        name = getattr(predicate, "__qualname__", None) or repr(predicate)
        where = f" ({code.co_filename}:{code.co_firstlineno})" if code is not None else ""
        waited = f"waited {timeout:g} s for {name}{where}"
        if newest is None:
            why = "" if self.error is None else f": {self.error}"
            return f"{waited}; no sample of the state came in that time{why}"
        on = [str(number) for number, is_on in enumerate(newest.io.digital_inputs) if is_on]
        return (
            f"{waited}; it held for none of {seen} samples. The newest: {newest.states!r}, "
            f"{newest.status.joints!r}, digital_inputs[n] on for n = {', '.join(on) or 'none'}"
        )

    def close(self) -> None:
        """End all subscriptions: no more samples come."""
        self._closed = True
        for subscription in self._subscriptions:
            subscription.end(RobotStateError("the robot is closed: no more samples come"))

    def _begin(self) -> None:
        if self._closed:
            raise RobotStateError("the robot is closed: no more samples come")
        self._lane.owner_loop.require("the feed")
        if not self._running:
            self._running = True
            self._begun = time.monotonic()
            self._background.start(self._run(), "aioduco feed")

    async def _run(self) -> None:
        ticker = every(1.0 / self.rate, first=on_grid(time.monotonic()))
        async for _ in ticker:
            try:
                snapshot = await self._read()
            except DucoError as exc:
                self._failures += 1
                self._error = exc
                ticker.postpone(_RETRY_EVERY)
            else:
                self._note(snapshot)
            ticker.period = 1.0 / self.rate

    async def _read(self) -> Snapshot:
        wanted = self.forces or self.force_readers
        questions = _STATE + _FORCES if wanted else _STATE
        if (along := self._along(1.0 / self._rate)) is not None:
            questions = (*questions, along[0])
        states_, status_, io_, *rest = await self._lane.ask(*questions)
        if along is not None:
            along[1](rest.pop())
        states = self._samples.states(states_.get(), states_.at)
        status = self._samples.status(status_.get(), status_.at)
        if io_.error is not None:
            raise io_.error
        io = self._samples.io(io_.get, io_.at)
        forces = None
        if wanted:
            # A value that a controller does not have, or does not report, is NaN.
            tool, external = (() if each.error else each.value for each in rest)
            forces = self._samples.forces(tool, external, rest[-1].at)
        return Snapshot(self._count, states.received_at, states, status, io, forces)

    def _note(self, snapshot: Snapshot) -> None:
        before, self._latest, self._error = self._latest, snapshot, None
        self._count += 1
        if before is not None:
            interval = trial.wall(snapshot.received_at) - trial.wall(before.received_at)
            known = self._interval
            self._interval = interval if known is None else known + _SMOOTHING * (interval - known)
        for subscription in self._subscriptions:
            subscription.give(snapshot)
