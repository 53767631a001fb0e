"""The program's side of a lane: it starts the lane, hears from it, and sees it end."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import anyio

from aioduco.errors import LaneFailed
from aioduco.streaming.lane import Lane
from aioduco.streaming.shared import Block, Command, Control, Status
from aioduco.streaming.source import Reason, State

if TYPE_CHECKING:
    from aioduco.streaming.config import LaneConfig

__all__ = ["Host"]

_LOOK = 0.25  # seconds between two looks at whether the lane's process stands still
_EXIT = 5.0  # seconds that a lane's process may take to go after it has said its last word


class Host:
    """One lane, seen from the program.

    The lane is a process of its own, or a thread of this one. Either way it hears of the end of
    the program by the end of a socket, and is heard of in the same way.

    Args:
        config: all that the lane is told.
    """

    def __init__(self, config: LaneConfig) -> None:
        self._in_thread = config.options.lane == "thread"
        self._process: subprocess.Popen[bytes] | None = None
        self._thread: threading.Thread | None = None
        self._link: socket.socket | None = None
        self._woken = anyio.Event()
        self._gone = False
        self.block: Block = Block.make(config, shared=not self._in_thread)
        self._outcome: tuple[Reason, str] | None = None

    @property
    def pid(self) -> int | None:
        """The lane's process; None for a thread."""
        return None if self._process is None else self._process.pid

    @property
    def ready(self) -> bool:
        """Whether the lane is connected."""
        return bool(self.block.status[Status.READY])

    @property
    def beat(self) -> int:
        """Time of the lane's last tick [ns of the monotonic clock]; 0 before the first."""
        return self.block.status[Status.BEAT]

    @property
    def state(self) -> State:
        """State of the stream."""
        return State.ENDED if self._gone else State(self.block.status[Status.STATE])

    @property
    def reason(self) -> Reason:
        """Why it ends; `LANE_DIED` if the lane went without a word."""
        if self._outcome is not None:
            return self._outcome[0]
        if self._gone and self.block.status[Status.STATE] != State.ENDED:
            return Reason.LANE_DIED
        return Reason(self.block.status[Status.REASON])

    @property
    def gone(self) -> bool:
        """Whether the lane is over: its thread or process does nothing any more."""
        return self._gone

    @property
    def text(self) -> str:
        """Why it ended, in words."""
        if self._outcome is not None:
            return self._outcome[1]
        if self.reason is Reason.LANE_DIED and self._process is not None:
            code = self._process.poll()
            if code is not None and code < 0:
                return f"its process was killed by {signal.Signals(-code).name}"
            return f"its process ended with code {code}"
        return self.block.text

    def command(self, command: Command) -> None:
        """Tell the lane what is wanted of it; from any thread or signal handler, at once.

        A command never takes back a stronger one.
        """
        # The block may be let go of at any moment, by another thread: then the lane is gone.
        with contextlib.suppress(ValueError):
            self.block.control[command] = 1

    def touch(self, alive: bool = True) -> None:
        """Show the lane that the program's event loop runs, or that it is to brake at once."""
        self.block.control[Control.ALIVE] = time.monotonic_ns() if alive else 0

    @property
    def silent(self) -> bool:
        """Whether the lane can send nothing any more; from any thread."""
        try:
            return self._gone or self.block.status[Status.STATE] == State.ENDED
        except ValueError:
            return True

    def start(self) -> None:
        """Start the lane.

        Raises:
            LaneFailed: no process can be started from here.
        """
        ours, theirs = socket.socketpair()
        ours.setblocking(False)
        theirs.setblocking(False)
        self._link = ours
        try:
            if self._in_thread:
                lane = Lane(self.block, theirs, process=False)
                self._thread = threading.Thread(target=lane.run, name="aioduco-stream", daemon=True)
                self._thread.start()
                return
            self._process = _spawn(self.block.descriptor, theirs.fileno())
        except BaseException:
            ours.close()
            theirs.close()
            self.block.close()
            raise
        self.block.close_descriptor()
        theirs.close()

    async def listen(self, patience: float) -> None:
        """Hear from the lane until it is gone, and see its thread or process go.

        Args:
            patience: time after which a process that stands still is ended: nobody could stop
                what it streams [s].
        """
        assert self._link is not None
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._guard, patience)
                while await self._hear(self._link):
                    self._wake()
                tasks.cancel_scope.cancel()
            await self._reap()
        finally:
            # A lane that lives on sees by this that nobody hears it, and ends.
            self._link.close()
            self._gone = True
            self._wake()

    @staticmethod
    async def _hear(link: socket.socket) -> bool:
        """Wait for a word from the lane; whether there was one, and not the end."""
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
            if self._thread is not None:
                # The socket's end is the last thing that the thread does.
                self._thread.join()
            if self._process is not None:
                await _exited(self._process)

    def release(self) -> None:
        """Let go of the shared block, once the lane is gone; what it said last stays."""
        self._outcome = self.reason, self.text
        self.block.close()

    def kill(self) -> None:
        """End a lane's process that does not end by itself."""
        if self._process is not None:
            self._process.kill()

    def _wake(self) -> None:
        woken, self._woken = self._woken, anyio.Event()
        woken.set()

    async def until_ready(self, timeout: float) -> None:
        """Wait until the lane is connected, or gone."""
        with anyio.move_on_after(timeout):
            await self._until(lambda: self.ready)

    async def until_begun(self) -> None:
        """Wait until the lane has taken the first set-point, or is gone."""
        await self._until(lambda: self.state is not State.WAITING)

    async def until_gone(self) -> None:
        """Wait until the lane is gone."""
        await self._until(lambda: False)

    async def until_level(self, level: int) -> None:
        """Wait until no more than so many set-points are in the ring, or the lane is gone."""
        control = self.block.control
        try:
            control[Control.WAKE_BELOW] = max(1, level)
            await self._until(lambda: self.block.ring.level <= level)
        finally:
            control[Control.WAKE_BELOW] = 0

    async def _until(self, reached: Any) -> None:
        while True:
            event = self._woken
            if self._gone or reached():
                return
            await event.wait()


def _spawn(memory: int, link: int) -> subprocess.Popen[bytes]:
    """Start a lane's process, by a plain start of the interpreter.

    No fork, so that it is small and the program may have threads; no `multiprocessing`, so that
    scripts need no main guard and notebooks work. It finds the modules where the program does.
    """
    if not sys.executable or getattr(sys, "frozen", False):
        raise LaneFailed(
            "no Python interpreter can be started from this program, so a stream cannot have a "
            'process of its own; nothing was sent. Use lane="thread"'
        )
    paths = os.pathsep.join(path for path in sys.path if path)
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "aioduco.streaming.lane", str(memory), str(link)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        pass_fds=(memory, link),
        # Ctrl-C and the end of a terminal are for the program; the lane sees its end.
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": paths},
    )


async def _exited(process: subprocess.Popen[bytes]) -> None:
    """Wait for the end of a process that has closed its socket, and free its entry."""
    with contextlib.suppress(ProcessLookupError):
        watched = os.pidfd_open(process.pid)
        try:
            with anyio.move_on_after(_EXIT) as scope:
                await anyio.wait_readable(watched)
            if scope.cancelled_caught:
                process.kill()
                await anyio.wait_readable(watched)
        finally:
            os.close(watched)
    process.wait()
