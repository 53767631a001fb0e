"""Messages of ROS 1 from the driver's values, and its values from messages. No I/O."""

# pyright: reportMissingImports=false
# ROS 1 and its messages come with the system or are made at run time, and have no types.

from __future__ import annotations

import functools
import struct
from typing import TYPE_CHECKING, Any, Final

from aioduco_msgs.msg import IOState, RobotState, ToolData
from control_msgs.msg import (
    FollowJointTrajectoryFeedback,
    FollowJointTrajectoryResult,
    JointTrajectoryControllerState,
)
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped, WrenchStamped
from rospy import Duration, Time
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectoryPoint

from aioduco.integrations.ros.arm_readings import io_state_fields, robot_state_fields
from aioduco.integrations.ros.trajectory_goals import GoalPoint, NamedTolerance, TrajectoryGoal

if TYPE_CHECKING:
    from aioduco import Snapshot
    from aioduco.integrations.ros.arm_readings import ArmReading, Diagnosis, PlacedFrame
    from aioduco.integrations.ros.trajectory_goals import ErrorCode
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
    "transforms",
    "twist",
    "wrench",
]


def goal(message: Any) -> TrajectoryGoal:
    """A goal of FollowJointTrajectory, unchecked."""
    trajectory = message.trajectory
    return TrajectoryGoal(
        joint_names=list(trajectory.joint_names),
        points=[
            GoalPoint(
                point.positions,
                point.velocities,
                point.accelerations,
                point.effort,
                point.time_from_start.to_sec(),
            )
            for point in trajectory.points
        ],
        stamp=trajectory.header.stamp.to_sec(),
        path_tolerance=[_tolerance(each) for each in message.path_tolerance],
        goal_tolerance=[_tolerance(each) for each in message.goal_tolerance],
        goal_time_tolerance=message.goal_time_tolerance.to_sec(),
    )


def _tolerance(message: Any) -> NamedTolerance:
    return NamedTolerance(message.name, message.position, message.velocity, message.acceleration)


def result(code: ErrorCode, text: str) -> Any:
    """A result of FollowJointTrajectory."""
    return FollowJointTrajectoryResult(error_code=int(code), error_string=text)


def feedback(names: tuple[str, ...], found: PathFeedback, stamp: float) -> Any:
    """A feedback of FollowJointTrajectory, with joints in the arm's order."""
    return _filled(FollowJointTrajectoryFeedback(joint_names=list(names)), found, stamp)


def controller_state(names: tuple[str, ...], found: PathFeedback, stamp: float) -> Any:
    """Where the arm is and is to be."""
    return _filled(JointTrajectoryControllerState(joint_names=list(names)), found, stamp)


def _filled(message: Any, found: PathFeedback, stamp: float) -> Any:
    message.header.stamp = Time.from_sec(stamp)
    time = Duration.from_sec(found.time)
    for part in ("desired", "actual", "error"):
        point = JointTrajectoryPoint(positions=getattr(found, part).tolist(), time_from_start=time)
        setattr(message, part, point)
    return message


def joint_state(names: tuple[str, ...], reading: ArmReading, frame: str, stamp: float) -> Any:
    """Joint states of the arm with that base."""
    message = _SixJoints()
    message.name, message.position = names, reading.position
    message.velocity, message.effort = reading.velocity, reading.effort
    message.header.frame_id, message.header.stamp = frame, Time.from_sec(stamp)
    return message


class _SixJoints(JointState):  # type: ignore[misc]  # genpy's have no types
    """Joint states of an arm, packed in one call; genpy makes a format for each name, each time."""

    def serialize(self, buff: Any) -> None:
        """Write the bytes of the message."""
        header = self.header
        stamp = _THREE.pack(header.seq, header.stamp.secs, header.stamp.nsecs)
        numbers = _NUMBERS.pack(6, *self.position, 6, *self.velocity, 6, *self.effort)
        buff.write(stamp + _packed(header.frame_id) + _packed_names(self.name) + numbers)


_THREE: Final = struct.Struct("<3I")
_NUMBERS: Final = struct.Struct("<I6dI6dI6d")


def _packed(text: str) -> bytes:
    data = text.encode()
    return len(data).to_bytes(4, "little") + data


@functools.lru_cache
def _packed_names(names: tuple[str, ...]) -> bytes:
    return len(names).to_bytes(4, "little") + b"".join(map(_packed, names))


def transforms(base: str, frames: list[PlacedFrame], stamp: float) -> Any:
    """Frames in the frame of the base."""
    at = Time.from_sec(stamp)
    found = []
    for frame in frames:
        message = TransformStamped(child_frame_id=frame.name)
        message.header.frame_id, message.header.stamp = base, at
        place, turn = message.transform.translation, message.transform.rotation
        place.x, place.y, place.z = frame.position
        turn.x, turn.y, turn.z, turn.w = frame.quaternion
        found.append(message)
    return TFMessage(found)


def wrench(frame: str, force: list[float], stamp: float) -> Any:
    """Force and torque at the tool."""
    message = WrenchStamped()
    message.header.frame_id, message.header.stamp = frame, Time.from_sec(stamp)
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
    message.header.frame_id, message.header.stamp = frame, Time.from_sec(stamp)
    return message


def robot_state(snapshot: Snapshot, frame: str, stamp: float) -> Any:
    """States of robot, program, safety and mode."""
    message = RobotState(**robot_state_fields(snapshot))
    message.header.frame_id, message.header.stamp = frame, Time.from_sec(stamp)
    return message


def io_state(snapshot: Snapshot, frame: str, stamp: float) -> Any:
    """Inputs and outputs; the first of each list has the number 1."""
    message = IOState(**io_state_fields(snapshot))
    message.header.frame_id, message.header.stamp = frame, Time.from_sec(stamp)
    return message


def diagnostics(name: str, host: str, found: Diagnosis, stamp: float) -> Any:
    """Diagnosis of the arm."""
    status = DiagnosticStatus(
        level=int(found.level), name=name, message=found.message, hardware_id=host
    )
    status.values = [KeyValue(key, value) for key, value in found.values.items()]
    message = DiagnosticArray(status=[status])
    message.header.stamp = Time.from_sec(stamp)
    return message
