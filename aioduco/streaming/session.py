"""One lane from its start to its end, as the robot and its supervision see it.

Guarantees:
- Leaving returns only when the lane can send nothing any more, and the arm has been seen to stand
  or been told to stop. Cancelling the one who leaves, once or more, does not cut that short.
- A lane that is gone without a word, or does not end in time, is followed by a stop of the robot
  on another connection.
"""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

import anyio

from aioduco.errors import DucoError, LaneFailed, StreamClosed
from aioduco.streaming.ends import failure
from aioduco.streaming.host import Host
from aioduco.streaming.report import StreamStatistics
from aioduco.streaming.shared import Command
from aioduco.streaming.source import Reason, State
from aioduco.supervision.background import Background
from aioduco.supervision.insist import insist

if TYPE_CHECKING:
    from aioduco.streaming.config import LaneConfig
    from aioduco.streaming.endpoint import Endpoint

__all__ = ["Session"]

_KILLED = 1.0  # seconds for a process that was killed to be gone
_SIGNS = 10  # signs of life of the event loop per stall limit
_SIGN_EVERY = 0.1  # seconds between two of them at most


class Session:
    """The life of one stream.

    Args:
        endpoint: where it leads to.
        config: all that its lane is told.
    """

    def __init__(self, endpoint: Endpoint, config: LaneConfig) -> None:
        self._endpoint = endpoint
        self._options = config.options
        self._config = config
        self._background = Background(self._crashed)
        self._minded = anyio.Event()
        self._halted = False
        self._final: StreamStatistics | None = None
        self._commanded: tuple[float, ...] | None = None
        self._taken = 0
        self.host: Host | None = None

    def __repr__(self) -> str:
        end = f" ({self.reason.name})" if self.reason else ""
        where = "process" if self._options.lane == "process" else "thread"
        return f"<Stream {self.name} {self.rate:g} Hz in a {where}, {self.state.name}{end}>"

    # -- what is known of it -------------------------------------------------------------------

    @property
    def name(self) -> str:
        """What the stream is called, mostly by its function of the wire."""
        return self._config.sent.name

    @property
    def rate(self) -> float:
        """Set-points per second [Hz]."""
        return self._config.feeding.rate

    @property
    def state(self) -> State:
        """State of the stream."""
        if self._final is not None:
            return State.ENDED
        return State.WAITING if self.host is None else self.host.state

    @property
    def reason(self) -> Reason:
        """Why it ended, or ends."""
        return Reason.NONE if self.host is None else self.host.reason

    @property
    def commanded(self) -> tuple[float, ...] | None:
        """The last set-point that the lane sent; None before the first, and up to 10 ms old."""
        if self.host is not None and self._final is None:
            point = self.host.block.report.newest()
            self._commanded = self._commanded if point is None else point.values
        return self._commanded

    @property
    def taken(self) -> int:
        """How many of the program's set-points the lane has taken."""
        if self.host is not None and self._final is None:
            self._taken = self.host.block.ring.read
        return self._taken

    def statistics(self) -> StreamStatistics:
        """Read the figures as they are now, or as they were at the end.

        Raises:
            StreamClosed: the stream was never opened.
        """
        if self._final is not None:
            return self._final
        if self.host is None:
            raise StreamClosed("the stream has not been opened, so it has no figures")
        return StreamStatistics.of(self.host)

    def check_end(self) -> None:
        """Raise what the end of the stream means; nothing if there is none, or it was closed.

        Raises:
            StreamError: says why it ended.
        """
        if self.host is None:
            return
        error = failure(self.name, self.host.reason, self.host.text, self.statistics())
        if error is not None:
            raise error

    def alive(self) -> Host:
        """The lane, if set-points can be sent to it.

        Raises:
            StreamClosed: it is not open, or was closed.
            StreamError: the stream has ended; says why.
        """
        if self.host is None:
            raise StreamClosed("the stream is not open: use it in `async with`")
        if self.host.reason or self._final is not None:
            self.check_end()
            raise StreamClosed("the stream was closed, and takes no set-points any more")
        return self.host

    # -- its life ------------------------------------------------------------------------------

    async def open(self) -> None:
        """Start the lane and see it connected.

        Raises:
            RobotStateError: another stream is open, or something moves the arm.
            StreamLost: there is no controller, or it does not answer.
            LaneFailed: no lane could be started.
        """
        if self.host is not None:
            raise StreamClosed("a stream is opened once: make another one")
        if self._endpoint.admit is not None:
            await self._endpoint.admit(self.name)
        # Nothing may be awaited here, or a motion could be sent in between.
        self._endpoint.streams.add(self)
        try:
            await self._start()
        except BaseException:
            await insist(self._end)
            raise

    async def _start(self) -> None:
        host = Host(self._config)
        host.touch()
        host.start()
        self.host = host
        self._background.start(self._mind(host), f"aioduco {self.name}")
        self._background.start(self._live(host), f"aioduco {self.name} sign of life")
        await host.until_ready(self._options.connect_timeout)
        if self._halted:
            # The robot was stopped before there was a lane to be told of it.
            host.command(Command.HALT)
            await host.until_gone()
        if host.gone:
            self.check_end()
        if not host.ready:
            raise LaneFailed("the stream's lane did not get ready in time; nothing was sent")

    async def close(self, *, at_once: bool) -> None:
        """End the stream and see its lane go.

        Args:
            at_once: bring the arm to rest now, instead of at the last set-point.
        """
        try:
            if not at_once and self.host is not None:
                self.host.command(Command.CLOSE)
                await self.host.until_gone()
        finally:
            _, cancelled = await insist(self._end)
        if cancelled is not None:
            raise cancelled

    async def _end(self) -> None:
        """Have the lane end, whatever it takes, and keep its figures. Safe to do twice."""
        host = self.host
        if host is not None and self._final is None:
            if not host.gone:
                host.command(Command.ABORT)
                with anyio.move_on_after(self._patience):
                    await host.until_gone()
            if not host.gone:
                host.kill()
                with anyio.move_on_after(_KILLED):
                    await host.until_gone()
            _ = self.commanded, self.taken
            self._final = StreamStatistics.of(host)
            if host.gone:
                host.release()
        if host is not None and host.gone:
            # A lane that died may be followed by a stop, which has a deadline of its own.
            await self._minded.wait()
        await self._background.aclose()
        self._endpoint.streams.remove(self)

    async def _mind(self, host: Host) -> None:
        """Hear from the lane to its end; stop the robot if it went without a word."""
        try:
            await host.listen(self._patience + 20 * self._config.period)
            if host.reason is Reason.LANE_DIED and self._endpoint.stop is not None:
                # `stop` says itself, to its own caller, when it cannot be confirmed; here is
                # nobody to tell but the one who meets the lane's death.
                with contextlib.suppress(DucoError):
                    await self._endpoint.stop(self._config.sent.ending)
        finally:
            self._minded.set()

    async def _live(self, host: Host) -> None:
        """Show the lane that the event loop runs and the heartbeat beats."""
        every = min(self._config.stall_limit / _SIGNS, _SIGN_EVERY)
        due = anyio.current_time()
        while not host.gone:
            host.touch(self._endpoint.beats is None or self._endpoint.beats())
            due = max(due + every, anyio.current_time())
            await anyio.sleep_until(due)

    def _crashed(self, _error: BaseException) -> None:
        """Nobody hears the lane any more; it sees that, and brings the arm to rest."""
        if self.host is not None:
            self.host.kill()

    @property
    def _patience(self) -> float:
        """How long the lane may take to bring the arm to rest, and to say good-bye [s]."""
        limits = self._config.sent.limits
        braking = max(v / a for v, a in zip(limits.velocity, limits.acceleration, strict=True))
        return 8.0 + 2 * braking + 4 * self._options.timeout

    # -- what a stop of the robot wants of it --------------------------------------------------

    @property
    def quiet(self) -> bool:
        """Whether the lane can send nothing any more; from any thread."""
        return self.host is None or self.host.silent

    def halt(self) -> None:
        """Send nothing more; from any thread or signal handler, at once."""
        self._halted = True
        if self.host is not None:
            self.host.command(Command.HALT)

    def kill(self) -> None:
        """End a lane that does not end by itself; one in a thread cannot be ended so."""
        if self.host is not None:
            self.host.kill()

    async def ended(self) -> None:
        """Wait until the stream has ended, for whatever reason, and its lane is gone."""
        if self.host is not None and self._final is None:
            await self.host.until_gone()
