"""Commands that may move the arm, from sending until it is known what became of them.

Such a command is sent by a task of its own, so that no cancellation of the caller can cut off the
answer that says whether it was accepted. Its connection waits for that answer longer than the
caller does: a controller that took the command and reads it late still answers it, and only the
answer tells that the command cannot come any later.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

import anyio
import anyio.lowlevel

from aioduco._wire.unanswered import NextStep, UnansweredMotion
from aioduco.errors import DucoError, NotSent, OutcomeUnknown, StopUnconfirmed
from aioduco.reporting import BackgroundLogger
from aioduco.supervision.concurrency import every
from aioduco.supervision.stop_channel import STANDSTILL_EVERY

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator
    from typing import Any

    from aioduco._wire.handoff import AwaitedCall
    from aioduco._wire.lane import WireLane
    from aioduco.supervision.concurrency import BackgroundTasks

__all__ = ["Delivery", "PendingCommand", "PendingCommands", "stop_until_certain"]

_log = BackgroundLogger(__name__)

#: seconds in which a peer acknowledges what it received, on any network that carries motions
_ACKNOWLEDGED = 0.25


class PendingCommand:
    """A command on its way to the controller.

    Args:
        name: the function of the wire.

    Attributes:
        answer: what the controller answered; -1 if nothing.
        error: why there is no answer; None if there is one.
        at: when its end was noticed [s of `time.monotonic`].
        answered: whether the controller answered it, be it by an error.
    """

    def __init__(self, name: str) -> None:
        self.name = name
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
        """Whether nothing is waited for any more."""
        return self._over.is_set()

    @property
    def sent(self) -> bool:
        """Whether a connection was asked to send it."""
        return self._call is not None and self._call.handed_over

    @property
    def stuck(self) -> bool:
        """Whether it should have been acknowledged, and this system still holds some of it."""
        late = time.monotonic() - self._begun > _ACKNOWLEDGED
        return late and self._call is not None and self._call.undelivered > 0

    def give_up(self) -> None:
        """Close its connection: what was not delivered by now never will be."""
        self._scope.cancel()

    async def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is over. Returns whether it is.

        Args:
            timeout: most seconds to wait; None for no limit.
        """
        with anyio.move_on_after(timeout):
            await self._over.wait()
        return self.over

    async def carry_out(self, lane: WireLane, args: tuple[Any, ...], timeout: float | None) -> None:
        """Send it, and keep its answer or error."""
        try:
            with self._scope:
                self.answer = await lane.call(self.name, args, timeout, self._take)
                self.answered = True
        except OutcomeUnknown as exc:
            self.error = exc
        except DucoError as exc:
            # not sent, or refused by the controller: either way it is known what became of it
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
        """Nothing sends it any more; one that was never sent never will be."""
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
        self.answered = True  # nothing of it will come: that is as certain as an answer
        return NotSent(f"{self.name} was not sent: no connection could be made in time")


class PendingCommands:
    """The commands of one robot that may move the arm and are on their way.

    Args:
        background: sends them.
        limit: seconds for which a late answer is waited for.
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
        self, lane: WireLane, name: str, args: tuple[Any, ...], timeout: float | None
    ) -> PendingCommand:
        """Send a command beside the caller.

        Args:
            lane: where.
            name: the function of the wire.
            args: its arguments.
            timeout: seconds in which its answer should come; None: at the end of the motion.
        """
        pending = PendingCommand(name)
        self._pending.append(pending)
        limit = None if timeout is None else timeout + self._limit
        work = self._carry_out(pending, lane, args, limit)
        self._background.start(work, f"aioduco {name}", lambda: self._over(pending))
        return pending

    async def _carry_out(
        self, pending: PendingCommand, lane: WireLane, args: tuple[Any, ...], limit: float | None
    ) -> None:
        try:
            await pending.carry_out(lane, args, limit)
        finally:
            self._over(pending)

    def _over(self, pending: PendingCommand) -> None:
        pending.close()
        if pending in self._pending:
            self._pending.remove(pending)


class Delivery(Protocol):
    """What is known of the delivery of a motion to the controller."""

    def tell(self, motion: UnansweredMotion) -> bool:
        """Tell `motion` what is known by now. Returns whether the controller can still be asked."""
        ...

    def dissolve(self) -> None:
        """Wait for its answer no more: close its connection."""
        ...


async def stop_until_certain(
    motion: UnansweredMotion,
    delivery: Delivery,
    stop: Callable[[], Awaitable[object]],
    moves: Callable[[], Awaitable[bool]],
) -> bool:
    """Stop the arm, and return when the motion cannot set it moving any more.

    Args:
        motion: says what to do.
        delivery: tells what is known of the motion.
        stop: sends a stop until one is accepted, and raises `StopUnconfirmed` if none is.
        moves: asks whether the arm moves, and raises a `DucoError` if nobody answers.

    Returns:
        Whether that is certain; if not, the time is over, or nobody can be asked.
    """
    ticker = every(STANDSTILL_EVERY)
    while True:
        if not delivery.tell(motion):
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
                    motion.unheard(time.monotonic())
                else:
                    motion.seen(time.monotonic(), moving=moving)
                await ticker.wait()
