"""Streams of set-points for blocking programs.

The stream itself runs on the robot's event loop, with its worker beside it: the functions here only
wait until a set-point has been taken. If a program computes longer than the stream's `hold` between
two set-points, the stream ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.errors import ParameterError, StreamError
from aioduco.sync._generated_objects import OffsetStreamCalls, StreamCalls, TrackStreamCalls

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable, Iterator

    from aioduco.models.rules import VectorLike
    from aioduco.streaming.ticks import Tick
    from aioduco.sync._runner import Runner


class Stream(StreamCalls):
    """A stream of set-points to the controller. Use it in `with`.

    Entering starts the worker and connects it; the arm does not move before the first set-point.
    Leaving follows the sent set-points to their end and leaves the arm at rest. Leaving by an error
    or by an interrupt (Ctrl-C) brings the arm to rest at once. So does closing the robot.
    """

    def __init__(self, runner: Runner, made: Any) -> None:
        super().__init__(runner, made)
        #: the error with which it ended, if the robot was closed before it
        self._close_error: StreamError | None = None

    def __repr__(self) -> str:
        return self._runner.call_sync(lambda: repr(self._made))

    def _enter(self) -> None:
        """Start the worker and connect it.

        Raises:
            RobotStateError: another stream is open on this robot, or something moves its arm.
            HeartbeatLost: the robot's heartbeat does not beat.
            StreamLost: there is no controller, or it does not answer.
            WorkerFailed: no worker could be started.
        """
        self._runner.call(self._open(), undo=lambda _: self._close(KeyboardInterrupt()))

    def _leave(self, exc: BaseException | None) -> None:
        """End the stream and wait until its worker has exited.

        Raises:
            StreamError: the stream ended for another reason, and the block raised no error.
        """
        if self._runner.running:
            self._runner.call(self._close(exc))
        if exc is None and self._close_error is not None:
            raise self._close_error

    async def _open(self) -> None:
        await self._made.__aenter__()
        self._runner.at_close(self._end)

    async def _close(self, exc: BaseException | None) -> None:
        await self._made.__aexit__(None if exc is None else type(exc), exc, None)
        self._runner.remove_at_close(self._end)

    async def _end(self) -> None:
        """Close the stream after the robot's closing has ended it."""
        try:
            await self._made.__aexit__(None, None, None)
        except StreamError as exc:
            self._close_error = exc

    def follow(self, source: Iterable[VectorLike]) -> None:
        """Send every set-point of an iterator, to its end.

        Args:
            source: the iterable of set-points.

        Raises:
            ParameterError: it is no iterable.
            StreamError: the stream has ended; the error says why.
        """
        if not hasattr(source, "__iter__"):
            raise ParameterError("source", source, "an iterable of set-points")
        for point in source:
            self.send(point)

    def ticks(self, rate: float | None = None) -> Iterator[Tick]:
        """Pace the program's own loop, on an absolute schedule.

            for tick in stream.ticks(30):
                stream.send(policy(tick.time))

        Ticks for which the program is not ready in time are skipped, and not made up for.

        Args:
            rate: ticks per second, above 0 to 100,000 [Hz]; None: the rate at which the stream
                takes set-points.

        Raises:
            ParameterError: the rate is out of range.
            StreamError: the stream has ended; the error says why.
        """
        return self._paced(self._made.ticks(rate))

    def _paced(self, ticks: AsyncIterator[Tick]) -> Iterator[Tick]:
        async def following() -> Tick:
            return await anext(ticks)

        while True:
            yield self._runner.call(following())


class OffsetStream(OffsetStreamCalls, Stream):
    """A stream of offsets in the tool's frame, each from the target of the one before."""


class TrackStream(TrackStreamCalls, Stream):
    """A stream into the track pool: points of a path, optionally with outputs to set.

    `play` takes no times: the controller plans them from speed and acceleration. It returns when
    the last points are in the controller's pool.
    """
