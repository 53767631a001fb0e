"""The simulated arm: what it costs, how fast its time can run, how well it answers and follows.

    python benchmarks/simulation.py [--quick] [--save]

The first rows say what is asked for and whether it was reached: by a simulator in a process of its
own, on a core of its own, whose arm moves all the time. Run it on a quiet machine with two cores.
Each model makes the same joint moves and lines at its full speed and acceleration, once through
the planner and MuJoCo together. Then come motions that take long to plan: what that takes in all,
for how long the controller's lock is held meanwhile, how long the slices of the work are, and how
long a stop waits that comes in the middle.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
from _common import arguments, percentile, print_table, write_results
from simulation_planning import judged
from simulation_planning import measure as measure_planning
from simulation_service import measure

from aioduco.kinematics import Arm, arm, models
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.segments import joint_move, line_move

if TYPE_CHECKING:
    from aioduco.models.rotation import Array

CYCLE = 0.001
HOME = np.radians([0.0, 0.0, 90.0, 0.0, -90.0, 0.0])
WAY = np.array([1.5, 0.3, -0.4, 1.0, 2.0, 3.0])


def program(any_arm: Arm, mover: Mover) -> list[float]:
    """Queue joint moves and lines, blended. Seconds that each took to plan."""
    v, a = max(any_arm.velocity), max(any_arm.acceleration)
    shift = np.array([0.0, 0.25, -0.1]) * any_arm.reach

    def target(q: Array) -> Array:
        pose = any_arm.fkine(q)
        pose[:3, 3] += shift
        return pose

    plans = (
        lambda q: joint_move(any_arm, q, HOME + WAY, v, a, 0.1),
        lambda q: joint_move(any_arm, q, HOME - 0.5 * WAY, v, a),
        lambda q: joint_move(any_arm, q, HOME, v, a),
        lambda q: line_move(any_arm, q, target(q), 1.0, 5.0, 0.05),
        lambda q: line_move(any_arm, q, any_arm.fkine(HOME), 1.0, 5.0),
    )
    seconds = []
    for key, plan in enumerate(plans):
        began = time.perf_counter()
        mover.append(key, plan)
        seconds.append(time.perf_counter() - began)
    return seconds


def cycles(any_arm: Arm, repeats: int) -> dict[str, Any]:
    """Run the program; costs of ticks and steps, and how the joints follow."""
    ticks: list[float] = []
    steps: list[float] = []
    plans: list[float] = []
    worst = end = 0.0
    for _ in range(repeats):
        world, mover = World(any_arm, CYCLE, HOME), Mover(any_arm, HOME, CYCLE)
        plans += program(any_arm, mover)
        while mover.moving:
            began = time.perf_counter()
            setpoint = mover.tick().setpoint
            ticked = time.perf_counter()
            world.step(setpoint)
            steps.append(time.perf_counter() - ticked)
            ticks.append(ticked - began)
            worst = max(worst, float(np.abs(world.q - setpoint.q).max()))
        end = max(end, float(np.abs(world.q - mover.setpoint.q).max()))
    both = sorted(a + b for a, b in zip(ticks, steps, strict=True))
    return {
        "tick_us": round(percentile(sorted(ticks), 50) * 1e6, 2),
        "step_us": round(percentile(sorted(steps), 50) * 1e6, 2),
        "both_us": round(percentile(both, 50) * 1e6, 2),
        "p99_us": round(percentile(both, 99) * 1e6, 2),
        "x_real_time": round(len(both) * CYCLE / sum(both), 1),
        "plan_ms": round(max(plans) * 1e3, 2),
        "worst_urad": round(worst * 1e6, 1),
        "end_urad": round(end * 1e6, 2),
        "cycles": len(both),
    }


def main() -> None:
    options = arguments(__doc__, "simulation")
    planning = measure_planning(options.quick)
    service = measure(options.quick)
    service["asked_for"] |= judged(planning)
    service["long_plans"] = planning
    for title, table in service.items():
        rows = [[name, *row.values()] for name, row in table.items()]
        print_table(title.replace("_", " "), ["", *next(iter(table.values()))], rows)
    chosen = ("gcr3_618", "gcr5_910", "gcr25_1800") if options.quick else models()
    results = {model: cycles(arm(model), 1 if options.quick else 3) for model in chosen}
    columns = list(next(iter(results.values())))
    rows = [[model, *result.values()] for model, result in results.items()]
    print_table("Cycles of 1 ms", ["model", *columns], rows)
    if options.save:
        path = write_results("simulation", service | {"cycles": results})
        print(f"written: {path}")


if __name__ == "__main__":
    main()
