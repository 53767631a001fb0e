"""What is different in the messages of ROS 2: times, and the types of the action. No I/O."""

# pyright: reportMissingImports=false
# ROS 2 and its messages come with the system or a workspace, and have no types.

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from builtin_interfaces.msg import Duration, Time
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState

from aioduco.integrations.ros import shared_messages
from aioduco.integrations.ros.trajectory_goals import ErrorCode, GoalRefused, TrajectoryGoal

if TYPE_CHECKING:
    from aioduco.integrations.ros.trajectory_server import GoalProgress


_NANO = 1_000_000_000


def stamp(seconds: float) -> Any:
    """A time of so many seconds."""
    return _filled(Time, seconds)


def _filled(kind: Any, seconds: float) -> Any:
    return kind(sec=int(seconds // 1), nanosec=int(seconds % 1.0 * _NANO))


def _seconds(message: Any) -> float:
    """Seconds of a time or a duration."""
    return float(message.sec + message.nanosec / _NANO)


def trajectory(message: Any) -> TrajectoryGoal:
    """A trajectory with the default tolerances, unchecked."""
    return shared_messages.trajectory(message, _seconds)


def goal(message: Any) -> TrajectoryGoal:
    """A goal of FollowJointTrajectory, unchecked.

    Raises:
        GoalRefused: it has joints of more than one axis, or component tolerances.
    """
    if message.multi_dof_trajectory.points:
        raise GoalRefused(ErrorCode.INVALID_JOINTS, "the arm has no joint of more than one axis")
    if message.component_path_tolerance or message.component_goal_tolerance:
        raise GoalRefused(ErrorCode.INVALID_GOAL, "tolerances of components are not looked at")
    return shared_messages.goal(message, _seconds)


def result(code: ErrorCode, text: str) -> Any:
    """A result of FollowJointTrajectory."""
    return FollowJointTrajectory.Result(error_code=int(code), error_string=text)


def feedback(names: tuple[str, ...], found: GoalProgress, at: float) -> Any:
    """A feedback of FollowJointTrajectory, with joints in the arm's order."""
    message = FollowJointTrajectory.Feedback(joint_names=list(names))
    return shared_messages.progress(message, found, stamp(at), _filled(Duration, found.time))


def controller_state(names: tuple[str, ...], found: GoalProgress, factor: float, at: float) -> Any:
    """Where the arm is and is to be, under the present names and those of Humble."""
    message = JointTrajectoryControllerState(joint_names=list(names))
    if hasattr(message, "speed_scaling_factor"):
        message.speed_scaling_factor = factor
    return shared_messages.progress(message, found, stamp(at))
