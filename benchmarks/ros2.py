"""The driver for ROS 2: how steady joint states are, what they cost, how soon the arm stands.

A subscriber in a process of its own counts `joint_states`; the processor time is that of the driver
and of the processes that it started, at rest, with the frames of `/tf`, which it always publishes.
Then driver and client are killed in the middle of a goal: the time from the kill until the
simulated arm stands, whose controller gives no slack beyond the heartbeat time. That a client was
killed is known by its silence alone: it has the lease of the driver's own profile for Fast DDS.
Needs ROS 2: run it by `.ci/ros2 figures`.
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
    from collections.abc import Callable

Domain: Callable[[Path, contextlib.ExitStack, int], Any] = test_module("ros2_domain").Domain
NUMBER = 60  # of the domain
COMMAND = ("-m", "aioduco.cli")


def joint_states(folder: Path, seconds: float) -> dict[str, Any]:
    """Count joint states, beside the processor time of the driver."""
    with contextlib.ExitStack() as stack:
        sim = stack.enter_context(Simulator.spawn())
        domain = Domain(folder, stack, NUMBER)
        node = domain.start_node(sim, program=COMMAND)
        domain.ready()
        counting = domain.client("states", str(seconds))
        assert counting.stdout is not None
        # It says when it begins, and what it found.
        counting.stdout.readline()
        begin, used = time.monotonic(), processor(node.pid)
        found = json.loads(counting.stdout.readline())
        share = (processor(node.pid) - used) / (time.monotonic() - begin)
    return {
        "asked_hz": RATE,
        "found_hz": found["rate"],
        "seconds": seconds,
        "share_of_a_core_percent": 100 * share,
    }


def kills(folder: Path, killed: str, guard: str, count: int) -> dict[str, Any]:
    """Kill something in the middle of a goal, so many times."""
    late: list[float] = []
    with contextlib.ExitStack() as stack:
        sim = stack.enter_context(Simulator(heartbeat_slack=0.0))
        domain = Domain(folder, stack, NUMBER)
        lease = domain.lease()
        node = None
        for number in range(count):
            name = f"duco{number}"
            if node is None:
                given = [f"heartbeat:={HEARTBEAT}", f"-r __node:={name}"]
                given += [f"guard:={guard}"] if guard else []
                node, at = domain.start_node(sim, *given, program=COMMAND), f"/{name}"
            domain.ready("recover", NODE=at)
            domain.go_to_start(NODE=at)
            client = domain.client("goal", "200", "60.0", "2.0", **lease)
            assert client.stdout is not None
            said = client.stdout.readline()
            assert json.loads(said) == {"moving": True}, (said, domain.errors)
            late.append(stood_after(sim, node if killed == "driver" else client))
            client.kill()
            if killed == "driver":
                node.wait(PATIENT)
                node = None
    return kill_row(late, LIMITS[guard])


def main() -> int:
    """Measure, and say whether all is within its limit."""
    given = parser(__doc__, "ros2")
    given.add_argument("--times", type=int, default=20, help="kills of each kind")
    options = given.parse_args()
    count, seconds = (2, 5.0) if options.quick else (options.times, 30.0)
    results: dict[str, Any] = {"heartbeat_s": HEARTBEAT, "until_the_arm_stands": {}}
    with tempfile.TemporaryDirectory() as folder:
        states = joint_states(Path(folder), seconds)
        results["joint_states"] = {"30 s" if seconds == 30.0 else f"{seconds:g} s": states}
        print_table("joint states", ["", ""], list(states.items()))
        for killed, guard in (("driver", ""), ("driver", "process"), ("client", "")):
            title = f"{killed} killed, {'with' if guard else 'without'} guard"
            row = kills(Path(folder), killed, guard, count)
            results["until_the_arm_stands"][title] = row
            print_table(title, ["", ""], list(row.items()))
    if options.save:
        print("written:", write_results("ros2", results).name)
    kept = abs(states["found_hz"] / RATE - 1) <= 0.05 and not any(
        row["beyond"] for row in results["until_the_arm_stands"].values()
    )
    print("within the limits" if kept else "BEYOND a limit")
    return int(not kept)


if __name__ == "__main__":
    sys.exit(main())
