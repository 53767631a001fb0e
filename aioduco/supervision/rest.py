"""Carries out what `UnansweredMotion` decides, on an event loop."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

import anyio.lowlevel

from aioduco.errors import DucoError, StopUnconfirmed
from aioduco.reporting import BackgroundLogger
from aioduco.supervision.concurrency import every
from aioduco.supervision.unanswered import LOOK_EVERY, NextStep, UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

__all__ = ["Delivery", "stop_until_certain"]

_log = BackgroundLogger(__name__)


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
