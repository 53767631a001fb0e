"""Long plans in the simulated controller: how long others wait while a motion is planned.

The simulator is in this process, so that its lock can be watched; the clients share its
interpreter, which makes what they wait for longer, never shorter.
"""

from __future__ import annotations

import math
import threading
import time
from functools import partial
from typing import TYPE_CHECKING, Any

from _common import percentile
from simulation_service import client

from aioduco._wire.rpc import Op
from aioduco.models.pose import Pose
from aioduco.sim.simulator import Simulator

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.rpc import RpcClient

    #: asks for a motion that takes long to plan, without waiting for its end
    Ask = Callable[[RpcClient], int]

#: of what others wait for while a motion is planned, asked for at most [ms]
WAIT = 2.0
WAY, SWINGS = 0.3, 300
SHAPES = {"triangle": 1, "sine": 2, "circle": 3, "trapezoid": 4, "eight": 5}


class WatchedLock:
    """A lock that notes how much its holder works while it is held [s]: it is never waited in."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._since = 0.0
        self.held: list[float] = []

    def acquire(self) -> bool:
        self._lock.acquire()
        self._since = time.thread_time()
        return True

    def release(self) -> None:
        self.held.append(time.thread_time() - self._since)
        self._lock.release()

    __enter__ = acquire

    def __exit__(self, *_: object) -> None:
        self.release()


class Watch:
    """Watches a running simulator: its lock, and the work in the slices in which it plans [s]."""

    def __init__(self, sim: Simulator) -> None:
        runtime: Any = sim._runtime
        planning = runtime.planning
        self.lock = runtime._lock = planning._lock = WatchedLock()
        self.slices: list[float] = []
        self._since = 0.0
        self._turn, self._take = planning.turn, planning._plan
        planning.turn, planning._plan = self._take_turn, self._plan

    def clear(self) -> None:
        self.lock.held.clear()
        self.slices.clear()

    def _plan(self, planning: object) -> None:
        self._since = time.thread_time()
        self._take(planning)
        self.slices.append(time.thread_time() - self._since)

    def _take_turn(self) -> None:
        self.slices.append(time.thread_time() - self._since)
        self._turn()
        self._since = time.thread_time()


def weave(robot: RpcClient, shape: int, swings: int, v: float = 0.02) -> None:
    """Have the lines that come swing so often on their way."""
    config: Any = (shape, 0, swings * v / WAY, 0.004, 0.0, 0.0, 0.0, [0, 0], False, [])
    robot.combine_motion_config(*config)
    robot.enable_combine_motion()


def line(start: Pose, robot: RpcClient) -> int:
    there = list(start.shifted(y=WAY))
    return robot.movel(there, 0.02, 1.0, 0.0, [], "", "", False, Op(), False)


def spline(start: Pose, robot: RpcClient) -> int:
    poses = [list(start.shifted(x=0.02 * math.sin(0.5 * i), y=WAY * i / 50)) for i in range(1, 51)]
    return robot.spline(poses, 0.1, 1.0, "", "", False, Op(), 0.0, False)


def spiral(start: Pose, robot: RpcClient) -> int:
    centre, turns = list(start.shifted(x=0.05)), 100.0
    ways = (turns, 0.05, 0.01, 0)
    return robot.move_spiral(centre, list(start), *ways, 0.1, 1.0, [], "", "", False, Op(), False)


def chain(start: Pose, robot: RpcClient) -> int:
    """Fifty short lines that blend, one behind the other."""
    id_ = 0
    for i in range(1, 51):
        pose = list(start.shifted(x=0.01 * (i % 2), y=WAY * i / 50))
        id_ = robot.movel(pose, 0.1, 1.0, 0.002, [], "", "", False, Op(), False)
    return id_


def alone(sim: Simulator, ask: Ask) -> None:
    """Ask on a connection of its own, which the thread of another must not use."""
    with client(sim.port) as robot:
        ask(robot)


def measured(sim: Simulator, watch: Watch, ask: Ask) -> dict[str, float]:
    """Ask for a motion, once to its plan's end, and once to stop in the middle."""
    with client(sim.port) as robot, client(sim.port) as other:
        watch.clear()
        began = time.perf_counter()
        ask(robot)
        took = time.perf_counter() - began
        held, parts = sorted(watch.lock.held), sorted(watch.slices)
        other.stop(True)
        waits = []
        for share in (0.25, 0.5, 0.75):
            asking = threading.Thread(target=alone, args=(sim, ask))
            asking.start()
            time.sleep(share * took)
            stopped = time.perf_counter()
            other.stop(False)
            waits.append(time.perf_counter() - stopped)
            asking.join()
            other.stop(True)
    milliseconds = {
        "plan": took,
        "lock_p50": percentile(held, 50),
        "lock_p99": percentile(held, 99),
        "lock_max": held[-1],
        "slice_p50": percentile(parts, 50),
        "slice_p99": percentile(parts, 99),
        "slice_max": parts[-1],
        "stop_waits": max(waits),
    }
    return {f"{name}_ms": round(1e3 * each, 3) for name, each in milliseconds.items()}


def measure(quick: bool) -> dict[str, dict[str, float]]:
    """A row for each motion that takes long to plan, in real time and with the arm enabled."""
    rows: dict[str, dict[str, float]] = {}
    with Simulator() as sim, client(sim.port) as robot:
        robot.power_on(True)
        robot.enable(True)
        watch, start = Watch(sim), Pose.of(robot.get_tcp_pose())
        for name, shape in SHAPES.items():
            if not quick or name in ("sine", "trapezoid"):
                weave(robot, shape, SWINGS)
                rows[f"weave of {SWINGS} swings, {name}"] = measured(
                    sim, watch, partial(line, start)
                )
                robot.disable_combine_motion()
        long = {"spline of 50 poses": spline, "spiral of 100 turns": spiral, "50 lines": chain}
        for name, ask in long.items():
            rows[name] = measured(sim, watch, partial(ask, start))
    return rows


def judged(rows: dict[str, dict[str, float]]) -> dict[str, dict[str, Any]]:
    """Each line: what is asked for, what was found, and whether that is enough."""
    found = {
        "longest under the lock while planning [ms]": max(
            row["lock_max_ms"] for row in rows.values()
        ),
        "longest slice of planning [ms]": max(row["slice_max_ms"] for row in rows.values()),
    }
    return {
        name: {"asked": f"at most {WAIT:g}", "found": value, "reached": value <= WAIT}
        for name, value in found.items()
    }
