"""The base class of all streams, for the program's end."""

from __future__ import annotations

import time
from contextlib import asynccontextmanager
from inspect import isasyncgen
from typing import TYPE_CHECKING, Any, Self

import anyio
import anyio.lowlevel

from aioduco._process.copying import Uncopied
from aioduco.errors import DucoError, ParameterError, SetPointTooFar, StreamError
from aioduco.models.rules import Number, VectorLike, listed
from aioduco.streaming.sampling import sampled
from aioduco.streaming.session import Session
from aioduco.streaming.shared.config import StreamSpec, WorkerConfig
from aioduco.streaming.shared.options import MOST_ACTIONS, checked, rate_rule
from aioduco.streaming.shared.space import JOINT_SPACE, too_far
from aioduco.streaming.shared.words import ActionTag, Reason, StreamState
from aioduco.streaming.ticks import Tick, Ticks

if TYPE_CHECKING:
    from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable, Sequence

    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.streaming.report import StreamStatistics
    from aioduco.streaming.shared.options import Feeding, WorkerOptions

__all__ = ["Stream", "Tick"]

_AT_ONCE = 256  # set-points written before the event loop runs again
_FARTHEST = 60.0  # s from now: the time of a chunk further away comes from another clock
_AT = Number(0.0, unit="s", source="this package")


class Stream(Uncopied):
    """A stream of set-points to the controller. Use it as an async context manager.

    Entering starts the worker and connects it; the arm does not move before the first set-point.
    Leaving follows all set-points that were sent, and the arm is then at rest. Leaving because of
    an error or a cancellation brings the arm to rest at once.

    Args:
        endpoint: the robot to which the stream sends.
        feeding: how the program feeds it.
        options: how its worker runs; None: the defaults.
        sent: what it sends to the controller.
        check: checks a set-point and returns its six numbers.

    Raises:
        ParameterError: chunks or up-sampling, of set-points for which there is none.
    """

    def __init__(
        self,
        endpoint: StreamEndpoint,
        feeding: Feeding,
        options: WorkerOptions | None,
        sent: StreamSpec,
        check: Callable[[str, VectorLike], list[float]],
    ) -> None:
        alone = "left out: it is for positions alone"
        if feeding.chunks and sent.meaning != "place":
            raise ParameterError("chunks", True, alone)
        if feeding.upsample != "none" and sent.meaning == "speed":
            raise ParameterError("upsample", feeding.upsample, alone)
        self._feeding = feeding
        self._sent = sent
        self._space = sent.space
        self._check = check
        config = WorkerConfig(
            host=endpoint.host,
            port=endpoint.port,
            guarded=endpoint.guarded,
            stall_limit=endpoint.stall_limit,
            unanswered_timeout=endpoint.unanswered_timeout,
            options=checked(options),
            feeding=feeding,
            sent=sent,
        )
        self._session = Session(endpoint, config)
        self._last: tuple[float, ...] | None = None
        self._begun = False
        self._chunks = 0
        #: when the first action of the last chunk was due [s], and its actions
        self._sent_chunk: tuple[float, Sequence[tuple[float, ...]]] | None = None

    # -- status --------------------------------------------------------------------------------

    @property
    def rate(self) -> float:
        """Set-points sent to the controller per second [Hz]."""
        return self._feeding.rate

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        return self._session.state

    @property
    def reason(self) -> Reason:
        """Why it ended, or is ending."""
        return self._session.reason

    @property
    def commanded(self) -> tuple[float, ...] | None:
        """The last set-point that the worker sent; None before the first, and up to 10 ms old."""
        return self._session.commanded

    @property
    def taken(self) -> int:
        """Number of the program's set-points that the worker has taken."""
        return self._session.taken

    @property
    def pid(self) -> int | None:
        """Id of the worker's process; None for a thread, and before it is started."""
        return self._session.pid

    @property
    def quiet(self) -> bool:
        """Whether the worker can send nothing any more; may be read from any thread."""
        return self._session.quiet

    def statistics(self) -> StreamStatistics:
        """Read the present statistics, or those at the end of the stream.

        Raises:
            StreamClosed: the stream was never opened.
        """
        return self._session.statistics()

    def __repr__(self) -> str:
        return repr(self._session)

    # -- life cycle ----------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Start the worker and connect it.

        Raises:
            RobotStateError: another stream is open on this robot, or something moves its arm.
            HeartbeatLost: the robot's heartbeat does not beat.
            StreamLost: there is no controller, or it does not answer.
            WorkerFailed: no worker could be started.
        """
        await self._session.open()
        return self

    async def __aexit__(self, _kind: object, exc: BaseException | None, _trace: object) -> None:
        """End the stream and wait until its worker has ended.

        What was sent is followed to its end. A task that sends from now on gets `StreamClosed`.

        Raises:
            StreamError: the stream had ended for another reason, and the block raised no error.
        """
        await self._session.close(at_once=exc is not None)
        if exc is None:
            self._session.check_end()

    async def ended(self) -> None:
        """Wait until the stream has ended, for any reason, and its worker has ended."""
        await self._session.ended()

    def halt(self) -> None:
        """Send nothing more, from now on; may be called from any thread or signal handler.

        This does not decelerate the arm: the caller must stop the robot itself.
        """
        self._session.halt()

    # -- sending -------------------------------------------------------------------------------

    async def send(self, point: VectorLike) -> None:
        """Send one set-point.

        The first call waits until the worker has compared the set-point with the arm's position; if
        it is interrupted, the stream ends. Later calls wait while enough set-points are queued, or
        never with `latest`; one that is interrupted sends nothing.

        Args:
            point: the set-point, in the stream's units. Shape (6,).

        Raises:
            ParameterError: it is not allowed; nothing was sent, and the stream continues.
            SetPointTooFar: it is too far from the one before; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        if self._feeding.chunks:
            await self.send_chunk([point])
            return
        await self._feed((tuple(self._check("point", point)),), self._feeding.queued)

    async def send_chunk(self, actions: Any, at: float | None = None) -> None:
        """Send a chunk of actions; from its time on it replaces earlier chunks.

        For streams opened with `chunks=True`. The time between two actions is 1 / `source_rate`.
        Where this chunk differs from the earlier ones, the worker blends from them to this one
        within the stream's limits. Actions whose time has passed are skipped, and counted:
        `StreamStatistics.chunks_late`, `chunks_dropped` and `actions_late`. After the last action
        the arm stands still; after `hold` the stream ends. If this is cancelled, the chunk is not
        sent; if the first one is, the stream ends.

        Args:
            actions: set-points in the stream's units, 1 to 1000 of them. Shape (n, 6).
            at: when the first action is due, by `time.monotonic()`, up to 60 s from now [s]. For
                actions of a policy this is the time of the observation. None: now.

        Raises:
            ParameterError: the chunk is not allowed; nothing was sent, and the stream continues.
            SetPointTooFar: two successive actions are further apart than `max_step`, or the chunk
                is further than that from the earlier ones; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        self._session.check_loop()
        await anyio.lowlevel.checkpoint()  # first: a chunk that was written is followed to its end
        ring = self._session.alive().ring
        points = self._checked_actions(actions, at)
        count = len(points)
        # The chunk is written completely or not at all: after this loop nothing is awaited until
        # the last action is written.
        while ring.level > self._feeding.capacity - count:
            await self._session.until_level(self._feeding.capacity - count)
            self._session.alive()
        # Now, and not before the wait: another task may have sent meanwhile.
        self._take_over(points, at)
        self._chunks += 1
        begin = 0 if at is None else max(1, round(at * 1e9))
        stamp = time.monotonic_ns()
        for index, values in enumerate(points):
            ring.put(values, stamp, ActionTag(self._chunks, begin, index, count).pack())
        await self._begin()

    def _checked_actions(self, actions: Any, at: float | None) -> list[tuple[float, ...]]:
        """Check a chunk by itself."""
        interval = self._feeding.interval
        if not self._feeding.chunks or interval is None:
            raise ParameterError("actions", "a chunk", "sent to a stream opened with chunks=True")
        if at is not None:
            at, now = _AT("at", at), time.monotonic()
            if abs(at - now) > _FARTHEST:
                raise ParameterError(
                    "at", at, f"a time of time.monotonic(), {now:.3f} now, within {_FARTHEST:g} s"
                )
        expected = f"1 to {MOST_ACTIONS} actions"
        actions = listed("actions", actions, expected)
        if not 1 <= len(actions) <= MOST_ACTIONS:
            raise ParameterError("actions", len(actions), expected)
        checked: list[tuple[float, ...]] = []
        for index, action in enumerate(actions):
            values = tuple(self._check(f"actions[{index}]", action))
            if checked:
                self._check_step(values, checked[-1], f"actions[{index}]")
            checked.append(values)
        return checked

    def _take_over(self, points: list[tuple[float, ...]], at: float | None) -> None:
        """Let a chunk take the place of the earlier one, which it must not be too far from.

        Raises:
            SetPointTooFar: it is.
        """
        now, interval = time.monotonic(), self._feeding.interval
        assert interval is not None
        begin = now if at is None else at
        if self._sent_chunk is not None:
            when = min(max(begin, now), begin + (len(points) - 1) * interval)
            before = self._place(interval, *self._sent_chunk, when)
            here = self._place(interval, begin, points, when)
            self._check_step(here, before, "actions")
        self._sent_chunk, self._last = (begin, points), points[-1]

    def _place(
        self, interval: float, begin: float, actions: Sequence[tuple[float, ...]], time: float
    ) -> tuple[float, ...]:
        """A chunk's position at a time, as six numbers."""
        space, last = self._space, len(actions) - 1
        place = min(max((time - begin) / interval, 0.0), float(last))
        index = min(int(place), max(0, last - 1))
        start = space.decode(actions[index])
        end = space.decode(actions[min(index + 1, last)])
        way = space.difference(start, end)
        return space.encode(space.moved(start, tuple((place - index) * w for w in way)))

    async def follow(self, source: AsyncIterable[VectorLike]) -> None:
        """Send every set-point of an async iterator until it ends.

        When the stream has ended, an iterator that gives no more of them is cancelled, and an async
        generator is closed.

        Args:
            source: async iterator over the set-points.

        Raises:
            ParameterError: it is no async iterator.
            StreamError: the stream has ended; the error says why.
        """
        if not hasattr(source, "__aiter__"):
            raise ParameterError("source", source, "an async iterator; an array goes to play()")
        self._session.check_loop()

        # a task of its own: what the iterator keeps open between two set-points is none of ours
        async def feed() -> None:
            try:
                async for point in source:
                    await self.send(point)
            except StreamError:
                if isasyncgen(source):
                    await source.aclose()
                raise
            tasks.cancel_scope.cancel()

        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(feed)
                await self._session.until_gone()
                tasks.cancel_scope.cancel()
        except BaseExceptionGroup as group:
            raise group.exceptions[0] from None  # the source may raise a group of its own
        self._session.alive()

    async def play(self, trajectory: Any, times: Any = None) -> None:
        """Send a whole array, and wait until the worker has taken it.

        The whole array is checked before any set-point is sent. It is sampled at the stream's rate
        by monotone cubic interpolation, and queued up to the ring's capacity, so that a stall of
        the program's event loop does not affect the arm.

        Cancelling this brings the arm to rest at once, and ends the stream: from then on it raises
        `StreamClosed`, also when its block is left without an error.

        Args:
            trajectory: the set-points. Shape (n, 6).
            times: due time of each set-point, rising, relative to the first [s]. Shape (n,). None:
                one set-point for each period of the stream.

        Raises:
            ParameterError: the array is not allowed; nothing was sent.
            SetPointTooFar: two successive set-points are too far apart; nothing was sent, unless
                another task has sent one meanwhile that is too far from the next.
            StreamError: the stream has ended; the error says why.
        """
        async with self._ended_by_interrupts():
            points = await self._sampled(trajectory, times)
            if self._sent.meaning != "speed":
                # The arm stays at the last point for one more tick, so the end does not count as
                # starved.
                points.append(points[-1])
            await self._feed(points, self._feeding.capacity)
            await self._taken()

    @asynccontextmanager
    async def _ended_by_interrupts(self) -> AsyncIterator[None]:
        """Bring the arm to rest, and end the stream, if what the block waits for is interrupted.

        Otherwise the arm would follow what is queued, or begin to, after its program was told of
        the cancellation.
        """
        try:
            yield
        except DucoError:
            raise
        except BaseException:
            await self._session.close(at_once=True)
            raise

    async def _taken(self) -> None:
        """Wait until the worker has taken all set-points that were sent."""
        self._session.alive()
        await self._session.until_level(0)
        self._session.alive()

    async def _sampled(self, trajectory: Any, times: Any) -> list[tuple[float, ...]]:
        """Sample a trajectory, and check its set-points."""
        interval = self._feeding.interval
        if self._feeding.latest or self._feeding.chunks or interval is None:
            raise ParameterError(
                "trajectory", "an array", "sent to a stream without `latest` and `chunks`"
            )
        found: list[tuple[float, ...]] = []
        before = self._last
        # speeds are numbers, also those that a pose has in place of angles
        space = JOINT_SPACE if self._sent.meaning == "speed" else self._space
        for point in sampled(space, trajectory, times, interval):
            values = tuple(self._check("trajectory", point))
            self._check_step(values, before)
            before = values
            found.append(values)
            if len(found) % _AT_ONCE == 0:
                await anyio.lowlevel.checkpoint()
        return found

    def ticks(self, rate: float | None = None) -> AsyncIterator[Tick]:
        """Ticks for the program's loop, on an absolute schedule.

        Ticks for which the program is not ready in time are skipped, never made up for.

        Args:
            rate: ticks per second, above 0 to 100,000 [Hz]; None: the rate at which the stream
                takes set-points.

        Raises:
            ParameterError: the rate is out of range.
            StreamError: the stream has ended; the error says why.
        """
        if rate is None:
            rate = self._feeding.source_rate or self._feeding.rate
        return Ticks(1 / rate_rule()("rate", rate), self._session.alive)

    async def _feed(
        self, points: Iterable[tuple[float, ...]], ahead: int, extra: bytes = b""
    ) -> None:
        self._session.check_loop()
        await anyio.lowlevel.checkpoint()  # first: a set-point that was written is followed
        ring = self._session.alive().ring
        for number, values in enumerate(points, 1):
            while ring.level >= ahead and not self._feeding.latest:
                await self._begin()
                # With a depth of one this waits for an empty ring.
                await self._session.until_level(ahead * 3 // 4)
                self._session.alive()
            # Now, and not before the wait: another task may have sent meanwhile.
            self._last = self._placed(values)
            ring.overwrite(self._last, time.monotonic_ns(), extra)
            if number % _AT_ONCE == 0:
                await anyio.lowlevel.checkpoint()
                self._session.alive()
        await self._begin()

    def _placed(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """Return the set-point for what the program gives, just before it is written.

        Raises:
            SetPointTooFar: it is too far from the one before.
        """
        self._check_step(values)
        return values

    async def _begin(self) -> None:
        """Wait, once, until the worker has compared the first set-point with the arm's position."""
        if not self._begun:
            async with self._ended_by_interrupts():
                await self._session.until_begun()
            self._session.alive()
            self._begun = True

    def _check_step(
        self, values: tuple[float, ...], before: Any = None, name: str = "point"
    ) -> None:
        """Check that a set-point is not too far from the one before."""
        before = before or self._last
        limits = self._feeding.max_step
        if before is None or not limits:
            return
        space = self._space
        if found := too_far(space, space.decode(before), space.decode(values), limits):
            raise SetPointTooFar(name, values, f"near the one before ({found})")
