"""What the clients of ROS 1 and ROS 2 have in common; it knows neither."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable
from typing import Any

#: types of the services that are no Trigger
SERVICES = {
    "set_digital_output": "SetOutput",
    "set_tool_output": "SetOutput",
    "set_speed": "SetSpeed",
    "set_tool": "SetTool",
    "set_load": "SetLoad",
    "movej": "MoveJ",
    "movel": "MoveL",
    "set_analog_output": "SetAnalogOutput",
    "io_and_status_controller/set_io": "SetIO",
    "io_and_status_controller/set_speed_slider": "SetSpeedFraction",
    "io_and_status_controller/set_payload": "SetLoad",
    "dashboard_client/load_program": "SetText",
    "dashboard_client/popup": "SetText",
    "dashboard_client/add_to_log": "SetText",
    "force_mode_controller/start_force_mode": "StartForceMode",
}


def say(**found: Any) -> None:
    sys.stdout.write(json.dumps(found) + "\n")
    sys.stdout.flush()


def apart(one: Iterable[float], other: Iterable[float]) -> float:
    """How far two places are apart, in the joint that is farthest [rad]."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


def smooth_way(
    start: list[float], count: int, duration: float, far: float
) -> list[tuple[list[float], float]]:
    """Places and their times from a start, joints 1 and 6 to another place, smoothly."""
    shares = [number / (count - 1) for number in range(count)]
    ways = [far * share * share * (3.0 - 2.0 * share) for share in shares]
    places = [[start[0] + way, *start[1:5], start[5] + way] for way in ways]
    return [(place, share * duration) for place, share in zip(places, shares, strict=True)]


def spoiled(goal: Callable[[], Any], duration: Callable[[float], Any], old: Any) -> dict[str, Any]:
    """Ten goals, each with one thing wrong."""
    names = ("partial", "name", "nan", "times", "negative", "empty", "lengths", "limits")
    made = {name: goal() for name in (*names, "elsewhere", "old")}
    made["partial"].trajectory.joint_names.pop()
    made["name"].trajectory.joint_names[0] = "elbow"
    made["nan"].trajectory.points[3].positions = [math.nan] * 6
    made["times"].trajectory.points[3].time_from_start = duration(0.01)
    made["negative"].trajectory.points[0].time_from_start = duration(-1.0)
    made["empty"].trajectory.points = []
    made["lengths"].trajectory.points[3].velocities = [0.0] * 5
    made["limits"].trajectory.points[-1].positions = [7.0] * 6
    for point in made["elsewhere"].trajectory.points:
        point.positions = [q + 0.5 for q in point.positions]
    made["old"].trajectory.header.stamp = old
    return made
