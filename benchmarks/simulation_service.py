"""What the simulated controller costs as a service: its process, its clock, its answers."""

from __future__ import annotations

import contextlib
import json
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from _common import ServerProcess, at_least, at_most, percentile

from aioduco._wire.connection import Connection
from aioduco._wire.rpc import Op, RpcClient
from aioduco.sim import Simulator

if TYPE_CHECKING:
    from collections.abc import Iterator

#: what is asked for: of a core, of real time, calls a second, and their p99 [ms]
SHARE, TIMES, CALLS, LATENCY = 0.15, 20.0, 5000.0, 1.0
#: what is asked for of a cycle, measured by tick and step of its case alone: which share of their
#: speed it has without the clock, and how many times their time it takes in real time
KEPT, WAKING = 0.7, 2.5
#: the model that the simulator has if it is told none: the measure is of the same
MODEL = "gcr5_910"
#: force control that moves the tool all the time, to and fro: (target - force) / damping
PUSH, DAMPING = 5.0, 1e4
HOME = np.radians([0.0, 0.0, 90.0, 0.0, -90.0, 0.0])
WAY = np.array([1.0, 0.3, -0.3, 0.2, 0.3, 0.5])


@contextlib.contextmanager
def client(port: int) -> Iterator[RpcClient]:
    """A connection below the SDK: each function, blocking."""
    connection = Connection("127.0.0.1", port)
    connection.open()
    try:
        yield RpcClient(lambda name, args: connection.call(name, args, 60.0))
    finally:
        connection.close()


def give_way(robot: RpcClient, push: float) -> None:
    """Have force control keep up a force along the tool's z, which nothing answers."""
    target = [0.0, 0.0, push, 0.0, 0.0, 0.0]
    along = [i == 2 for i in range(6)]
    robot.fc_config(along, target, [DAMPING] * 6, [0.05] * 6, [0.0] * 6, "", "", 0)


def move(port: int, done: threading.Event, forced: bool) -> None:
    """Move to and fro, one blocking joint motion after the other."""
    with client(port) as robot:
        if forced:
            give_way(robot, PUSH)
            robot.fc_start()
        while not done.is_set():
            for goal, push in ((HOME + WAY, PUSH), (HOME - WAY, -PUSH)):
                if forced:
                    give_way(robot, push)
                robot.movej2(goal.tolist(), 1.0, 3.0, 0.0, True, Op(), False)


@contextlib.contextmanager
def moving(speed: str, *, forced: bool = False) -> Iterator[tuple[ServerProcess, RpcClient]]:
    """A simulator in a process of its own, on a core of its own, whose arm moves all the time."""
    with ServerProcess(Path(__file__).name, speed) as server:
        port, done = server.endpoints["port"], threading.Event()
        with client(port) as robot:
            robot.power_on(True)
            robot.enable(True)
            mover = threading.Thread(target=move, args=(port, done, forced))
            mover.start()
            time.sleep(1.0)
            try:
                yield server, robot
            finally:
                done.set()
                mover.join()


def share(speed: str, seconds: float, *, forced: bool = False) -> dict[str, float]:
    """What a second costs: of a core, and how much simulated time it gives."""
    with moving(speed, forced=forced) as (server, robot):
        before, began = json.loads(server.ask("?")), time.perf_counter()
        time.sleep(seconds)
        after, took = json.loads(server.ask("?")), time.perf_counter() - began
        if errors := robot.get_last_error():
            raise RuntimeError(f"the arm did not move all the time: {errors}")
    simulated = after["time"] - before["time"]
    cpu = after["cpu"] - before["cpu"]
    return {
        "core_percent": round(100.0 * cpu / took, 1),
        "x_real_time": round(simulated / took, 2),
        "cpu_per_cycle_us": round(cpu / simulated * 1e3, 1),
        "slipped_s": round(after["slipped"] - before["slipped"], 4),
        "cycle_late_p99_us": round(after["late_p99"] * 1e6, 1),
    }


def calls(seconds: float) -> dict[str, float]:
    """One client asks for the state as fast as it is answered, while the arm moves in real time."""
    with moving("1") as (server, robot):
        took: list[float] = []
        now = began = time.perf_counter()
        while now - began < seconds:
            robot.get_robot_state()
            after = time.perf_counter()
            took.append(after - now)
            now = after
        kept = json.loads(server.ask("?"))
    took.sort()
    return {
        "calls_a_second": round(len(took) / (now - began)),
        "p50_ms": round(percentile(took, 50) * 1e3, 3),
        "p99_ms": round(percentile(took, 99) * 1e3, 3),
        "p99.9_ms": round(percentile(took, 99.9) * 1e3, 3),
        "slipped_s": round(kept["slipped"], 4),
    }


def measure(quick: bool) -> dict[str, Any]:
    """All of it, but for the verdicts."""
    seconds = 2.0 if quick else 15.0
    clock = {
        "in real time": share("1", seconds),
        "without the clock": share("inf", seconds),
        "force control, in real time": share("1", seconds, forced=True),
        "force control, without the clock": share("inf", seconds, forced=True),
    }
    return {"clock": clock, "calls_while_moving": {"get_robot_state": calls(seconds)}}


def judged(
    clock: dict[str, dict[str, float]],
    answers: dict[str, dict[str, float]],
    work: float,
    forced: float,
) -> dict[str, dict[str, Any]]:
    """What is asked for of the service, and what was found.

    Args:
        clock, answers: as `measure` gives them.
        work: what tick and step alone take [µs].
        forced: and with the tick of force control between them [µs].
    """
    real, free = clock["in real time"], clock["without the clock"]
    state = answers["get_robot_state"]
    rows: dict[str, dict[str, Any]] = {}
    for case, alone in (("", work), ("force control, ", forced)):
        kept = round(alone / clock[f"{case}without the clock"]["cpu_per_cycle_us"], 2)
        name = f"{case}without the clock, of the speed of tick and step alone"
        rows[name] = at_least(KEPT, kept)
        times = round(clock[f"{case}in real time"]["cpu_per_cycle_us"] / alone, 2)
        rows[f"{case}in real time, times tick and step alone"] = at_most(WAKING, times)
    return rows | {
        "one arm at 1 kHz in real time, % of a core": at_most(100 * SHARE, real["core_percent"]),
        "without the clock, server included, times real time": at_least(TIMES, free["x_real_time"]),
        "calls a second to one client while moving": at_least(CALLS, state["calls_a_second"]),
        "their p99 [ms]": at_most(LATENCY, state["p99_ms"]),
    }


def main() -> None:
    """A simulator that says where it serves, and answers each line by how well it keeps time."""
    with Simulator(speed=float(sys.argv[1])) as sim:
        print(json.dumps({"port": sim.port}), flush=True)
        for _ in sys.stdin:
            kept = sim.statistics()
            said = {
                "time": sim.time,
                "cpu": time.process_time(),
                "slipped": kept.slipped,
                "late_p99": kept.late_p99,
            }
            print(json.dumps(said), flush=True)


if __name__ == "__main__":
    main()
