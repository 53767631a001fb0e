"""The program's side of a worker: it starts the worker, hears from it, and sees it end."""

from __future__ import annotations

import contextlib
import signal
import socket
import threading
import time
from typing import TYPE_CHECKING, Any

import anyio

from aioduco._spawn import Process, Unstartable
from aioduco._wire.forks import fork_hooks
from aioduco.errors import LaneFailed
from aioduco.streaming.shared.block import Block, ControlWord, StatusWord, StreamCommand
from aioduco.streaming.shared.state import Reason, StreamState

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.streaming.shared.config import WorkerConfig

__all__ = ["WorkerHandle"]

_LOOK = 0.25  # seconds between two looks at whether the worker's process stands still
_LOOK_EVERY = 0.005  # seconds between two looks at whether a worker is gone
_EXIT = 5.0  # seconds that a worker's process may take to go after it has said its last word


class WorkerHandle:
    """One worker, seen from the program.

    The worker is a process of its own, or a thread of this one. Either way it hears of the end of
    the program by the end of a socket, and is heard of in the same way.

    Args:
        config: all that the worker is told.
        in_thread: runs a worker to its end, given the block and its end of the socket.
    """

    def __init__(
        self, config: WorkerConfig, in_thread: Callable[[Block, socket.socket], None]
    ) -> None:
        self._config = config
        self._run = in_thread
        self._in_thread = config.options.lane == "thread"
        self._process: Process | None = None
        self._thread: threading.Thread | None = None
        self._link: socket.socket | None = None
        self._woken = anyio.Event()
        self._gone = False
        # A controller that is stopping refuses a set-point that was on its way.
        self._halted = False
        self.block: Block = Block.make(config, shared=not self._in_thread)
        self._outcome: tuple[Reason, str] | None = None

    @property
    def pid(self) -> int | None:
        """The worker's process; None for a thread."""
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
        """Why it ends; `LANE_DIED` if the worker went without a word."""
        if self._outcome is not None:
            return self._outcome[0]
        if self._gone and self.block.status[StatusWord.STATE] != StreamState.ENDED:
            return Reason.LANE_DIED
        reason = Reason(self.block.status[StatusWord.REASON])
        return Reason.STOPPED if reason is Reason.REFUSED and self._halted else reason

    @property
    def gone(self) -> bool:
        """Whether the worker is over: its thread or process does nothing any more."""
        return self._gone

    @property
    def text(self) -> str:
        """Why it ended, in words."""
        if self._outcome is not None:
            return self._outcome[1]
        if self.reason is Reason.LANE_DIED and self._process is not None:
            code = self._process.popen.poll()
            if code is not None and code < 0:
                return f"its process was killed by {signal.Signals(-code).name}"
            return f"its process ended with code {code}: {self._process.last_words}".strip(": ")
        return self.block.text

    def command(self, command: StreamCommand) -> None:
        """Tell the worker what is wanted of it; from any thread or signal handler, at once.

        A command never takes back a stronger one.
        """
        # The block may be let go of at any moment, by another thread: then the worker is gone.
        with contextlib.suppress(ValueError):
            if command is StreamCommand.HALT and not self.reason:
                self._halted = True
            self.block.control[command] = 1

    def touch(self, alive: bool = True) -> None:
        """Show the worker that the program's event loop runs, or that it is to brake at once."""
        self.block.control[ControlWord.ALIVE] = time.monotonic_ns() if alive else 0

    @property
    def silent(self) -> bool:
        """Whether the worker can send nothing any more; from any thread."""
        try:
            return self._gone or self.block.status[StatusWord.STATE] == StreamState.ENDED
        except ValueError:
            return True

    @property
    def unanswered(self) -> bool:
        """Whether the worker waits until an unanswered set-point cannot move the arm any more."""
        return not self._gone and bool(self.block.status[StatusWord.UNANSWERED])

    def start(self) -> None:
        """Start the worker.

        Raises:
            LaneFailed: no process can be started from here.
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
        """Hear from the worker until it is gone, and see its thread or process go.

        Args:
            patience: time after which a process that stands still is ended: nobody could stop
                what it streams [s].
        """
        assert self._link is not None
        gone = True
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._guard, patience)
                while await self._hear(self._link):
                    self._wake()
                tasks.cancel_scope.cancel()
            await self._reap()
        except Exception:
            gone = False
            raise
        finally:
            # A worker that lives on sees by this that nobody hears it, and ends.
            self._link.close()
            self._gone = self._gone or gone
            self._wake()

    async def bury(self, patience: float) -> None:
        """See a worker go that was told to end, if nobody may be listening to it any more.

        Args:
            patience: seconds after which its process is killed.
        """
        await self._seen_off(patience)
        self._gone = True
        self._wake()

    async def _seen_off(self, patience: float) -> None:
        # By looking: to be woken takes a descriptor, and there may be none.
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
        """Whether its thread or process runs; a process that has ended is seen off by this."""
        if self._thread is not None:
            return self._thread.is_alive()
        return self._process is not None and self._process.popen.poll() is None

    @staticmethod
    async def _hear(link: socket.socket) -> bool:
        """Wait for a word from the worker; whether there was one, and not the end."""
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
            # A program that was itself held up looks once more before it judges.
            await anyio.sleep_until(max(start + number * _LOOK, anyio.current_time()))
            if self.beat != beat or not self.ready:
                beat, changed = self.beat, anyio.current_time()
            elif anyio.current_time() - changed > patience:
                self.kill()

    async def _reap(self) -> None:
        with anyio.CancelScope(shield=True):
            await self._seen_off(_EXIT)

    def forked(self) -> None:
        """This is a forked child: the worker is the parent's, and its block is left alone."""
        self.block = Block.make(self._config, shared=False)
        self._process = self._thread = None
        self._gone = True
        if self._link is not None:
            self._link.close()

    def release(self) -> None:
        """Let go of the shared block, once the worker is gone; what it said last stays."""
        self._outcome = self.reason, self.text
        self.block.close()

    def kill(self) -> None:
        """End a worker's process that does not end by itself."""
        if self._process is not None:
            self._process.popen.kill()

    def _wake(self) -> None:
        woken, self._woken = self._woken, anyio.Event()
        woken.set()

    async def until_ready(self, timeout: float) -> None:
        """Wait until the worker is connected, or gone."""
        with anyio.move_on_after(timeout):
            await self._until(lambda: self.ready)

    async def until_begun(self) -> None:
        """Wait until the worker has taken the first set-point, or is gone."""
        await self._until(lambda: self.state is not StreamState.WAITING)

    async def until_gone(self) -> None:
        """Wait until the worker is gone."""
        await self._until(lambda: False)

    async def until_level(self, level: int) -> None:
        """Wait until no more than so many set-points are in the ring, or the worker is gone."""
        control = self.block.control
        try:
            control[ControlWord.WAKE_BELOW] = max(1, level)
            await self._until(lambda: self.block.ring.level <= level)
        finally:
            control[ControlWord.WAKE_BELOW] = 0

    async def _until(self, reached: Any) -> None:
        while True:
            event = self._woken
            if self._gone or reached():
                return
            await event.wait()


def _start(memory: int | str, link: socket.socket) -> Process:
    """Start a worker's process, by a plain start of the interpreter.

    No fork, so that it is small and the program may have threads; no `multiprocessing`, so that
    scripts need no main guard and notebooks work.
    """
    try:
        return Process("aioduco.streaming.worker.main", [link], memory=memory)
    except Unstartable as exc:
        raise LaneFailed(
            f"a stream cannot have a process of its own, and nothing was sent: {exc}, "
            'or use lane="thread"'
        ) from exc
