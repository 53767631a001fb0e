"""One worker from its start to its end: for its stream, and for the robot's supervision.

The worker is a separate process, or a thread of this process. In both cases it detects the end of
the program by EOF on a socket, and the program detects the worker's end likewise.

Guarantees:
- `Session.close` returns only when the worker can send nothing any more, and the arm was observed
  at rest or a stop was sent. Cancelling the caller, once or more, does not cut this short.
- If the worker ends without giving a reason, or does not end in time, the session stops the robot
  on another connection. It does the same if the program cannot supervise the worker any more, or if
  the worker could not bring the arm to rest, or end the mode of the stream.
- From the moment at which the stream is admitted, the end of its permit reaches the worker, also if
  that does not exist yet. The robot knows the mode of the stream from then on, until the worker has
  seen it end.
"""

from __future__ import annotations

import contextlib
import math
import signal
import socket
import threading
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import anyio
import anyio.lowlevel

from aioduco._process import trial
from aioduco._process.platform import boot_time, clock_step
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.spawn import Process, Unstartable
from aioduco._wire.failures import resource_error
from aioduco._wire.forks import fork_hooks
from aioduco._wire.owner_loop import OwnerLoop
from aioduco.errors import DucoError, RobotStateError, StreamClosed, WorkerFailed
from aioduco.streaming.ends import failure
from aioduco.streaming.report import StreamStatistics
from aioduco.streaming.shared.block import Block
from aioduco.streaming.shared.words import ControlWord, Reason, StatusWord, StreamState
from aioduco.streaming.worker.main import run_in_thread
from aioduco.supervision.concurrency import BackgroundTasks, every, run_to_completion
from aioduco.supervision.gate import Permit, PermitEnding
from aioduco.supervision.loop_watchdog import keep_alives
from aioduco.supervision.motion_sources import OpenStream

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.streaming.shared.config import WorkerConfig


_log = BackgroundLogger(__name__)

_HALTED = 2.0  # seconds within which a halted worker must end
_KILLED = 1.0  # seconds within which a killed process must end
_EXIT = 5.0  # seconds within which a worker's process must exit after it has closed its socket
_LOOK = 0.25  # seconds between two checks whether the worker's process hangs
_LOOK_EVERY = 0.005  # seconds between two checks whether a worker has ended
_FOR_EVER = 2**64 - 1  # ns

#: why a stream ends whose permit has ended; FAILED for others
_REASONS = {PermitEnding.LAPSED: Reason.LAPSED, PermitEnding.HUNG: Reason.HUNG}


class Session(OpenStream):
    """The life cycle of one stream and of its worker.

    Args:
        endpoint: the robot to which the stream sends.
        config: the configuration of its worker.

    Attributes:
        block: the memory that the worker shares; None before the worker is started.
        gone: whether the worker's thread or process has ended.
    """

    def __init__(self, endpoint: StreamEndpoint, config: WorkerConfig) -> None:
        if trial.current is not None:
            config = replace(config, options=trial.current.settings(config.options))
        self._endpoint = endpoint
        self._gate = endpoint.gate
        self._options = config.options
        self._config = config
        self._owner_loop = OwnerLoop("the stream", moves=False)
        self._background = BackgroundTasks(self._crashed)
        #: tasks that stop the robot after a task of `_background` has failed
        self._rescue = BackgroundTasks(self._rescue_failed)
        self._fault = ""
        self.stopped_by: DucoError | None = None
        self._supervised = anyio.Event()
        self._permit: Permit | None = None
        #: commands that were given, for a worker that does not exist yet
        self._commands: dict[ControlWord, int] = {}
        # A controller that is stopping refuses a set-point that was already sent.
        self._halted = False
        #: whether its mode was on before; None: the robot does not know the mode from this stream
        self._mode_was_on: bool | None = None
        self._process: Process | None = None
        self._thread: threading.Thread | None = None
        self._link: socket.socket | None = None
        self._woken = anyio.Event()
        #: levels of the ring for which tasks wait
        self._levels: list[int] = []
        self.block: Block | None = None
        self.gone: bool = False
        # what is kept of the block after its release
        self._final: StreamStatistics | None = None
        self._outcome: tuple[Reason, str] | None = None
        self._commanded: tuple[float, ...] | None = None
        self._taken = 0
        self._closing = False

    def __repr__(self) -> str:
        end = f" ({self.reason.name})" if self.reason else ""
        where = self._options.run_in
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
    def pid(self) -> int | None:
        """Id of the worker's process; None for a thread, and before it is started."""
        return None if self._process is None else self._process.popen.pid

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        if self.gone or self._final is not None:
            return StreamState.ENDED
        if self.block is None:
            return StreamState.WAITING
        return StreamState(self.block.status[StatusWord.STATE])

    @property
    def reason(self) -> Reason:
        """Why it ended, or is ending."""
        return Reason.FAILED if self._fault else self._worker_reason

    @property
    def _worker_reason(self) -> Reason:
        """Why the worker ends; `WORKER_DIED` if it ended without giving a reason."""
        if self._outcome is not None:
            return self._outcome[0]
        if self.block is None:
            return Reason.NONE
        status = self.block.status
        if self.gone and status[StatusWord.STATE] != StreamState.ENDED:
            return Reason.WORKER_DIED
        reason = Reason(status[StatusWord.REASON])
        return Reason.STOPPED if reason is Reason.REFUSED and self._halted else reason

    @property
    def _worker_text(self) -> str:
        """More about why the worker ended."""
        if self._outcome is not None:
            return self._outcome[1]
        if self._worker_reason is Reason.WORKER_DIED and self._process is not None:
            code = self._process.popen.poll()
            if code is not None and code < 0:
                return f"its process was killed by {_signal_name(-code)}"
            return f"its process ended with code {code}: {self._process.stderr_tail}".strip(": ")
        return "" if self.block is None else self.block.text

    @property
    def commanded(self) -> tuple[float, ...] | None:
        """The last set-point that the worker sent; None before the first, and up to 10 ms old."""
        if self.block is not None and self._final is None:
            point = self.block.report.newest()
            self._commanded = self._commanded if point is None else point.values
        return self._commanded

    @property
    def taken(self) -> int:
        """Number of the program's set-points that the worker has taken."""
        if self.block is not None and self._final is None:
            self._taken = self.block.ring.read
        return self._taken

    def statistics(self) -> StreamStatistics:
        """Read the present statistics, or those at the end of the stream.

        Raises:
            StreamClosed: the stream was never opened.
        """
        if self._final is not None:
            return self._final
        if self.block is None:
            raise StreamClosed("the stream has not been opened, so it has no figures")
        return StreamStatistics.of(
            self.block, self.state, self._worker_reason, in_process=self._process is not None
        )

    def check_end(self) -> None:
        """Raise the error for the end of the stream, unless it is open or was closed.

        Raises:
            StreamError: the stream has ended; the error says why.
        """
        if self.block is None:
            return
        text = self._fault or self._worker_text
        error = failure(
            self.name,
            self.reason,
            text,
            self.statistics(),
            self.stopped_by,
            reads=self._config.sent.kind == "probe",
        )
        if error is not None:
            raise error

    def check_loop(self) -> None:
        """Raise `WrongLoop` or `WrongProcess` unless the stream belongs to this event loop."""
        self._owner_loop.require(self.name)

    def alive(self) -> Block:
        """The block of the worker, if set-points can be sent to it.

        Raises:
            StreamClosed: the stream is not open, or was closed.
            StreamError: the stream has ended; the error says why.
        """
        if self.block is None:
            raise StreamClosed(
                "the stream is not open: use it in its block, by `with` or, where it is awaited, "
                "`async with`"
            )
        self._owner_loop.require(self.name)
        if self.reason or self._final is not None or self._closing:
            self.check_end()
            raise StreamClosed("the stream was closed, and takes no set-points any more")
        return self.block

    # -- life cycle ----------------------------------------------------------------------------

    async def open(self) -> None:
        """Start the worker and wait until it is connected.

        Raises:
            RobotStateError: another stream is open, or something moves the arm.
            StreamLost: there is no controller, or it does not answer.
            WorkerFailed: no worker could be started.
        """
        if self.block is not None:
            raise StreamClosed("a stream is opened once: make another one")
        self._owner_loop.require(self.name)
        with self._endpoint.asked(self.name):
            if self._endpoint.envelope is not None:
                envelope = await self._endpoint.envelope(self._config.sent)
                if envelope is not None:
                    self._config = replace(self._config, envelope=envelope)
            if self._endpoint.admit is not None:
                self._permit = await self._endpoint.admit(self.name)
        # Nothing may be awaited here; otherwise a motion could be sent in between.
        for other in self._endpoint.streams:
            raise RobotStateError(
                f"{other!r} is open on this robot; close it before you open another one. "
                "Nothing was sent"
            )
        self._endpoint.streams.append(self)
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
            self._launch()
        except (OSError, RuntimeError) as exc:
            why = resource_error(exc) or exc
            raise WorkerFailed(f"no worker could be started: {why}. Nothing was sent") from exc
        # What ended before the line above is told now, and what ends after it at once.
        if self._permit is not None and (ending := self._gate.ending(self._permit)) is not None:
            self.halt() if ending.stops else self.withdraw(ending)
        for command, value in dict(self._commands).items():
            self._command(command, value)
        self._background.start(self._supervise(), f"aioduco {self.name}", self._supervised.set)
        self._background.start(self._send_keep_alives(), f"aioduco {self.name} keep-alive")
        with anyio.move_on_after(self._options.connect_timeout):
            await self._until(lambda: bool(self._word(StatusWord.READY)))
        if self._commands:
            await self.until_gone()
        if self.gone:
            self.check_end()
        if not self._word(StatusWord.READY):
            raise WorkerFailed("the stream's worker did not get ready in time; nothing was sent")

    def _launch(self) -> None:
        """Start the worker, as a thread or as a process."""
        if trial.current is not None:
            trial.current.at_own_pace(lambda: self.gone)
        in_thread = self._options.run_in == "thread"
        with contextlib.ExitStack() as undo:
            self.block = block = Block.make(self._config, shared=not in_thread)
            undo.callback(setattr, self, "block", None)
            undo.callback(block.close)
            self._touch()
            self.renew(self._gate.lease)
            fork_hooks.add(self)
            self._link, theirs = socket.socketpair()
            undo.callback(self._link.close)
            undo.callback(theirs.close)
            self._link.setblocking(False)
            theirs.setblocking(False)
            if in_thread:
                self._thread = threading.Thread(
                    target=run_in_thread, args=(block, theirs), name="aioduco-stream", daemon=True
                )
                self._thread.start()
            else:
                self._process = _start(block.handle, theirs)
                block.close_descriptor()
                theirs.close()
            undo.pop_all()

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
            # Other tasks send nothing more: the worker ends only once all is taken.
            self._closing = True
            if not at_once and self.block is not None:
                self._command(ControlWord.CLOSE)
                await self.until_gone()
        finally:
            _, cancelled = await run_to_completion(self._end)
        if cancelled is not None:
            raise cancelled

    async def _end(self) -> None:
        """End the worker, by force if necessary, and keep its statistics. Safe to do twice."""
        block = self.block
        if block is not None and self._final is None:
            if not self.gone:
                self._command(ControlWord.ABORT)
                await self._until_gone_within(self._end_timeout)
            if self.unanswered:
                await self._until_gone_within(self._config.unanswered_timeout)
            if not self.gone:
                self.kill()
                await self._until_gone_within(_KILLED)
            _ = self.commanded, self.taken
            self._final = self.statistics()
            self._note_mode()
            if self.gone:
                self._outcome = self._worker_reason, self._worker_text
                block.close()
        if block is not None and self.gone:
            # After a worker that died, `_supervise` may still stop the robot, within a deadline.
            await self._supervised.wait()
        with anyio.move_on_after(self._end_timeout):
            await self._rescue.ended()
        await self._rescue.aclose()
        await self._background.aclose()
        self._note_mode()
        if self in self._endpoint.streams:
            self._endpoint.streams.remove(self)

    def _note_mode(self) -> None:
        """Note that the mode of the stream is over, or may be on although its worker has ended."""
        modes, ending = self._endpoint.modes, self._config.sent.ending
        was_on, self._mode_was_on = self._mode_was_on, None
        if modes is None or was_on is None:
            return
        if self._word(StatusWord.MODE):
            modes.overdue(ending)
        elif not was_on:
            modes.over(ending)

    def forked(self) -> None:
        """Detach in a forked child: the worker belongs to the parent, and so does its block."""
        self.block = Block.make(self._config, shared=False)
        self._process = self._thread = None
        self.gone = True
        if self._link is not None:
            self._link.close()

    @property
    def _end_timeout(self) -> float:
        """Time within which the worker must bring the arm to rest and end [s]."""
        limits = self._config.sent.limits
        braking = max(v / a for v, a in zip(limits.velocity, limits.acceleration, strict=True))
        return 8.0 + 2 * braking + 4 * self._options.timeout

    # -- supervision of the worker -------------------------------------------------------------

    async def _supervise(self) -> None:
        """Listen to the worker until it ends; stop the robot if it gave no reason."""
        try:
            await self._listen(self._end_timeout + 20 * self._config.period)
        except Exception as error:
            # At once: the worker detects the closed socket, and would report that as its reason.
            self._crashed(error)
            raise
        if self._worker_reason is Reason.STOPPED and not self._halted:
            self._gate.end(PermitEnding.STOPPED)  # by another program
        lost = self._worker_reason is Reason.WORKER_DIED or self._word(StatusWord.MODE)
        lost = lost or self._word(StatusWord.UNSTOPPED)
        if lost and self._endpoint.stop is not None:
            await self._stop_robot(self._endpoint.stop)

    async def _listen(self, patience: float) -> None:
        """Listen to the worker until it ends, and reap its thread or process.

        Args:
            patience: time after which a process that hangs is killed, because it would no longer
                react to commands [s].
        """
        assert self._link is not None
        gone = True
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._kill_if_hung, patience)
                told = False
                while await self._receive(self._link):
                    self._wake()
                    if self.unanswered and not told:
                        told = True
                        _log.warning(
                            "the arm is stopped, and watched until nothing can come any more of a "
                            "set-point of %s that was not answered, for up to %g s",
                            self.name,
                            self._config.unanswered_timeout,
                        )
                tasks.cancel_scope.cancel()
            with anyio.CancelScope(shield=True):
                await self._wait_for_exit(_EXIT)
        except Exception:
            gone = False
            raise
        finally:
            # A worker that still runs detects the closed socket, and ends.
            self._link.close()
            self.gone = self.gone or gone
            self._wake()

    @staticmethod
    async def _receive(link: socket.socket) -> bool:
        """Wait for a byte from the worker; returns False at the end of the socket's data (EOF)."""
        while True:
            await anyio.wait_readable(link)
            try:
                return bool(link.recv(4096))
            except BlockingIOError:
                continue
            except OSError:
                return False

    async def _kill_if_hung(self, patience: float) -> None:
        beat, changed = self._word(StatusWord.BEAT), time.monotonic()
        async for _ in every(_LOOK):
            if self._word(StatusWord.BEAT) != beat or not self._word(StatusWord.READY):
                beat, changed = self._word(StatusWord.BEAT), time.monotonic()
            elif time.monotonic() - changed > patience:
                self.kill()

    async def _wait_for_exit(self, patience: float) -> None:
        # This polls: a wait for an event needs a descriptor, and there may be no free descriptor.
        looks = 0  # and no time: a worker is not killed because this program stood still
        async for _ in every(_LOOK_EVERY):
            if not self._runs():
                break
            looks += 1
            if looks * _LOOK_EVERY > patience:
                self.kill()
        if self._process is not None:
            self._process.close()

    def _runs(self) -> bool:
        """Whether its thread or process runs; this also reaps a process that has exited."""
        if self._thread is not None:
            return self._thread.is_alive()
        return self._process is not None and self._process.popen.poll() is None

    async def _send_keep_alives(self) -> None:
        """Send the worker keep-alives of the event loop; none counts once the gate is closed."""
        async for _ in keep_alives(self._config.stall_limit):
            if self.gone:
                return
            if self._gate.alive(boot_time()):
                self._touch()
            self.renew(self._gate.lease)

    def _touch(self) -> None:
        """Send the worker a keep-alive of the event loop."""
        self._write(ControlWord.ALIVE, round(boot_time() * 1e9))

    def _crashed(self, error: BaseException) -> None:
        """End the worker and stop the robot, because a task that supervises the worker failed."""
        if self._fault or self.block is None:
            return  # it is already in progress
        self._fault = f"what looks after it failed: {error!r}"
        stop = self._endpoint.stop
        if stop is None:
            # Only the worker can bring the arm to rest.
            self._command(ControlWord.ABORT)
            patience = self._end_timeout
        else:
            self._command(ControlWord.HALT)
            self._rescue.start(self._stop_robot(stop), f"aioduco stop of {self.name}")
            patience = _HALTED
        self._rescue.start(self._reap(patience), f"aioduco end of {self.name}")

    async def _reap(self, patience: float) -> None:
        """Reap a worker that got the command to end, if `_listen` may have ended before."""
        await self._wait_for_exit(patience)
        self.gone = True
        self._wake()

    async def _stop_robot(self, stop: Callable[[str], Awaitable[object]]) -> None:
        # `stop` raises if the stop cannot be confirmed. This task has no caller that could handle
        # the error; the user of the stream gets the error for the worker's end, and who leaves the
        # robot that of a further stop.
        with contextlib.suppress(DucoError):
            await stop(self._config.sent.ending)

    def _rescue_failed(self, error: BaseException) -> None:
        """Kill the worker's process, because the rescue failed too."""
        self._fault = f"{self._fault}, and then {error!r}"
        self.kill()

    # -- waiting for the worker ----------------------------------------------------------------

    async def until_begun(self) -> None:
        """Wait until the worker has taken the first set-point, or has ended."""
        await self._until(lambda: self.state is not StreamState.WAITING)

    async def until_level(self, level: int) -> None:
        """Wait until at most `level` set-points are in the ring, or the worker has ended."""
        assert self.block is not None
        ring, awaited = self.block.ring, max(1, level)
        self._levels.append(awaited)
        try:
            self._write(ControlWord.WAKE_BELOW, max(self._levels))
            await self._until(lambda: ring.level <= level)
        finally:
            self._levels.remove(awaited)
            self._write(ControlWord.WAKE_BELOW, max(self._levels, default=0))

    async def until_gone(self) -> None:
        """Wait until the worker has ended."""
        await self._until(lambda: False)

    async def _until_gone_within(self, timeout: float) -> None:
        with anyio.move_on_after(timeout):
            await self.until_gone()

    async def _until(self, reached: Callable[[], bool]) -> None:
        # The caller may call this in a loop, so the event loop runs even if it is reached already.
        await anyio.lowlevel.checkpoint()
        while True:
            event = self._woken
            if self.gone or reached():
                return
            await event.wait()

    def _wake(self) -> None:
        woken, self._woken = self._woken, anyio.Event()
        woken.set()

    # -- for a stop of the robot ---------------------------------------------------------------

    # Of these, some are called on any thread, and the block may be released at any moment: the
    # worker has then ended.

    def _word(self, word: StatusWord) -> int:
        """A word of the worker's status; 0 before the worker is started, and after its end."""
        try:
            return 0 if self.block is None else self.block.status[word]
        except ValueError:
            return 0

    def _write(self, word: ControlWord, value: int) -> None:
        """Set a word that the worker reads."""
        with contextlib.suppress(ValueError):
            if self.block is not None:
                self.block.control[word] = value

    @property
    def quiet(self) -> bool:
        """Whether the worker can send nothing any more; may be read from any thread."""
        block = self.block
        try:
            return block is None or self.gone or block.status[StatusWord.STATE] == StreamState.ENDED
        except ValueError:
            return True

    @property
    def unanswered(self) -> bool:
        """Whether the worker keeps the arm stopped until its last set-point cannot move it."""
        return not self.gone and self._final is None and bool(self._word(StatusWord.UNANSWERED))

    def halt(self) -> None:
        """Send nothing more, from now on; may be called from any thread or signal handler."""
        self._command(ControlWord.HALT)

    def withdraw(self, ending: PermitEnding) -> None:
        """Send nothing more and stop the arm; may be called from any thread or signal handler.

        Args:
            ending: why the permit has ended.
        """
        self._command(ControlWord.WITHDRAW, _REASONS.get(ending, Reason.FAILED))

    def _command(self, command: ControlWord, value: int = 1) -> None:
        """Send a command to the worker; a command never cancels a stronger one."""
        self._commands[command] = value
        with contextlib.suppress(ValueError):
            if command is ControlWord.HALT and not self._worker_reason:
                self._halted = True
        self._write(command, value)

    def renew(self, lease: float) -> None:
        """Tell the worker until when the controller does not stop the arm; from any thread.

        Args:
            lease: that time [s of `boot_time`]; inf: for ever.
        """
        nanoseconds = round(max(lease, 0.0) * 1e9) if math.isfinite(lease) else 0
        self._write(ControlWord.LEASE, _FOR_EVER if lease == math.inf else nanoseconds)

    def kill(self) -> None:
        """Kill a worker's process that does not end by itself; a thread cannot be killed."""
        if self._process is not None:
            self._process.popen.kill()

    async def ended(self) -> None:
        """Wait until the stream has ended, for any reason, and its worker has ended."""
        if self.block is not None and self._final is None:
            await self.until_gone()
            if self._final is None:
                self._note_mode()


def _signal_name(number: int) -> str:
    """The name of a signal; its number if it has no name, as most real-time signals."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _start(memory: int | str, link: socket.socket) -> Process:
    """Start a worker's process, as a new interpreter.

    It is not forked, so it is small and the program may have threads. It does not use
    `multiprocessing`, so scripts need no main guard and notebooks work.
    """
    try:
        return Process("aioduco.streaming.worker.main", [link], memory=memory)
    except Unstartable as exc:
        raise WorkerFailed(
            f"a stream cannot have a process of its own, and nothing was sent: {exc}, "
            'or use run_in="thread"'
        ) from exc
