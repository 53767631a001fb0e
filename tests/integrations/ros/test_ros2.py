"""The driver under ROS 2 for real: node and clients in processes of their own.

It runs where rclpy is installed: `.ci/ros2` sets that up from nothing.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from aioduco import Joints
from aioduco.sim import Simulator
from aioduco.sim.scene import Box
from aioduco.testing import Delay, FaultProxy, eventually

from .programs import ROOT, START, WAVE, processor_time, ur_services
from .ros2_domain import Domain

pytestmark = [
    pytest.mark.ros2,
    pytest.mark.slow,
    pytest.mark.timeout(900),
    pytest.mark.skipif(
        importlib.util.find_spec("rclpy") is None,
        reason="needs rclpy of ROS 2, which .ci/ros2 sets up",
    ),
]

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
#: s for what takes part of one: a net, for no machine is so busy
PATIENT = 90.0


@pytest.fixture
def domain(tmp_path: Path, worker_id: str) -> Iterator[Domain]:
    number = 40 + int(worker_id.removeprefix("gw")) if worker_id != "master" else 40
    with contextlib.ExitStack() as stack:
        yield Domain(tmp_path, stack, number)


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with Simulator(programs=WAVE) as sim:
        yield sim


@pytest.fixture
def node(domain: Domain, sim: Simulator) -> subprocess.Popen[str]:
    node = domain.start_node(sim, "heartbeat:=10.0")
    domain.ready()
    domain.go_to_start()
    return node


def test_a_trajectory_a_cancellation_and_wrong_goals(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    found = domain.last("goal", "200", "2.0", "0.3")
    assert (found["status"], found["code"]) == (SUCCEEDED, 0), found
    assert found["error"] <= 0.0101
    # Of a share of the 20 a second that were asked for: the rest is the machine's.
    assert 0.3 * 20 <= found["feedback"] / found["span"] <= 25, found
    found = domain.last("goal", "200", "6.0", "0.9", "0.8")
    assert found["status"] == CANCELED, found
    assert 0.0 < found["went"] < 0.85
    assert not sim.moving
    replies = {each["name"]: each for each in domain.ask("wrong")}
    codes = dict.fromkeys(replies, -1) | {"partial": -2, "name": -2, "old": -3}
    assert len(replies) == 10
    assert {name: each["code"] for name, each in replies.items()} == codes
    assert all(each["status"] == ABORTED and each["moved"] < 1e-3 for each in replies.values())
    assert all(each["text"] for each in replies.values())
    replies = {each["name"]: each for each in domain.ask("tight")}
    assert {name: each["code"] for name, each in replies.items()} == {"path": -4, "goal": -5}
    assert all(each["status"] == ABORTED for each in replies.values())
    assert domain.last("call", "recover")["success"]
    found = domain.last("goal", "20", "1.0", "-0.1")
    assert found["status"] == SUCCEEDED, found
    node.send_signal(signal.SIGINT)
    assert node.wait(PATIENT) == 0, domain.errors


def test_services(domain: Domain, sim: Simulator, node: subprocess.Popen[str]) -> None:
    assert domain.last("call", "set_digital_output", '{"number": 4, "value": true}')["success"]
    assert sim.get_digital_output(4)
    reply = domain.last("call", "set_digital_output", '{"number": 77, "value": true}')
    assert (reply["success"], "16" in reply["message"]) == (False, True)
    assert domain.last("call", "set_load", '{"mass": 0.5, "centre": [0, 0, 0.1]}')["success"]
    assert domain.last("call", "set_speed", '{"percent": 50}')["success"]
    assert domain.last("states", "0.1")["speed"] == 50.0
    assert domain.last("call", "set_speed", '{"percent": 100}')["success"]
    client = domain.moving_client("200", "20.0", "1.0")
    assert domain.last("call", "stop")["success"]
    assert not sim.moving
    found = json.loads(client.communicate(timeout=PATIENT)[0].splitlines()[-1])
    assert (found["status"], found["code"]) == (ABORTED, -4)


def test_what_is_published(domain: Domain, sim: Simulator, node: subprocess.Popen[str]) -> None:
    before, begun = processor_time(node.pid), time.monotonic()
    found = domain.last("states", "10")
    share = (processor_time(node.pid) - before) / (time.monotonic() - begun)
    print(f"joint states at {found['rate']:.1f} Hz, {share:.1%} of a core")  # noqa: T201 - figures
    assert found["rising"]
    assert found["rate"] <= 125 * 1.05
    assert found["names"] == [f"joint_{number}" for number in range(1, 7)]
    assert found["frames"] == ["tcp_controller", "flange_controller"]
    assert (found["ready"], found["outputs"], found["speed"]) == (True, 16, 100.0)
    assert found["diagnosis"] == "ready"


@pytest.mark.parametrize("how", ["trajectory", "command"])
def test_set_points_by_topics(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str], how: str
) -> None:
    assert domain.last("stream", how)["arrived"], domain.errors
    # They have ceased: the arm is free for a goal.
    eventually(lambda: not sim.moving, PATIENT)
    found = domain.last("goal", "20", "1.0", "-0.1")
    while "joint commands" in found["text"] or "stream" in found["text"]:
        found = domain.last("goal", "20", "1.0", "-0.1")
    assert found["status"] == SUCCEEDED, found


def test_goals_that_are_late_replaced_or_too_fast(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    (found,) = domain.ask("late")
    assert (found["status"], found["code"]) == (ABORTED, -5), found
    assert "own end" in found["text"]
    assert not sim.moving
    domain.go_to_start()
    found = domain.last("replace")
    assert (found["status"], found["before"]) == (SUCCEEDED, ABORTED), found
    assert found["error"] <= 0.0101
    domain.go_to_start()
    replies = {each["name"]: (each["status"], each["code"]) for each in domain.ask("speeds")}
    assert replies == {"wide": (SUCCEEDED, 0), "tight": (ABORTED, -4)}


def test_set_points_that_move_at_once(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    assert domain.last("move")["moved"] > 0.5, domain.errors


def test_what_a_user_of_the_ur_driver_knows(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    ur_services(lambda asked: domain.ask("calls", json.dumps(asked)), sim)
    domain.ready("recover")
    domain.go_to_start()
    found = domain.last("guide")
    assert (found["robot"], found["safety"], found["offset"]) == ("ENABLE", "RUN", 6)
    assert found["names"][0] == "joint_1"


def test_wrong_transitions_end_nothing(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    wrong = ["99", "1", "3", "255", "destroy", "transition_success"]  # 3: it is active already
    assert domain.ask("lifecycle", *wrong) == [{"done": False, "state": "active"}] * len(wrong)
    assert domain.last("call", "bring_up")["success"]
    assert node.poll() is None
    eventually(lambda: "transition 99 refused" in domain.errors)


@pytest.mark.parametrize("how", ["signal", "transition"])
def test_a_goal_has_its_result_when_the_driver_ends(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str], how: str
) -> None:
    client = domain.moving_client("200", "60.0", "2.0")
    if how == "signal":
        node.send_signal(signal.SIGINT)
    else:
        assert domain.last("lifecycle", "shutdown") == {"done": True, "state": "finalized"}
    found = json.loads(client.communicate(timeout=PATIENT)[0].splitlines()[-1])
    assert found["status"] == ABORTED
    assert "the driver ends" in found["text"]
    assert not sim.moving


def test_a_signal_ends_a_driver_that_still_connects(domain: Domain, sim: Simulator) -> None:
    """It had no arm to leave yet, and then held its connections and heartbeat for ever."""
    with FaultProxy(sim.host, sim.port) as proxy:
        for name in ("get_robot_state", "get_robot_version"):
            proxy.on(name, Delay(reply=1.2))
        node = domain.start_node(proxy)
        eventually(lambda: bool(proxy.calls("get_robot_state")), PATIENT)
        node.send_signal(signal.SIGTERM)
        assert node.wait(PATIENT) == 0, domain.errors


def test_a_driver_that_could_not_bring_the_arm_to_rest_does_not_end_well(
    domain: Domain, sim: Simulator
) -> None:
    with FaultProxy(sim.host, sim.port) as proxy:
        node = domain.start_node(proxy, "heartbeat:=30.0")
        domain.ready()
        domain.go_to_start()
        client = domain.moving_client("200", "20.0", "1.0")
        proxy.refuse()
        proxy.cut()
        node.send_signal(signal.SIGTERM)
        assert node.wait(PATIENT) != 0
        assert "emergency stop" in domain.errors
        client.kill()


def test_transitions_and_parameters(domain: Domain, sim: Simulator) -> None:
    given = ("autostart:=false", "heartbeat:=10.0", "feedback_rate:=10")
    domain.start_node(sim, *given, "robot_ip:=127.0.0.9")  # --host comes before its alias
    assert not domain.last("call", "bring_up")["success"]
    assert domain.last("set", "rate", "1000.0")["done"]
    reply = domain.last("set", "prefix", '"left_"')  # services already have their names
    assert (reply["done"], "as the driver starts" in reply["reason"]) == (False, True)
    # What is wrong is told when it is read; and can be put right.
    assert domain.ask("lifecycle", "configure") == [{"done": False, "state": "unconfigured"}]
    assert "rate" in domain.errors
    assert domain.last("set", "rate", "50.0")["done"]
    assert domain.ask("lifecycle", "configure") == [{"done": True, "state": "inactive"}]
    reply = domain.last("set", "rate", "60.0")
    assert (reply["done"], "clean" in reply["reason"]) == (False, True)
    assert domain.last("call", "bring_up")["success"]
    domain.go_to_start()
    assert domain.ask("lifecycle", "activate") == [{"done": True, "state": "active"}]
    found = domain.last("goal", "20", "2.0", "0.2")
    assert found["status"] == SUCCEEDED, found
    assert found["feedback"] / found["span"] <= 12.5
    # The arm comes to rest before it is inactive.
    client = domain.moving_client("200", "60.0", "2.0")
    assert domain.ask("lifecycle", "deactivate") == [{"done": True, "state": "inactive"}]
    assert not sim.moving
    client.kill()
    steps = {
        "activate": "active",
        "deactivate": "inactive",
        "cleanup": "unconfigured",
        "configure": "inactive",
        "shutdown": "finalized",
    }
    assert domain.ask("lifecycle", *steps) == [
        {"done": True, "state": state} for state in steps.values()
    ]


def test_a_motion_by_a_service_ends_as_the_driver_is_deactivated(
    domain: Domain, sim: Simulator, node: subprocess.Popen[str]
) -> None:
    there = {"joints": [3.0, *START[1:]], "v": 0.03, "a": 1.0}  # which takes more than a minute
    client = domain.client("call", "movej", json.dumps(there))
    eventually(lambda: sim.moving)
    assert domain.ask("lifecycle", "deactivate") == [{"done": True, "state": "inactive"}]
    assert not sim.moving
    assert "was stopped" in client.communicate(timeout=PATIENT)[0]


@pytest.mark.parametrize("killed", ["node", "guarded node", "client", "client that ends"])
def test_the_arm_stands_when_one_of_them_is_killed(
    domain: Domain, sim: Simulator, killed: str
) -> None:
    # A client on a busy machine may be silent for longer than the lease that is for real arms.
    patient = domain.lease(os.environ.get("LEASE", "<sec>4</sec>"))
    given = ["heartbeat:=2.0"] + ["guard:=process"] * (killed == "guarded node")
    for number in range(int(os.environ.get("KILLS", "1"))):
        if number == 0 or "node" in killed:
            node = domain.start_node(sim, *given, f"-r __node:=duco{number}")
            name = f"/duco{number}"
        domain.ready("recover", NODE=name)
        domain.go_to_start(NODE=name)
        client = domain.moving_client("200", "60.0", "2.0", **patient)
        eventually(lambda: sim.moving)
        victim = node if "node" in killed else client
        killed_at = time.monotonic()
        victim.terminate() if killed == "client that ends" else victim.kill()
        eventually(lambda: not sim.moving, PATIENT)
        took = time.monotonic() - killed_at
        # Not on its own: the goal takes a minute.
        assert took < 45.0
        assert sim.joints[0] < 1.9
        print(f"{killed}: the arm stood after {took:.2f} s")  # noqa: T201 - a figure for people
        client.kill()


def test_two_arms_under_prefixes(domain: Domain, sim: Simulator) -> None:
    with Simulator() as other:
        for arm, prefix in ((sim, "left_"), (other, "right_")):
            domain.start_node(
                arm, f"prefix:={prefix}", f"-r __node:={prefix}driver", "heartbeat:=10.0"
            )
        for prefix in ("left_", "right_"):
            domain.ready(NODE=f"/{prefix}driver")
        before = other.joints
        domain.go_to_start(NODE="/left_driver")
        # Both publish joint_states: the client is to wait for those of its arm.
        found = domain.last("goal", "20", "1.0", "0.1", PREFIX="left_")
        assert found["status"] == SUCCEEDED, found
        assert other.joints.almost_equal(before, 1e-3)
        # Each arm's states are its own, and say whose they are.
        found = domain.last("states", "0.1", PREFIX="right_")
        assert found["bases"] == ["right_base_link"], found


def test_the_demonstration_goes_round_an_obstacle(domain: Domain) -> None:
    pytest.importorskip("ompl", reason="needs pip install 'aioduco[plan]'")
    board = Box(at=(0.55, 0.0, 0.35), size=(0.5, 0.04, 0.7), name="board")
    with Simulator(scene=[board], joints=Joints.deg(50, 0, 90, 0, -90, 0)) as sim:
        domain.start_node(sim, "heartbeat:=10.0")
        domain.ready()
        program = ROOT / "examples" / "ros2_plan_round_obstacle.py"
        client = domain.start(sys.executable, str(program))
        out, _ = client.communicate(timeout=400)
        assert client.returncode == 0, (out, domain.errors)
        assert "on the right side" in out
        assert sim.joints.almost_equal(Joints.deg(-50, 0, 90, 0, -90, 0), 0.02)


def test_a_node_says_why_it_does_not_start(domain: Domain, sim: Simulator) -> None:
    for given, said in (
        ("hurst:=1", "hurst"),
        ("rate:=fast", "rate"),
        ("model:=elephant", "elephant"),
        ("prefix:=left arm", "prefix is 'left arm'"),
        ("autostart:='false'", "true or false"),
    ):
        node = domain.start_node(sim, given)
        assert (node.wait(PATIENT), said in domain.errors) == (2, True), domain.errors
    command = (sys.executable, "-m", "aioduco.cli", "ros2", "--host", sim.host, "prefix=left_")
    node = domain.start(*command)
    assert (node.wait(PATIENT), "after --ros-args" in domain.errors) == (2, True), domain.errors
    for given in ("joint_names:=[]", "rate"):
        node = domain.start_node(sim, given)
        assert node.wait(PATIENT) == 1
        assert "ROS refuses the arguments" in domain.errors.splitlines()[-1]
