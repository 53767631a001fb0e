"""The simulated arm: what it costs, how fast its time can run, how well it answers and follows.

    python benchmarks/simulation.py [--quick] [--save]

The first rows say what is asked for and whether it was reached: by a simulator in a process of its
own, on a core of its own, whose arm moves all the time. Run it on a quiet machine with two cores.
What it takes for a cycle is compared with the same motions through the planner and MuJoCo alone,
and with force control between the two: the p50 of all together.

Then come motions that take long to plan: what that takes in all, for how long the controller's lock
is held meanwhile, and how long a stop waits that comes in the middle.
"""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import simulation_planning
from _common import arguments, percentile, print_table, write_results
from simulation_service import DAMPING, HOME, MODEL, PUSH, WAY, judged, measure

from aioduco.kinematics import Arm, arm
from aioduco.sim.cycle import SensedState
from aioduco.sim.force.control import AdmittanceLaw, ForceControl
from aioduco.sim.force.sensor import ForceAxes
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.segments import joint_move

if TYPE_CHECKING:
    from aioduco.sim.planner.path import JointSetPoint

CYCLE = 0.001


def to_and_fro(any_arm: Arm, mover: Mover) -> None:
    """Queue the motions that the whole simulator is measured by."""
    for key in range(4):
        goal = HOME - WAY if key % 2 else HOME + WAY
        mover.append(key, partial(joint_move, any_arm, q1=goal, v=1.0, a=3.0))


class GivingWay:
    """Force control between planner and physics, which moves the tool to and fro all the time."""

    def __init__(self, any_arm: Arm, mover: Mover, world: World) -> None:
        self._mover, self._world, self._time = mover, world, 0.0
        self.control = ForceControl(any_arm, CYCLE)
        self.control.start(mover.setpoint)

    def tick(self, setpoint: JointSetPoint) -> JointSetPoint:
        """The set-point of the drives, as the controller makes it."""
        control, now = self.control, self._world.reading()
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
    """Go to and fro; the costs of ticks and steps.

    Args:
        any_arm: the arm.
        repeats: how often.
        forced: whether force control gives way meanwhile, which counts as part of the tick.
    """
    ticks: list[float] = []
    steps: list[float] = []
    for _ in range(repeats):
        world, mover = World(any_arm, CYCLE, HOME), Mover(any_arm, HOME, CYCLE)
        to_and_fro(any_arm, mover)
        giving = GivingWay(any_arm, mover, world) if forced else None
        setpoint = mover.setpoint
        while mover.moving:
            began = time.perf_counter()
            setpoint = mover.tick().setpoint
            if giving is not None:
                setpoint = giving.tick(setpoint)
            ticked = time.perf_counter()
            world.step(setpoint)
            steps.append(time.perf_counter() - ticked)
            ticks.append(ticked - began)
    both = sorted(a + b for a, b in zip(ticks, steps, strict=True))
    return {
        "tick_us": round(percentile(sorted(ticks), 50) * 1e6, 2),
        "step_us": round(percentile(sorted(steps), 50) * 1e6, 2),
        "both_us": round(percentile(both, 50) * 1e6, 2),
        "p99_us": round(percentile(both, 99) * 1e6, 2),
        "x_real_time": round(len(both) * CYCLE / sum(both), 1),
        "cycles": len(both),
    }


def main() -> None:
    options = arguments(__doc__, "simulation")
    planning = simulation_planning.measure(options.quick)
    service = measure(options.quick)
    repeats = 1 if options.quick else 3
    results = {
        MODEL: cycles(arm(MODEL), repeats),
        f"{MODEL}, force control": cycles(arm(MODEL), repeats, forced=True),
    }
    work, forced = (row["both_us"] for row in results.values())
    asked = judged(service["clock"], service["calls_while_moving"], work, forced)
    asked |= simulation_planning.judged(planning)
    tables = {"asked_for": asked} | service | {"long_plans": planning, "cycles": results}
    for title, table in tables.items():
        rows = [[name, *row.values()] for name, row in table.items()]
        print_table(title.replace("_", " "), ["", *next(iter(table.values()))], rows)
    if options.save:
        print(f"written: {write_results('simulation', tables)}")


if __name__ == "__main__":
    main()
