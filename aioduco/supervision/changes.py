"""What happened to the robot, told by two samples of its state: no I/O, no clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
    from aioduco.supervision.feed import Snapshot
    from aioduco.supervision.pulse import HeartbeatState

__all__ = [
    "CollisionDetected",
    "CollisionReset",
    "ConnectionBack",
    "ConnectionGone",
    "EmergencyStopPressed",
    "EmergencyStopReleased",
    "ErrorsChanged",
    "Event",
    "HeartbeatChanged",
    "LoopBlocked",
    "ModeChanged",
    "ProgramStateChanged",
    "RobotStateChanged",
    "SafetyStateChanged",
    "changes",
]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened to the robot.

    Attributes:
        at: when it was seen, on the clock of `time.monotonic` [s].
    """

    at: float


@dataclass(frozen=True, slots=True)
class ConnectionGone(Event):
    """The controller does not answer any more.

    Attributes:
        reason: the error of the last question.
    """

    reason: str


@dataclass(frozen=True, slots=True)
class ConnectionBack(Event):
    """The controller answers again.

    Attributes:
        seconds: how long it did not.
    """

    seconds: float


@dataclass(frozen=True, slots=True)
class RobotStateChanged(Event):
    """The state of the robot (机器人状态) changed."""

    before: RobotState
    after: RobotState


@dataclass(frozen=True, slots=True)
class ProgramStateChanged(Event):
    """The state of the program (程序状态) changed."""

    before: ProgramState
    after: ProgramState


@dataclass(frozen=True, slots=True)
class SafetyStateChanged(Event):
    """The state of the safety controller (安全控制器状态) changed."""

    before: SafetyState
    after: SafetyState


@dataclass(frozen=True, slots=True)
class ModeChanged(Event):
    """The operation mode (操作模式) changed."""

    before: OperationMode
    after: OperationMode


@dataclass(frozen=True, slots=True)
class ErrorsChanged(Event):
    """The controller's error list (错误列表) changed.

    Attributes:
        errors: the list now.
        added: entries that were not in it before.
    """

    errors: tuple[str, ...]
    added: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class CollisionDetected(Event):
    """The controller detected a collision (碰撞).

    Attributes:
        joint: the joint that detected it, 1 to 6.
    """

    joint: int


@dataclass(frozen=True, slots=True)
class CollisionReset(Event):
    """The collision was reset."""


@dataclass(frozen=True, slots=True)
class EmergencyStopPressed(Event):
    """An emergency stop (急停) was pressed."""


@dataclass(frozen=True, slots=True)
class EmergencyStopReleased(Event):
    """The emergency stop was released."""


@dataclass(frozen=True, slots=True)
class HeartbeatChanged(Event):
    """The state of the heartbeat (心跳) changed."""

    before: HeartbeatState
    after: HeartbeatState


@dataclass(frozen=True, slots=True)
class LoopBlocked(Event):
    """The event loop did not run for a while, since something blocked it.

    Attributes:
        seconds: for how long.
        where: the program's line that ran meanwhile, with its callers; empty if it was not seen.
    """

    seconds: float
    where: str


def changes(before: Snapshot, after: Snapshot) -> Iterator[Event]:
    """Every event between two samples, the gravest first."""
    at = after.received_at
    old, new = before.status, after.status
    if new.emergency_stop != old.emergency_stop:
        yield EmergencyStopPressed(at) if new.emergency_stop else EmergencyStopReleased(at)
    if new.collision != old.collision:
        yield CollisionDetected(at, new.collision_axis) if new.collision else CollisionReset(at)
    was, now = before.states, after.states
    if now.safety != was.safety:
        yield SafetyStateChanged(at, was.safety, now.safety)
    if now.robot != was.robot:
        yield RobotStateChanged(at, was.robot, now.robot)
    if now.mode != was.mode:
        yield ModeChanged(at, was.mode, now.mode)
    if now.program != was.program:
        yield ProgramStateChanged(at, was.program, now.program)


def suspicious(before: Snapshot, after: Snapshot) -> bool:
    """Whether the error list may have changed between two samples."""
    old, new = before.status, after.status
    return (
        old.error != new.error
        or old.collision != new.collision
        or old.emergency_stop != new.emergency_stop
        or before.states.safety != after.states.safety
    )
