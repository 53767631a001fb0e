"""Events of a robot: the classes of the items that `robot.events` yields.

with robot.events.subscribe() as stream:
    async for event in stream:
        if isinstance(event, events.CollisionDetected):
            ...
"""

from __future__ import annotations

from aioduco.supervision.events import (
    CollisionDetected,
    CollisionReset,
    ConnectionBack,
    ConnectionGone,
    EmergencyStopPressed,
    EmergencyStopReleased,
    EnvelopeLeft,
    ErrorsChanged,
    Event,
    HeartbeatChanged,
    LoopBlocked,
    ModeChanged,
    ProgramStateChanged,
    RobotStateChanged,
    SafetyStateChanged,
)

__all__ = [
    "CollisionDetected",
    "CollisionReset",
    "ConnectionBack",
    "ConnectionGone",
    "EmergencyStopPressed",
    "EmergencyStopReleased",
    "EnvelopeLeft",
    "ErrorsChanged",
    "Event",
    "HeartbeatChanged",
    "LoopBlocked",
    "ModeChanged",
    "ProgramStateChanged",
    "RobotStateChanged",
    "SafetyStateChanged",
]
