"""A client of the driver, in a process of its own, written to ROS alone: a line of JSON per answer.

python ros2_client.py goal [COUNT] [DURATION] [FAR] [CANCEL_AFTER]
python ros2_client.py wrong          # ten goals that are to be refused
python ros2_client.py tight          # two whose tolerances no arm keeps
python ros2_client.py states SECONDS # how many joint states come, and what else does
python ros2_client.py late           # one that no arm reaches by its own times
python ros2_client.py replace        # two, the second from where the arm is on its way
python ros2_client.py speeds         # two with tolerances of the speed: wide, and too tight
python ros2_client.py stream HOW     # lead the arm by the topic: trajectory, command
python ros2_client.py move           # and by set-points that move at once
python ros2_client.py call SERVICE [ARGUMENTS AS JSON]
python ros2_client.py calls [[SERVICE, ARGUMENTS], …] AS JSON
python ros2_client.py guide          # hand guiding, speeds of the tool, and what is told by names
python ros2_client.py lifecycle TRANSITION …  # by their labels, or their numbers
python ros2_client.py set NAME VALUE AS JSON
"""

from __future__ import annotations

import functools
import itertools
import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

import aioduco_msgs.srv
import rclpy
from aioduco_msgs.msg import IOState, RobotState, ToolData
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance, JointTrajectoryControllerState
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from integrations.ros.client_parts import SERVICES, apart, say, smooth_way, spoiled

PREFIX = os.environ.get("PREFIX", "")
NAMES = [f"{PREFIX}joint_{number}" for number in range(1, 7)]
NODE = os.environ.get("NODE", "/duco")
CONTROLLER = f"{PREFIX}joint_trajectory_controller"
PATIENT = 90.0


class Peer:
    """A node, and what it waits for."""

    def __init__(self) -> None:
        self.node = rclpy.create_node(f"client_{os.getpid()}")
        self._joints: Any = None
        #: where the arm was by the last state that came
        self.place: list[float] = []
        # Reliable, as rclpy asks by itself; `states` asks for sensor data.
        self.node.create_subscription(JointState, "joint_states", self._note, 5)

    def _note(self, message: Any) -> None:
        if list(message.name) == NAMES:  # of two arms there may be two kinds
            self._joints = message
            self.place = list(message.position)

    def until(self, condition: Callable[[], object], patience: float = PATIENT) -> bool:
        end = time.monotonic() + patience
        while not condition():
            rclpy.spin_once(self.node, timeout_sec=0.05)
            if time.monotonic() > end:
                return False
        return True

    def result(self, future: Any) -> Any:
        if not self.until(future.done):
            raise SystemExit("no answer")
        return future.result()

    def here(self, patience: float = PATIENT) -> list[float]:
        """Where the arm is, by a state that comes from now on; the last one if the driver ended."""
        self._joints = None
        if not self.until(lambda: self._joints, patience) and patience == PATIENT:
            raise SystemExit("no joint states")
        return self.place

    def ask(self, kind: Any, name: str, request: Any) -> Any:
        service = self.node.create_client(kind, name)
        if not self.until(service.service_is_ready):
            raise SystemExit(f"no service {name}")
        return self.result(service.call_async(request))

    def action(self) -> Any:
        name = f"{CONTROLLER}/follow_joint_trajectory"
        made = ActionClient(self.node, FollowJointTrajectory, name)
        if not self.until(made.server_is_ready):
            raise SystemExit("no action server")
        return made

    def goal(self, count: int = 200, duration: float = 2.0, far: float = 0.3) -> Any:
        """A goal from where the arm is, joints 1 and 6 to another place, smoothly."""
        start = self.here()
        made = FollowJointTrajectory.Goal()
        made.trajectory.joint_names = list(NAMES)
        for place, seconds in smooth_way(start, count, duration, far):
            point = JointTrajectoryPoint(positions=place)
            point.time_from_start = Duration(seconds=seconds).to_msg()
            made.trajectory.points.append(point)
        return made


def run_goal(peer: Peer, count: int, duration: float, far: float, cancel_after: float) -> None:
    action, asked = peer.action(), peer.goal(count, duration, far)
    seen: list[tuple[float, float]] = []

    def feedback(message: Any) -> None:
        at = message.feedback.desired.time_from_start
        seen.append((time.monotonic(), at.sec + at.nanosec * 1e-9))

    handle = peer.result(action.send_goal_async(asked, feedback_callback=feedback))
    if not handle.accepted:
        say(accepted=False)
        return
    ended = handle.get_result_async()
    peer.until(lambda: ended.done() or (seen and seen[-1][1] > (cancel_after or 0.2)))
    if not ended.done():
        say(moving=True)
    if cancel_after:
        peer.result(handle.cancel_goal_async())
    found = peer.result(ended)
    end, here = asked.trajectory.points[-1].positions, peer.here(1.0)
    say(
        status=found.status,
        code=found.result.error_code,
        text=found.result.error_string,
        feedback=len(seen),
        span=seen[-1][0] - seen[0][0] if seen else 0.0,
        error=apart(here, end),
        went=abs(here[0] - asked.trajectory.points[0].positions[0]),
    )


def wrong_goals(peer: Peer) -> dict[str, Any]:
    """Ten goals, each with one thing wrong."""
    old = peer.node.get_clock().now() - Duration(seconds=30)
    return spoiled(
        lambda: peer.goal(20, 2.0), lambda at: Duration(seconds=at).to_msg(), old.to_msg()
    )


def tight_goals(peer: Peer) -> dict[str, Any]:
    """Two that are right, but for tolerances that no arm keeps."""
    path, end = peer.goal(50, 1.0, -0.1), peer.goal(50, 1.0, -0.1)
    path.path_tolerance = [JointTolerance(name=name, position=1e-8) for name in NAMES]
    end.goal_tolerance = [JointTolerance(name=name, position=1e-14) for name in NAMES]
    end.goal_time_tolerance = Duration(seconds=0.2).to_msg()
    return {"path": path, "goal": end}


def speed_goals(peer: Peer) -> dict[str, Any]:
    """Two with tolerances of the speed: as clients of other drivers send them, and too tight."""
    wide, tight = peer.goal(50, 1.0, -0.1), peer.goal(50, 1.0, -0.1)
    wide.path_tolerance = [JointTolerance(name=name, velocity=2.0) for name in NAMES]
    wide.goal_tolerance = [JointTolerance(name=n, position=0.02, velocity=0.02) for n in NAMES]
    tight.path_tolerance = [JointTolerance(name=name, velocity=1e-9) for name in NAMES]
    back = [point.positions for point in reversed(wide.trajectory.points)]
    for point, place in zip(tight.trajectory.points, back, strict=True):
        point.positions = place
    return {"wide": wide, "tight": tight}


def late_goals(peer: Peer) -> dict[str, Any]:
    """One that is right, but leaves no time for anything but the motion."""
    asked = peer.goal(50, 0.5, -0.1)
    asked.goal_time_tolerance = Duration(nanoseconds=1000).to_msg()
    return {"late": asked}


def replace_goal(peer: Peer) -> None:
    """Send a goal, and on its way another that begins where the arm is, and goes elsewhere."""
    action, progress = peer.action(), [0.0]
    first = peer.goal(200, 8.0, 1.2)

    def feedback(message: Any) -> None:
        progress[0] = message.feedback.desired.time_from_start.sec

    old = peer.result(action.send_goal_async(first, feedback_callback=feedback))
    peer.until(lambda: progress[0] >= 2)
    second = peer.goal(100, 3.0, -0.3)
    new = peer.result(action.send_goal_async(second))
    found, before = (peer.result(each.get_result_async()) for each in (new, old))
    end = second.trajectory.points[-1].positions
    say(
        status=found.status,
        text=found.result.error_string,
        before=before.status,
        error=apart(peer.here(), end),
    )


def run_wrong(peer: Peer, kind: str) -> None:
    action = peer.action()
    kinds = {"wrong": wrong_goals, "tight": tight_goals, "late": late_goals, "speeds": speed_goals}
    for name, asked in kinds[kind](peer).items():
        before = peer.here()
        if kind in ("tight", "speeds"):
            asked.trajectory.points[0].positions = before
        handle = peer.result(action.send_goal_async(asked))
        found = peer.result(handle.get_result_async())
        moved = apart(before, peer.here())
        say(
            name=name,
            status=found.status,
            code=found.result.error_code,
            text=found.result.error_string,
            moved=moved,
        )
        if kind == "tight":
            peer.ask(Trigger, f"{NODE}/recover", Trigger.Request())


def count_states(peer: Peer, seconds: float) -> None:
    """Count joint states for a time, and see that the other topics come at all."""
    came: list[tuple[float, Any]] = []
    others: dict[str, Any] = {}
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

    def keep(topic: str) -> Callable[[Any], None]:
        return lambda message: others.__setitem__(topic, message)

    for topic, kind, quality in (
        ("/tf", TFMessage, 100),
        (f"{PREFIX}robot_state", RobotState, latched),
        (f"{PREFIX}io_states", IOState, latched),
        (f"{PREFIX}speed_scaling", Float64, latched),
        ("/diagnostics", DiagnosticArray, 10),
    ):
        peer.node.create_subscription(kind, topic, keep(topic), quality)
    peer.until(lambda: len(others) == 5)
    frames = [each.child_frame_id for each in others["/tf"].transforms]

    def note(message: Any) -> None:
        if list(message.name) == NAMES:
            came.append((time.monotonic(), message))

    peer.node.create_subscription(JointState, "joint_states", note, qos_profile_sensor_data)
    peer.until(lambda: came)
    say(counting=True)
    peer.until(lambda: came[-1][0] > came[0][0] + seconds, seconds + PATIENT)
    stamps = [message.header.stamp.sec + message.header.stamp.nanosec * 1e-9 for _, message in came]
    say(
        rate=(len(came) - 1) / (stamps[-1] - stamps[0]),
        rising=all(a < b for a, b in itertools.pairwise(stamps)),
        names=list(came[0][1].name),
        frames=frames,
        bases=sorted(
            {others[f"{PREFIX}{name}"].header.frame_id for name in ("robot_state", "io_states")}
        ),
        ready=others[f"{PREFIX}robot_state"].enabled,
        outputs=len(others[f"{PREFIX}io_states"].digital_outputs),
        speed=others[f"{PREFIX}speed_scaling"].data,
        diagnosis=others["/diagnostics"].status[0].message,
    )


def stream(peer: Peer, how: str) -> None:
    """Lead joint 1 by 0.2 rad, by set-points 50 times a second."""
    start = peer.here()
    if how == "trajectory":
        publisher = peer.node.create_publisher(JointTrajectory, f"{CONTROLLER}/joint_trajectory", 5)
    else:
        publisher = peer.node.create_publisher(JointState, f"{PREFIX}joint_commands", 1)
    peer.until(publisher.get_subscription_count)
    sent, lead = 0, start[0]

    def send() -> None:
        nonlocal sent, lead
        sent += 1
        here = peer.place[0]
        if abs(lead - here) > 0.03:
            lead = here  # a busy machine ended the stream: the next one begins where the arm is
        elif sent > 50:  # the first second stands, for the driver's stream to open
            lead = min(lead + 0.001, start[0] + 0.2)
        place = [lead, *start[1:]]
        if how == "trajectory":
            point = JointTrajectoryPoint(positions=place)
            point.time_from_start = Duration(seconds=0.02).to_msg()
            publisher.publish(JointTrajectory(joint_names=NAMES, points=[point]))
        else:
            publisher.publish(JointState(name=NAMES, position=place))

    peer.node.create_timer(0.02, send)
    arrived = peer.until(lambda: abs(peer.here()[0] - start[0] - 0.2) < 2e-3)
    say(arrived=arrived, off=abs(peer.here()[0] - start[0] - 0.2))


def move(peer: Peer) -> None:
    """Set-points of joint 1 that move at once, at 0.3 rad/s, until the arm has followed."""
    start = peer.here()
    publisher = peer.node.create_publisher(JointState, f"{PREFIX}joint_commands", 1)
    peer.until(publisher.get_subscription_count)
    begun, farthest = time.monotonic(), start[0]

    def send() -> None:
        nonlocal farthest
        phase = (time.monotonic() - begun) % 6.0
        lead = start[0] + 0.3 * min(phase, 6.0 - phase)
        publisher.publish(JointState(name=NAMES, position=[lead, *start[1:]]))
        farthest = max(farthest, peer.place[0])

    peer.node.create_timer(0.02, send)
    peer.until(lambda: farthest - start[0] > 0.5)
    say(moved=farthest - start[0])


def guide(peer: Peer) -> None:
    """Ask for hand guiding, then move the tool by speeds; tell what the topics said meanwhile."""
    newest: dict[str, Any] = {}
    for topic, kind in (
        ("io_and_status_controller/robot_mode", String),
        ("io_and_status_controller/safety_mode", String),
        ("tool_data", ToolData),
        ("joint_trajectory_controller/controller_state", JointTrajectoryControllerState),
    ):
        keep = functools.partial(newest.__setitem__, topic)
        peer.node.create_subscription(kind, PREFIX + topic, keep, 5)
    guided = peer.node.create_publisher(
        Bool, f"{PREFIX}freedrive_mode_controller/enable_freedrive_mode", 5
    )
    twist = peer.node.create_publisher(Twist, f"{PREFIX}twist_controller/command", 1)
    start, asked, sent = peer.here(), Twist(), 0
    asked.linear.z = 0.05

    def send() -> None:
        nonlocal sent
        sent += 1
        if sent <= 50:
            guided.publish(Bool(data=sent < 50))
        elif sent % 150 < 100:
            # A busy computer may starve the stream; the driver then follows after a silence alone.
            twist.publish(asked)

    def gone() -> bool:
        return apart(peer.place, start) > 0.03

    peer.until(twist.get_subscription_count)
    peer.node.create_timer(0.02, send)
    peer.until(lambda: gone() and len(newest) == 4)
    say(
        robot=newest["io_and_status_controller/robot_mode"].data,
        safety=newest["io_and_status_controller/safety_mode"].data,
        offset=len(newest["tool_data"].offset),
        names=list(newest["joint_trajectory_controller/controller_state"].joint_names),
    )


def call(peer: Peer, name: str, given: dict[str, Any]) -> None:
    whole = f"/{PREFIX}{name}" if "/" in name else f"{NODE}/{name}"
    kind = getattr(aioduco_msgs.srv, SERVICES[name]) if name in SERVICES else Trigger
    reply = peer.ask(kind, whole, kind.Request(**given))
    say(success=reply.success, message=reply.message)


def change(peer: Peer, transitions: list[str]) -> None:
    """Make transitions, and say what each led to."""
    for label in transitions:
        named = {"id": int(label)} if label.isdigit() else {"label": label}
        request = ChangeState.Request(transition=Transition(**named))
        done = peer.ask(ChangeState, f"{NODE}/change_state", request).success
        state = peer.ask(GetState, f"{NODE}/get_state", GetState.Request()).current_state.label
        say(done=done, state=state)


def set_parameter(peer: Peer, name: str, value: Any) -> None:
    request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    found = peer.ask(SetParameters, f"{NODE}/set_parameters", request).results[0]
    say(done=found.successful, reason=found.reason)


def main() -> None:
    what, *rest = sys.argv[1:]
    rclpy.init()
    peer = Peer()
    if what == "goal":
        numbers = [float(each) for each in rest] + [200.0, 2.0, 0.3, 0.0][len(rest) :]
        run_goal(peer, int(numbers[0]), *numbers[1:])
    elif what == "states":
        count_states(peer, float(rest[0]))
    elif what == "stream":
        stream(peer, rest[0])
    elif what == "calls":
        for name, given in json.loads(rest[0]):
            call(peer, name, given)
    elif what == "guide":
        guide(peer)
    elif what == "move":
        move(peer)
    elif what == "replace":
        replace_goal(peer)
    elif what == "call":
        call(peer, rest[0], json.loads(rest[1]) if rest[1:] else {})
    elif what == "lifecycle":
        change(peer, rest)
    elif what == "set":
        set_parameter(peer, rest[0], json.loads(rest[1]))
    else:
        run_wrong(peer, what)
    peer.node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
