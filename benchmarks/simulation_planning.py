"""Long plans in the simulated controller: how long others wait while a motion is planned.

Its lock is watched in a simulator in this process. How long a stop waits that comes in the middle
is measured at one in a process of its own, as a program would see it, and beside it the same stop
while nothing is planned.
"""

from __future__ import annotations

import math
import threading
import time
from functools import partial
from typing import TYPE_CHECKING, Any

from _common import at_most
from simulator import client

from aioduco._wire.rpc import Op
from aioduco.models.pose import Pose
from aioduco.sim.simulator import Simulator

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

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


def watched(sim: Simulator) -> WatchedLock:
    """The lock of a running simulator, which notes from now on."""
    runtime: Any = sim._running().runtime
    lock = WatchedLock()
    runtime._lock = runtime.planning._lock = lock
    return lock


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


def planned(port: int, lock: WatchedLock, ask: Ask) -> dict[str, float]:
    """Ask for a motion; what its plan cost [s]."""
    with client(port) as robot:
        lock.held.clear()
        began = time.perf_counter()
        ask(robot)
        took = time.perf_counter() - began
        longest = max(lock.held)
        robot.stop(True)
    return {"plan": took, "lock_max": longest}


def stopped(port: int, ask: Ask, count: int) -> dict[str, float]:
    """Stop in the middle of planning, at as many moments, and as often while nothing is planned."""
    waits: list[float] = []
    idle: list[float] = []

    def alone() -> None:
        with client(port) as robot:  # no other thread may use this connection
            ask(robot)

    with client(port) as other:
        began = time.perf_counter()
        alone()
        took = time.perf_counter() - began
        other.stop(True)
        for number in range(count):
            asking = threading.Thread(target=alone)
            asking.start()
            time.sleep(took * (number + 0.5) / count)
            waits.append(_stop(other))
            asking.join()
            other.stop(True)
            time.sleep(0.05)
            idle.append(_stop(other))
    return {"stop_waits_max": max(waits), "idle_stop_max": max(idle)}


def _stop(robot: RpcClient) -> float:
    began = time.perf_counter()
    robot.stop(False)
    return time.perf_counter() - began


def measure(quick: bool) -> dict[str, dict[str, float]]:
    """A row for each motion that takes long to plan, in real time and with the arm enabled."""
    rows: dict[str, dict[str, float]] = {}
    with Simulator() as sim:
        lock = watched(sim)
        for name, ask in asks(sim.port, quick):
            rows[name] = planned(sim.port, lock, ask)
    with Simulator.spawn() as spawned:
        for name, ask in asks(spawned.port, quick):
            rows[name] |= stopped(spawned.port, ask, 5 if quick else 20)
    return {
        name: {f"{key}_ms": round(1e3 * each, 3) for key, each in row.items()}
        for name, row in rows.items()
    }


def asks(port: int, quick: bool) -> Iterator[tuple[str, Ask]]:
    """Enable the arm, and name each motion with what asks for it."""
    with client(port) as robot:
        robot.power_on(True)
        robot.enable(True)
        start = Pose.of(robot.get_tcp_pose())
        for name, shape in SHAPES.items():
            if not quick or name in ("sine", "trapezoid"):
                weave(robot, shape, SWINGS)
                yield f"weave of {SWINGS} swings, {name}", partial(line, start)
                robot.disable_combine_motion()
        long = {"spline of 50 poses": spline, "spiral of 100 turns": spiral, "50 lines": chain}
        for name, ask in long.items():
            yield name, partial(ask, start)


def judged(rows: dict[str, dict[str, float]]) -> dict[str, dict[str, Any]]:
    """What is asked for of long plans, and what was found; beside it, what the machine does."""
    lock, stop, idle = (
        max(row[key] for row in rows.values())
        for key in ("lock_max_ms", "stop_waits_max_ms", "idle_stop_max_ms")
    )
    return {
        "longest under the lock while planning [ms]": at_most(WAIT, lock),
        "longest stop while planning [ms]": at_most(WAIT, stop),
        "longest stop while nothing is planned [ms]": {"asked": "", "found": idle, "reached": ""},
    }
