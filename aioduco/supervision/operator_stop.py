"""Stops an arm without a robot: for an operator at a shell, whom nothing may keep waiting.

The stop is the first thing that is sent, on the first connection that opens. Nothing is asked
before it, and no more is loaded than a stop needs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import anyio

from aioduco._wire.framing import Malformed
from aioduco._wire.lane import WireLane
from aioduco.errors import (
    DucoError,
    NotAController,
    ProtocolError,
    StaleState,
    StopUnconfirmed,
    UnknownFunction,
)
from aioduco.models.samples import Samples
from aioduco.supervision.concurrency import run_to_completion
from aioduco.supervision.stop_channel import FIRST_ATTEMPT, StopChannel

if TYPE_CHECKING:
    from aioduco.models.state import RobotStates


async def stop_arm(
    host: str,
    port: int,
    *,
    connect_timeout: float = 3.0,
    call_timeout: float = 2.0,
    stop_timeout: float = 5.0,
    standstill_timeout: float = 5.0,
) -> RobotStates:
    """Stop an arm, whichever program moves it, and wait until it stands; to its end if cancelled.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        connect_timeout: maximum seconds for opening a connection.
        call_timeout: maximum seconds for reading the states.
        stop_timeout: seconds within which the controller must accept a stop.
        standstill_timeout: seconds within which the arm must stand after that.

    Returns:
        The states of the controller after that.

    Raises:
        ConnectError: there is no controller; nothing was sent.
        NotAController: something else answers.
        StopUnconfirmed: it is not known that the arm stands: press the emergency stop.
        StaleState: the arm stands; its states could not be read.
    """
    lane = WireLane("stop", host, port, connect_timeout=connect_timeout, call_timeout=call_timeout)
    # one lane for all, since nothing else is sent meanwhile; each repeat has a fresh connection
    channel = StopChannel(lane, lane, lane)

    async def bring_to_rest() -> None:
        try:
            if not await _accepted(lane):
                await channel.stop(stop_timeout)
        except StopUnconfirmed:
            await _check_peer(lane)
            raise
        await channel.rest(stop_timeout, standstill_timeout)

    await lane.open()
    try:
        _, cancelled = await run_to_completion(bring_to_rest)
        if cancelled is not None:
            raise cancelled
        try:
            return Samples().states(await lane.call("get_robot_state", ()))
        except DucoError as exc:
            what = f"the arm was stopped, and stands; its states could not be read: {exc}"
            raise StaleState(what) from exc
    finally:
        with anyio.CancelScope(shield=True):
            await lane.aclose()


async def _accepted(lane: WireLane) -> bool:
    """Send a first stop. Returns whether the controller accepted it.

    Raises:
        NotAController: what answers is no controller.
    """
    try:
        answer: int = await lane.call("stop", (False,), FIRST_ATTEMPT)
    except DucoError as exc:
        if isinstance(exc, UnknownFunction) or isinstance(exc.__cause__, Malformed):
            await _check_peer(lane)
        return False
    return answer >= 0


async def _check_peer(lane: WireLane) -> None:
    """Check that the other end has functions of a controller, after it did not take a stop."""
    try:
        await lane.call("get_robot_state", ())
    except (ProtocolError, UnknownFunction) as exc:
        reason = f"what answers there is no controller ({exc}); the controller's port is 7003"
        raise NotAController(lane.host, lane.port, reason) from exc
    except DucoError:
        return
