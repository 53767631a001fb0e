"""Messages to pages about an arm: plain values for JSON, from samples of its state. No I/O.

Lengths are in metres and angles in radians; a value that the controller did not send is null.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from aioduco.models.state import alarm_of, standing

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco import Snapshot


def page_sample(sample: Snapshot) -> dict[str, Any]:
    """The message about a sample, sent many times a second."""
    status, io, states = sample.status, sample.io, sample.states
    forces, stands = sample.read_forces, standing(status)
    return {
        "joints": _rounded(status.joints, 5),
        "told": _rounded(status.expected_joints, 5),
        "speeds": _rounded(status.joint_speeds.tolist(), 4),
        "pose": _rounded(status.pose, 5),
        "tool_speed": _length(status.tool_speed.tolist()[:3]),
        "force": None if forces is None else _rounded(forces.tool.tolist(), 2),
        "inputs": _bits(io.digital_inputs),
        "outputs": _bits(io.digital_outputs),
        "tool_inputs": _bits(io.tool_inputs),
        "tool_outputs": _bits(io.tool_outputs),
        "robot": states.robot.name,
        "program": states.program.name,
        "safety": states.safety.name,
        "mode": states.mode.name,
        "moving": None if stands is None else not stands,
    }


def alarm_text(sample: Snapshot | None, silent_after: float, age: float) -> str:
    """The alarm, in capitals; empty if there is none.

    Args:
        sample: the newest sample; None before the first.
        silent_after: seconds after which a sample is old [s].
        age: age of the sample [s].
    """
    if sample is None:
        return "NO ANSWER FROM THE CONTROLLER YET"
    if age > silent_after:
        return f"NO ANSWER FROM THE CONTROLLER FOR {age:.0f} s: WHAT IS SHOWN IS OLD"
    return alarm_of(sample.status, sample.states)


def history_point(told: dict[str, Any]) -> list[Any]:
    """Values of a sample for the plots of the last minute.

    Args:
        told: message from `page_sample`.

    Returns:
        Joint speeds [rad/s], six; the tool's speed [m/s]; the force at the tool [N]; the largest
        difference of a joint from its commanded angle [rad].
    """
    force = None if told["force"] is None else _length(told["force"][:3])
    late = [
        abs(a - b)
        for a, b in zip(told["joints"], told["told"], strict=True)
        if a is not None and b is not None
    ]
    lag = round(max(late), 5) if late else None
    return [*told["speeds"], told["tool_speed"], force, lag]


def _rounded(values: Iterable[float], digits: int) -> list[float | None]:
    return [round(value, digits) + 0.0 if math.isfinite(value) else None for value in values]


def _length(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None and math.isfinite(value)]
    return round(math.hypot(*known), 4) if len(known) == 3 else None


def _bits(values: Iterable[bool]) -> str:
    """Signals as a string of 0 and 1, the first one first."""
    return "".join("1" if value else "0" for value in values)
