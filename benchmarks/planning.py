"""Planning: how often and how fast a free way is found, and whether it is free; beside movej2.

    python benchmarks/planning.py [--quick] [--save]

Three scenes (a wall, a shelf with boxes, a narrow slot), three arms, and 100 random queries each:
from a configuration on one side to a pose of the flange on the other. A query for which nothing is
found within 1 s counts as unsolved if another search finds a way within 20 s; if that does not
either, it is not known to be solvable, and another query takes its place. Each plan is checked
closely (0.2°, 1 mm), and its trajectory is followed by the simulator's arm, step by step. `movej2`
is the straight way of the joints to the nearest free solution of the same pose, looked at as
closely. Times are those of the planner's process; the whole is that of the call.

TOPP-RA's durations are for the same path and the same limits of speed and acceleration, without
one of jerk, on a grid of its own.

With `pip install tesseract-robotics` in another environment, named by `--tesseract PYTHON`, its
RRT-Connect plans the same queries between the same joints in the same run, with the same padding
and shapes.
"""

from __future__ import annotations

import argparse
import itertools
import json
import logging
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import toppra
import toppra.constraint
from _common import HERE, percentile, print_table, write_results
from planning_tesseract import srdf, urdf

from aioduco import Joints, Pose
from aioduco.errors import PlanningError
from aioduco.kinematics import arm as arm_of
from aioduco.models.rotation import matrix_from_rpy
from aioduco.planning import Planner, Scene
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.scene import Box, mjcf_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning import Plan
    from aioduco.planning.collision import CollisionChecker

    Points = NDArray[np.float64]

ARMS = ("gcr3_618", "gcr5_910", "gcr10_1300")
V, A = 1.5, 3.0
LONG = 20.0
DOWN, AHEAD = (np.pi, 0.0, 0.0), (0.0, 0.5 * np.pi, 0.0)


class Side(NamedTuple):
    """Where poses are drawn: corners of a box [of the arm's reach], and how the flange points."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    facing: tuple[float, float, float]
    tilt: float


class Setting(NamedTuple):
    """A scene with the two sides that queries lead between."""

    things: list[Box]
    start: Side
    goal: Side


def wall(r: float) -> Setting:
    things = [Box(at=(0.65 * r, 0, 0.4 * r), size=(0.6 * r, 0.05 * r, 0.8 * r), name="wall")]
    low, high = (0.4, 0.15, 0.25), (0.8, 0.6, 0.8)
    other = Side((0.4, -0.6, 0.25), (0.8, -0.15, 0.8), DOWN, 0.6)
    return Setting(things, Side(low, high, DOWN, 0.6), other)


def shelf(r: float) -> Setting:
    x, wide, deep, thick = 0.8 * r, 1.0 * r, 0.35 * r, 0.02 * r
    things = [
        Box(at=(x, 0, z * r), size=(deep, wide, thick), name=f"board{i}")
        for i, z in enumerate((0.25, 0.65, 1.05))
    ]
    things += [
        Box(at=(x, s * 0.5 * wide, 0.65 * r), size=(deep, thick, 0.82 * r), name=f"side{i}")
        for i, s in enumerate((-1, 1))
    ]
    things += [
        Box(at=(x + 0.5 * deep, 0, 0.65 * r), size=(thick, wide, 0.82 * r), name="back"),
        Box(at=(x, 0.3 * r, 0.33 * r), size=(0.12 * r, 0.1 * r, 0.14 * r), name="box0"),
        Box(at=(x, -0.2 * r, 0.32 * r), size=(0.1 * r, 0.12 * r, 0.12 * r), name="box1"),
        Box(at=(x, 0.1 * r, 0.72 * r), size=(0.1 * r, 0.1 * r, 0.12 * r), name="box2"),
    ]
    within = Side((0.66, -0.42, 0.35), (0.8, 0.42, 0.95), AHEAD, 0.3)
    return Setting(things, Side((0.1, -0.7, 0.3), (0.55, 0.7, 0.9), AHEAD, 0.8), within)


def slot(r: float) -> Setting:
    x, thick, middle, gap = 0.62 * r, 0.03 * r, 0.55 * r, 0.4 * r
    wide, high = 1.8 * r, 1.4 * r
    low = middle - 0.5 * gap
    top = high - middle - 0.5 * gap
    side = 0.5 * (wide - gap)
    things = [
        Box(at=(x, 0, 0.5 * low), size=(thick, wide, low), name="below"),
        Box(at=(x, 0, high - 0.5 * top), size=(thick, wide, top), name="above"),
        Box(at=(x, 0.5 * (gap + side), middle), size=(thick, side, gap), name="left"),
        Box(at=(x, -0.5 * (gap + side), middle), size=(thick, side, gap), name="right"),
    ]
    beyond = Side((0.68, -0.1, 0.45), (0.85, 0.1, 0.65), AHEAD, 0.4)
    return Setting(things, Side((0.1, -0.6, 0.3), (0.45, 0.6, 0.9), AHEAD, 0.8), beyond)


SCENES: dict[str, Callable[[float], Setting]] = {"wall": wall, "shelf": shelf, "slot": slot}


class Query(NamedTuple):
    start: Joints
    goal: Pose
    direct: Joints


def draw(arm: Arm, setting: Setting, checker: CollisionChecker, random: Any) -> Query:
    """A query whose start and goal are free and within reach."""

    def free(side: Side, near: Points) -> tuple[Pose, list[Points]]:
        while True:
            pose = np.eye(4)
            tilt = random.uniform(-side.tilt, side.tilt, 3)
            pose[:3, :3] = matrix_from_rpy(np.array(side.facing)) @ matrix_from_rpy(tilt)
            pose[:3, 3] = random.uniform(np.array(side.low), np.array(side.high)) * arm.reach
            found = [q for q in arm.ikine_all(pose) if checker.free(q)]
            if found:
                return Pose.from_matrix(pose), sorted(found, key=lambda q: np.abs(q - near).sum())

    home = np.array([0.0, 0.0, 0.5 * np.pi, 0.0, -0.5 * np.pi, 0.0])
    start = free(setting.start, home)[1][0]
    pose, goals = free(setting.goal, start)
    return Query(Joints.of(start), pose, Joints.of(goals[0]))


def straight_collides(arm: Arm, checker: CollisionChecker, query: Query) -> bool:
    """Whether plain movej2 to the goal's nearest free solution would touch something."""
    start, goal = query.start.array, arm.ikine(query.goal, query.direct)
    goal = query.direct.array
    count = int(np.ceil(np.abs(goal - start) @ checker.radii / 0.001)) + 1
    checker.padding = 0.0
    try:
        shares = np.linspace(0.0, 1.0, count)[:, None]
        return not all(checker.free(q) for q in start + shares * (goal - start))
    finally:
        checker.padding = 0.005


def touches(world: World, plan: Plan) -> str:
    """What the simulator's arm touches as it follows the plan, step by step; empty for nothing."""
    world.reset(plan.start.array)
    times = np.arange(0.0, plan.duration + 0.3, 0.001)
    curve = plan.trajectory.curve(plan.start)
    q, qd = curve.at(times), curve.velocity(times)
    qdd = np.gradient(qd, 0.001, axis=0)
    for row in range(len(times)):
        world.step(JointSetPoint(q[row], qd[row], qdd[row]))
        if world.data.ncon:
            return world.touched()
    return ""


def beyond_limits(plan: Plan) -> float:
    """The largest share of a limit by differences of the positions; 1 is the limit itself."""
    step = 0.0005
    times = np.arange(0.0, plan.duration, step)
    q = plan.trajectory.curve(plan.start).at(times)
    shares = []
    for order, limit in enumerate(plan.limits.arrays, start=1):
        change = np.diff(q, order, axis=0) / step**order
        shares.append(float((np.abs(change) / limit).max(initial=0.0)))
    return max(shares)


def toppra_duration(plan: Plan) -> float:
    """What TOPP-RA makes of the same path, without a limit of jerk [s]."""
    q = plan.trajectory.positions
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
    rows = np.unique(np.searchsorted(length, np.arange(0.0, length[-1], 0.01)))
    rows = np.append(rows[length[rows] < length[-1] - 5e-3], len(q) - 1)
    path = toppra.SplineInterpolator(length[rows], q[rows])
    speed, acceleration, _ = plan.limits.arrays
    law = toppra.algorithm.TOPPRA(
        [
            toppra.constraint.JointVelocityConstraint(np.column_stack([-speed, speed])),
            toppra.constraint.JointAccelerationConstraint(
                np.column_stack([-acceleration, acceleration])
            ),
        ],
        path,
        np.linspace(0.0, length[-1], 400),
        solver_wrapper="seidel",
    )
    return float(law.compute_trajectory().duration)


def measure(arm: Arm, setting: Setting, number: int, collect: list[Any]) -> dict[str, Any]:
    """One scene and one arm."""
    random = np.random.default_rng(7)
    scene = Scene(arm, setting.things)
    checker = scene.checker()
    world = World(arm, scene=mjcf_of(setting.things, free=False))
    path, times, whole, durations, shares, excess = [], [], [], [], [], []
    unsolved = obstructed = touched = collided = dropped = 0
    with Planner(scene) as planner, Planner(scene, seed=2) as other:
        planner.plan_blocking(Joints.of([0.0] * 6), Joints.of([0.1] + [0.0] * 5))  # starts it
        done = 0
        while done < number:
            query = draw(arm, setting, checker, random)
            begin = time.perf_counter()
            try:
                plan = planner.plan_blocking(query.start, query.goal, v=V, a=A, timeout=1.0)
            except PlanningError:
                try:
                    other.plan_blocking(query.start, query.goal, v=V, a=A, timeout=LONG)
                except PlanningError:
                    dropped += 1
                    continue
                unsolved, done = unsolved + 1, done + 1
                continue
            whole.append(time.perf_counter() - begin)
            done += 1
            collect.append([list(query.start), list(plan.end)])
            path.append(plan.searching)
            times.append(plan.searching + plan.timing)
            durations.append(plan.duration)
            shares.append(plan.duration / toppra_duration(plan))
            excess.append(beyond_limits(plan))
            obstructed += not plan.check(scene)
            touched += bool(touches(world, plan))
            collided += straight_collides(arm, checker, query)
    return {
        "queries": number,
        "solved_percent": round(100.0 * (number - unsolved) / number, 1),
        "not_known_to_be_solvable": dropped,
        "path_p50_ms": round(percentile(sorted(path), 50) * 1e3, 1),
        "path_p95_ms": round(percentile(sorted(path), 95) * 1e3, 1),
        "with_times_p50_ms": round(percentile(sorted(times), 50) * 1e3, 1),
        "with_times_p95_ms": round(percentile(sorted(times), 95) * 1e3, 1),
        "whole_call_p50_ms": round(percentile(sorted(whole), 50) * 1e3, 1),
        "fails_the_dense_check": obstructed,
        "touches_in_the_simulator": touched,
        "movej2_collides_percent": round(100.0 * collided / len(path), 1),
        "duration_p50_s": round(percentile(sorted(durations), 50), 2),
        "of_TOPPRA_p50": round(percentile(sorted(shares), 50), 3),
        "of_TOPPRA_p95": round(percentile(sorted(shares), 95), 3),
        "of_TOPPRA_max": round(max(shares), 3),
        "largest_share_of_a_limit": round(max(excess), 5),
    }


def tesseract(
    python: str, arm: Arm, setting: Setting, queries: Sequence[Any]
) -> dict[str, Any] | None:
    """What tesseract's OMPL planner needs for the same queries, in its own environment."""
    with tempfile.TemporaryDirectory() as folder:
        task = Path(folder) / "task.json"
        task.write_text(
            json.dumps({"urdf": urdf(arm, setting.things), "srdf": srdf(arm), "queries": queries}),
            encoding="utf-8",
        )
        done = subprocess.run(
            [python, str(HERE / "planning_tesseract.py"), str(task)],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            print(f"tesseract failed: {done.stderr.strip()[-400:]}", file=sys.stderr)
            return None
        answer = json.loads(done.stdout.splitlines()[-1])
    found = [np.array(each) for each in answer["paths"] if each]
    seconds = sorted(answer["seconds"])
    checker = Scene(arm, setting.things).checker()
    checker.padding = 0.0

    def free(corners: Points) -> bool:
        for one, two in itertools.pairwise(corners):
            count = int(np.ceil(np.abs(two - one) @ checker.radii / 0.001)) + 1
            if not all(checker.free(q) for q in np.linspace(one, two, count)):
                return False
        return True

    return {
        "queries": len(queries),
        "solved_percent": round(100.0 * len(found) / len(queries), 1),
        "path_p50_ms": round(percentile(seconds, 50) * 1e3, 1),
        "path_p95_ms": round(percentile(seconds, 95) * 1e3, 1),
        "path_not_free_between_points": sum(not free(each) for each in found),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="5 queries each, for CI")
    parser.add_argument(
        "--save", action="store_true", help="write benchmarks/results/planning.json"
    )
    parser.add_argument("--tesseract", metavar="PYTHON", help="interpreter that has tesseract")
    options = parser.parse_args()
    logging.getLogger("toppra").setLevel(logging.ERROR)
    number = 5 if options.quick else 100
    figures: dict[str, Any] = {}
    beside: dict[str, Any] = {}
    for name, make in SCENES.items():
        for model in ARMS:
            arm = arm_of(model)
            queries: list[Any] = []
            figures[f"{name}, {model}"] = measure(arm, make(arm.reach), number, queries)
            print(f"{name}, {model}: {figures[f'{name}, {model}']}", flush=True)
            if options.tesseract:
                found = tesseract(options.tesseract, arm, make(arm.reach), queries)
                if found is not None:
                    beside[f"{name}, {model}"] = found
                    print(f"  tesseract: {found}", flush=True)
    keys = ("solved_percent", "path_p50_ms", "with_times_p50_ms", "fails_the_dense_check",
            "touches_in_the_simulator", "movej2_collides_percent", "of_TOPPRA_p50")  # fmt: skip
    rows = [[name, *(row[key] for key in keys)] for name, row in figures.items()]
    print_table("planning", ("scene", *keys), rows)
    if options.save:
        results: dict[str, Any] = {"planning": figures}
        if beside:
            results["tesseract_robotics_OMPL_on_the_same_queries"] = beside
        write_results("planning", results)


if __name__ == "__main__":
    main()
