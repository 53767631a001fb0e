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
import threading
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import simulation_planning
from _common import at_least, at_most, parser, percentile, report
from _processes import ServerProcess, client, processor_time

from aioduco._wire.rpc import Op
from aioduco.kinematics import Arm, arm
from aioduco.sim.cycle import SensedState
from aioduco.sim.force.control import AdmittanceLaw, ForceControl
from aioduco.sim.force.sensor import ForceAxes
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.segments import joint_move

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco._wire.rpc import RpcClient
    from aioduco.sim.planner.path import JointSetPoint

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


# -- a simulator in a process of its own ---------------------------------------------------------


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
    with ServerProcess("simulator.py", speed) as server, client(server.ports[0]) as robot:
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
            times = float(server.ask("?")), processor_time(server.process.pid), time.perf_counter()
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
        calls, begin = 0, time.perf_counter()
        while (took := time.perf_counter() - begin) < seconds:
            robot.get_robot_state()
            calls += 1
    return round(calls / took)


# -- planner and physics alone -------------------------------------------------------------------


class GivingWay:
    """Force control between planner and physics, which moves the tool to and fro all the time."""

    def __init__(self, any_arm: Arm, start: JointSetPoint, world: World) -> None:
        self._world, self._time = world, 0.0
        self._control = ForceControl(any_arm, CYCLE)
        self._control.start(start)

    def tick(self, setpoint: JointSetPoint) -> JointSetPoint:
        """The set-point of the drives, as the controller makes it."""
        control, now = self._control, self._world.reading()
        if control.law is None or self._time % 1.0 < CYCLE:
            push = PUSH if control.law is None else -control.law.target[2]
            control.law = AdmittanceLaw(
                (False, False, True, False, False, False),
                (0.0, 0.0, push, 0.0, 0.0, 0.0),
                (DAMPING,) * 6,
                (0.05,) * 6,
                (0.0,) * 6,
                ForceAxes(np.eye(4), np.eye(4)),
            )
        self._time += CYCLE
        sensed = SensedState(self._time, 0.0, now.q, now.qd, now.wrench, now.external_torque)
        drives, outcome = control.tick(setpoint, sensed, compliant=True)
        if outcome is not None:
            raise RuntimeError(f"force control cannot follow: {outcome.message}")
        return drives


def cycles(any_arm: Arm, repeats: int, *, forced: bool = False) -> dict[str, Any]:
    """Go to and fro; the costs of ticks and steps together, and of steps alone.

    Args:
        any_arm: the arm.
        repeats: how often.
        forced: whether force control gives way meanwhile, which counts as part of the tick.
    """
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


# -- all of it -----------------------------------------------------------------------------------


def judged(
    clock: dict[str, dict[str, float]], calls: int, cycle: dict[str, dict[str, Any]]
) -> dict[str, dict[str, Any]]:
    """What is asked for of the simulator, and what was found."""
    rows: dict[str, dict[str, Any]] = {}
    for case, model in (("", MODEL), ("force control, ", f"{MODEL}, force control")):
        alone = cycle[model]["both_us"]
        kept = round(alone / clock[f"{case}without the clock"]["cpu_per_cycle_us"], 2)
        name = f"{case}without the clock, of the speed of tick and step alone"
        rows[name] = at_least(KEPT, kept)
        times = round(clock[f"{case}in real time"]["cpu_per_cycle_us"] / alone, 2)
        rows[f"{case}in real time, times tick and step alone"] = at_most(WAKING, times)
    share, fast = clock["in real time"]["core_percent"], clock["without the clock"]["x_real_time"]
    return rows | {
        "one arm at 1 kHz in real time, % of a core": at_most(100 * SHARE, share),
        "without the clock, server included, times real time": at_least(TIMES, fast),
        "calls a second to one client while moving": at_least(CALLS, calls),
    }


def main() -> None:
    options = parser(__doc__).parse_args()
    waits = simulation_planning.measure(options.quick)
    seconds, repeats = (2.0, 1) if options.quick else (15.0, 3)
    clock = {
        "in real time": share("1", seconds),
        "without the clock": share("inf", seconds),
        "force control, in real time": share("1", seconds, forced=True),
        "force control, without the clock": share("inf", seconds, forced=True),
    }
    cycle = {
        MODEL: cycles(arm(MODEL), repeats),
        f"{MODEL}, force control": cycles(arm(MODEL), repeats, forced=True),
    }
    tables = {
        "asked_for": judged(clock, calls_a_second(seconds), cycle) | waits,
        "clock": clock,
        "cycles": cycle,
    }
    report(options, "simulation", tables)


if __name__ == "__main__":
    main()
