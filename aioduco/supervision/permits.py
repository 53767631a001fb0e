"""Permits of one robot: the gate, with the clock, the waits for stops, and undertakings."""

from __future__ import annotations

import contextlib
from contextvars import ContextVar
from typing import TYPE_CHECKING

import anyio

from aioduco._process.platform import boot_time
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.supervision.gate import Gate, Permit


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

    def ask(self, name: str, asked: Permit | None = None, *, lasting: bool = False) -> Permit:
        """Ask for a permit, within the undertaking in progress.

        Args:
            name: what can move the arm.
            asked: the permit of the moment in which the program asked for it; None for now.
            lasting: whether it is an undertaking: a pause does not end it.

        Raises:
            RobotStateError: the robot is closed, or is being closed.
            HeartbeatLost: the heartbeat does not beat, or the program hung.
            TaskStopped: the undertaking, or that permit, has ended.
        """
        within = [permit for owner, permit in _undertakings.get() if owner is self][-1:]
        if asked is not None:
            within.append(asked)
        return self.gate.ask(name, boot_time(), within, lasting=lasting)

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
        """Let what the block hands over to the robot's loop count as asked for now; any thread.

        A stop or a pause that comes before the loop has begun it ends it. It is refused when the
        loop asks, and not here: most of it moves nothing.

        Args:
            name: what is handed over, for messages.
        """
        if any(owner is self for owner, _ in _undertakings.get()):
            return contextlib.nullcontext()  # its permit is older
        return self.within(self.gate.present(name))

    @contextlib.contextmanager
    def within(self, permit: Permit) -> Iterator[None]:
        """Let everything that is asked for in the block end with a permit."""
        token = _undertakings.set((*_undertakings.get(), (self, permit)))
        try:
            yield
        finally:
            _undertakings.reset(token)
