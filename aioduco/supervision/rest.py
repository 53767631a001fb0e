"""Brings the arm to rest, by the steps of `UnansweredMotion`, on an event loop."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import anyio.lowlevel

from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError, StopUnconfirmed
from aioduco.supervision.concurrency import every
from aioduco.supervision.unanswered import LOOK_EVERY, NextStep, UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

__all__ = ["Delivery", "bring_to_rest"]

_log = BackgroundLogger(__name__)


class Delivery:
    """What is known of the delivery of a motion to the controller: here, nothing more."""

    def report(self, motion: UnansweredMotion) -> bool:  # noqa: ARG002  # nothing to report
        """Report it to `motion`. Returns whether the controller can still be polled."""
        return True

    def dissolve(self) -> None:
        """Stop waiting for its answer: close its connection."""


async def bring_to_rest(
    motion: UnansweredMotion,
    stop: Callable[[], Awaitable[object]],
    moves: Callable[[], Awaitable[bool]],
    delivery: Delivery | None = None,
) -> bool:
    """Return when the arm stands and the motion cannot move it any more.

    Args:
        motion: decides on the next step.
        stop: sends a stop until one is accepted, and raises `StopUnconfirmed` if none is.
        moves: polls whether the arm moves, and raises a `DucoError` if no answer comes.
        delivery: reports the delivery of the motion; None if there is nothing to report.

    Returns:
        Whether that is certain; if not, the time is over, or the controller cannot be polled.
    """
    delivery = delivery or Delivery()
    ticker = every(LOOK_EVERY)
    while delivery.report(motion):
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
                    motion.poll_failed(now, time.monotonic())
                else:
                    motion.stopped(now, time.monotonic())
            case NextStep.LOOK:
                try:
                    moving = await moves()
                except (DucoError, MemoryError):
                    motion.poll_failed(now, time.monotonic())
                else:
                    motion.seen(now, time.monotonic(), moving=moving)
                await ticker.wait()
    return False
