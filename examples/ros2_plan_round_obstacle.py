"""Plan a way round a board, and carry it out through the driver of ROS 2.

    aioduco ros2 --host 192.168.1.10      in another terminal
    python ros2_plan_round_obstacle.py

What the vendor's `duco_demo` does, as a client of ROS: bring-up by a service, the arm's joints by a
topic, the plan by `FollowJointTrajectory`. It needs rclpy and `pip install 'aioduco[plan]'`. On a
real arm the board must stand there, or be taken out of the scene below.
"""

# pyright: reportMissingImports=false
# ROS 2 comes with the system, and has no types.

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.wait_for_message import wait_for_message
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

from aioduco import Joints
from aioduco.planning import Planner, Scene
from aioduco.sim.scene import Box

if TYPE_CHECKING:
    from aioduco.planning import Plan

BOARD = Box(at=(0.55, 0.0, 0.35), size=(0.5, 0.04, 0.7), name="board")
LEFT = Joints.deg(50, 0, 90, 0, -90, 0)
RIGHT = Joints.deg(-50, 0, 90, 0, -90, 0)


def answer(node: Node, future: Any) -> Any:
    """What a request gives."""
    rclpy.spin_until_future_complete(node, future)
    return future.result()


def joints(node: Node) -> JointState:
    """Where the arm is."""
    there, state = wait_for_message(
        JointState, node, "joint_states", qos_profile=qos_profile_sensor_data, time_to_wait=60.0
    )
    if not there:
        sys.exit("the driver tells no joint states")
    return state


def goal_of(plan: Plan, names: list[str]) -> Any:
    """A plan as a goal of ROS."""
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = names
    way = plan.trajectory
    for number, time in enumerate(way.times):
        point = JointTrajectoryPoint(positions=list(way.positions[number]))
        if way.velocities is not None:
            point.velocities = list(way.velocities[number])
        if way.accelerations is not None:
            point.accelerations = list(way.accelerations[number])
        point.time_from_start = Duration(seconds=float(time)).to_msg()
        goal.trajectory.points.append(point)
    return goal


def main() -> None:
    """Bring the arm up, and lead it to one side of the board and then to the other."""
    rclpy.init()
    node = Node("plan_round_obstacle")
    bring_up = node.create_client(Trigger, "/duco/bring_up")
    if not bring_up.wait_for_service(timeout_sec=60.0):
        sys.exit("the driver is not there")
    ready = answer(node, bring_up.call_async(Trigger.Request()))
    print("bring-up:", ready.message)
    if not ready.success:
        sys.exit(1)
    arm = ActionClient(
        node, FollowJointTrajectory, "joint_trajectory_controller/follow_joint_trajectory"
    )
    if not arm.wait_for_server(timeout_sec=60.0):
        sys.exit("the driver's action is not there")

    with Planner(Scene("gcr5_910", [BOARD])) as planner:
        for side, there in (("left", LEFT), ("right", RIGHT)):
            here = joints(node)
            plan = planner.plan_blocking(here.position, there, v=0.8, a=2.0)
            print(f"planned: {plan.duration:.1f} s, {plan.clearance * 1e3:.0f} mm clear")
            handle = answer(node, arm.send_goal_async(goal_of(plan, list(here.name))))
            result = answer(node, handle.get_result_async()).result
            if result.error_code != result.SUCCESSFUL:
                sys.exit(f"the arm did not get there: {result}")
            print(f"on the {side} side")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
