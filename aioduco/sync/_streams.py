"""Streams of set-points for blocking programs.

The stream itself runs on the robot's event loop, with its worker beside it: the functions here only
wait until a set-point has been taken. If a program computes longer than the stream's `hold` between
two set-points, the stream ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.errors import StreamError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable, Iterator
    from types import TracebackType
    from typing import Self

    from aioduco.models.op import Op
    from aioduco.models.rules import VectorLike
    from aioduco.streaming import stream as aio_stream
    from aioduco.streaming import track as aio_track
    from aioduco.streaming.report import StreamStatistics
    from aioduco.streaming.shared.state import Reason, StreamState
    from aioduco.streaming.ticks import Tick
    from aioduco.sync._runner import Runner

__all__ = ["OffsetStream", "Stream", "TrackStream"]


class Stream:
    """A stream of set-points to the controller. Use it in `with`.

    Entering starts the worker and connects it; the arm does not move before the first set-point.
    Leaving follows the sent set-points to their end and leaves the arm at rest. Leaving by an error
    or by an interrupt (Ctrl-C) brings the arm to rest at once. So does closing the robot.
    """

    def __init__(self, runner: Runner, stream: aio_stream.Stream) -> None:
        self._runner = runner
        self._stream = stream
        #: the error with which it ended, if the robot was closed before it
        self._close_error: StreamError | None = None

    def __repr__(self) -> str:
        return self._runner.call_sync(lambda: repr(self._stream))

    # -- what it is ----------------------------------------------------------------------------

    @property
    def rate(self) -> float:
        """Set-points that are sent to the controller per second [Hz]."""
        return self._stream.rate

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        return self._runner.call_sync(lambda: self._stream.state)

    @property
    def reason(self) -> Reason:
        """Why it ended, or ends."""
        return self._runner.call_sync(lambda: self._stream.reason)

    @property
    def commanded(self) -> tuple[float, ...] | None:
        """The last set-point that the worker sent; None before the first, and up to 10 ms old."""
        return self._runner.call_sync(lambda: self._stream.commanded)

    @property
    def taken(self) -> int:
        """Number of the program's set-points that the worker has taken."""
        return self._runner.call_sync(lambda: self._stream.taken)

    @property
    def pid(self) -> int | None:
        """Id of the worker's process; None for a thread, and before it is started."""
        return self._runner.call_sync(lambda: self._stream.pid)

    @property
    def quiet(self) -> bool:
        """Whether the worker can send nothing any more."""
        return self._stream.quiet

    def statistics(self) -> StreamStatistics:
        """Read the figures as they are now, or as they were at the end.

        Raises:
            StreamClosed: the stream was never opened.
        """
        return self._runner.call_sync(self._stream.statistics)

    # -- its life ------------------------------------------------------------------------------

    def __enter__(self) -> Self:
        """Start the worker and connect it.

        Raises:
            RobotStateError: another stream is open on this robot, or something moves its arm.
            HeartbeatLost: the robot's heartbeat does not beat.
            StreamLost: there is no controller, or it does not answer.
            LaneFailed: no worker could be started.
        """
        self._runner.call(self._open(), undo=lambda _: self._close(KeyboardInterrupt()))
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End the stream and wait until its worker has exited.

        Raises:
            StreamError: the stream ended for another reason, and the block raised no error.
        """
        if self._runner.running:
            self._runner.call(self._close(exc))
        if exc is None and self._close_error is not None:
            raise self._close_error

    async def _open(self) -> None:
        await self._stream.__aenter__()
        self._runner.at_close(self._leave)

    async def _close(self, exc: BaseException | None) -> None:
        await self._stream.__aexit__(None if exc is None else type(exc), exc, None)
        self._runner.remove_at_close(self._leave)

    async def _leave(self) -> None:
        """Close the stream after the robot's closing has ended it."""
        try:
            await self._stream.__aexit__(None, None, None)
        except StreamError as exc:
            self._close_error = exc

    def ended(self) -> None:
        """Wait until the stream has ended, for whatever reason, and its worker has exited."""
        self._runner.call(self._stream.ended())

    def halt(self) -> None:
        """Send nothing more; from any thread or signal handler, at once.

        This does not decelerate the arm: it is for callers that stop the robot themselves.
        """
        self._stream.halt()

    # -- feeding it ----------------------------------------------------------------------------

    def send(self, point: VectorLike) -> None:
        """Send one set-point.

        The first call waits until the worker has compared the set-point with the arm's position.
        Later calls wait while enough set-points are queued; if the stream takes only the latest
        one, they never wait.

        Args:
            point: the set-point, in the stream's units. Shape (6,).

        Raises:
            ParameterError: it is not allowed; nothing was sent, and the stream continues.
            SetPointTooFar: it is too far from the previous one; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        self._runner.call(self._stream.send(point))

    def send_chunk(self, actions: Any, at: float | None = None) -> None:
        """Send a chunk of actions; from its time on it replaces the actions sent before.

        For streams opened with `chunks=True`. `source_rate` is the rate of the actions. Where this
        chunk and the earlier actions differ, the worker blends from one to the other within the
        stream's limits. Actions whose time has passed are left out, and counted:
        `StreamStatistics.chunks_late`, `chunks_dropped` and `actions_late`. After the last action
        the arm stands; after `hold` the stream ends.

        Args:
            actions: set-points in the stream's units, 1 to 1000 of them. Shape (n, 6).
            at: due time of the first action, by `time.monotonic()`, up to 60 s from now [s]. For
                actions of a policy that is the time of the observation. None: now.

        Raises:
            ParameterError: it is not allowed; nothing was sent, and the stream continues.
            SetPointTooFar: two neighbours are further apart than `max_step`, or the chunk is
                further than that from the actions sent before; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        self._runner.call(self._stream.send_chunk(actions, at))

    def follow(self, source: Iterable[VectorLike]) -> None:
        """Send every set-point of an iterator, to its end.

        Args:
            source: the iterable of set-points.

        Raises:
            StreamError: the stream has ended; the error says why.
        """
        for point in source:
            self.send(point)

    def play(self, trajectory: Any, times: Any = None) -> None:
        """Send a whole array, and wait until the worker has taken it.

        The whole array is checked before any of it is sent. It is resampled to the stream's rate
        by monotone cubic interpolation, and queued as far ahead as the ring buffer is long, so that
        a stall of the program does not affect the arm.

        Args:
            trajectory: the set-points. Shape (n, 6).
            times: due times of the set-points, ascending, from the first one on [s]. Shape (n,).
                None: one for each period of the stream.

        Raises:
            ParameterError: the array is not allowed; nothing was sent.
            SetPointTooFar: two neighbours are too far apart; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        self._runner.call(self._stream.play(trajectory, times))

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
        return self._paced(self._stream.ticks(rate))

    def _paced(self, ticks: AsyncIterator[Tick]) -> Iterator[Tick]:
        async def following() -> Tick:
            return await anext(ticks)

        while True:
            yield self._runner.call(following())


class OffsetStream(Stream):
    """A stream of offsets in the tool's frame, each from the target of the one before.

    `send` takes one offset (x, y, z [m], rx, ry, rz [rad]), `play` a list of them without times.
    """


class TrackStream(Stream):
    """A stream into the track pool: points of a path, optionally with outputs to set.

    `play` takes no times: the controller plans them from speed and acceleration. It returns when
    the last points are in the controller's pool.
    """

    def __init__(self, runner: Runner, stream: aio_track.TrackStream) -> None:
        super().__init__(runner, stream)
        self._track = stream

    def send(self, point: VectorLike, op: Op | None = None) -> None:
        """Send one point of the path.

        The worker keeps the first points until there are enough of them to begin.

        Args:
            point: the point, in the stream's units. Shape (6,).
            op: outputs to set there; only for streams opened with `operations`.

        Raises:
            ParameterError: it is not allowed; nothing was sent, and the stream continues.
            StreamError: the stream has ended; the error says why.
        """
        self._runner.call(self._track.send(point, op))
