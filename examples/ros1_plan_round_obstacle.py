"""Plan a way round a board, and carry it out through the driver of ROS 1.

    aioduco ros1 --host 192.168.1.10      in another terminal, beside a ROS master
    python ros1_plan_round_obstacle.py

What the vendor's `duco_demo` does, as a client of ROS: bring-up by a service, the arm's joints by a
topic, the plan by `FollowJointTrajectory`. It needs rospy and `pip install 'aioduco[plan]'`. On a
real arm the board must stand there, or be taken out of the scene below.
"""

# pyright: reportMissingImports=false
# ROS 1 and its messages come with the system or are made at run time, and have no types.

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import rospy
from actionlib import SimpleActionClient
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

from aioduco import Joints
from aioduco.integrations.ros.ros1.message_classes import install
from aioduco.planning import Planner, Scene
from aioduco.sim.scene import Box

install()  # control_msgs, where it is not installed

from control_msgs.msg import (  # noqa: E402
    FollowJointTrajectoryAction,
    FollowJointTrajectoryGoal,
)

if TYPE_CHECKING:
    from aioduco.planning import Plan

BOARD = Box(at=(0.55, 0.0, 0.35), size=(0.5, 0.04, 0.7), name="board")
LEFT = Joints.deg(50, 0, 90, 0, -90, 0)
RIGHT = Joints.deg(-50, 0, 90, 0, -90, 0)


def joints() -> JointState:
    """Where the arm is."""
    return rospy.wait_for_message("joint_states", JointState, 60.0)


def goal_of(plan: Plan, names: list[str]) -> Any:
    """A plan as a goal of ROS."""
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = names
    way = plan.trajectory
    for number, time in enumerate(way.times):
        point = JointTrajectoryPoint(positions=list(way.positions[number]))
        if way.velocities is not None:
            point.velocities = list(way.velocities[number])
        if way.accelerations is not None:
            point.accelerations = list(way.accelerations[number])
        point.time_from_start = rospy.Duration.from_sec(time)
        goal.trajectory.points.append(point)
    return goal


def main() -> None:
    """Bring the arm up, and lead it to one side of the board and then to the other."""
    rospy.init_node("plan_round_obstacle", anonymous=True)
    rospy.wait_for_service("/duco/bring_up", 60.0)
    ready = rospy.ServiceProxy("/duco/bring_up", Trigger)()
    print("bring-up:", ready.message)
    if not ready.success:
        sys.exit(1)
    arm = SimpleActionClient(
        "joint_trajectory_controller/follow_joint_trajectory", FollowJointTrajectoryAction
    )
    if not arm.wait_for_server(rospy.Duration(60.0)):
        sys.exit("the driver's action is not there")

    with Planner(Scene("gcr5_910", [BOARD])) as planner:
        for side, there in (("left", LEFT), ("right", RIGHT)):
            here = joints()
            plan = planner.plan_blocking(here.position, there, v=0.8, a=2.0)
            print(f"planned: {plan.duration:.1f} s, {plan.clearance * 1e3:.0f} mm clear")
            arm.send_goal_and_wait(goal_of(plan, list(here.name)))
            result = arm.get_result()
            if result is None or result.error_code != result.SUCCESSFUL:
                sys.exit(f"the arm did not get there: {result}")
            print(f"on the {side} side")


if __name__ == "__main__":
    main()
