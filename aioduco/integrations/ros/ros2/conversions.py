"""Messages of ROS 2 from the driver's values, and its values from messages. No I/O."""

# pyright: reportMissingImports=false
# ROS 2 and its messages come with the system or a workspace, and have no types.

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco_msgs.msg import IOState, RobotState, ToolData
from builtin_interfaces.msg import Duration, Time
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped, WrenchStamped
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectoryPoint

from aioduco.integrations.ros.arm_readings import io_state_fields, robot_state_fields
from aioduco.integrations.ros.trajectory_goals import (
    ErrorCode,
    GoalPoint,
    GoalRefused,
    NamedTolerance,
    TrajectoryGoal,
)

if TYPE_CHECKING:
    from aioduco import Snapshot
    from aioduco.integrations.ros.arm_readings import ArmReading, Diagnosis, PlacedFrame
    from aioduco.integrations.ros.trajectory_server import PathFeedback

__all__ = [
    "controller_state",
    "diagnostics",
    "feedback",
    "goal",
    "io_state",
    "joint_state",
    "result",
    "robot_state",
    "tool_data",
    "trajectory",
    "transforms",
    "twist",
    "wrench",
]

_NANO = 1_000_000_000
#: fields of JointTrajectoryControllerState, in all its versions, for each part of a feedback
_PARTS = {
    "desired": ("reference", "desired", "output"),
    "actual": ("feedback", "actual"),
    "error": ("error",),
}


def _time(seconds: float) -> Any:
    return Time(sec=int(seconds // 1), nanosec=int(seconds % 1.0 * _NANO))


def _seconds(message: Any) -> float:
    """Seconds of a time or a duration."""
    return float(message.sec + message.nanosec / _NANO)


def trajectory(message: Any) -> TrajectoryGoal:
    """A trajectory with the default tolerances, unchecked."""
    return TrajectoryGoal(
        joint_names=list(message.joint_names),
        points=[
            GoalPoint(
                point.positions.tolist(),
                point.velocities.tolist(),
                point.accelerations.tolist(),
                point.effort.tolist(),
                _seconds(point.time_from_start),
            )
            for point in message.points
        ],
        stamp=_seconds(message.header.stamp),
    )


def goal(message: Any) -> TrajectoryGoal:
    """A goal of FollowJointTrajectory, unchecked.

    Raises:
        GoalRefused: it has joints of more than one axis, or component tolerances.
    """
    if message.multi_dof_trajectory.points:
        raise GoalRefused(ErrorCode.INVALID_JOINTS, "the arm has no joint of more than one axis")
    if message.component_path_tolerance or message.component_goal_tolerance:
        raise GoalRefused(ErrorCode.INVALID_GOAL, "tolerances of components are not looked at")
    found = trajectory(message.trajectory)
    return TrajectoryGoal(
        found.joint_names,
        found.points,
        found.stamp,
        [_tolerance(each) for each in message.path_tolerance],
        [_tolerance(each) for each in message.goal_tolerance],
        _seconds(message.goal_time_tolerance),
    )


def _tolerance(message: Any) -> NamedTolerance:
    return NamedTolerance(message.name, message.position, message.velocity, message.acceleration)


def result(code: ErrorCode, text: str) -> Any:
    """A result of FollowJointTrajectory."""
    return FollowJointTrajectory.Result(error_code=int(code), error_string=text)


def feedback(names: tuple[str, ...], found: PathFeedback, stamp: float) -> Any:
    """A feedback of FollowJointTrajectory, with joints in the arm's order."""
    message = FollowJointTrajectory.Feedback(joint_names=list(names))
    message.header.stamp = _time(stamp)
    at = _time(found.time)
    time = Duration(sec=at.sec, nanosec=at.nanosec)
    for part in ("desired", "actual", "error"):
        point = JointTrajectoryPoint(positions=getattr(found, part).tolist(), time_from_start=time)
        setattr(message, part, point)
    return message


def controller_state(
    names: tuple[str, ...], found: PathFeedback, factor: float, stamp: float
) -> Any:
    """Where the arm is and is to be, under the present names and those of Humble."""
    message = JointTrajectoryControllerState(joint_names=list(names))
    message.header.stamp = _time(stamp)
    for part, titles in _PARTS.items():
        point = JointTrajectoryPoint(positions=getattr(found, part).tolist())
        for title in titles:
            if hasattr(message, title):
                setattr(message, title, point)
    if hasattr(message, "speed_scaling_factor"):
        message.speed_scaling_factor = factor
    return message


def joint_state(names: tuple[str, ...], reading: ArmReading, frame: str, stamp: float) -> Any:
    """Joint states of the arm with that base."""
    message = JointState(name=names, position=reading.position)
    message.velocity, message.effort = reading.velocity, reading.effort
    message.header.frame_id, message.header.stamp = frame, _time(stamp)
    return message


def transforms(base: str, frames: list[PlacedFrame], stamp: float) -> Any:
    """Frames in the frame of the base."""
    at = _time(stamp)
    found = []
    for frame in frames:
        message = TransformStamped(child_frame_id=frame.name)
        message.header.frame_id, message.header.stamp = base, at
        place, turn = message.transform.translation, message.transform.rotation
        place.x, place.y, place.z = frame.position
        turn.x, turn.y, turn.z, turn.w = frame.quaternion
        found.append(message)
    return TFMessage(transforms=found)


def wrench(frame: str, force: list[float], stamp: float) -> Any:
    """Force and torque at the tool."""
    message = WrenchStamped()
    message.header.frame_id, message.header.stamp = frame, _time(stamp)
    push, twist = message.wrench.force, message.wrench.torque
    push.x, push.y, push.z, twist.x, twist.y, twist.z = force
    return message


def twist(message: Any) -> tuple[list[float], str]:
    """A speed of the tool, and the frame of its axes: of a Twist or a TwistStamped."""
    frame = "" if not hasattr(message, "header") else message.header.frame_id
    inner = getattr(message, "twist", message)
    push, turn = inner.linear, inner.angular
    return [push.x, push.y, push.z, turn.x, turn.y, turn.z], frame


def tool_data(fields: dict[str, Any], frame: str, stamp: float) -> Any:
    """Data of the tool in use."""
    message = ToolData(**fields)
    message.header.frame_id, message.header.stamp = frame, _time(stamp)
    return message


def robot_state(snapshot: Snapshot, frame: str, stamp: float) -> Any:
    """States of robot, program, safety and mode."""
    message = RobotState(**robot_state_fields(snapshot))
    message.header.frame_id, message.header.stamp = frame, _time(stamp)
    return message


def io_state(snapshot: Snapshot, frame: str, stamp: float) -> Any:
    """Inputs and outputs; the first of each list has the number 1."""
    message = IOState(**io_state_fields(snapshot))
    message.header.frame_id, message.header.stamp = frame, _time(stamp)
    return message


def diagnostics(name: str, host: str, found: Diagnosis, stamp: float) -> Any:
    """Diagnosis of the arm."""
    status = DiagnosticStatus(
        level=bytes([found.level]), name=name, message=found.message, hardware_id=host
    )
    status.values = [KeyValue(key=key, value=value) for key, value in found.values.items()]
    message = DiagnosticArray(status=[status])
    message.header.stamp = _time(stamp)
    return message
