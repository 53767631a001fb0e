"""A client of the driver, in a process of its own, written to ROS alone: a line of JSON per answer.

python ros1_client.py goal [COUNT] [DURATION] [FAR] [CANCEL_AFTER]
python ros1_client.py wrong          # ten goals that are to be refused
python ros1_client.py states SECONDS BAG  # how many joint states come, and a bag of them
python ros1_client.py call SERVICE [ARGUMENTS AS JSON]
"""

from __future__ import annotations

import itertools
import json
import math
import os
import sys
import threading
import time
from typing import Any

import rosbag
import rospy
from actionlib import SimpleActionClient

from aioduco.integrations.ros.ros1.message_classes import install

install()

import aioduco_msgs.srv  # noqa: E402
from control_msgs.msg import (  # noqa: E402
    FollowJointTrajectoryAction,
    FollowJointTrajectoryGoal,
    JointTolerance,
)
from sensor_msgs.msg import JointState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from trajectory_msgs.msg import JointTrajectoryPoint  # noqa: E402

PREFIX = os.environ.get("PREFIX", "")
NAMES = [f"{PREFIX}joint_{number}" for number in range(1, 7)]
NODE = os.environ.get("NODE", "/duco")


def say(**found: Any) -> None:
    sys.stdout.write(json.dumps(found) + "\n")
    sys.stdout.flush()


def here() -> list[float]:
    return list(rospy.wait_for_message("joint_states", JointState, 30.0).position)


def goal(count: int = 200, duration: float = 2.0, far: float = 0.3) -> Any:
    """A goal from where the arm is, joints 1 and 6 to another place, smoothly."""
    start = here()
    made = FollowJointTrajectoryGoal()
    made.trajectory.joint_names = list(NAMES)
    for number in range(count):
        share = number / (count - 1)
        way = far * share * share * (3.0 - 2.0 * share)
        place = [start[0] + way, *start[1:5], start[5] + way]
        at = rospy.Duration.from_sec(share * duration)
        made.trajectory.points.append(JointTrajectoryPoint(positions=place, time_from_start=at))
    return made


def client() -> Any:
    made = SimpleActionClient(
        f"{PREFIX}joint_trajectory_controller/follow_joint_trajectory", FollowJointTrajectoryAction
    )
    if not made.wait_for_server(rospy.Duration(60.0)):
        raise SystemExit("no action server")
    return made


def run_goal(count: int, duration: float, far: float, cancel_after: float) -> None:
    action, asked = client(), goal(count, duration, far)
    seen: list[tuple[float, float]] = []
    moving = threading.Event()

    def feedback(message: Any) -> None:
        seen.append((time.monotonic(), message.desired.time_from_start.to_sec()))
        if seen[-1][1] > (cancel_after or 0.2) and not moving.is_set():
            moving.set()
            say(moving=True)

    action.send_goal(asked, feedback_cb=feedback)
    if cancel_after:
        moving.wait(60.0)
        action.cancel_goal()
    if not action.wait_for_result(rospy.Duration(90.0)):
        say(error="no result")
        return
    found = action.get_result()
    end = asked.trajectory.points[-1].positions
    say(
        state=action.get_state(),
        code=found.error_code,
        text=found.error_string,
        feedback=len(seen),
        span=seen[-1][0] - seen[0][0] if seen else 0.0,
        error=max(abs(a - b) for a, b in zip(here(), end, strict=True)),
        went=abs(here()[0] - asked.trajectory.points[0].positions[0]),
    )


def wrong_goals() -> dict[str, Any]:
    """Ten goals, each with one thing wrong."""
    made = {
        name: goal(20, 2.0)
        for name in (
            "partial",
            "name",
            "nan",
            "times",
            "negative",
            "empty",
            "lengths",
            "limits",
            "elsewhere",
            "old",
        )
    }
    made["partial"].trajectory.joint_names.pop()
    made["name"].trajectory.joint_names[0] = "elbow"
    made["nan"].trajectory.points[3].positions = [math.nan] * 6
    made["times"].trajectory.points[3].time_from_start = rospy.Duration(0.01)
    made["negative"].trajectory.points[0].time_from_start = rospy.Duration(-1)
    made["empty"].trajectory.points = []
    made["lengths"].trajectory.points[3].velocities = [0.0] * 5
    made["limits"].trajectory.points[-1].positions = [7.0] * 6
    for point in made["elsewhere"].trajectory.points:
        point.positions = [q + 0.5 for q in point.positions]
    made["old"].trajectory.header.stamp = rospy.Time.now() - rospy.Duration(30)
    return made


def tight_goals() -> dict[str, Any]:
    """Two that are right, but for tolerances that no arm keeps."""
    path, end = goal(50, 1.0, -0.1), goal(50, 1.0, -0.1)
    path.path_tolerance = [JointTolerance(name=name, position=1e-8) for name in NAMES]
    end.goal_tolerance = [JointTolerance(name=name, position=1e-14) for name in NAMES]
    end.goal_time_tolerance = rospy.Duration(0.2)
    return {"path": path, "goal": end}


def run_wrong(kind: str) -> None:
    action = client()
    for name, asked in (wrong_goals() if kind == "wrong" else tight_goals()).items():
        if kind == "tight":
            asked.trajectory.points[0].positions = here()
        before = here()
        action.send_goal_and_wait(asked, rospy.Duration(60.0))
        found = action.get_result()
        moved = max(abs(a - b) for a, b in zip(before, here(), strict=True))
        say(name=name, state=action.get_state(), code=found.error_code, moved=moved)
        if kind == "tight":
            rospy.ServiceProxy(f"{NODE}/recover", Trigger)()


def count_states(seconds: float, path: str) -> None:
    """Count joint states, put them into a bag, and play that on a topic of its own."""
    came: list[tuple[float, Any]] = []
    here()
    subscriber = rospy.Subscriber(
        "joint_states", JointState, lambda message: came.append((time.monotonic(), message))
    )
    time.sleep(seconds + 1.0)
    subscriber.unregister()
    recorded = list(came)
    with rosbag.Bag(path, "w") as bag:
        for _, message in recorded:
            bag.write("joint_states", message, message.header.stamp)
    played: list[Any] = []
    publisher = rospy.Publisher("played", JointState, queue_size=len(recorded))
    rospy.Subscriber("played", JointState, played.append)
    while not publisher.get_num_connections():
        time.sleep(0.01)
    with rosbag.Bag(path) as bag:
        for _, message, _ in bag.read_messages():
            publisher.publish(message)
    until = time.monotonic() + 60.0
    while len(played) < len(recorded) and time.monotonic() < until:
        time.sleep(0.01)
    stamps = [message.header.stamp.to_sec() for _, message in recorded]
    kept = [at for at, _ in recorded if at - recorded[0][0] <= seconds]
    say(
        rate=(len(kept) - 1) / (kept[-1] - kept[0]),
        rising=all(a < b for a, b in itertools.pairwise(stamps)),
        recorded=len(recorded),
        played=sum(a.position == b.position for (_, a), b in zip(recorded, played, strict=False)),
    )


def call(name: str, given: dict[str, Any]) -> None:
    kinds = {
        "set_digital_output": "SetOutput",
        "set_tool_output": "SetOutput",
        "set_tool": "SetTool",
        "set_load": "SetLoad",
        "movej": "MoveJ",
        "movel": "MoveL",
    }
    kind = getattr(aioduco_msgs.srv, kinds[name]) if name in kinds else Trigger
    rospy.wait_for_service(f"{NODE}/{name}", 60.0)
    reply = rospy.ServiceProxy(f"{NODE}/{name}", kind)(**given)
    say(success=reply.success, message=reply.message)


def main() -> None:
    what, *rest = sys.argv[1:]
    rospy.init_node("client", anonymous=True, disable_signals=True)
    if what == "goal":
        rest = [each for each in rest if ":=" not in each]  # remappings
        numbers = [float(each) for each in rest] + [200.0, 2.0, 0.3, 0.0][len(rest) :]
        run_goal(int(numbers[0]), *numbers[1:])
    elif what == "states":
        count_states(float(rest[0]), rest[1])
    elif what == "call":
        call(rest[0], json.loads(rest[1]) if rest[1:] else {})
    else:
        run_wrong(what)
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    main()
