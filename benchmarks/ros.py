"""The drivers for ROS 1 and 2: how steady joint states are, and how soon the arm stands.

A subscriber in a process of its own counts `joint_states`; the processor time is that of the driver
and of the processes that it started. Then driver, master and client are killed in the middle of a
goal: the time from the kill until the simulated arm stands, whose controller gives no slack beyond
the heartbeat time. In ROS 2 there is no master, the frames of `/tf` are published, too, and that a
client was killed is known by its silence alone: it has the lease of the driver's own profile for
Fast DDS. Needs ROS: run it by `.ci/ros1 figures` or `.ci/ros2 figures`.
"""

from __future__ import annotations

import contextlib
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from _common import of_tests, parser, report, spread
from _processes import processor_time

from aioduco.sim import Simulator

RATE = 125.0
HEARTBEAT = 1.0
#: s from a kill until the arm stands: by the heartbeat, and by the guard
LIMITS = {"": HEARTBEAT + 0.1, "process": 0.05}
#: s within which whatever is waited for has come
PATIENT = 120.0
NUMBER = 60  # of the domain of ROS 2


class Ros1:
    """A master, with a driver and clients.

    Attributes:
        kills: what is killed, with which guards.
    """

    kills = dict.fromkeys(("driver", "master", "client"), tuple(LIMITS))

    def __init__(self, folder: Path, stack: contextlib.ExitStack) -> None:
        self._folder = folder
        self.graph: Any = of_tests("integrations.ros.ros1_graph").Graph(folder, stack)

    def start(self, sim: Any, name: str = "", guard: str = "") -> Any:
        """Start the driver of an arm."""
        given = [f"_heartbeat:={HEARTBEAT}", f"__name:={name}"] if name else []
        return self.graph.start_node(sim, *given, *([f"_guard:={guard}"] if guard else []))

    def counting(self, seconds: float) -> Any:
        """A client that counts joint states, of an arm that is ready."""
        self.graph.call("bring_up")
        return self.graph.client("states", str(seconds), str(self._folder / "states.bag"))

    def moving(self, name: str) -> Any:
        """A client whose goal is being carried out."""
        # a driver that the machine held up may not begin a goal
        for left in range(4, -1, -1):
            with contextlib.nullcontext() if not left else contextlib.suppress(AssertionError):
                self.graph.make_ready(f"/{name}")
                return self.graph.moving_client("200", "60.0", "2.0")
        raise AssertionError("the last try raises by itself")


class Ros2:
    """A domain, with a driver and clients; as `Ros1`."""

    kills = {"driver": tuple(LIMITS), "client": ("",)}  # noqa: RUF012  # never changed
    command = ("-m", "aioduco.cli")

    def __init__(self, folder: Path, stack: contextlib.ExitStack) -> None:
        self.graph: Any = of_tests("integrations.ros.ros2_domain").Domain(folder, stack, NUMBER)

    def start(self, sim: Any, name: str = "", guard: str = "") -> Any:
        given = [f"heartbeat:={HEARTBEAT}", f"-r __node:={name}"] if name else []
        given += [f"guard:={guard}"] if guard else []
        return self.graph.start_node(sim, *given, program=self.command)

    def counting(self, seconds: float) -> Any:
        self.graph.ready()
        return self.graph.client("states", str(seconds))

    def moving(self, name: str) -> Any:
        self.graph.ready("recover", NODE=f"/{name}")
        self.graph.go_to_start(NODE=f"/{name}")
        return self.graph.moving_client("200", "60.0", "2.0", **self.graph.lease())


KINDS: dict[str, type[Ros1 | Ros2]] = {"1": Ros1, "2": Ros2}


def processor(pid: int) -> float:
    """Seconds of processor time of a process and of its children."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return sum(processor_time(each) for each in (pid, *map(int, children)))


def joint_states(kind: type[Ros1 | Ros2], folder: Path, seconds: float) -> dict[str, Any]:
    """Count joint states, beside the processor time of the driver."""
    with contextlib.ExitStack() as stack:
        sim = stack.enter_context(Simulator.spawn())
        ros = kind(folder, stack)
        node = ros.start(sim)
        client = ros.counting(seconds)
        client.stdout.readline()  # it begins
        begin, used = time.monotonic(), processor(node.pid)
        line = client.stdout.readline()  # it has counted
        took, used = time.monotonic() - begin, processor(node.pid) - used
        found = json.loads((line + client.communicate(timeout=PATIENT)[0]).splitlines()[-1])
    return {
        "asked_hz": RATE,
        "found_hz": found["rate"],
        "seconds": round(took, 1),
        "share_of_a_core_percent": 100 * used / took,
    }


def kills(
    kind: type[Ros1 | Ros2], folder: Path, killed: str, guard: str, count: int
) -> dict[str, Any]:
    """Kill something in the middle of a goal, so many times."""
    late: list[float] = []
    with contextlib.ExitStack() as stack:
        sim = stack.enter_context(Simulator(heartbeat_slack=0.0))
        ros = kind(folder, stack)
        node = None
        for number in range(count):
            if node is None:
                name = f"duco{number}"  # one of its own: the names of the dead are kept
                node = ros.start(sim, name, guard)
            client = ros.moving(name)
            victims = {"driver": node, "client": client}
            victim = ros.graph.master if killed == "master" else victims[killed]
            begin = time.monotonic()
            victim.kill()
            while sim.moving and time.monotonic() < begin + PATIENT:
                time.sleep(0.0005)
            late.append(time.monotonic() - begin)
            client.kill()
            if killed != "client":
                node.terminate()
                node.wait(PATIENT)
                node = None
            if killed == "master":
                ros.graph.restart_master()
    figures = spread(late)
    return {
        "p50_ms": round(figures["p50_us"] / 1e3, 1),
        "max_ms": round(figures["max_us"] / 1e3, 1),
        "limit_ms": LIMITS[guard] * 1e3,
        "beyond": sum(each > LIMITS[guard] for each in late),
        "times": len(late),
    }


def main() -> int:
    """Measure, and say whether the arm stood within its limits."""
    given = parser(__doc__)
    given.add_argument("version", choices=KINDS)
    given.add_argument("--times", type=int, default=20, help="kills of each kind")
    options = given.parse_args()
    kind = KINDS[options.version]
    count, seconds = (2, 5.0) if options.quick else (options.times, 30.0)
    stands: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        states = joint_states(kind, Path(folder), seconds)
        for killed, guards in kind.kills.items():
            for guard in guards:
                title = f"{killed} killed, {'with' if guard else 'without'} guard"
                stands[title] = kills(kind, Path(folder), killed, guard, count)
    results = {
        "heartbeat_s": HEARTBEAT,
        "until_the_arm_stands": stands,
        "joint_states": {f"{seconds:g} s": states},
    }
    report(options, f"ros{options.version}", results)
    return int(any(row["beyond"] for row in stands.values()))


if __name__ == "__main__":
    sys.exit(main())
