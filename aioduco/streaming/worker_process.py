"""The program's side of a worker: starts the worker, listens to it, and waits for its end."""

from __future__ import annotations

import contextlib
import math
import signal
import socket
import threading
from typing import TYPE_CHECKING, Any

import anyio
import anyio.lowlevel

from aioduco._platform import boot_time
from aioduco._spawn import Process, Unstartable
from aioduco._wire.forks import fork_hooks
from aioduco.errors import WorkerFailed
from aioduco.streaming.shared.block import Block
from aioduco.streaming.shared.state import Reason, StreamState
from aioduco.streaming.shared.words import ControlWord, StatusWord, StreamCommand

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.streaming.shared.config import WorkerConfig

__all__ = ["WorkerHandle"]

_LOOK = 0.25  # seconds between two checks whether the worker's process hangs
_LOOK_EVERY = 0.005  # seconds between two checks whether a worker has ended
_EXIT = 5.0  # seconds within which a worker's process must exit after it has closed its socket
_FOR_EVER = 2**64 - 1  # ns


class WorkerHandle:
    """The program's handle of one worker.

    The worker is a separate process, or a thread of this process. In both cases the worker detects
    the end of the program by EOF on a socket, and the program detects the worker's end likewise.

    Args:
        config: the configuration of the worker.
        in_thread: runs a worker until it ends; its arguments are the block and the worker's socket.
    """

    def __init__(
        self, config: WorkerConfig, in_thread: Callable[[Block, socket.socket], None]
    ) -> None:
        self._config = config
        self._run = in_thread
        self._in_thread = config.options.run_in == "thread"
        self._process: Process | None = None
        self._thread: threading.Thread | None = None
        self._link: socket.socket | None = None
        self._woken = anyio.Event()
        self._gone = False
        # A controller that is stopping refuses a set-point that was already sent.
        self._halted = False
        self.block: Block = Block.make(config, shared=not self._in_thread)
        self._outcome: tuple[Reason, str] | None = None

    @property
    def pid(self) -> int | None:
        """Id of the worker's process; None for a thread."""
        return None if self._process is None else self._process.popen.pid

    @property
    def ready(self) -> bool:
        """Whether the worker is connected."""
        return bool(self.block.status[StatusWord.READY])

    @property
    def beat(self) -> int:
        """Time of the worker's last tick [ns of the monotonic clock]; 0 before the first."""
        return self.block.status[StatusWord.BEAT]

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        return StreamState.ENDED if self._gone else StreamState(self.block.status[StatusWord.STATE])

    @property
    def reason(self) -> Reason:
        """Why it ends; `WORKER_DIED` if the worker ended without giving a reason."""
        if self._outcome is not None:
            return self._outcome[0]
        if self._gone and self.block.status[StatusWord.STATE] != StreamState.ENDED:
            return Reason.WORKER_DIED
        reason = Reason(self.block.status[StatusWord.REASON])
        return Reason.STOPPED if reason is Reason.REFUSED and self._halted else reason

    @property
    def gone(self) -> bool:
        """Whether the worker's thread or process has ended."""
        return self._gone

    @property
    def text(self) -> str:
        """Why it ended, as text."""
        if self._outcome is not None:
            return self._outcome[1]
        if self.reason is Reason.WORKER_DIED and self._process is not None:
            code = self._process.popen.poll()
            if code is not None and code < 0:
                return f"its process was killed by {_signal_name(-code)}"
            return f"its process ended with code {code}: {self._process.stderr_tail}".strip(": ")
        return self.block.text

    # Of these, some are called on any thread, and the block may be released at any moment: the
    # worker has then ended.

    def command(self, command: StreamCommand, value: int = 1) -> None:
        """Send a command to the worker; may be called from any thread or signal handler.

        A command never cancels a stronger one.
        """
        with contextlib.suppress(ValueError):
            if command is StreamCommand.HALT and not self.reason:
                self._halted = True
            self.block.control[command] = value

    def touch(self) -> None:
        """Give the worker a sign of life of the event loop."""
        with contextlib.suppress(ValueError):
            self.block.control[ControlWord.ALIVE] = round(boot_time() * 1e9)

    def renew(self, lease: float) -> None:
        """Tell the worker until when the controller does not stop the arm; from any thread.

        Args:
            lease: that time [s of `boot_time`]; inf: for ever.
        """
        nanoseconds = round(max(lease, 0.0) * 1e9) if math.isfinite(lease) else 0
        with contextlib.suppress(ValueError):
            self.block.control[ControlWord.LEASE] = _FOR_EVER if lease == math.inf else nanoseconds

    @property
    def silent(self) -> bool:
        """Whether the worker can send nothing any more; may be read from any thread."""
        try:
            return self._gone or self.block.status[StatusWord.STATE] == StreamState.ENDED
        except ValueError:
            return True

    @property
    def mode_on(self) -> bool:
        """Whether the mode of the stream may be on, or its points in the track pool."""
        return bool(self.block.status[StatusWord.MODE])

    @property
    def unanswered(self) -> bool:
        """Whether the worker waits until an unanswered set-point cannot move the arm any more."""
        return not self._gone and bool(self.block.status[StatusWord.UNANSWERED])

    def start(self) -> None:
        """Start the worker.

        Raises:
            WorkerFailed: no process can be started from here.
        """
        fork_hooks.add(self)
        try:
            ours, theirs = socket.socketpair()
        except BaseException:
            self.block.close()
            raise
        ours.setblocking(False)
        theirs.setblocking(False)
        self._link = ours
        try:
            if self._in_thread:
                self._thread = threading.Thread(
                    target=self._run, args=(self.block, theirs), name="aioduco-stream", daemon=True
                )
                self._thread.start()
                return
            self._process = _start(self.block.handle, theirs)
        except BaseException:
            ours.close()
            theirs.close()
            self.block.close()
            raise
        self.block.close_descriptor()
        theirs.close()

    async def listen(self, patience: float) -> None:
        """Listen to the worker until it ends, and reap its thread or process.

        Args:
            patience: time after which a process that hangs is killed, because it would no longer
                react to commands [s].
        """
        assert self._link is not None
        gone = True
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._guard, patience)
                while await self._receive(self._link):
                    self._wake()
                tasks.cancel_scope.cancel()
            with anyio.CancelScope(shield=True):
                await self._wait_for_exit(_EXIT)
        except Exception:
            gone = False
            raise
        finally:
            # A worker that still runs detects the closed socket, and ends.
            self._link.close()
            self._gone = self._gone or gone
            self._wake()

    async def reap(self, patience: float) -> None:
        """Reap a worker that got the command to end, if `listen` may have ended before.

        Args:
            patience: seconds after which its process is killed.
        """
        await self._wait_for_exit(patience)
        self._gone = True
        self._wake()

    async def _wait_for_exit(self, patience: float) -> None:
        # This polls: a wait for an event needs a descriptor, and there may be no free descriptor.
        start = anyio.current_time()
        looks = 0
        while self._alive():
            looks += 1
            if looks * _LOOK_EVERY > patience:
                self.kill()
            await anyio.sleep_until(start + looks * _LOOK_EVERY)
        if self._process is not None:
            self._process.close()

    def _alive(self) -> bool:
        """Whether its thread or process runs; this also reaps a process that has exited."""
        if self._thread is not None:
            return self._thread.is_alive()
        return self._process is not None and self._process.popen.poll() is None

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

    async def _guard(self, patience: float) -> None:
        start = changed = anyio.current_time()
        beat, number = self.beat, 0
        while True:
            number += 1
            # After a stall of this program, one more check follows before the worker is killed.
            await anyio.sleep_until(max(start + number * _LOOK, anyio.current_time()))
            if self.beat != beat or not self.ready:
                beat, changed = self.beat, anyio.current_time()
            elif anyio.current_time() - changed > patience:
                self.kill()

    def forked(self) -> None:
        """Detach in a forked child: the worker belongs to the parent, and so does its block."""
        self.block = Block.make(self._config, shared=False)
        self._process = self._thread = None
        self._gone = True
        if self._link is not None:
            self._link.close()

    def release(self) -> None:
        """Release the shared block, after the worker has ended; its reason and text are kept."""
        self._outcome = self.reason, self.text
        self.block.close()

    def kill(self) -> None:
        """Kill a worker's process that does not end by itself."""
        if self._process is not None:
            self._process.popen.kill()

    def _wake(self) -> None:
        woken, self._woken = self._woken, anyio.Event()
        woken.set()

    async def until_ready(self, timeout: float) -> None:
        """Wait until the worker is connected, or has ended."""
        with anyio.move_on_after(timeout):
            await self._until(lambda: self.ready)

    async def until_begun(self) -> None:
        """Wait until the worker has taken the first set-point, or has ended."""
        await self._until(lambda: self.state is not StreamState.WAITING)

    async def until_gone(self) -> None:
        """Wait until the worker has ended."""
        await self._until(lambda: False)

    async def until_level(self, level: int) -> None:
        """Wait until at most `level` set-points are in the ring, or the worker has ended."""
        control = self.block.control
        try:
            control[ControlWord.WAKE_BELOW] = max(1, level)
            await self._until(lambda: self.block.ring.level <= level)
        finally:
            # Another task may have left the stream meanwhile: its block is then released.
            if not self._gone:
                control[ControlWord.WAKE_BELOW] = 0

    async def _until(self, reached: Any) -> None:
        # The caller may call this in a loop, so the event loop runs even if it is reached already.
        await anyio.lowlevel.checkpoint()
        while True:
            event = self._woken
            if self._gone or reached():
                return
            await event.wait()


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
