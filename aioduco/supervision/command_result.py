"""What the end of a call says of a command: taken, stopped on its way, never there, or unknown."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import (
    ControllerError,
    DucoError,
    HeartbeatLost,
    OutcomeUnknown,
    TaskStopped,
    UnknownFunction,
)
from aioduco.models.enums import TaskState

if TYPE_CHECKING:
    from aioduco._wire.channel import LaneCall
    from aioduco.supervision.gate import PermitEnding


def taken(call: LaneCall, *, followed: bool) -> bool:
    """Whether the answer says that a command is carried out: by the id of a task, or its end."""
    if not call.answered or call.error is not None:
        return False
    answer: int = call.value
    return answer >= 0 if followed else answer == TaskState.FINISHED


def give_up(call: LaneCall) -> None:
    """Wait for its answer no longer."""
    missing = "no answer came in time" if call.handed_over else "it could not be sent in time"
    call.abandon(missing, late=True)


def stopped_on_its_way(name: str, ending: PermitEnding | None) -> TaskStopped:
    """The error of a command whose permit has ended, and with it what it had begun."""
    if ending is None or ending.stops:
        return TaskStopped(name, None, "was stopped: a stop was requested while it was on its way")
    error = TaskStopped(name, None, f"was stopped: {ending.value} while it was on its way")
    error.__cause__ = HeartbeatLost(ending.value)
    return error


def void(call: LaneCall) -> bool:
    """Whether it is certain that the controller did not get it."""
    return call.answered and call.error is not None and not isinstance(call.error, ControllerError)


def may_move(error: BaseException | None) -> bool:
    """Whether the controller may have accepted a command that ended with this error."""
    if error is not None and not isinstance(error, DucoError):
        return True
    if isinstance(error, OutcomeUnknown):
        return True
    # An application error says that something failed, perhaps after the motion was queued.
    return isinstance(error, ControllerError) and not isinstance(error, UnknownFunction)
