"""What is different in the messages of ROS 1: times, and the types of the action. No I/O."""

# pyright: reportMissingImports=false
# ROS 1 and its messages come with the system or are made at run time, and have no types.

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from control_msgs.msg import (
    FollowJointTrajectoryFeedback,
    FollowJointTrajectoryResult,
    JointTrajectoryControllerState,
)
from rospy import Duration, Time

from aioduco.integrations.ros import shared_messages

if TYPE_CHECKING:
    from aioduco.integrations.ros.trajectory_goals import ErrorCode, TrajectoryGoal
    from aioduco.integrations.ros.trajectory_server import GoalProgress


def stamp(seconds: float) -> Any:
    """A time of so many seconds."""
    return Time.from_sec(seconds)


def _seconds(message: Any) -> float:
    """Seconds of a time or a duration."""
    return float(message.to_sec())


def goal(message: Any) -> TrajectoryGoal:
    """A goal of FollowJointTrajectory, unchecked."""
    return shared_messages.goal(message, _seconds)


def result(code: ErrorCode, text: str) -> Any:
    """A result of FollowJointTrajectory."""
    return FollowJointTrajectoryResult(error_code=int(code), error_string=text)


def feedback(names: tuple[str, ...], found: GoalProgress, at: float) -> Any:
    """A feedback of FollowJointTrajectory, with joints in the arm's order."""
    return _progress(FollowJointTrajectoryFeedback(joint_names=list(names)), found, at)


def controller_state(names: tuple[str, ...], found: GoalProgress, at: float) -> Any:
    """Where the arm is and is to be."""
    return _progress(JointTrajectoryControllerState(joint_names=list(names)), found, at)


def _progress(message: Any, found: GoalProgress, at: float) -> Any:
    return shared_messages.progress(message, found, stamp(at), Duration.from_sec(found.time))
