"""Move the arm by MoveIt 1, one step at each press of "next" in RViz.

    aioduco export ros1 --moveit --group duco_gcr5 --tip link_6 -o ros
    roslaunch gcr5_910_moveit_config moveit_planning_execution.launch robot_ip:=192.168.1.10
    python ros1_moveit_demo.py duco_gcr5

What the vendor's `duco_demo` does: bring-up by a service, then each goal by MoveIt's action, when
"next" is pressed in the RvizVisualToolsGui panel. It needs rospy and moveit_msgs. Keep clear of the
arm.
"""

# pyright: reportMissingImports=false
# ROS 1 and its messages come with the system, and have no types.

from __future__ import annotations

import sys
import threading
from typing import Any

import rospy
from actionlib import SimpleActionClient
from moveit_msgs.msg import Constraints, JointConstraint, MoveGroupAction, MoveGroupGoal
from sensor_msgs.msg import Joy
from std_srvs.srv import Trigger

STEPS = {
    "up": (0.0, 0.0, 1.57, 0.0, -1.57, 0.0),
    "left": (0.7, 0.2, 1.4, 0.0, -1.57, 0.0),
    "right": (-0.7, 0.2, 1.4, 0.0, -1.57, 0.0),
}
NEXT = 1  # the panel's button


def goal_of(group: str, joints: tuple[float, ...]) -> Any:
    """A goal of MoveIt: these joints, at a fifth of the arm's speed."""
    goal = MoveGroupGoal()
    goal.request.group_name = group
    goal.request.num_planning_attempts = 5
    goal.request.allowed_planning_time = 5.0
    goal.request.max_velocity_scaling_factor = 0.2
    goal.request.max_acceleration_scaling_factor = 0.2
    wanted = Constraints()
    for number, angle in enumerate(joints, 1):
        wanted.joint_constraints.append(
            JointConstraint(
                joint_name=f"joint_{number}",
                position=angle,
                tolerance_above=0.001,
                tolerance_below=0.001,
                weight=1.0,
            )
        )
    goal.request.goal_constraints = [wanted]
    return goal


def main(group: str) -> None:
    """Bring the arm up, and move it at each press."""
    rospy.init_node("moveit_demo", anonymous=True)
    pressed = threading.Event()

    def press(message: Joy) -> None:
        if len(message.buttons) > NEXT and message.buttons[NEXT]:
            pressed.set()

    rospy.Subscriber("/rviz_visual_tools_gui", Joy, press)
    rospy.wait_for_service("/duco/bring_up", 60.0)
    ready = rospy.ServiceProxy("/duco/bring_up", Trigger)()
    print("bring-up:", ready.message)
    if not ready.success:
        sys.exit(1)
    arm = SimpleActionClient("move_group", MoveGroupAction)
    if not arm.wait_for_server(rospy.Duration(60.0)):
        sys.exit("move_group's action is not there")
    for name, joints in STEPS.items():
        print(f"press next: {name}", flush=True)
        while not pressed.wait(0.2):
            if rospy.is_shutdown():
                return
        pressed.clear()
        arm.send_goal_and_wait(goal_of(group, joints))
        result = arm.get_result()
        if result is None or result.error_code.val != 1:
            sys.exit(f"MoveIt did not move the arm: {result}")
        print(f"at {name}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1] if sys.argv[1:] else "manipulator")
