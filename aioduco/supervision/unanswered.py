"""Commands that may move the arm, from sending until their result is certain.

Each such command is sent by a task of its own, so that a cancellation of the caller cannot lose the
answer that says whether it was accepted. Its connection waits for that answer longer than the
caller does: a controller that received the command and reads it late still answers it, and only the
answer shows that the command cannot take effect later.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

import anyio
import anyio.lowlevel

from aioduco._wire.unanswered import LOOK_EVERY, NextStep, UnansweredMotion
from aioduco.errors import (
    ControllerError,
    DucoError,
    NotSent,
    OutcomeUnknown,
    StopUnconfirmed,
)
from aioduco.reporting import BackgroundLogger
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator
    from typing import Any

    from aioduco._wire.channel import AwaitedCall
    from aioduco._wire.lane import WireLane
    from aioduco.supervision.concurrency import BackgroundTasks

__all__ = ["Delivery", "PendingCommand", "PendingCommands", "stop_until_certain"]

_log = BackgroundLogger(__name__)

#: seconds within which a peer acknowledges received bytes, on any network that carries motions
_ACKNOWLEDGED = 0.25


class PendingCommand:
    """A command on its way to the controller.

    Args:
        name: the function of the wire.
        mode: the mode that it enters, as for `Modes.enter`; None if it enters none.

    Attributes:
        answer: the controller's answer; -1 without one.
        error: why there is no answer; None if there is one.
        at: when its end was noticed [s of `time.monotonic`].
        answered: whether its result is certain: the controller answered it, also by an error, or
            it was not sent.
    """

    def __init__(self, name: str, mode: tuple[str, tuple[bool, ...]] | None = None) -> None:
        self.name = name
        self.mode = mode
        self.answer: int = -1
        self.error: DucoError | None = None
        self.at: float = 0.0
        self.answered: bool = False
        self._begun = time.monotonic()
        self._call: AwaitedCall | None = None
        self._scope = anyio.CancelScope()
        self._over = anyio.Event()

    def __repr__(self) -> str:
        how = "answered" if self.answered else "over" if self.over else "on its way"
        return f"<PendingCommand {self.name} {how}>"

    @property
    def over(self) -> bool:
        """Whether the wait for its answer has ended."""
        return self._over.is_set()

    @property
    def sent(self) -> bool:
        """Whether a connection was asked to send it."""
        return self._call is not None and self._call.handed_over

    @property
    def void(self) -> bool:
        """Whether it is certain that the controller did not get it."""
        error = self.error
        return self.answered and error is not None and not isinstance(error, ControllerError)

    @property
    def stuck(self) -> bool:
        """Whether its acknowledgement is overdue, and this system still holds some of its bytes."""
        late = time.monotonic() - self._begun > _ACKNOWLEDGED
        return late and self._call is not None and self._call.undelivered > 0

    def give_up(self) -> None:
        """Close its connection: bytes that were not delivered by now never will be."""
        self._scope.cancel()

    async def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is over. Returns whether it is.

        Args:
            timeout: most seconds to wait; None for no limit.
        """
        with anyio.move_on_after(timeout):
            await self._over.wait()
        return self.over

    async def carry_out(
        self,
        lane: WireLane,
        args: tuple[Any, ...],
        timeout: float | None,
        permit: Callable[[], object] | None = None,
    ) -> None:
        """Send it if `permit` does not raise, and keep its answer or error."""
        try:
            with self._scope:
                self.answer = await lane.call(self.name, args, timeout, self._take, permit)
                self.answered = True
        except OutcomeUnknown as exc:
            self.error = exc
        except DucoError as exc:
            # not sent, or refused by the controller: either way its result is certain
            self.error, self.answered = exc, True
        except BaseException:
            self.error = OutcomeUnknown(self.name, "the program was ended meanwhile")
            raise
        else:
            if not self.answered:
                self.error = self._given_up()
        finally:
            self.at = time.monotonic()
            self._over.set()

    def close(self) -> None:
        """Mark it as over: no task sends it any more. If it was not sent, it never will be."""
        if not self.over:
            self.answered = True
            self.error = NotSent(f"{self.name} was not sent: the program's event loop ends")
            self.at = time.monotonic()
            self._over.set()

    def _take(self, call: AwaitedCall) -> None:
        self._call = call

    def _given_up(self) -> DucoError:
        if self.sent:
            return OutcomeUnknown(self.name, "no answer came in time")
        self.answered = True  # no part of it will arrive: that is as certain as an answer
        return NotSent(f"{self.name} was not sent: no connection could be made in time")


class PendingCommands:
    """The commands of one robot that may move the arm and are on their way.

    A command stays one of them until its sender has its result: meanwhile it is neither on its way
    nor known to move the arm otherwise.

    Args:
        background: sends them.
        limit: seconds to wait for a late answer.
    """

    def __init__(self, background: BackgroundTasks, limit: float) -> None:
        self._background = background
        self._limit = limit
        self._pending: list[PendingCommand] = []

    def __len__(self) -> int:
        return len(self._pending)

    def __iter__(self) -> Iterator[PendingCommand]:
        return iter(tuple(self._pending))

    def send(
        self,
        lane: WireLane,
        name: str,
        args: tuple[Any, ...],
        timeout: float | None,
        permit: Callable[[], object],
        mode: tuple[str, tuple[bool, ...]] | None = None,
    ) -> PendingCommand:
        """Send a command in the background; `remove` must follow when its result is taken in.

        Args:
            lane: lane on which to send it.
            name: the function of the wire.
            args: its arguments.
            timeout: seconds within which its answer should come; None: at the end of the motion.
            permit: called last, before it is sent; it raises if it may not be sent any more.
            mode: the mode that it enters, as for `Modes.enter`; None if it enters none.
        """
        pending = PendingCommand(name, mode)
        self._pending.append(pending)
        limit = None if timeout is None else timeout + self._limit
        work = pending.carry_out(lane, args, limit, permit)
        self._background.start(work, f"aioduco {name}", pending.close)
        return pending

    def remove(self, pending: PendingCommand) -> None:
        """Remove a command whose sender has its result."""
        self._pending.remove(pending)


class Delivery(Protocol):
    """Interface that reports the delivery of a motion to the controller."""

    def report(self, motion: UnansweredMotion) -> bool:
        """Report the delivery to `motion`. Returns whether the controller can still be polled."""
        ...

    def dissolve(self) -> None:
        """Stop waiting for its answer: close its connection."""
        ...


async def stop_until_certain(
    motion: UnansweredMotion,
    delivery: Delivery,
    stop: Callable[[], Awaitable[object]],
    moves: Callable[[], Awaitable[bool]],
) -> bool:
    """Stop the arm, and return when the motion cannot move it any more.

    Args:
        motion: decides on the next step.
        delivery: reports the delivery of the motion.
        stop: sends a stop until one is accepted, and raises `StopUnconfirmed` if none is.
        moves: polls whether the arm moves, and raises a `DucoError` if no answer comes.

    Returns:
        Whether that is certain; if not, the time is over, or the controller cannot be polled.
    """
    ticker = every(LOOK_EVERY)
    while True:
        if not delivery.report(motion):
            return False
        now = time.monotonic()
        match motion.step(now):
            case NextStep.DONE:
                return True
            case NextStep.GIVE_UP:
                return False
            case NextStep.DISSOLVE:
                delivery.dissolve()
                await anyio.lowlevel.checkpoint()
            case NextStep.STOP:
                try:
                    await stop()
                except StopUnconfirmed as exc:
                    _log.error("%s", exc)
                else:
                    motion.stopped(now, time.monotonic())
            case NextStep.LOOK:
                try:
                    moving = await moves()
                except DucoError:
                    motion.poll_failed(time.monotonic())
                else:
                    motion.seen(now, time.monotonic(), moving=moving)
                await ticker.wait()
