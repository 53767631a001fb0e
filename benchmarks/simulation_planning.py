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
from _processes import client

from aioduco._wire.rpc import Op
from aioduco.models.pose import Pose
from aioduco.sim.simulator import Simulator

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco._wire.rpc import RpcClient

    #: asks for a motion that takes long to plan, without waiting for its end
    Ask = Callable[[RpcClient], object]

#: of what others wait for while a motion is planned, asked for at most [ms]
WAIT = 2.0
WAY, SWINGS = 0.3, 300
#: shapes of weaving, by their numbers
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


def line(start: Pose, robot: RpcClient, *, v: float = 0.02) -> None:
    robot.movel(list(start.shifted(y=WAY)), v, 1.0, 0.0, [], "", "", False, Op(), False)


def spline(start: Pose, robot: RpcClient) -> None:
    poses = [list(start.shifted(x=0.02 * math.sin(0.5 * i), y=WAY * i / 50)) for i in range(1, 51)]
    robot.spline(poses, 0.1, 1.0, "", "", False, Op(), 0.0, False)


def spiral(start: Pose, robot: RpcClient) -> None:
    centre, turns = list(start.shifted(x=0.05)), 100.0
    ways = (turns, 0.05, 0.01, 0)
    robot.move_spiral(centre, list(start), *ways, 0.1, 1.0, [], "", "", False, Op(), False)


def chain(start: Pose, robot: RpcClient) -> None:
    """Fifty short lines that blend, one behind the other."""
    for i in range(1, 51):
        pose = list(start.shifted(x=0.01 * (i % 2), y=WAY * i / 50))
        robot.movel(pose, 0.1, 1.0, 0.002, [], "", "", False, Op(), False)


def asks(port: int, quick: bool) -> Iterator[Ask]:
    """Enable the arm, and give what asks for each motion."""
    with client(port) as robot:
        robot.power_on(True)
        robot.enable(True)
        start = Pose.of(robot.get_tcp_pose())
        for name, shape in SHAPES.items():
            if not quick or name in ("sine", "trapezoid"):
                weave: Any = (
                    shape,
                    0,
                    SWINGS * 0.02 / WAY,
                    0.004,
                    0.0,
                    0.0,
                    0.0,
                    [0, 0],
                    False,
                    [],
                )
                robot.combine_motion_config(*weave)
                robot.enable_combine_motion()
                yield partial(line, start)
                robot.disable_combine_motion()
        for motion in (spline, spiral, chain):
            yield partial(motion, start)


def longest_held(quick: bool) -> float:
    """The longest that the controller's lock was held while a motion was planned [s]."""
    with Simulator() as sim:
        runtime: Any = sim._running().runtime
        runtime._lock = runtime.planning._lock = lock = WatchedLock()
        longest = 0.0
        for ask in asks(sim.port, quick):
            with client(sim.port) as robot:
                lock.held.clear()
                ask(robot)
                longest = max(longest, *lock.held)
                robot.stop(True)
        return longest


def longest_stops(quick: bool) -> tuple[float, float]:
    """The longest that a stop waited while a motion was planned, and while none was [s]."""
    count = 5 if quick else 20
    waits: list[float] = []
    idle: list[float] = []

    def stop() -> float:
        began = time.perf_counter()
        robot.stop(False)
        return time.perf_counter() - began

    def alone(ask: Ask) -> None:
        with client(sim.port) as other:  # no other thread may use this connection
            ask(other)

    with Simulator.spawn() as sim, client(sim.port) as robot:
        for ask in asks(sim.port, quick):
            began = time.perf_counter()
            alone(ask)
            took = time.perf_counter() - began
            robot.stop(True)
            # at as many moments of planning
            for number in range(count):
                asking = threading.Thread(target=alone, args=(ask,))
                asking.start()
                time.sleep(took * (number + 0.5) / count)
                waits.append(stop())
                asking.join()
                robot.stop(True)
                time.sleep(0.05)
                idle.append(stop())
    return max(waits), max(idle)


def measure(quick: bool) -> dict[str, dict[str, Any]]:
    """What is asked for of long plans, and what was found; beside it, what the machine does."""
    lock = round(1e3 * longest_held(quick), 3)
    planning, idle = (round(1e3 * each, 3) for each in longest_stops(quick))
    return {
        "longest under the lock while planning [ms]": at_most(WAIT, lock),
        "longest stop while planning [ms]": at_most(WAIT, planning),
        "longest stop while nothing is planned [ms]": {"asked": "", "found": idle, "reached": ""},
    }
