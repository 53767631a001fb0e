"""What all streams have in common, seen from the program."""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING, Any, Self

import anyio
import anyio.lowlevel

from aioduco.errors import DucoError, LaneFailed, ParameterError, SetPointTooFar, StreamClosed
from aioduco.streaming.ends import failure
from aioduco.streaming.host import Host
from aioduco.streaming.report import StreamStatistics
from aioduco.streaming.sampling import sampled
from aioduco.streaming.settings import LaneOptions
from aioduco.streaming.shared import Command
from aioduco.streaming.source import Reason, State
from aioduco.streaming.ticks import Tick, ticks

if TYPE_CHECKING:
    from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable
    from types import TracebackType

    from anyio.abc import TaskGroup

    from aioduco.models.rules import VectorLike
    from aioduco.streaming.settings import Endpoint, Feeding
    from aioduco.streaming.space import Space

__all__ = ["Stream", "Tick"]

_AT_ONCE = 256  # set-points written between two looks at the event loop


class Stream:
    """A stream of set-points to the controller. Use it as an async context manager.

    Entering starts the lane and connects it; the arm does not move before the first set-point.
    Leaving follows what was sent to its end and leaves the arm at rest. Leaving by an error or
    a cancellation brings the arm to rest at once.

    Args:
        endpoint: where it leads to.
        feeding: how it is fed.
        options: how its lane runs.
        space: the space of its set-points.
        check: checks a set-point and returns its six numbers.
        config: what its driver needs to know.
        name: the function of the wire that carries the set-points.
    """

    def __init__(
        self,
        endpoint: Endpoint,
        feeding: Feeding,
        options: LaneOptions | None,
        *,
        space: Space,
        check: Callable[[str, VectorLike], list[float]],
        config: dict[str, Any],
        name: str,
    ) -> None:
        self._endpoint = endpoint
        self._feeding = feeding
        self._options = options = options or LaneOptions()
        self._space = space
        self._check = check
        self._name = name
        self._config: dict[str, Any] = {
            "host": endpoint.host,
            "port": endpoint.port,
            "extra": 0,
            "guarded": endpoint.guarded,
            **options.config(),
            **feeding.config(),
            **config,
        }
        self._host: Host | None = None
        self._tasks: TaskGroup | None = None
        self._last: tuple[float, ...] | None = None
        self._final: StreamStatistics | None = None
        self._begun = False
        self._halted = False
        self._taken = 0
        self._commanded: tuple[float, ...] | None = None
        self._minding: anyio.CancelScope | None = None

    # -- what it is ----------------------------------------------------------------------------

    @property
    def rate(self) -> float:
        """Set-points that are sent to the controller per second [Hz]."""
        return self._feeding.rate

    @property
    def state(self) -> State:
        """State of the stream."""
        return State.WAITING if self._host is None else self._host.state

    @property
    def reason(self) -> Reason:
        """Why it ended, or ends."""
        return Reason.NONE if self._host is None else self._host.reason

    @property
    def commanded(self) -> tuple[float, ...] | None:
        """The last set-point that the lane sent; None before the first, and up to 10 ms old."""
        if self._host is not None and self._final is None:
            point = self._host.block.report.newest()
            self._commanded = self._commanded if point is None else point.values
        return self._commanded

    @property
    def taken(self) -> int:
        """How many of the program's set-points the lane has taken."""
        if self._host is None or self._final is not None:
            return self._taken
        self._taken = self._host.block.ring.read
        return self._taken

    @property
    def pid(self) -> int | None:
        """The lane's process; None for a thread, and before it is started."""
        return None if self._host is None else self._host.pid

    def statistics(self) -> StreamStatistics:
        """Read the figures as they are now, or as they were at the end.

        Raises:
            StreamClosed: the stream was never opened.
        """
        if self._final is not None:
            return self._final
        if self._host is None:
            raise StreamClosed("the stream has not been opened, so it has no figures")
        return StreamStatistics.of(self._host)

    @property
    def quiet(self) -> bool:
        """Whether the lane can send nothing any more; from any thread."""
        return self._host is None or self._host.silent

    def __repr__(self) -> str:
        end = f" ({self.reason.name})" if self.reason else ""
        where = "process" if self._options.lane == "process" else "thread"
        return f"<Stream {self._name} {self.rate:g} Hz in a {where}, {self.state.name}{end}>"

    # -- its life ------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Start the lane and connect it.

        Raises:
            RobotStateError: another stream is open on this robot, or something moves its arm.
            HeartbeatLost: the robot's heartbeat does not beat.
            StreamLost: there is no controller, or it does not answer.
            LaneFailed: no lane could be started.
        """
        if self._endpoint.admit is not None:
            await self._endpoint.admit(self._name)
        # Nothing may be awaited here, or a motion could be sent in between.
        self._endpoint.streams.add(self)
        try:
            await self._open()
        except BaseException:
            await self._end()
            raise
        return self

    async def _open(self) -> None:
        host = Host(self._config, thread=self._options.lane == "thread")
        host.start()
        self._host = host
        self._tasks = anyio.create_task_group()
        await self._tasks.__aenter__()
        self._tasks.start_soon(self._mind, host)
        await host.until_ready(self._options.connect_timeout)
        if self._halted:
            # The robot was stopped before there was a lane to be told of it.
            host.command(Command.HALT)
            await host.until_gone()
        if host.gone:
            self._raise(host)
        if not host.ready:
            raise LaneFailed("the stream's lane did not get ready in time; nothing was sent")

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End the stream and see its lane go.

        Raises:
            StreamError: the stream ended by something else than this, and no error is under way.
        """
        try:
            if exc is None and self._host is not None:
                self._host.command(Command.CLOSE)
                await self._host.until_gone()
        finally:
            await self._end()
        if exc is None and self._host is not None:
            self._raise(self._host)

    async def _mind(self, host: Host) -> None:
        """Hear from the lane to its end; stop the robot if it went without a word."""
        with anyio.CancelScope(shield=True) as scope:
            self._minding = scope
            await host.listen(self._patience() + 20 * self._config["period"])
            if host.reason is Reason.LANE_DIED and self._endpoint.stop is not None:
                # `stop` says itself, to its own caller, when it cannot be confirmed; here is
                # nobody to tell but the one who meets the lane's death.
                with contextlib.suppress(DucoError):
                    await self._endpoint.stop(self._config.get("ending", ""))

    async def _end(self) -> None:
        """Have the lane end, whatever it takes, and keep its figures."""
        host, tasks = self._host, self._tasks
        if host is None or tasks is None:
            self._endpoint.streams.remove(self)
            return
        with anyio.CancelScope(shield=True):
            if not host.gone:
                host.command(Command.ABORT)
                with anyio.move_on_after(self._patience()):
                    await host.until_gone()
            if not host.gone:
                host.kill()
                with anyio.move_on_after(1.0):
                    await host.until_gone()
        self._tasks = None
        self._endpoint.streams.remove(self)
        if not host.gone and self._minding is not None:
            self._minding.cancel()
        if host.gone:
            _ = self.commanded, self.taken
            self._final = StreamStatistics.of(host)
            host.release()
        await tasks.__aexit__(None, None, None)

    def _patience(self) -> float:
        """How long the lane may take to bring the arm to rest, and to say good-bye [s]."""
        velocity, acceleration, *_ = self._config["limits"]
        braking: float = max(v / a for v, a in zip(velocity, acceleration, strict=True))
        return 8.0 + 2 * braking + 4 * self._options.timeout

    async def ended(self) -> None:
        """Wait until the stream has ended, for whatever reason, and its lane is gone."""
        if self._host is not None and self._tasks is not None:
            await self._host.until_gone()

    def halt(self) -> None:
        """Send nothing more; from any thread or signal handler, at once.

        The arm is not decelerated by this: it is for those who stop the robot themselves.
        """
        self._halted = True
        if self._host is not None:
            self._host.command(Command.HALT)

    def kill(self) -> None:
        """End a lane that does not end by itself; one in a thread cannot be ended so."""
        if self._host is not None:
            self._host.kill()

    def _raise(self, host: Host) -> None:
        """Raise what the end of the stream means, unless it was closed."""
        error = failure(self._name, host.reason, host.text, self.statistics())
        if error is not None:
            raise error

    # -- feeding it ----------------------------------------------------------------------------

    async def send(self, point: VectorLike) -> None:
        """Send one set-point.

        The first one waits until the lane has compared it with where the arm is. Later ones
        wait while enough are queued, or never, if the stream takes only the latest.

        Args:
            point: the set-point, in the stream's units. Shape (6,).

        Raises:
            ParameterError: it is not allowed; nothing was sent, and the stream goes on.
            SetPointTooFar: it is too far from the one before; nothing was sent.
            StreamError: the stream has ended; says why.
        """
        values = tuple(self._check("point", point))
        self._check_step(values)
        await self._feed((values,), self._feeding.queued)

    async def follow(self, source: AsyncIterable[VectorLike]) -> None:
        """Send every set-point of an async iterator, to its end.

        Args:
            source: gives the set-points.

        Raises:
            StreamError: the stream has ended; says why.
        """
        async for point in source:
            await self.send(point)

    async def play(self, trajectory: Any, times: Any = None) -> None:
        """Send a whole array, and wait until the lane has taken it.

        All of it is checked before any of it is sent. It is brought to the stream's rate by
        monotone cubic interpolation, and queued as far ahead as the ring is long, so that a
        stall of the program's event loop does not reach the arm.

        Args:
            trajectory: the set-points. Shape (n, 6).
            times: when each is due, rising, from the first one on [s]. Shape (n,). None: one
                for each period of the stream.

        Raises:
            ParameterError: the array is not allowed; nothing was sent.
            SetPointTooFar: two neighbours are too far from one another; nothing was sent.
            StreamError: the stream has ended; says why.
        """
        points = await self._sampled(trajectory, times)
        if not self._config["rates"]:
            # The arm stands at the last point for a tick, so the end is no lack of set-points.
            points.append(points[-1])
        await self._feed(points, self._feeding.capacity)
        await self._alive().until_level(0)
        self._alive()

    async def _sampled(self, trajectory: Any, times: Any) -> list[tuple[float, ...]]:
        """The set-points of a trajectory, checked."""
        interval = self._feeding.interval
        if self._feeding.latest or interval is None:
            raise ParameterError("trajectory", "an array", "sent to a stream without `latest`")
        found: list[tuple[float, ...]] = []
        before = self._last
        for point in sampled(self._space, trajectory, times, interval).tolist():
            values = tuple(self._check("trajectory", point))
            self._check_step(values, before)
            before = values
            found.append(values)
            if len(found) % _AT_ONCE == 0:
                await anyio.lowlevel.checkpoint()
        return found

    async def ticks(self, rate: float | None = None) -> AsyncIterator[Tick]:
        """Rounds of the program's own loop, on an absolute schedule.

        Ticks for which the program is not ready in time are left out, never made up for.

        Args:
            rate: ticks per second [Hz]; None: as many as the stream takes set-points.

        Raises:
            StreamError: the stream has ended; says why.
        """
        period = 1 / (rate or self._feeding.source_rate or self._feeding.rate)
        async for tick in ticks(period, self._alive):
            yield tick

    def _alive(self) -> Host:
        """The lane, if set-points can be sent to it."""
        host = self._host
        if host is None or self._tasks is None:
            raise StreamClosed("the stream is not open: use it in `async with`")
        if host.reason:
            self._raise(host)
            raise StreamClosed("the stream was closed, and takes no set-points any more")
        return host

    async def _feed(
        self, points: Iterable[tuple[float, ...]], ahead: int, extra: bytes = b""
    ) -> None:
        host = self._alive()
        ring = host.block.ring
        for number, values in enumerate(points, 1):
            if self._feeding.latest:
                ring.overwrite(values, time.monotonic_ns(), extra)
            else:
                while ring.level >= ahead or not ring.put(values, time.monotonic_ns(), extra):
                    await self._begin(host)
                    await host.until_level(max(1, ahead * 3 // 4))
                    self._alive()
            self._last = values
            if number % _AT_ONCE == 0:
                await anyio.lowlevel.checkpoint()
                self._alive()
        await self._begin(host)
        await anyio.lowlevel.checkpoint()

    async def _begin(self, host: Host) -> None:
        """Wait, once, until the lane has compared the first set-point with where the arm is."""
        if not self._begun:
            await host.until_begun()
            self._alive()
            self._begun = True

    def _check_step(self, values: tuple[float, ...], before: Any = None) -> None:
        """See that a set-point is not too far from the one before."""
        before = before or self._last
        limits = self._feeding.max_step
        if before is None or not limits:
            return
        space = self._space
        step = space.difference(space.decode(before), space.decode(values))
        for group, most in zip(space.groups, limits, strict=True):
            length = sum(s * s for s in step[group]) ** 0.5
            if length > most:
                raise SetPointTooFar(
                    "point", values, f"within {most:g} of the one before, not {length:.4g} away"
                )
