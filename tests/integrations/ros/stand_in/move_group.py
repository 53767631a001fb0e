"""Stands for MoveIt's move_group: it reads its parameters, speaks its action, and plans straight.

A goal of joint constraints goes to the controller that the parameters name, as MoveIt's would.
"""

# pyright: reportMissingImports=false

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import rospy
from actionlib import SimpleActionClient, SimpleActionServer
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

from aioduco.integrations.ros.ros1.message_classes import install

install()
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal  # noqa: E402
from moveit_msgs.msg import MoveGroupAction, MoveGroupResult, MoveItErrorCodes  # noqa: E402


class MoveGroup:
    """The action, and the controller to which plans go."""

    def __init__(self) -> None:
        semantic = ElementTree.fromstring(rospy.get_param("/robot_description_semantic"))
        self.groups = {each.get("name") for each in semantic.findall("group")}
        pipelines = rospy.get_param("~planning_pipelines")
        planner = pipelines[rospy.get_param("~default_planning_pipeline")]
        assert planner["planning_plugin"] == "ompl_interface/OMPLPlanner"
        assert self.groups & planner.keys()
        assert self.groups & rospy.get_param("/robot_description_kinematics").keys()
        self.limits = rospy.get_param("/robot_description_planning/joint_limits")
        (controller,) = rospy.get_param("~controller_list")
        self.names = controller["joints"]
        self.arm = SimpleActionClient(
            f"{controller['name']}/{controller['action_ns']}", FollowJointTrajectoryAction
        )
        self.server = SimpleActionServer("move_group", MoveGroupAction, self.move, auto_start=False)
        self.server.start()

    def move(self, asked: Any) -> None:
        request = asked.request
        result = MoveGroupResult()
        if request.group_name not in self.groups:
            result.error_code.val = MoveItErrorCodes.INVALID_GROUP_NAME
            self.server.set_aborted(result)
            return
        wanted = {
            each.joint_name: each.position for each in request.goal_constraints[0].joint_constraints
        }
        here = rospy.wait_for_message("joint_states", JointState, 60.0)
        start = dict(zip(here.name, here.position, strict=True))
        seconds = max(
            2.0 * abs(wanted[name] - start[name]) / self.limits[name]["max_velocity"]
            for name in self.names
        ) / (request.max_velocity_scaling_factor or 1.0)
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = self.names
        for places, time in ((start, 0.0), (wanted, max(seconds, 0.5))):
            point = JointTrajectoryPoint(positions=[places[name] for name in self.names])
            point.time_from_start = rospy.Duration.from_sec(time)
            goal.trajectory.points.append(point)
        self.arm.wait_for_server()
        self.arm.send_goal_and_wait(goal)
        good = self.arm.get_result().error_code == 0
        codes = MoveItErrorCodes
        result.error_code.val = codes.SUCCESS if good else codes.CONTROL_FAILED
        (self.server.set_succeeded if good else self.server.set_aborted)(result)


def main() -> None:
    rospy.init_node("move_group")
    MoveGroup()
    rospy.spin()
