"""The event loop to which a lane or a robot belongs, and how another thread wakes it."""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import signal
from typing import TYPE_CHECKING, Any

from aioduco._wire.forks import fork_hooks
from aioduco.errors import WrongLoop, WrongProcess

if TYPE_CHECKING:
    from collections.abc import Callable


class OwnerLoop:
    """The event loop that owns a lane, or a robot with all its lanes: the first one that uses it.

    On any other loop, under any other library and in a forked child, nothing is sent. The check
    takes a fifth of a microsecond: in Python 3.11 asyncio asks the system for the process id before
    it returns the running loop. Comparing threads would be faster, but could not distinguish a
    loop from another one that runs inside it, as in some notebooks.

    Args:
        owner: name of the object that belongs to the loop, for messages.
        moves: whether the object moves to another loop by itself when its own has been closed.
    """

    __slots__ = ("__weakref__", "_loop", "_moves", "_owner", "in_forked_child")

    def __init__(self, owner: str = "the lane", *, moves: bool = True) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._owner = owner
        self._moves = moves
        #: whether this is a child that was forked from the owner's process
        self.in_forked_child: bool = False
        fork_hooks.add(self)

    def require(self, what: str) -> asyncio.AbstractEventLoop:
        """Require that this loop runs here, in the process that opened it.

        Args:
            what: name of the operation, for messages.

        Returns:
            The loop.

        Raises:
            WrongLoop: another loop runs here, or none.
            WrongProcess: this is a forked child.
        """
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            raise self._refusal(what) from None
        if loop is not self._loop:
            self._adopt(loop, what)
        return loop

    def require_process(self, what: str) -> None:
        """Require that this is the owner's process; from any thread.

        Args:
            what: name of the operation, for messages.

        Raises:
            WrongProcess: this is a forked child.
        """
        if self.in_forked_child:
            raise self._refusal(what)

    @property
    def closed(self) -> bool:
        """Whether the loop has been closed: nothing can run on it any more."""
        return self._loop is not None and self._loop.is_closed()

    def run(self, callback: Callable[[], object]) -> None:
        """Call something on the loop: at once if it runs here or was closed; from any thread."""
        loop = self._loop
        try:
            here = asyncio.get_running_loop()
        except RuntimeError:
            here = None
        if loop is not None and loop is not here:
            with contextlib.suppress(RuntimeError):  # it is closed
                loop.call_soon_threadsafe(callback)
                return
        callback()

    def move(self, what: str) -> None:
        """Move to the running loop, since the own loop has been closed.

        Args:
            what: name of the operation, for messages.

        Raises:
            WrongLoop: the loop has not been closed, or asyncio runs none.
        """
        if self.closed:
            self._loop = None
        self.require(what)

    def forked(self) -> None:
        """In a forked child: refuse all calls, and detach its copy of the loop."""
        self.in_forked_child = True
        if self._loop is not None and not self._loop.is_closed():
            _detach_copy(self._loop)

    def _adopt(self, loop: asyncio.AbstractEventLoop, what: str) -> None:
        # where trio runs as a guest of this loop, there is no asyncio task: nothing can be awaited
        if self.in_forked_child or asyncio.current_task() is None:
            raise self._refusal(what)
        if self._loop is not None and not (self._moves and self._loop.is_closed()):
            raise self._refusal(what)
        self._loop = loop

    def _refusal(self, what: str) -> WrongLoop | WrongProcess:
        if self.in_forked_child:
            return WrongProcess(
                f"{what}: refused, since {self._owner} belongs to the process that forked this "
                "one; nothing was sent. Open another one in this process"
            )
        if self._loop is None:
            return WrongLoop(
                f"{what}: refused, since aioduco needs asyncio, and no task of an asyncio event "
                "loop runs here (trio's are none); nothing was sent. Use asyncio.run(...) or "
                'anyio.run(..., backend="asyncio"); a program without an event loop uses '
                "aioduco.sync"
            )
        return WrongLoop(
            f"{what}: refused, since {self._owner} belongs to the event loop on which it was "
            f"opened, {self._loop!r}, and this is not that one; nothing was sent. Open one for "
            "each event loop. From other threads use stop_now() or "
            "asyncio.run_coroutine_threadsafe(..., loop). In notebooks, and wherever several "
            "threads use one robot, use aioduco.sync: its robot has a loop of its own"
        )


def _detach_copy(loop: asyncio.AbstractEventLoop) -> None:
    """In a forked child: detach its copy of the loop from the parent's.

    Parent and child share one epoll. If the child closes its copy of the loop, for example by
    `sys.exit`, this removes the pipe that wakes the loop from that epoll. Then no thread can wake
    the parent's loop any more. So the child gets its own epoll and its own pipe, and its signals no
    longer wake the parent's loop.
    """
    with contextlib.suppress(ValueError):
        signal.set_wakeup_fd(-1)
    ours: Any = loop
    if hasattr(ours, "_get_backend_id"):  # uvloop
        number = ours._get_backend_id()
    elif (selector := getattr(ours, "_selector", None)) is not None and hasattr(selector, "fileno"):
        number = selector.fileno()
    else:
        return  # the loop has no object of the system
    if hasattr(select, "epoll"):
        with select.epoll() as own:
            os.dup2(own.fileno(), number, inheritable=False)
    # A kqueue is not inherited: there, the copy must only not use its descriptor again.
    if hasattr(select, "epoll") and hasattr(ours, "_make_self_pipe"):
        ours._close_self_pipe()
        ours._make_self_pipe()
        return
    # libuv also shares memory with the system. The child's copy would still disturb the parent's
    # loop by that, so this copy never runs again.
    for task in asyncio.all_tasks(loop):
        asyncio.tasks._unregister_task(task)
    ours.run_forever = ours.close = lambda: None
    ours.run_until_complete = lambda work: work.close() if asyncio.iscoroutine(work) else None


def loop_callback(callback: Callable[[], None]) -> Callable[[], None]:
    """Return a function for any thread that schedules the callback on the running event loop."""
    loop = asyncio.get_running_loop()

    def call() -> None:
        try:
            loop.call_soon_threadsafe(callback)
        except RuntimeError:
            # the loop is closed: no task waits for this any more
            return

    return call
