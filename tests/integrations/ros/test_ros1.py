"""The driver under ROS 1 for real: master, node and client in processes of their own.

It runs where rospy is installed: `.ci/ros1` sets that up from nothing.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
from cli_runner import CliRunner
from ports import free_port

from aioduco import Joints
from aioduco.cli.app import app
from aioduco.integrations.ros.arm_node import NodeSettings
from aioduco.integrations.ros.arm_readings import ArmReading
from aioduco.integrations.ros.trajectory_server import GoalProgress
from aioduco.sim import Simulator
from aioduco.sim.scene import Box
from aioduco.testing import eventually

from .programs import START, WAVE, ur_services
from .ros1_graph import HERE, ROOT, Graph

pytestmark = [
    pytest.mark.ros1,
    pytest.mark.slow,  # .ci/ros1 runs them all
    pytest.mark.timeout(600),
    pytest.mark.skipif(
        importlib.util.find_spec("rospy") is None,
        reason="needs rospy of ROS 1, which .ci/ros1 sets up",
    ),
]

SUCCEEDED, PREEMPTED, ABORTED, REJECTED = 3, 2, 4, 5
#: what a name of ROS lacks
NAMED = str.maketrans("=:", "__")
#: s for what takes part of one: a net, for no machine is so busy
PATIENT = 60.0


def start_node(graph: Graph, sim: Any, *given: str) -> subprocess.Popen[str]:
    """A driver that forgives a busy machine."""
    program = (str(HERE.parents[1] / "patient.py"), str(HERE / "ros1_node.py"))
    # the controller's queue holds a tenth of a second, and this machine may be busy
    return graph.start_node(
        sim, "_through:=servoj", "_goal_time_tolerance:=60.0", *given, program=program
    )


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    with contextlib.ExitStack() as stack:
        yield Graph(tmp_path, stack)


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with Simulator(programs=WAVE) as sim:
        yield sim


@pytest.fixture
def node(graph: Graph, sim: Simulator) -> subprocess.Popen[str]:
    node = start_node(graph, sim, "_heartbeat:=10.0")
    graph.call("bring_up")
    graph.go_to_start()
    return node


def test_the_messages_have_the_released_checksum() -> None:
    code = (
        "from aioduco.integrations.ros.ros1.message_classes import install\n"
        "install()\n"
        "from control_msgs.msg import JointTolerance\n"
        "print(JointTolerance._md5sum)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    found = subprocess.check_output([sys.executable, "-c", code], env=environment, text=True)
    assert found == "f544fe9c16cf04547e135dd6063ff5be\n"


def test_a_trajectory_a_cancellation_and_wrong_goals(
    graph: Graph, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    found = graph.last("goal", "200", "2.0", "0.3")
    assert (found["state"], found["code"]) == (SUCCEEDED, 0), found
    assert found["error"] <= 0.0101
    # Of a share of the 20 a second that were asked for: the rest is the machine's.
    assert 0.3 * 20 <= found["feedback"] / found["span"] <= 25, found
    found = graph.last("goal", "200", "6.0", "0.9", "0.8")
    assert found["state"] == PREEMPTED, found
    assert 0.0 < found["went"] < 0.85
    assert not sim.moving
    replies = {each["name"]: each for each in graph.ask("wrong")}
    codes = dict.fromkeys(replies, -1) | {"partial": -2, "name": -2, "old": -3}
    assert len(replies) == 10
    assert {name: each["code"] for name, each in replies.items()} == codes
    assert all(each["state"] == REJECTED and each["moved"] < 1e-3 for each in replies.values())
    malformed = graph.ask("malformed")
    assert len(malformed) == 60
    refused = [each for each in malformed if each["state"] == REJECTED and each["code"] < 0]
    assert [each for each in malformed if each not in refused] == []
    assert [each for each in malformed if each["moved"] >= 1e-3] == []
    # An earlier result is lost in SimpleActionClient, which waits for it for ever.
    assert all(each["took"] >= 0.1 for each in [*replies.values(), *malformed])
    replies = {each["name"]: each for each in graph.ask("tight")}
    assert {name: each["code"] for name, each in replies.items()} == {"path": -4, "goal": -5}
    assert all(each["state"] == ABORTED for each in replies.values())
    graph.call("recover")
    found = graph.last("goal", "20", "1.0", "-0.1")
    assert found["state"] == SUCCEEDED, found


def test_services(graph: Graph, sim: Simulator, node: subprocess.Popen[str]) -> None:
    graph.call("set_digital_output", number=4, value=True)
    assert sim.get_digital_output(4)
    reply = graph.last("call", "set_digital_output", '{"number": 77, "value": true}')
    assert (reply["success"], "16" in reply["message"]) == (False, True)
    graph.call("set_load", mass=0.5, centre=[0, 0, 0.1])
    client = graph.moving_client("200", "20.0", "1.0")
    graph.call("stop")
    assert not sim.moving
    found = json.loads(client.communicate(timeout=PATIENT)[0].splitlines()[-1])
    assert (found["state"], found["code"]) == (ABORTED, -4)


def test_what_a_user_of_the_ur_driver_knows(
    graph: Graph, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    ur_services(lambda asked: graph.ask("calls", json.dumps(asked)), sim)
    graph.make_ready("/duco")
    found = graph.last("guide")
    assert (found["robot"], found["safety"], found["offset"]) == ("ENABLE", "RUN", 6)
    assert found["names"][0] == "joint_1"


@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("told", [signal.SIGINT, signal.SIGHUP])
def test_a_goal_has_its_result_when_the_driver_ends(
    graph: Graph, sim: Simulator, node: subprocess.Popen[str], told: signal.Signals
) -> None:
    client = graph.moving_client("200", "60.0", "2.0")
    node.send_signal(told)
    found = json.loads(client.communicate(timeout=PATIENT)[0].splitlines()[-1])
    assert found["state"] == PREEMPTED
    assert "the driver ends" in found["text"]
    assert not sim.moving


def test_a_motion_by_a_service_ends_with_the_driver(
    graph: Graph, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    there = {"joints": [3.0, *START[1:]], "v": 0.03, "a": 1.0}  # which takes more than a minute
    client = graph.client("call", "movej", json.dumps(there))
    eventually(lambda: sim.moving)
    node.send_signal(signal.SIGINT)
    assert node.wait(PATIENT) == 0, graph.errors
    assert not sim.moving
    assert "was stopped" in client.communicate(timeout=PATIENT)[0]


def test_joint_states_and_a_bag_of_them(
    graph: Graph, node: subprocess.Popen[str], tmp_path: Path
) -> None:
    """How many come, and what they cost, `benchmarks/ros.py` tells."""
    found = graph.last("states", "3.0", str(tmp_path / "states.bag"))
    assert found["rising"]
    assert found["rate"] <= 125 * 1.02
    assert found["played"] == found["recorded"] > 0


@pytest.mark.parametrize("killed", ["node", "master", "client"])
def test_the_arm_stands_when_one_of_them_is_killed(
    graph: Graph, sim: Simulator, node: subprocess.Popen[str], killed: str
) -> None:
    """How soon, `benchmarks/ros.py` tells."""
    client = graph.moving_client("200", "60.0", "2.0")
    eventually(lambda: sim.moving)
    {"node": node, "master": graph.master, "client": client}[killed].kill()
    # Not on its own: the goal takes a minute, and leads farther.
    eventually(lambda: not sim.moving, PATIENT)
    assert sim.joints[0] < 1.9


def test_two_arms_under_prefixes(graph: Graph, sim: Simulator) -> None:
    with Simulator() as other:
        for arm, prefix in ((sim, "left_"), (other, "right_")):
            start_node(
                graph,
                arm,
                f"_prefix:={prefix}",
                f"__name:={prefix}driver",
                "_heartbeat:=10.0",
                f"joint_states:={prefix}joint_states",
            )
        for prefix in ("left_", "right_"):
            graph.call("bring_up", f"/{prefix}driver")
        before = other.joints
        graph.go_to_start("/left_driver")
        found = graph.last(
            "goal", "20", "1.0", "0.1", "joint_states:=left_joint_states", PREFIX="left_"
        )
        assert found["state"] == SUCCEEDED, found
        assert other.joints.almost_equal(before, 1e-3)


def test_a_node_says_why_it_does_not_start(graph: Graph, sim: Simulator) -> None:
    for given, said in (
        (("_hurst:=1",), "hurst"),
        (("_rate:=fast",), "rate"),
        (("_model:=elephant",), "elephant"),
        (("_prefix=left_",), "_prefix=left_"),
        (("a:=b:=c",), "a:=b:=c"),
    ):
        # each under a name of its own: the master keeps the parameters of a name
        node = start_node(graph, sim, *given, "__name:=node_" + said.translate(NAMED))
        assert node.wait(PATIENT) == 2
        assert said in graph.errors
    assert "rosparam delete /node_hurst/hurst" in graph.errors
    node = start_node(graph, sim, "_prefix:=[left")
    assert node.wait(PATIENT) == 1
    assert "ROS refuses" in graph.errors


def test_the_demonstration_goes_round_an_obstacle(graph: Graph) -> None:
    board = Box(at=(0.55, 0.0, 0.35), size=(0.5, 0.04, 0.7), name="board")
    with Simulator(scene=[board], joints=Joints.deg(50, 0, 90, 0, -90, 0)) as sim:
        start_node(graph, sim, "_heartbeat:=10.0")
        client = graph.start(sys.executable, str(ROOT / "examples" / "ros1_plan_round_obstacle.py"))
        out, _ = client.communicate(timeout=300)
        assert client.returncode == 0, graph.errors
        assert "on the right side" in out
        assert sim.joints.almost_equal(Joints.deg(-50, 0, 90, 0, -90, 0), 0.02)


def test_joint_states_are_packed_as_genpy_packs_them() -> None:
    from aioduco.integrations.ros.ros1.message_classes import install  # noqa: PLC0415

    install()
    from sensor_msgs.msg import JointState  # noqa: PLC0415 - of ROS

    from aioduco.integrations.ros import shared_messages  # noqa: PLC0415 - needs it
    from aioduco.integrations.ros.ros1 import conversions  # noqa: PLC0415 - as this
    from aioduco.integrations.ros.ros1._packed_joint_state import PackedJointState  # noqa: PLC0415

    reading = ArmReading((0.1, -0.2, 0.3, 1e-9, 5.0, -6.0), [0.5] * 6, [1.0, 2, 3, 4, 5, 6.5])
    for names in (tuple("abcdef"), tuple(f"links_gelenk_ä{number}" for number in range(6))):
        stamp = conversions.stamp(1234.5678)
        message = shared_messages.joint_state(
            PackedJointState(), names, reading, "base_link", stamp
        )
        message.header.seq = 77
        ours, theirs = io.BytesIO(), io.BytesIO()
        message.serialize(ours)
        JointState.serialize(message, theirs)
        assert ours.getvalue() == theirs.getvalue()
        read = JointState().deserialize(ours.getvalue())
        assert (tuple(read.name), tuple(read.position)) == (names, reading.position)
        assert (list(read.velocity), list(read.effort)) == (reading.velocity, reading.effort)


def test_a_sample_from_before_a_clock_that_stands_at_0_has_the_time_0() -> None:
    """As with /use_sim_time, before the first message of the clock; ROS has no negative times."""
    from aioduco.integrations.ros.ros1.message_classes import install  # noqa: PLC0415

    install()
    from aioduco.integrations.ros.ros1 import conversions  # noqa: PLC0415 - needs it
    from aioduco.integrations.ros.topics import StatePublisher  # noqa: PLC0415 - as this

    class Publisher(StatePublisher):
        stamp = staticmethod(conversions.stamp)

        def wall(self) -> float:
            return 0.0

        def wants_frames(self) -> bool:
            return False

        def progress(self, place: GoalProgress, factor: float) -> None:
            """Publish nothing."""

    before, published = time.monotonic(), list[Any]()
    topic = SimpleNamespace(publish=published.append)
    state = Publisher(NodeSettings(host="-"), "/duco", {"joint_states": topic})
    state.joints(before, ArmReading((0.0,) * 6, [0.0] * 6, [0.0] * 6), [])
    assert published[0].header.stamp.to_sec() == 0.0


@pytest.mark.skipif(shutil.which("roslaunch") is None, reason="needs roslaunch")
def test_the_launch_file_starts_simulator_driver_and_robot_state_publisher(
    graph: Graph, tmp_path: Path
) -> None:
    done = CliRunner().invoke(app, ["export", "ros1", "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    launch = graph.start(
        *("roslaunch", "gcr5_910_bringup", "arm.launch", "rviz:=false", "through:=servoj"),
        f"simulator_port:={free_port()}",
        ROS_PACKAGE_PATH=os.pathsep.join([str(tmp_path), "/usr/share"]),
    )
    graph.call("bring_up")
    for frame in ("tcp_controller", "link_6"):
        assert graph.last("frame", frame)["found"], (frame, graph.errors)
    graph.end_launch(launch, PATIENT)


ONE = ("gcr5_910_moveit_config", ())
TWO = (
    "cell_moveit_config",
    (
        *("--name", "cell", "--model", "gcr5_910", "--model", "gcr5_910"),
        *("--prefix", "left_", "--mounting", "0,0.4,0,0,0,0"),
        *("--prefix", "right_", "--mounting", "0,-0.4,0,0,0,0"),
    ),
)


@pytest.mark.parametrize(
    ("package", "options", "given", "started"),
    [
        (*ONE, (), {"/simulator", "/duco", "/move_group", "/moveit_rviz"}),
        (*ONE, ("robot_ip:=192.168.1.10",), {"/duco", "/move_group", "/moveit_rviz"}),
        (
            *ONE,
            ("robot_ip:=192.168.1.10", "rviz:=false", "guard:=process", "through:=servoj"),
            {"/duco", "/move_group"},
        ),
        (
            *TWO,
            ("left_robot_ip:=192.168.1.10", "rviz:=false", "simulator_port:=7100"),
            {"/left_duco", "/right_duco", "/right_simulator", "/move_group"},
        ),
    ],
)
def test_roslaunch_takes_moveit_s_launch_file_with_each_argument(
    package: str,
    options: tuple[str, ...],
    given: tuple[str, ...],
    started: set[str],
    tmp_path: Path,
) -> None:
    command = ["export", "ros1", "--moveit", "-o", str(tmp_path), *options]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    found = subprocess.run(
        ["roslaunch", "--nodes", package, "moveit_planning_execution.launch", *given],
        env={**os.environ, "ROS_PACKAGE_PATH": f"{tmp_path}:/usr/share"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert set(found.stdout.split()) == {*started, "/robot_state_publisher"}


def test_moveit_s_launch_file_and_the_demonstration_with_a_stand_in_for_move_group(
    graph: Graph, tmp_path: Path
) -> None:
    stand_in = HERE / "stand_in"
    names = ("--group", "duco_gcr5", "--tip", "link_6")
    done = CliRunner().invoke(app, ["export", "ros1", "--moveit", *names, "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    package = tmp_path / "moveit_ros_move_group"
    package.mkdir()
    (package / "package.xml").write_text(
        "<package><name>moveit_ros_move_group</name><version>1.0.0</version>"
        "<description>-</description><maintainer email='a@b.example'>-</maintainer>"
        "<license>-</license></package>"
    )
    program = package / "move_group"
    program.write_text(f"#!{sys.executable}\nimport move_group\nmove_group.main()\n")
    program.chmod(0o755)
    path = os.pathsep.join([str(stand_in), graph.environment["PYTHONPATH"]])
    # this machine may be busy
    with ServerProxy(graph.environment["ROS_MASTER_URI"]) as master:
        master.setParam("/test", "/duco/goal_time_tolerance", 60.0)
    launch = graph.start(
        *("roslaunch", "gcr5_910_moveit_config", "moveit_planning_execution.launch"),
        *("rviz:=false", "through:=servoj", f"simulator_port:={free_port()}"),
        ROS_PACKAGE_PATH=os.pathsep.join([str(tmp_path), "/usr/share"]),
        PYTHONPATH=path,
    )
    demo = graph.start(
        *(sys.executable, str(ROOT / "examples" / "ros1_moveit_demo.py"), "duco_gcr5"),
        PYTHONPATH=path,
    )
    assert demo.stdout is not None
    assert "bring-up" in demo.stdout.readline(), graph.errors
    for step in ("up", "left", "right"):
        assert demo.stdout.readline() == f"press next: {step}\n", graph.errors
        assert graph.last("press")["pressed"]
        assert demo.stdout.readline() == f"at {step}\n", graph.errors
    assert demo.wait(PATIENT) == 0
    graph.end_launch(launch, PATIENT)
