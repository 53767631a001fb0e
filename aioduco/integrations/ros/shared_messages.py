"""Messages that ROS 1 and ROS 2 have alike, from the driver's values, and its values from messages.

Times differ: a shell gives them, and reads them, as its version of ROS has them. No I/O.
"""

# pyright: reportMissingImports=false
# Messages come with an installed ROS or are made at run time, and have no types.

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from aioduco_msgs.msg import IOState, RobotState, ToolData
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped, WrenchStamped
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectoryPoint

from aioduco.integrations.ros.arm_readings import io_state_fields, robot_state_fields
from aioduco.integrations.ros.trajectory_goals import GoalPoint, NamedTolerance, TrajectoryGoal

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco import Snapshot
    from aioduco.integrations.ros.arm_readings import ArmReading, Diagnosis, PlacedFrame
    from aioduco.integrations.ros.trajectory_server import GoalProgress


#: fields for each part of a feedback: its own, and those of a controller's state in all versions
_PARTS = {
    "desired": ("reference", "desired", "output"),
    "actual": ("feedback", "actual"),
    "error": ("error",),
}


def trajectory(message: Any, seconds: Callable[[Any], float]) -> TrajectoryGoal:
    """A trajectory with the default tolerances, unchecked.

    Args:
        message: a JointTrajectory.
        seconds: reads a time or a duration [s].
    """
    return TrajectoryGoal(
        joint_names=list(message.joint_names),
        points=[
            GoalPoint(
                list(point.positions),
                list(point.velocities),
                list(point.accelerations),
                list(point.effort),
                seconds(point.time_from_start),
            )
            for point in message.points
        ],
        stamp=seconds(message.header.stamp),
    )


def goal(message: Any, seconds: Callable[[Any], float]) -> TrajectoryGoal:
    """A goal of FollowJointTrajectory, unchecked.

    Args:
        message: the goal.
        seconds: reads a time or a duration [s].
    """
    return replace(
        trajectory(message.trajectory, seconds),
        path_tolerance=[_tolerance(each) for each in message.path_tolerance],
        goal_tolerance=[_tolerance(each) for each in message.goal_tolerance],
        goal_time_tolerance=seconds(message.goal_time_tolerance),
    )


def _tolerance(message: Any) -> NamedTolerance:
    return NamedTolerance(message.name, message.position, message.velocity, message.acceleration)


def progress(message: Any, found: GoalProgress, stamp: Any, time: Any = None) -> Any:
    """Fill in where the arm is and is to be, with joints in the arm's order.

    Args:
        message: a feedback of FollowJointTrajectory, or a JointTrajectoryControllerState.
        found: the place of the arm on its way.
        stamp: time of the message.
        time: time on the trajectory, as a duration; None: left out.
    """
    message.header.stamp = stamp
    for part, titles in _PARTS.items():
        point = JointTrajectoryPoint(positions=getattr(found, part).tolist())
        if time is not None:
            point.time_from_start = time
        for title in titles:
            if hasattr(message, title):
                setattr(message, title, point)
    return message


def _stamped(message: Any, frame: str, stamp: Any) -> Any:
    message.header.frame_id, message.header.stamp = frame, stamp
    return message


def joint_state(
    message: Any, names: tuple[str, ...], reading: ArmReading, frame: str, stamp: Any
) -> Any:
    """Fill in joint states of the arm with that base."""
    message.name, message.position = names, reading.position
    message.velocity, message.effort = reading.velocity, reading.effort
    return _stamped(message, frame, stamp)


def transforms(base: str, frames: list[PlacedFrame], stamp: Any) -> Any:
    """Frames in the frame of the base."""
    found = []
    for frame in frames:
        message = _stamped(TransformStamped(child_frame_id=frame.name), base, stamp)
        place, turn = message.transform.translation, message.transform.rotation
        place.x, place.y, place.z = frame.position
        turn.x, turn.y, turn.z, turn.w = frame.quaternion
        found.append(message)
    return TFMessage(transforms=found)


def wrench(frame: str, force: list[float], stamp: Any) -> Any:
    """Force and torque at the tool."""
    message = _stamped(WrenchStamped(), frame, stamp)
    push, twist = message.wrench.force, message.wrench.torque
    push.x, push.y, push.z, twist.x, twist.y, twist.z = force
    return message


def twist(message: Any) -> tuple[list[float], str]:
    """A speed of the tool, and the frame of its axes: of a Twist or a TwistStamped."""
    frame = "" if not hasattr(message, "header") else message.header.frame_id
    inner = getattr(message, "twist", message)
    push, turn = inner.linear, inner.angular
    return [push.x, push.y, push.z, turn.x, turn.y, turn.z], frame


def tool_data(fields: dict[str, Any], frame: str, stamp: Any) -> Any:
    """Data of the tool in use."""
    return _stamped(ToolData(**fields), frame, stamp)


def robot_state(snapshot: Snapshot, frame: str, stamp: Any) -> Any:
    """States of robot, program, safety and mode."""
    return _stamped(RobotState(**robot_state_fields(snapshot)), frame, stamp)


def io_state(snapshot: Snapshot, frame: str, stamp: Any) -> Any:
    """Inputs and outputs; the first of each list has the number 1."""
    return _stamped(IOState(**io_state_fields(snapshot)), frame, stamp)


def diagnostics(name: str, host: str, found: Diagnosis, stamp: Any) -> Any:
    """Diagnosis of the arm."""
    # by its name: a level is a number in ROS 1, and a byte in ROS 2
    level = getattr(DiagnosticStatus, found.level.name)
    status = DiagnosticStatus(level=level, name=name, message=found.message, hardware_id=host)
    status.values = [KeyValue(key=key, value=value) for key, value in found.values.items()]
    message = DiagnosticArray(status=[status])
    message.header.stamp = stamp
    return message
