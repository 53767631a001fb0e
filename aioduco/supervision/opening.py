"""Opening the connections of a robot, and seeing that a controller is at their other end."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

import anyio

from aioduco.errors import (
    ConnectionLost,
    ConnectTimeout,
    ControllerError,
    DucoError,
    NotAController,
)

if TYPE_CHECKING:
    from aioduco._wire.lane import Lane
    from aioduco.supervision.heartbeat import Heart
    from aioduco.supervision.settings import Settings

#: seconds between two looks whether the first heartbeat was answered
_LOOK_EVERY = 0.002


class Lines(Protocol):
    """What is to be opened."""

    host: str
    port: int
    settings: Settings
    heartbeat: Heart | None

    @property
    def lanes(self) -> tuple[Lane, ...]:
        """All lanes, the most important first."""
        ...

    async def under_guard(self) -> None:
        """Have the guard look after the robot, if there is to be one."""
        ...

    @property
    def poll(self) -> Lane:
        """The lane for the first question."""
        ...


async def open_lines(lines: Lines) -> str:
    """Open every lane, ask two questions, have a guard if wanted, and beat the heart once.

    Returns:
        The version of the controller's software; empty if it does not tell.

    Raises:
        ConnectError: the host is unknown, the port is closed, or nothing answers.
        NotAController: something else answers.
        ConnectTimeout: something accepts connections, but answers nothing.
        GuardLost: the guard cannot be started.
    """
    first, *others = lines.lanes
    await first.open()
    for lane in others:
        await lane.open()
    try:
        await lines.poll.call("get_robot_state", ())
        version = await _version(lines.poll)
        await lines.under_guard()
        if lines.heartbeat is not None:
            lines.heartbeat.start()
            await _heard(lines.heartbeat, lines.settings.call_timeout)
    except TimeoutError as exc:
        raise ConnectTimeout(
            lines.host,
            lines.port,
            f"it accepts connections, but did not answer within {lines.settings.call_timeout:g} s; "
            "is the controller still starting, or does it hang?",
        ) from exc
    except ControllerError as exc:
        raise NotAController(
            lines.host,
            lines.port,
            f"it speaks Thrift, but does not know the controller's functions ({exc}); "
            "the controller's port is 7003",
        ) from exc
    except ConnectionLost as exc:
        raise NotAController(
            lines.host,
            lines.port,
            f"what answers there is no controller, or one that is still starting ({exc}); "
            "the controller's port is 7003",
        ) from exc
    return version


async def _version(lane: Lane) -> str:
    try:
        version: str = await lane.call("get_robot_version", ())
    except ControllerError:
        return ""  # it does not tell, which older ones may not
    return version


async def _heard(heartbeat: Heart, timeout: float) -> None:
    """Wait until the first beat was answered, or could not be sent."""
    due = time.monotonic()
    until = due + timeout
    error: DucoError | None = None
    while due < until:
        if heartbeat.heard:
            return
        error = heartbeat.error
        due += _LOOK_EVERY
        await anyio.sleep(max(0.0, due - time.monotonic()))
    raise TimeoutError("the heartbeat was not answered") from error
