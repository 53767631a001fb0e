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


_log = BackgroundLogger(__name__)


async def bring_to_rest(
    motion: UnansweredMotion,
    stop: Callable[[], Awaitable[object]],
    moves: Callable[[], Awaitable[bool]],
    report: Callable[[], bool] = lambda: True,
    reset: Callable[[], object] = lambda: None,
) -> bool:
    """Return when the arm stands and the motion cannot move it any more.

    Args:
        motion: decides on the next step.
        stop: sends a stop until one is accepted, and raises `StopUnconfirmed` if none is.
        moves: polls whether the arm moves, and raises a `DucoError` if no answer comes.
        report: tells `motion` what is known of its delivery; returns whether the controller can
            still be polled.
        reset: waits for its answer no longer: closes its connection.

    Returns:
        Whether that is certain; if not, the time is over, or the controller cannot be polled.
    """
    ticker = every(LOOK_EVERY)
    while report():
        now = time.monotonic()
        match motion.step(now):
            case NextStep.DONE:
                return True
            case NextStep.GIVE_UP:
                return False
            case NextStep.RESET:
                reset()
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
