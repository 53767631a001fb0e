"""The operating envelope: limits (zones, speeds, margins, forces) that a program keeps for an arm.

    from aioduco.envelope import Envelope, ToolSpeed, Zone

    robot.envelope = Envelope(
        "gcr5_910",
        Zone.plane((0, 0, 0.02), (0, 0, 1), name="table"),
        Zone.sphere((0.5, 0.2, 0.3), 0.15, name="fixture"),
        ToolSpeed(0.5),
    )

This module imports only the limits and the errors, because the worker of a stream loads it, too.
"""

from __future__ import annotations

from aioduco.envelope.limits import (
    BODIES,
    Action,
    Body,
    Crossing,
    Envelope,
    EnvelopeLimit,
    JointMargin,
    SingularityMargin,
    ToolForce,
    ToolSpeed,
    Zone,
)

__all__ = [
    "BODIES",
    "Action",
    "Body",
    "Crossing",
    "Envelope",
    "EnvelopeLimit",
    "JointMargin",
    "SingularityMargin",
    "ToolForce",
    "ToolSpeed",
    "Zone",
]
