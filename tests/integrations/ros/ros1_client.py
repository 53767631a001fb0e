"""A client of the driver, in a process of its own, written to ROS alone: a line of JSON per answer.

python ros1_client.py goal [COUNT] [DURATION] [FAR] [CANCEL_AFTER]
python ros1_client.py wrong          # ten goals that are to be refused
python ros1_client.py malformed      # sixty more, of which any part may be anything
python ros1_client.py tight          # two with tolerances that no arm keeps
python ros1_client.py states SECONDS BAG  # how many joint states come, and a bag of them
python ros1_client.py call SERVICE [ARGUMENTS AS JSON]
python ros1_client.py calls [[SERVICE, ARGUMENTS], …] AS JSON
python ros1_client.py guide          # hand guiding, speeds of the tool, and what is told by names
python ros1_client.py ready [JOINTS AS JSON]  # recover, and move there
python ros1_client.py press          # the button "next" of RViz
python ros1_client.py frame NAME     # until a transform to this frame comes
"""

from __future__ import annotations

import functools
import itertools
import json
import math
import os
import random
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import rosbag
import rospy
from actionlib import ActionClient, CommState, SimpleActionClient

from aioduco.integrations.ros.ros1.message_classes import install
from integrations.ros.client_parts import SERVICES, apart, say, smooth_way, spoiled

install()

import aioduco_msgs.msg  # noqa: E402
import aioduco_msgs.srv  # noqa: E402
from control_msgs.msg import (  # noqa: E402
    FollowJointTrajectoryAction,
    FollowJointTrajectoryGoal,
    JointTolerance,
    JointTrajectoryControllerState,
)
from geometry_msgs.msg import Twist  # noqa: E402
from sensor_msgs.msg import JointState, Joy  # noqa: E402
from std_msgs.msg import Bool, String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402
from trajectory_msgs.msg import JointTrajectoryPoint  # noqa: E402

PREFIX = os.environ.get("PREFIX", "")
NAMES = [f"{PREFIX}joint_{number}" for number in range(1, 7)]
NODE = os.environ.get("NODE", "/duco")


def here(patience: float = 60.0) -> list[float]:
    return list(rospy.wait_for_message("joint_states", JointState, patience).position)


def goal(
    count: int = 200, duration: float = 2.0, far: float = 0.3, start: list[float] | None = None
) -> Any:
    """A goal from where the arm is, joints 1 and 6 to another place, smoothly."""
    start = start or here()
    made = FollowJointTrajectoryGoal()
    made.trajectory.joint_names = list(NAMES)
    for place, seconds in smooth_way(start, count, duration, far):
        at = rospy.Duration.from_sec(seconds)
        made.trajectory.points.append(JointTrajectoryPoint(positions=place, time_from_start=at))
    return made


def client(kind: Any = SimpleActionClient) -> Any:
    name = f"{PREFIX}joint_trajectory_controller/follow_joint_trajectory"
    made = kind(name, FollowJointTrajectoryAction)
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
    try:
        place = here(5.0)
    except rospy.ROSException:  # the driver has ended
        place = list(asked.trajectory.points[0].positions)
    say(
        state=action.get_state(),
        code=found.error_code,
        text=found.error_string,
        feedback=len(seen),
        span=seen[-1][0] - seen[0][0] if seen else 0.0,
        error=apart(place, end),
        went=abs(place[0] - asked.trajectory.points[0].positions[0]),
    )


def wrong_goals() -> dict[str, Any]:
    """Ten goals, each with one thing wrong."""
    start, old = here(), rospy.Time.now() - rospy.Duration(30)
    return spoiled(lambda: goal(20, 2.0, start=start), rospy.Duration.from_sec, old)


def tight_goals() -> dict[str, Any]:
    """Two that are right, but for tolerances that no arm keeps."""
    path, end = goal(50, 1.0, -0.1), goal(50, 1.0, -0.1)
    path.path_tolerance = [JointTolerance(name=name, position=1e-8) for name in NAMES]
    end.goal_tolerance = [JointTolerance(name=name, position=1e-14) for name in NAMES]
    end.goal_time_tolerance = rospy.Duration(0.2)
    return {"path": path, "goal": end}


def malformed_goals(count: int) -> dict[str, Any]:
    """Goals of which any part may be anything; each has at least one thing wrong."""
    chance = random.Random(count)
    odd = [math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 7.0, 0.0]

    def row() -> list[float]:
        return [chance.choice(odd) for _ in range(chance.choice([0, 1, 5, 6, 7, 300]))]

    def duration() -> Any:
        return rospy.Duration(chance.choice([-(2**31), -1, 0, 0, 1, 2**31 - 1]))

    start, made = here(), {}
    for number in range(count):
        asked = goal(chance.choice([2, 3, 20]), 2.0, start=start)
        points = asked.trajectory.points
        asked.trajectory.joint_names = chance.choice(
            [NAMES, NAMES, NAMES[::-1], [], [""] * 6, ["\x00", "é" * 40], NAMES * 3]
        )
        for _ in range(chance.randint(0, 2)):
            point = chance.choice(points)
            setattr(point, chance.choice(["velocities", "accelerations", "effort"]), row())
            point.time_from_start = duration()
        chance.choice(points).positions = [*row(), math.nan]
        for tolerances in (asked.path_tolerance, asked.goal_tolerance):
            for _ in range(chance.randint(0, 2)):
                name = chance.choice([*NAMES, "elbow"])
                tolerances.append(JointTolerance(name, *(chance.choice(odd) for _ in range(3))))
        asked.goal_time_tolerance = duration()
        made[str(number)] = asked
    return made


def ended(action: Any, asked: Any) -> Any:
    """The handle of a goal that has ended.

    On a machine that is busy enough `SimpleActionClient` misses an early end: it begins to track a
    goal after it has sent it.
    """
    done = threading.Event()

    def look(handle: Any) -> None:
        if handle.get_comm_state() == CommState.DONE:
            done.set()

    handle = action.send_goal(asked, look)
    if not done.wait(60.0):
        raise SystemExit("no result")
    return handle


def run_wrong(kind: str) -> None:
    action = client(ActionClient)
    goals: dict[str, Callable[[], dict[str, Any]]] = {
        "wrong": wrong_goals,
        "tight": tight_goals,
        "malformed": functools.partial(malformed_goals, 60),
    }
    for name, asked in goals[kind]().items():
        if kind == "tight":
            asked.trajectory.points[0].positions = here()
        before, sent = here(), time.monotonic()
        handle = ended(action, asked)
        took = time.monotonic() - sent
        code = handle.get_result().error_code
        moved = apart(before, here())
        say(name=name, state=handle.get_terminal_state(), code=code, moved=moved, took=took)
        if kind == "tight":
            rospy.ServiceProxy(f"{NODE}/recover", Trigger)()


class Subscribed(rospy.SubscribeListener):  # type: ignore[misc]  # ROS 1 has no types
    """Notes when a topic has its subscriber."""

    def __init__(self) -> None:
        super().__init__()
        self.there = threading.Event()

    def peer_subscribe(self, topic_name: str, topic_publish: Any, peer_publish: Any) -> None:
        del topic_name, topic_publish, peer_publish
        self.there.set()


def count_states(seconds: float, path: str) -> None:
    """Count joint states, put them into a bag, and play that on a topic of its own."""
    came: list[tuple[float, Any]] = []
    enough, played_all = threading.Event(), threading.Event()
    here()

    def note(message: Any) -> None:
        came.append((time.monotonic(), message))
        if len(came) == 1:
            say(counting=True)
        if came[-1][0] > came[0][0] + seconds:
            enough.set()

    subscriber = rospy.Subscriber("joint_states", JointState, note)
    enough.wait(seconds + 60.0)
    say(counted=True)
    subscriber.unregister()
    recorded = list(came)
    with rosbag.Bag(path, "w") as bag:
        for _, message in recorded:
            bag.write("joint_states", message, message.header.stamp)
    played: list[Any] = []

    def play(message: Any) -> None:
        played.append(message)
        if len(played) == len(recorded):
            played_all.set()

    listener = Subscribed()
    publisher = rospy.Publisher(
        "played", JointState, queue_size=len(recorded), subscriber_listener=listener
    )
    rospy.Subscriber("played", JointState, play)
    listener.there.wait(60.0)
    with rosbag.Bag(path) as bag:
        for _, message, _ in bag.read_messages():
            publisher.publish(message)
    played_all.wait(60.0)
    stamps = [message.header.stamp.to_sec() for _, message in recorded]
    kept = [at for at, _ in recorded if at - recorded[0][0] <= seconds]
    say(
        rate=(len(kept) - 1) / (kept[-1] - kept[0]),
        rising=all(a < b for a, b in itertools.pairwise(stamps)),
        recorded=len(recorded),
        played=sum(a.position == b.position for (_, a), b in zip(recorded, played, strict=False)),
    )


def call(name: str, given: dict[str, Any]) -> None:
    whole = f"/{PREFIX}{name}" if "/" in name else f"{NODE}/{name}"
    kind = getattr(aioduco_msgs.srv, SERVICES[name]) if name in SERVICES else Trigger
    rospy.wait_for_service(whole, 60.0)
    reply = rospy.ServiceProxy(whole, kind)(**given)
    say(success=reply.success, message=reply.message)


def guide() -> None:
    """Ask for hand guiding, then move the tool by speeds; tell what the topics said meanwhile."""
    newest: dict[str, Any] = {}
    for topic, kind in (
        ("io_and_status_controller/robot_mode", String),
        ("io_and_status_controller/safety_mode", String),
        ("tool_data", aioduco_msgs.msg.ToolData),
        ("joint_trajectory_controller/state", JointTrajectoryControllerState),
    ):
        rospy.Subscriber(PREFIX + topic, kind, functools.partial(newest.__setitem__, topic))
    guided = rospy.Publisher(
        f"{PREFIX}freedrive_mode_controller/enable_freedrive_mode", Bool, queue_size=1
    )
    twist = rospy.Publisher(f"{PREFIX}twist_controller/command", Twist, queue_size=1)
    rate, asked = rospy.Rate(50), Twist()
    asked.linear.z = 0.05
    start = here()
    for _ in range(50):
        guided.publish(True)
        rate.sleep()
    guided.publish(False)
    sent = 0
    while apart(here(), start) < 0.03 or len(newest) < 4:
        # A busy computer may starve the stream; the driver then follows after a silence alone.
        if sent % 150 < 100:
            twist.publish(asked)
        sent += 1
        rate.sleep()
    say(
        robot=newest["io_and_status_controller/robot_mode"].data,
        safety=newest["io_and_status_controller/safety_mode"].data,
        offset=len(newest["tool_data"].offset),
        names=newest["joint_trajectory_controller/state"].joint_names,
    )


def press() -> None:
    """Press "next" of RvizVisualToolsGui once somebody listens."""
    panel = rospy.Publisher("/rviz_visual_tools_gui", Joy, queue_size=1)
    rate = rospy.Rate(20)
    while not panel.get_num_connections():
        rate.sleep()
    panel.publish(Joy(buttons=[0, 1, 0, 0, 0]))
    rate.sleep()
    say(pressed=True)


def await_frame(name: str) -> None:
    """Wait until a frame is placed, by the driver or by robot_state_publisher."""
    found = threading.Event()

    def look(message: Any) -> None:
        if any(each.child_frame_id == name for each in message.transforms):
            found.set()

    for topic in ("/tf", "/tf_static"):
        rospy.Subscriber(topic, TFMessage, look)
    say(found=found.wait(120.0))


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
    elif what == "ready":
        call("recover", {})
        call("movej", {"joints": json.loads(rest[0]), "v": 2.0, "a": 10.0})
    elif what == "calls":
        for name, given in json.loads(rest[0]):
            call(name, given)
    elif what == "guide":
        guide()
    elif what == "press":
        press()
    elif what == "frame":
        await_frame(rest[0])
    else:
        run_wrong(what)
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    main()
