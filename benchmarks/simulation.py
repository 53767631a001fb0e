"""The simulated arm: what it costs, how fast its time can run, how well it answers and follows.

    python benchmarks/simulation.py [--quick] [--save]

The first rows say what is asked for and whether it was reached: by a simulator in a process of its
own, on a core of its own, whose arm moves all the time. Run it on a quiet machine with two cores.
What it takes for a cycle is compared with the same motions through the planner and MuJoCo alone,
and with force control between the two: the p50 of all together.

Then come motions that take long to plan: for how long the controller's lock is held meanwhile, and
how long a stop waits that comes in the middle.
"""

from __future__ import annotations

import contextlib
import math
import threading
import time
from functools import partial
from statistics import median
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np
from _common import at_least, at_most, parser, percentile, report
from _processes import ServerProcess, client, processor_time
from rpc import called

from aioduco._wire.rpc import Op
from aioduco.kinematics import Arm, arm
from aioduco.models.pose import Pose
from aioduco.sim import Simulator
from aioduco.sim.cycle import SensedState
from aioduco.sim.force.control import AdmittanceLaw, ForceControl
from aioduco.sim.force.sensor import ForceAxes
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.segments import joint_move

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco._wire.rpc import RpcClient
    from aioduco.sim.planner.path import JointSetPoint

    #: asks for a motion that takes long to plan, without waiting for its end
    Ask = Callable[[RpcClient], object]

Rows = dict[str, dict[str, Any]]

#: what is asked for: of a core, of real time, calls a second
SHARE, TIMES, CALLS = 0.15, 20.0, 5000.0
#: what is asked for of a cycle, measured by tick and step of its case alone: which share of their
#: speed it has without the clock, and how many times their time it takes in real time
KEPT, WAKING = 0.7, 2.5
#: the model that the simulator has if it is told none: the measure is of the same
MODEL = "gcr5_910"
#: force control that moves the tool all the time, to and fro: (target - force) / damping
PUSH, DAMPING = 5.0, 1e4
HOME = np.radians([0.0, 0.0, 90.0, 0.0, -90.0, 0.0])
WAY = np.array([1.0, 0.3, -0.3, 0.2, 0.3, 0.5])
CYCLE = 0.001
#: says where it listens, and answers each line by its time
SIMULATOR = """
import json, sys
from aioduco.sim import Simulator
with Simulator(speed=float(sys.argv[1])) as sim:
    print(json.dumps({"ports": [sim.port]}), flush=True)
    for _ in sys.stdin:
        print(sim.time, flush=True)
"""
#: of what others wait for while a motion is planned, asked for at most [ms]
WAIT = 2.0
#: a line along y [m] with so many swings of a weave, whose shapes have these numbers
LENGTH, SWINGS = 0.3, 300
SHAPES = TRIANGLE, SINE, CIRCLE, TRAPEZOID, EIGHT = range(1, 6)


def law(push: float) -> tuple[Any, Any, Any, Any, Any]:
    """Of force control that keeps up a force along the tool's z, which nothing answers."""
    along = (False, False, True, False, False, False)
    return along, (0.0, 0.0, push, 0.0, 0.0, 0.0), (DAMPING,) * 6, (0.05,) * 6, (0.0,) * 6


def move(port: int, done: threading.Event, forced: bool) -> None:
    """Move to and fro, one blocking joint motion after the other."""
    with client(port) as robot:
        if forced:
            robot.fc_config(*law(PUSH), "", "", 0)
            robot.fc_start()
        while not done.is_set():
            for goal, push in ((HOME + WAY, PUSH), (HOME - WAY, -PUSH)):
                if forced:
                    robot.fc_config(*law(push), "", "", 0)
                robot.movej2(goal.tolist(), 1.0, 3.0, 0.0, True, Op(), False)


@contextlib.contextmanager
def moving(speed: str, *, forced: bool = False) -> Iterator[tuple[ServerProcess, RpcClient]]:
    """A simulator in a process of its own, on a core of its own, whose arm moves all the time."""
    with ServerProcess("-c", SIMULATOR, speed) as server, client(server.ports[0]) as robot:
        robot.power_on(True)
        robot.enable(True)
        done = threading.Event()
        mover = threading.Thread(target=move, args=(server.ports[0], done, forced))
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

        def now() -> Any:
            times = float(server.ask("?")), processor_time(server.pid), time.perf_counter()
            return np.array(times)

        before = now()
        time.sleep(seconds)
        simulated, cpu, took = (now() - before).tolist()
        if errors := robot.get_last_error():
            raise RuntimeError(f"the arm did not move all the time: {errors}")
    return {
        "core_percent": round(100.0 * cpu / took, 1),
        "x_real_time": round(simulated / took, 2),
        "cpu_per_cycle_us": round(cpu / simulated * CYCLE * 1e6, 1),
    }


def calls_a_second(seconds: float) -> int:
    """One client asks for the state as fast as it is answered, while the arm moves in real time."""
    with moving("1") as (_, robot):
        durations = anyio.run(called, robot.get_robot_state, seconds)
    return round(len(durations) / sum(durations))


class GivingWay:
    """Force control between planner and physics, which moves the tool to and fro all the time."""

    def __init__(self, any_arm: Arm, start: JointSetPoint, world: World) -> None:
        self._world, self._cycle, self._push = world, 0, -PUSH
        self._control = ForceControl(any_arm, CYCLE)
        self._control.start(start)

    def tick(self, setpoint: JointSetPoint) -> JointSetPoint:
        """The set-point of the drives, as the controller makes it."""
        now, time = self._world.reading(), self._cycle * CYCLE
        if self._cycle % 1000 == 0:
            self._push = -self._push
            self._control.law = AdmittanceLaw(*law(self._push), ForceAxes(np.eye(4), np.eye(4)))
        self._cycle += 1
        sensed = SensedState(time, 0.0, now.q, now.qd, now.wrench, now.external_torque)
        drives, outcome = self._control.tick(setpoint, sensed, compliant=True)
        if outcome is not None:
            raise RuntimeError(f"force control cannot follow: {outcome.message}")
        return drives


def cycles(repeats: int, *, forced: bool) -> dict[str, Any]:
    """Go to and fro so often; the costs of ticks and steps together, and of steps alone.

    Force control that gives way meanwhile, if it is asked for, counts as part of the tick.
    """
    any_arm = arm(MODEL)
    both: list[float] = []
    steps: list[float] = []
    for _ in range(repeats):
        world, mover = World(any_arm, CYCLE, HOME), Mover(any_arm, HOME, CYCLE)
        for key in range(4):  # as the whole simulator goes
            goal = HOME - WAY if key % 2 else HOME + WAY
            mover.append(key, partial(joint_move, any_arm, q1=goal, v=1.0, a=3.0))
        giving = GivingWay(any_arm, mover.setpoint, world) if forced else None
        while mover.moving:
            began = time.perf_counter()
            setpoint = mover.tick().setpoint
            if giving is not None:
                setpoint = giving.tick(setpoint)
            ticked = time.perf_counter()
            world.step(setpoint)
            ended = time.perf_counter()
            steps.append(ended - ticked)
            both.append(ended - began)
    return {
        "step_us": round(percentile(steps, 50) * 1e6, 2),
        "both_us": round(percentile(both, 50) * 1e6, 2),
        "cycles": len(both),
    }


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


def line(start: Pose, robot: RpcClient) -> None:
    robot.movel(list(start.shifted(y=LENGTH)), 0.02, 1.0, 0.0, [], "", "", False, Op(), False)


def spline(start: Pose, robot: RpcClient) -> None:
    ways = ((0.02 * math.sin(0.5 * i), LENGTH * i / 50) for i in range(1, 51))
    poses = [list(start.shifted(x=x, y=y)) for x, y in ways]
    robot.spline(poses, 0.1, 1.0, "", "", False, Op(), 0.0, False)


def spiral(start: Pose, robot: RpcClient) -> None:
    """A hundred turns."""
    centre, ways = list(start.shifted(x=0.05)), (100.0, 0.05, 0.01, 0)
    robot.move_spiral(centre, list(start), *ways, 0.1, 1.0, [], "", "", False, Op(), False)


def chain(start: Pose, robot: RpcClient) -> None:
    """Fifty short lines that blend, one behind the other."""
    for i in range(1, 51):
        pose = list(start.shifted(x=0.01 * (i % 2), y=LENGTH * i / 50))
        robot.movel(pose, 0.1, 1.0, 0.002, [], "", "", False, Op(), False)


def asks(port: int, quick: bool) -> Iterator[Ask]:
    """Enable the arm, and give what asks for each motion."""
    with client(port) as robot:
        robot.power_on(True)
        robot.enable(True)
        start = Pose.of(robot.get_tcp_pose())
        for shape in (SINE, TRAPEZOID) if quick else SHAPES:
            swings: Any = (SWINGS * 0.02 / LENGTH, 0.004, 0.0, 0.0, 0.0, [0, 0], False, [])
            robot.combine_motion_config(shape, 0, *swings)
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


def longest_stops(quick: bool) -> tuple[float, float, float]:
    """The longest that a stop waited: while a motion was planned, the same as a median of three at
    one moment (what the machine does beside comes at another), and with nothing planned [s].
    """
    count = 5 if quick else 20
    waits: list[float] = []
    idle: list[float] = []

    def timed(step: Callable[[], object]) -> float:
        began = time.perf_counter()
        step()
        return time.perf_counter() - began

    def alone(ask: Ask) -> None:
        with client(sim.port) as other:  # no other thread may use this connection
            ask(other)

    with Simulator.spawn() as sim, client(sim.port) as robot:
        stop = partial(robot.stop, False)
        for ask in asks(sim.port, quick):
            took = timed(partial(alone, ask))
            robot.stop(True)
            for number in range(3 * count):
                asking = threading.Thread(target=alone, args=(ask,))
                asking.start()
                time.sleep(took * (number // 3 + 0.5) / count)
                waits.append(timed(stop))
                asking.join()
                robot.stop(True)
                time.sleep(0.05)
                idle.append(timed(stop))
    return max(waits), max(map(median, zip(*[iter(waits)] * 3, strict=True))), max(idle)


def judged_plans(quick: bool) -> Rows:
    """What is asked for of long plans, and what was found; beside it, what the machine does."""
    lock = round(1e3 * longest_held(quick), 3)
    longest, again, idle = (round(1e3 * each, 3) for each in longest_stops(quick))
    return {
        "longest under the lock while planning [ms]": at_most(WAIT, lock),
        "longest stop while planning [ms]": at_most(WAIT, longest),
        "longest stop while planning, median of three [ms]": at_most(WAIT, again),
        "longest stop while nothing is planned [ms]": {"asked": "", "found": idle, "reached": ""},
    }


def main() -> None:
    options = parser(__doc__).parse_args()
    plans = judged_plans(options.quick)
    seconds, repeats = (2.0, 1) if options.quick else (15.0, 3)
    clock: Rows = {}
    cycle: Rows = {}
    asked: Rows = {}
    for case, forced in (("", False), ("force control, ", True)):
        real = clock[f"{case}in real time"] = share("1", seconds, forced=forced)
        free = clock[f"{case}without the clock"] = share("inf", seconds, forced=forced)
        own = cycle[f"{MODEL}, force control" if forced else MODEL] = cycles(repeats, forced=forced)
        kept = round(own["both_us"] / free["cpu_per_cycle_us"], 2)
        name = f"{case}without the clock, of the speed of tick and step alone"
        asked[name] = at_least(KEPT, kept)
        times = round(real["cpu_per_cycle_us"] / own["both_us"], 2)
        asked[f"{case}in real time, times tick and step alone"] = at_most(WAKING, times)
    usage, fast = clock["in real time"]["core_percent"], clock["without the clock"]["x_real_time"]
    asked |= {
        "one arm at 1 kHz in real time, % of a core": at_most(100 * SHARE, usage),
        "without the clock, server included, times real time": at_least(TIMES, fast),
        "calls a second to one client while moving": at_least(CALLS, calls_a_second(seconds)),
    }
    report(options, "simulation", {"asked_for": asked | plans, "clock": clock, "cycles": cycle})


if __name__ == "__main__":
    main()
