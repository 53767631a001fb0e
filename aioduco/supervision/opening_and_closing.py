"""What opening a robot waits for, and the steps by which it is left."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, TypeAlias

import anyio

from aioduco._process.platform import boot_time
from aioduco._process.reporting import FLUSH_LIMIT, BackgroundLogger, reporter
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import ControllerError, DucoError
from aioduco.models.version import ControllerVersion
from aioduco.supervision.concurrency import every, run_to_completion
from aioduco.supervision.heartbeat import HeartbeatState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco._wire.lane import WireLane
    from aioduco.supervision.gate import Gate
    from aioduco.supervision.guard.guarded import GuardClient
    from aioduco.supervision.heartbeat import Heartbeat


_log = BackgroundLogger(__name__)

#: seconds between two checks whether a heartbeat was answered
_LOOK_EVERY = 0.002

ClosingStep: TypeAlias = "tuple[str, float | None, Callable[[float], Awaitable[object]]]"
"""A step: its name, its limit [s] (None: it is left out), and what it does."""


async def version_of(lane: WireLane) -> ControllerVersion:
    """Read the version of a controller's software; an empty one if it does not report it."""
    try:
        return ControllerVersion(await lane.call("get_robot_version", ()))
    except ControllerError:
        return ControllerVersion("")  # of an older controller


async def until_beating(
    heartbeat: Heartbeat | GuardClient, gate: Gate, timeout: float, *, opening: bool = False
) -> bool:
    """Wait until a beat was answered, and the gate knows. Returns whether it was in time.

    The heartbeat's thread tells the gate after it has noted the answer. Until then the gate may
    have the end of an earlier beat's time, which has passed.

    Args:
        heartbeat: the heartbeat.
        gate: what it opens.
        timeout: seconds to wait.
        opening: whether the robot is being opened: an event loop that hung meanwhile moved nothing.
    """
    until = time.monotonic() + timeout
    async for due in every(_LOOK_EVERY):
        if opening and (gate.hung or heartbeat.state is HeartbeatState.STALLED):
            heartbeat.rearm()
            gate.rearm(boot_time())
        elif heartbeat.state is HeartbeatState.BEATING and gate.lease > boot_time():
            return True
        if due >= until or (gate.hung and not opening):
            break
    return False


async def carry_out(
    name: str, limit: float | None, step: Callable[[float], Awaitable[object]]
) -> tuple[Exception | None, BaseException | None]:
    """Carry out a step when a robot is left, to its end, even if it is cancelled.

    Returns:
        Why it failed, and the last cancellation that came meanwhile.
    """
    if limit is None:
        _log.info("leaving the robot: %s is left out", name)
        return None, None
    begin = time.monotonic()
    try:
        _, cancelled = await run_to_completion(lambda: step(limit))
    except Exception as exc:
        took = time.monotonic() - begin
        known = isinstance(exc, DucoError)
        _log.warning(
            "leaving the robot: %s failed after %.3f s: %s",
            *(name, took, exc),
            exc_info=None if known else exc,
        )
        return exc, None
    _log.debug("leaving the robot: %s took %.3f s", name, time.monotonic() - begin)
    return None, cancelled


async def log_written() -> None:
    """Wait until the log messages are written, but not long if the program's handlers hang."""
    done = anyio.Event()
    if reporter.written(loop_callback(done.set)):
        with anyio.move_on_after(FLUSH_LIMIT):
            await done.wait()
