"""Permits of one robot: the gate, with the clock, the waits for stops, and undertakings."""

from __future__ import annotations

import contextlib
import functools
import inspect
import sys
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import anyio

from aioduco._process.platform import boot_time
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterator

    from aioduco.supervision.gate import Gate, Permit


P = ParamSpec("P")
T = TypeVar("T")

#: seconds between two checks whether a stop is confirmed, of what waits for it
_STOPPING_EVERY = 0.01

#: permits of the undertakings in progress, each with the permits of its robot
_undertakings: ContextVar[tuple[tuple[Permits, Permit], ...]] = ContextVar(
    "aioduco_undertakings", default=()
)


class Permits:
    """Asks the gate for permits, and checks them.

    Args:
        gate: decides.
    """

    def __init__(self, gate: Gate) -> None:
        self.gate = gate

    def ask(self, name: str, *, lasting: bool = False) -> Permit:
        """Ask for a permit, within the undertaking in progress.

        Args:
            name: what can move the arm.
            lasting: whether it is an undertaking: a pause does not end it.

        Raises:
            RobotStateError: the robot is closed, or is being closed.
            HeartbeatLost: the heartbeat does not beat, or the program hung.
            TaskStopped: the undertaking has ended.
        """
        return self.gate.ask(name, boot_time(), self._outer(), lasting=lasting)

    def _outer(self) -> Permit | None:
        """The permit of the innermost undertaking in progress."""
        within = [permit for owner, permit in _undertakings.get() if owner is self]
        return within[-1] if within else None

    async def after_stops(self, permit: Permit) -> None:
        """Wait until no stop is being confirmed.

        Raises:
            StopUnconfirmed: a stop was not confirmed.
            TaskStopped, HeartbeatLost, RobotStateError: the permit has ended; nothing was sent.
        """
        if self.gate.stopping:
            async for _ in every(_STOPPING_EVERY):
                if not self.gate.waits(permit, boot_time()):
                    return

    async def stops_ended(self, timeout: float | None = None) -> None:
        """Wait until no stop is being confirmed.

        Args:
            timeout: the longest wait [s]; None for no limit.
        """
        with anyio.move_on_after(timeout):
            async for _ in every(_STOPPING_EVERY):
                if not self.gate.stopping:
                    return

    def check(self, permit: Permit) -> None:
        """Check that a permit is valid.

        Raises:
            TaskStopped, HeartbeatLost, RobotStateError: it has ended; nothing was sent.
        """
        self.gate.check(permit, boot_time())

    def last_check(self, permit: Permit) -> Callable[[], object]:
        """Return the check for the moment before the bytes are handed to a socket."""
        return lambda: self.gate.check(permit, boot_time())

    def undertaking(self, name: str) -> contextlib.AbstractContextManager[None]:
        """Let everything in the block end with the next stop, also what it asks for after it.

        Args:
            name: what the program does in the block, for messages.

        Raises:
            RobotStateError, HeartbeatLost, TaskStopped: as for `ask`.
        """
        return self.within(self.ask(name, lasting=True))

    def from_now(self, name: str) -> contextlib.AbstractContextManager[None]:
        """Let what a block asks for count as asked for now; any thread.

        A stop or a pause that comes before the block has asked ends it. It is refused when the
        block asks, and not here.

        Args:
            name: what the block asks for, for messages.
        """
        outer = self._outer()
        if outer is not None and self.gate.ending(outer) is not None:
            return self.within(outer)
        return self.within(self.gate.present(name))

    @contextlib.contextmanager
    def within(self, permit: Permit) -> Iterator[None]:
        """Let everything that is asked for in the block end with a permit."""
        token = _undertakings.set((*_undertakings.get(), (self, permit)))
        try:
            yield
        finally:
            _undertakings.reset(token)


def asked_at_call(
    function: Callable[P, Coroutine[Any, Any, T]],
) -> Callable[P, Coroutine[Any, Any, T]]:
    """Let a coroutine function count as asked for when it is called, not when a loop begins it.

    Between the two a stop may come: of the code that made a task of it, or, if another thread
    handed it over, while the loop is busy.

    Args:
        function: a method of an object with `_permits`, or a function whose first argument,
            `robot`, is one.
    """

    @functools.wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> Coroutine[Any, Any, T]:
        owner = args[0] if args else kwargs.get("robot")
        permits: Permits | None = getattr(owner, "_permits", None)
        if permits is None:
            return function(*args, **kwargs)  # which says what is wrong
        moment = permits.from_now(function.__name__)

        async def begun() -> T:
            with moment:
                return await function(*args, **kwargs)

        begun.__qualname__ = function.__qualname__  # Python's name of a coroutine never awaited
        return begun()

    if sys.version_info >= (3, 12):
        inspect.markcoroutinefunction(called)
    return called
