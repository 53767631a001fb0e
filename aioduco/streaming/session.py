"""One worker from its start to its end, for the robot and its supervision.

Guarantees:
- `Session.close` returns only when the worker can send nothing any more, and the arm was observed
  at rest or a stop was sent. Cancelling the caller, once or more, does not cut this short.
- If the worker ends without giving a reason, or does not end in time, the session stops the robot
  on another connection. It does the same if the program cannot supervise the worker any more, or if
  the worker could not end the mode of the stream.
- From the moment at which the stream is admitted, the end of its permit reaches the worker, also if
  that does not exist yet. The robot knows the mode of the stream from then on, until the worker has
  seen it end.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace
from typing import TYPE_CHECKING

import anyio

from aioduco._platform import boot_time, clock_step
from aioduco._wire.owner_loop import OwnerLoop
from aioduco._wire.resource_errors import resource_error
from aioduco.errors import DucoError, StreamClosed, WorkerFailed
from aioduco.streaming.ends import failure
from aioduco.streaming.report import StreamStatistics
from aioduco.streaming.shared.state import Reason, StreamState
from aioduco.streaming.shared.words import StreamCommand
from aioduco.streaming.worker.main import run_in_thread
from aioduco.streaming.worker_process import WorkerHandle
from aioduco.supervision.concurrency import BackgroundTasks, run_to_completion
from aioduco.supervision.gate import PermitEnding

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.streaming.shared.config import WorkerConfig
    from aioduco.supervision.gate import Permit

__all__ = ["Session"]

_HALTED = 2.0  # seconds within which a halted worker must end
_KILLED = 1.0  # seconds within which a killed process must end
_SIGNS = 10  # signs of life of the event loop per stall limit
_SIGN_EVERY = 0.1  # longest time between two signs of life [s]
#: why a stream ends whose permit has ended; FAILED for others
_REASONS = {PermitEnding.LAPSED: Reason.LAPSED, PermitEnding.HUNG: Reason.HUNG}


class Session:
    """The life cycle of one stream.

    Args:
        endpoint: the robot to which the stream sends.
        config: the configuration of its worker.
    """

    def __init__(self, endpoint: StreamEndpoint, config: WorkerConfig) -> None:
        self._endpoint = endpoint
        self._options = config.options
        self._config = config
        self._owner_loop = OwnerLoop("the stream", moves=False)
        self._background = BackgroundTasks(self._crashed)
        #: tasks that stop the robot after a task of `_background` has failed
        self._rescue = BackgroundTasks(self._rescue_failed)
        self._fault = ""
        self._supervised = anyio.Event()
        self._permit: Permit | None = None
        #: commands that were given, for a worker that does not exist yet
        self._commands: dict[StreamCommand, int] = {}
        #: whether its mode was on before; None: the robot does not know the mode from this stream
        self._mode_was_on: bool | None = None
        self._final: StreamStatistics | None = None
        self._commanded: tuple[float, ...] | None = None
        self._taken = 0
        self.host: WorkerHandle | None = None

    def __repr__(self) -> str:
        end = f" ({self.reason.name})" if self.reason else ""
        where = "process" if self._options.run_in == "process" else "thread"
        return f"<Stream {self.name} {self.rate:g} Hz in a {where}, {self.state.name}{end}>"

    # -- status --------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the stream, usually its function of the wire."""
        return self._config.sent.name

    @property
    def rate(self) -> float:
        """Set-points per second [Hz]."""
        return self._config.feeding.rate

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        if self._final is not None:
            return StreamState.ENDED
        return StreamState.WAITING if self.host is None else self.host.state

    @property
    def reason(self) -> Reason:
        """Why it ended, or is ending."""
        if self._fault:
            return Reason.FAILED
        return Reason.NONE if self.host is None else self.host.reason

    @property
    def commanded(self) -> tuple[float, ...] | None:
        """The last set-point that the worker sent; None before the first, and up to 10 ms old."""
        if self.host is not None and self._final is None:
            point = self.host.block.report.newest()
            self._commanded = self._commanded if point is None else point.values
        return self._commanded

    @property
    def taken(self) -> int:
        """Number of the program's set-points that the worker has taken."""
        if self.host is not None and self._final is None:
            self._taken = self.host.block.ring.read
        return self._taken

    def statistics(self) -> StreamStatistics:
        """Read the present statistics, or those at the end of the stream.

        Raises:
            StreamClosed: the stream was never opened.
        """
        if self._final is not None:
            return self._final
        if self.host is None:
            raise StreamClosed("the stream has not been opened, so it has no figures")
        return StreamStatistics.of(self.host)

    def check_end(self) -> None:
        """Raise the error for the end of the stream, unless it is open or was closed.

        Raises:
            StreamError: the stream has ended; the error says why.
        """
        if self.host is None:
            return
        text = self._fault or self.host.text
        error = failure(self.name, self.reason, text, self.statistics())
        if error is not None:
            raise error

    def alive(self) -> WorkerHandle:
        """The worker, if set-points can be sent to it.

        Raises:
            StreamClosed: the stream is not open, or was closed.
            StreamError: the stream has ended; the error says why.
        """
        if self.host is None:
            raise StreamClosed("the stream is not open: use it in `async with`")
        self._owner_loop.require(self.name)
        if self.host.reason or self._fault or self._final is not None:
            self.check_end()
            raise StreamClosed("the stream was closed, and takes no set-points any more")
        return self.host

    # -- life cycle ----------------------------------------------------------------------------

    async def open(self) -> None:
        """Start the worker and wait until it is connected.

        Raises:
            RobotStateError: another stream is open, or something moves the arm.
            StreamLost: there is no controller, or it does not answer.
            WorkerFailed: no worker could be started.
        """
        if self.host is not None:
            raise StreamClosed("a stream is opened once: make another one")
        self._owner_loop.require(self.name)
        if self._endpoint.envelope is not None:
            envelope = await self._endpoint.envelope(self._config.sent)
            if envelope is not None:
                self._config = replace(self._config, envelope=envelope)
        if self._endpoint.admit is not None:
            self._permit = await self._endpoint.admit(self.name)
        # Nothing may be awaited here; otherwise a motion could be sent in between.
        self._endpoint.streams.add(self)
        if self._endpoint.modes is not None and self._config.sent.ending:
            self._mode_was_on = self._endpoint.modes.enter(self._config.sent.ending)
        try:
            await self._start()
        except BaseException:
            await run_to_completion(self._end)
            raise

    async def _start(self) -> None:
        if (step := clock_step()) > self._config.period:
            raise WorkerFailed(
                f"no worker was started: the clock of this Python goes on in steps of "
                f"{step * 1e3:.1f} ms, and the stream's period is "
                f"{self._config.period * 1e3:g} ms. "
                "On Windows, Python 3.13 has a finer one. Nothing was sent"
            )
        try:
            host = WorkerHandle(self._config, run_in_thread)
            host.touch()
            host.renew(self._lease)
            host.start()
        except (OSError, RuntimeError) as exc:
            why = resource_error(exc) or exc
            raise WorkerFailed(f"no worker could be started: {why}. Nothing was sent") from exc
        self.host = host
        # What ended before the line above is told now, and what ends after it at once.
        if self._permit is not None and self._endpoint.gate is not None:
            ending = self._endpoint.gate.ending(self._permit)
            if ending is not None:
                self.halt() if ending.stops else self.withdraw(ending)
        for command, value in dict(self._commands).items():
            host.command(command, value)
        self._background.start(self._supervise(host), f"aioduco {self.name}", self._supervised.set)
        self._background.start(self._send_signs_of_life(host), f"aioduco {self.name} sign of life")
        await host.until_ready(self._options.connect_timeout)
        if self._commands:
            await host.until_gone()
        if host.gone:
            self.check_end()
        if not host.ready:
            raise WorkerFailed("the stream's worker did not get ready in time; nothing was sent")

    async def close(self, *, at_once: bool) -> None:
        """End the stream and wait until its worker has ended.

        Args:
            at_once: whether to bring the arm to rest now, instead of at the last set-point.

        In a forked child this does nothing.
        """
        if self._owner_loop.in_forked_child:
            return
        self._owner_loop.require(self.name)
        try:
            if not at_once and self.host is not None:
                self.host.command(StreamCommand.CLOSE)
                await self.host.until_gone()
        finally:
            _, cancelled = await run_to_completion(self._end)
        if cancelled is not None:
            raise cancelled

    async def _end(self) -> None:
        """End the worker, by force if necessary, and keep its statistics. Safe to do twice."""
        host = self.host
        if host is not None and self._final is None:
            if not host.gone:
                host.command(StreamCommand.ABORT)
                with anyio.move_on_after(self._end_timeout):
                    await host.until_gone()
            if host.unanswered:
                with anyio.move_on_after(self._config.unanswered_timeout):
                    await host.until_gone()
            if not host.gone:
                host.kill()
                with anyio.move_on_after(_KILLED):
                    await host.until_gone()
            _ = self.commanded, self.taken
            self._final = StreamStatistics.of(host)
            self._note_mode()
            if host.gone:
                host.release()
        if host is not None and host.gone:
            # After a worker that died, `_supervise` may still stop the robot, within a deadline.
            await self._supervised.wait()
        with anyio.move_on_after(self._end_timeout):
            await self._rescue.ended()
        await self._rescue.aclose()
        await self._background.aclose()
        self._note_mode()
        self._endpoint.streams.remove(self)

    def _note_mode(self) -> None:
        """Note that the mode of the stream is over, or may be on although its worker has ended."""
        modes, ending = self._endpoint.modes, self._config.sent.ending
        was_on, self._mode_was_on = self._mode_was_on, None
        if modes is None or was_on is None:
            return
        if self.host is not None and self.host.mode_on:
            modes.overdue(ending)
        elif not was_on:
            modes.over(ending)

    async def _supervise(self, host: WorkerHandle) -> None:
        """Listen to the worker until it ends; stop the robot if it gave no reason."""
        try:
            await host.listen(self._end_timeout + 20 * self._config.period)
        except Exception as error:
            # At once: the worker detects the closed socket, and would report that as its reason.
            self._crashed(error)
            raise
        lost = host.reason is Reason.WORKER_DIED or host.mode_on
        if lost and self._endpoint.stop is not None:
            await self._stop_robot(self._endpoint.stop)

    async def _send_signs_of_life(self, host: WorkerHandle) -> None:
        """Give the worker signs of life of the event loop; none counts once the gate is closed."""
        every = min(self._config.stall_limit / _SIGNS, _SIGN_EVERY)
        due = anyio.current_time()
        gate = self._endpoint.gate
        while not host.gone:
            if gate is None or gate.alive(boot_time()):
                host.touch()
            host.renew(self._lease)
            due = max(due + every, anyio.current_time())
            await anyio.sleep_until(due)

    def _crashed(self, error: BaseException) -> None:
        """End the worker and stop the robot, because a task that supervises the worker failed."""
        if self._fault or self.host is None:
            return  # it is already in progress
        self._fault = f"what looks after it failed: {error!r}"
        stop = self._endpoint.stop
        if stop is None:
            # Only the worker can bring the arm to rest.
            self.host.command(StreamCommand.ABORT)
            patience = self._end_timeout
        else:
            self.host.command(StreamCommand.HALT)
            self._rescue.start(self._stop_robot(stop), f"aioduco stop of {self.name}")
            patience = _HALTED
        self._rescue.start(self.host.reap(patience), f"aioduco end of {self.name}")

    async def _stop_robot(self, stop: Callable[[str], Awaitable[object]]) -> None:
        # `stop` raises if the stop cannot be confirmed. This task has no caller that could handle
        # the error; the user of the stream gets the error for the worker's end.
        with contextlib.suppress(DucoError):
            await stop(self._config.sent.ending)

    def _rescue_failed(self, error: BaseException) -> None:
        """Kill the worker's process, because the rescue failed too."""
        self._fault = f"{self._fault}, and then {error!r}"
        if self.host is not None:
            self.host.kill()

    @property
    def _end_timeout(self) -> float:
        """Time within which the worker must bring the arm to rest and end [s]."""
        limits = self._config.sent.limits
        braking = max(v / a for v, a in zip(limits.velocity, limits.acceleration, strict=True))
        return 8.0 + 2 * braking + 4 * self._options.timeout

    # -- for a stop of the robot ---------------------------------------------------------------

    @property
    def quiet(self) -> bool:
        """Whether the worker can send nothing any more; may be read from any thread."""
        return self.host is None or self.host.silent

    @property
    def unanswered(self) -> bool:
        """Whether the worker keeps the arm stopped until its last set-point cannot move it."""
        return self.host is not None and self._final is None and self.host.unanswered

    def halt(self) -> None:
        """Send nothing more, from now on; may be called from any thread or signal handler."""
        self._command(StreamCommand.HALT)

    def withdraw(self, ending: PermitEnding) -> None:
        """Send nothing more and stop the arm; may be called from any thread or signal handler.

        Args:
            ending: why the permit has ended.
        """
        self._command(StreamCommand.WITHDRAW, _REASONS.get(ending, Reason.FAILED))

    def _command(self, command: StreamCommand, value: int = 1) -> None:
        self._commands[command] = value
        if self.host is not None:
            self.host.command(command, value)

    def renew(self, lease: float) -> None:
        """Pass on until when the controller does not stop the arm; from any thread."""
        if self.host is not None:
            self.host.renew(lease)

    @property
    def _lease(self) -> float:
        gate = self._endpoint.gate
        return math.inf if gate is None else gate.lease

    def kill(self) -> None:
        """Kill a worker's process that does not end by itself; a thread cannot be killed."""
        if self.host is not None:
            self.host.kill()

    async def ended(self) -> None:
        """Wait until the stream has ended, for any reason, and its worker has ended."""
        if self.host is not None and self._final is None:
            await self.host.until_gone()
            if self._final is None:
                self._note_mode()
