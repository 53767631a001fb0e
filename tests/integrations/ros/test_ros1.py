"""The driver under ROS 1 for real: master, node and client in processes of their own.

It runs where rospy is installed: `.ci/ros1` sets that up from nothing.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from aioduco.sim import Simulator
from aioduco.testing import eventually

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = [
    pytest.mark.ros1,
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(
        importlib.util.find_spec("rospy") is None,
        reason="needs rospy of ROS 1, which .ci/ros1 sets up",
    ),
]

HERE = Path(__file__).parent
START = [0.0, 0.3, 1.2, 0.1, -1.5, 0.0]
SUCCEEDED, PREEMPTED, ABORTED, REJECTED = 3, 2, 4, 5
#: s for what takes part of one: a net, for no machine is so busy
PATIENT = 60.0


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port


class Graph:
    """A master, and what is started with it; all of it ends with the test."""

    def __init__(self, folder: Path, stack: contextlib.ExitStack) -> None:
        self._stack = stack
        self.folder = folder
        self.port = free_port()
        self.environment = {
            **os.environ,
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(folder),
            "PYTHONPATH": os.pathsep.join([str(HERE.parents[2]), *sys.path]),
        }
        self.master = self.start_master()

    def start(self, *command: str, **environment: str) -> subprocess.Popen[str]:
        """Start a program, whose output is kept from this one's but for what it answers."""
        with (self.folder / "errors").open("a") as errors:
            process = subprocess.Popen(
                command,
                env={**self.environment, **environment},
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        self._stack.callback(self._end, process)
        return process

    @staticmethod
    def _end(process: subprocess.Popen[str]) -> None:
        if process.poll() is None:
            process.kill()
        process.wait()
        assert process.stdout is not None
        process.stdout.close()

    def start_master(self) -> subprocess.Popen[str]:
        code = "import rosmaster.main as m; m.rosmaster_main()"
        process = self.start(sys.executable, "-c", code, "--core", "-p", str(self.port))

        def answers() -> bool:
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port)):
                return True
            return False

        eventually(answers)
        return process

    def start_node(self, sim: Any, *given: str) -> subprocess.Popen[str]:
        return self.start(
            *(sys.executable, str(HERE.parents[1] / "patient.py")),
            *(str(HERE / "ros1_node.py"), "ros1", "--host", sim.host, "--port", str(sim.port)),
            # the controller's queue holds a tenth of a second, and this machine may be busy
            *("_through:=servoj", *given),
        )

    def client(self, *asked: str, **environment: str) -> subprocess.Popen[str]:
        return self.start(sys.executable, str(HERE / "ros1_client.py"), *asked, **environment)

    def ask(self, *asked: str, **environment: str) -> list[dict[str, Any]]:
        """What a client answers, to its end."""
        process = self.client(*asked, **environment)
        out, _ = process.communicate(timeout=300)
        assert process.returncode == 0, (self.folder / "errors").read_text()[-3000:]
        return [json.loads(line) for line in out.splitlines()]

    def last(self, *asked: str, **environment: str) -> dict[str, Any]:
        return self.ask(*asked, **environment)[-1]


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    with contextlib.ExitStack() as stack:
        yield Graph(tmp_path, stack)


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with Simulator() as sim:
        yield sim


@pytest.fixture
def node(graph: Graph, sim: Simulator) -> subprocess.Popen[str]:
    node = graph.start_node(sim, "_heartbeat:=10.0")
    assert graph.last("call", "bring_up")["success"]
    go_to_start(graph)
    return node


def test_the_messages_have_the_released_checksum() -> None:
    code = (
        "from aioduco.integrations.ros.ros1.message_classes import install\n"
        "install()\n"
        "from control_msgs.msg import JointTolerance\n"
        "print(JointTolerance._md5sum)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE.parents[2]), *sys.path])}
    found = subprocess.check_output([sys.executable, "-c", code], env=environment, text=True)
    assert found == "f544fe9c16cf04547e135dd6063ff5be\n"


def go_to_start(graph: Graph) -> None:
    reply = graph.last("call", "movej", json.dumps({"joints": START, "v": 2.0, "a": 10.0}))
    assert reply["success"], reply


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
    replies = {each["name"]: each for each in graph.ask("tight")}
    assert {name: each["code"] for name, each in replies.items()} == {"path": -4, "goal": -5}
    assert all(each["state"] == ABORTED for each in replies.values())
    assert graph.last("call", "recover")["success"]
    found = graph.last("goal", "20", "1.0", "-0.1")
    assert found["state"] == SUCCEEDED, found


def test_services(graph: Graph, sim: Simulator, node: subprocess.Popen[str]) -> None:
    assert graph.last("call", "set_digital_output", '{"number": 4, "value": true}')["success"]
    assert sim.get_digital_output(4)
    reply = graph.last("call", "set_digital_output", '{"number": 77, "value": true}')
    assert (reply["success"], "16" in reply["message"]) == (False, True)
    assert graph.last("call", "set_load", '{"mass": 0.5, "centre": [0, 0, 0.1]}')["success"]
    client = graph.client("goal", "200", "20.0", "1.0")
    assert client.stdout is not None
    assert json.loads(client.stdout.readline()) == {"moving": True}
    assert graph.last("call", "stop")["success"]
    assert not sim.moving
    found = json.loads(client.communicate(timeout=PATIENT)[0].splitlines()[-1])
    assert (found["state"], found["code"]) == (ABORTED, -4)


def test_joint_states_and_a_bag_of_them(
    graph: Graph, sim: Simulator, node: subprocess.Popen[str], thorough: bool, tmp_path: Path
) -> None:
    seconds = 30.0 if thorough else 5.0
    before, begun = cpu(node.pid), time.monotonic()
    found = graph.last("states", str(seconds), str(tmp_path / "states.bag"))
    share = (cpu(node.pid) - before) / (time.monotonic() - begun)
    print(f"joint states at {found['rate']:.1f} Hz, {share:.1%} of a core")  # noqa: T201 - figures
    assert found["rising"]
    assert found["rate"] <= 125 * 1.02
    assert found["played"] == found["recorded"] > 0


def cpu(pid: int) -> float:
    """Seconds of processor time that a process has used."""
    numbers = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.parametrize("killed", ["node", "master", "client"])
def test_the_arm_stands_when_one_of_them_is_killed(
    graph: Graph, sim: Simulator, killed: str, thorough: bool
) -> None:
    for number in range(20 if thorough else 1):
        if number == 0 or killed == "node":
            node = graph.start_node(sim, "_heartbeat:=2.0", f"__name:=duco{number}")
            name = f"/duco{number}"
        assert graph.last("call", "recover", NODE=name)["success"]
        reply = graph.last(
            "call", "movej", json.dumps({"joints": START, "v": 2.0, "a": 10.0}), NODE=name
        )
        assert reply["success"], reply
        client = graph.client("goal", "200", "60.0", "2.0")
        assert client.stdout is not None
        assert json.loads(client.stdout.readline()) == {"moving": True}
        eventually(lambda: sim.moving)
        {"node": node, "master": graph.master, "client": client}[killed].kill()
        killed_at = time.monotonic()
        eventually(lambda: not sim.moving, PATIENT)
        took = time.monotonic() - killed_at
        # Not on its own: the goal takes a minute.
        assert took < 45.0
        assert sim.joints[0] < 1.9
        print(f"{killed}: the arm stood after {took:.2f} s")  # noqa: T201 - a figure for people
        client.kill()
        if killed == "master":
            graph.master.wait()
            graph.master = graph.start_master()
            node.terminate()
            node.wait(PATIENT)
            if thorough:
                node = graph.start_node(sim, "_heartbeat:=2.0", f"__name:=duco{number}")


def test_two_arms_under_prefixes(graph: Graph, sim: Simulator) -> None:
    with Simulator() as other:
        for arm, prefix in ((sim, "left_"), (other, "right_")):
            graph.start_node(
                arm,
                f"_prefix:={prefix}",
                f"__name:={prefix}driver",
                "_heartbeat:=10.0",
                f"joint_states:={prefix}joint_states",
            )
        for prefix in ("left_", "right_"):
            assert graph.last("call", "bring_up", NODE=f"/{prefix}driver")["success"]
        before = other.joints
        given = json.dumps({"joints": START, "v": 2.0, "a": 10.0})
        assert graph.last("call", "movej", given, NODE="/left_driver")["success"]
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
    ):
        # each under a name of its own: the master keeps the parameters of a name
        node = graph.start_node(sim, *given, f"__name:={said}")
        assert node.wait(PATIENT) == 1
        assert said in (graph.folder / "errors").read_text()
