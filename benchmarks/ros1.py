"""The driver for ROS 1: how steady joint states are, what they cost, how soon the arm stands.

A subscriber in a process of its own counts `joint_states`; the processor time is that of the driver
and of the processes that it started. Then driver, master and client are killed in the middle of a
goal: the time from the kill until the simulated arm stands, whose controller gives no slack beyond
the heartbeat time. Needs ROS 1: run it by `.ci/ros1 figures`.
"""

from __future__ import annotations

import contextlib
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from _common import parser, print_table, write_results
from _ros_driver import (
    HEARTBEAT,
    LIMITS,
    PATIENT,
    RATE,
    kill_row,
    processor,
    stood_after,
    test_module,
)

from aioduco.sim import Simulator

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Callable

# a master and programs under it are started as by the tests
Graph: Callable[[Path, contextlib.ExitStack], Any] = test_module("ros1_graph").Graph


def joint_states(folder: Path, seconds: float) -> dict[str, Any]:
    """Count joint states, beside the processor time of the driver."""
    with contextlib.ExitStack() as stack:
        sim = stack.enter_context(Simulator.spawn())
        graph = Graph(folder, stack)
        node = graph.start_node(sim)
        graph.call("bring_up")
        client = graph.client("states", str(seconds), str(folder / "states.bag"))
        assert client.stdout is not None
        used: list[float] = []
        times: list[float] = []
        for _ in range(2):
            client.stdout.readline()
            used.append(processor(node.pid))
            times.append(time.monotonic())
        found = json.loads(client.communicate(timeout=PATIENT)[0].splitlines()[-1])
        share = (used[1] - used[0]) / (times[1] - times[0])
    return {
        "asked_hz": RATE,
        "found_hz": found["rate"],
        "seconds": round(times[1] - times[0], 1),
        "share_of_a_core_percent": 100 * share,
        "recorded": found["recorded"],
        "played": found["played"],
    }


def moving_client(graph: Any, name: str) -> subprocess.Popen[str]:
    """A client whose goal is on its way: a driver that the machine held up may not begin one."""
    for _ in range(4):
        with contextlib.suppress(AssertionError):
            return begin(graph, name)
    return begin(graph, name)


def begin(graph: Any, name: str) -> subprocess.Popen[str]:
    """Lead the arm to its start, and have it carry a goal out."""
    graph.make_ready(f"/{name}")
    client: subprocess.Popen[str] = graph.moving_client("200", "60.0", "2.0")
    return client


def kills(folder: Path, killed: str, guard: str, count: int) -> dict[str, Any]:
    """Kill something in the middle of a goal, so many times."""
    late: list[float] = []
    with contextlib.ExitStack() as stack:
        sim = stack.enter_context(Simulator(heartbeat_slack=0.0))
        graph = Graph(folder, stack)
        node = None
        for number in range(count):
            if node is None:
                name = f"duco{number}"  # one of its own: the master keeps those of the dead
                given = [f"_heartbeat:={HEARTBEAT}", f"__name:={name}"]
                node = graph.start_node(sim, *given, *([f"_guard:={guard}"] if guard else []))
            client = moving_client(graph, name)
            victims = {"driver": node, "master": graph.master, "client": client}
            late.append(stood_after(sim, victims[killed]))
            client.kill()
            if killed == "client":
                continue
            node.terminate()
            node.wait(PATIENT)
            node = None
            if killed == "master":
                graph.restart_master()
    return kill_row(late, LIMITS[guard])


def main() -> int:
    """Measure, and say whether all is within its limit."""
    given = parser(__doc__, "ros1")
    given.add_argument("--times", type=int, default=20, help="kills of each kind")
    options = given.parse_args()
    count, seconds = (2, 5.0) if options.quick else (options.times, 30.0)
    results: dict[str, Any] = {"heartbeat_s": HEARTBEAT, "until_the_arm_stands": {}}
    with tempfile.TemporaryDirectory() as folder:
        states = joint_states(Path(folder), seconds)
        results["joint_states"] = {"30 s" if seconds == 30.0 else f"{seconds:g} s": states}
        print_table("joint states", ["", ""], list(states.items()))
        for killed in ("driver", "master", "client"):
            for guard in LIMITS:
                title = f"{killed} killed, {'with' if guard else 'without'} guard"
                row = kills(Path(folder), killed, guard, count)
                results["until_the_arm_stands"][title] = row
                print_table(title, ["", ""], list(row.items()))
    if options.save:
        print("written:", write_results("ros1", results).name)
    kept = (
        abs(states["found_hz"] / RATE - 1) <= 0.02
        and states["share_of_a_core_percent"] < 15
        and states["played"] == states["recorded"] > 0
        and not any(row["beyond"] for row in results["until_the_arm_stands"].values())
    )
    print("within the limits" if kept else "BEYOND a limit")
    return int(not kept)


if __name__ == "__main__":
    sys.exit(main())
