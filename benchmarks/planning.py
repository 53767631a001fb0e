"""Planning: how often and how fast a free way is found, and whether it is free; beside movej2.

    python benchmarks/planning.py [--quick] [--save]

Three scenes (a wall, a shelf with boxes, a narrow slot), three arms, and 100 random queries for
each of the nine: from a configuration on one side to a pose of the flange on the other. A query for
which nothing is found within 1 s of processor time counts as unsolved if the same search, or a
second one with another seed, finds a way within `PATIENCE`; if neither does, it is not known to be
solvable, and another query takes its place. Each plan is checked closely (0.2°, 1 mm), and its
trajectory is followed by the simulator's arm, step by step. `movej2` is the straight way of the
joints to the nearest free solution of the same pose, looked at each mrad. Times are processor time
of the planner's process.

The duration of each fifth plan is compared, on the same curve of the joints, with the best that is
found under the limit of jerk: by the same program, at points four times as close and with barriers
ten times as steep (`tests/planning/test_timing.py` compares it with closed forms).
"""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, NamedTuple
from unittest.mock import patch

import numpy as np
from _common import parser, percentile, report

from aioduco import Joints, Pose
from aioduco.errors import NoPathFound
from aioduco.kinematics import arm as arm_of
from aioduco.models.rotation import matrix_from_rpy
from aioduco.planning import Planner, Scene, time_law, timing
from aioduco.planning.search import straight
from aioduco.planning.spline import BSpline
from aioduco.planning.timing import timed
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.scene import Box, mjcf_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning import Plan
    from aioduco.planning.collision import CollisionChecker

    Points = NDArray[np.float64]

ARMS = ("gcr3_618", "gcr5_910", "gcr10_1300")
V, A = 1.5, 3.0
#: s of processor time that each of two searches for a way may take
PATIENCE = 20.0
#: durations are compared for one plan of so many
SOME = 5
DOWN, AHEAD = (np.pi, 0.0, 0.0), (0.0, 0.5 * np.pi, 0.0)


Triple = tuple[float, float, float]


class Side(NamedTuple):
    """Where poses are drawn: corners of a box [of the arm's reach], and how the flange points."""

    low: Triple
    high: Triple
    facing: Triple
    tilt: float


class Setting(NamedTuple):
    """Boxes, each with centre and size [of the reach], and the sides that queries lead between."""

    boxes: dict[str, tuple[Triple, Triple]]
    start: Side
    goal: Side


SCENES = {
    "wall": Setting(
        {"wall": ((0.65, 0.0, 0.4), (0.6, 0.05, 0.8))},
        Side((0.4, 0.15, 0.25), (0.8, 0.6, 0.8), DOWN, 0.6),
        Side((0.4, -0.6, 0.25), (0.8, -0.15, 0.8), DOWN, 0.6),
    ),
    "shelf": Setting(
        {
            "board0": ((0.8, 0.0, 0.25), (0.35, 1.0, 0.02)),
            "board1": ((0.8, 0.0, 0.65), (0.35, 1.0, 0.02)),
            "board2": ((0.8, 0.0, 1.05), (0.35, 1.0, 0.02)),
            "side0": ((0.8, -0.5, 0.65), (0.35, 0.02, 0.82)),
            "side1": ((0.8, 0.5, 0.65), (0.35, 0.02, 0.82)),
            "back": ((0.975, 0.0, 0.65), (0.02, 1.0, 0.82)),
            "box0": ((0.8, 0.3, 0.33), (0.12, 0.1, 0.14)),
            "box1": ((0.8, -0.2, 0.32), (0.1, 0.12, 0.12)),
            "box2": ((0.8, 0.1, 0.72), (0.1, 0.1, 0.12)),
        },
        Side((0.1, -0.7, 0.3), (0.55, 0.7, 0.9), AHEAD, 0.8),
        Side((0.66, -0.42, 0.35), (0.8, 0.42, 0.95), AHEAD, 0.3),
    ),
    "slot": Setting(
        {
            "below": ((0.62, 0.0, 0.175), (0.03, 1.8, 0.35)),
            "above": ((0.62, 0.0, 1.075), (0.03, 1.8, 0.65)),
            "left": ((0.62, 0.55, 0.55), (0.03, 0.7, 0.4)),
            "right": ((0.62, -0.55, 0.55), (0.03, 0.7, 0.4)),
        },
        Side((0.1, -0.6, 0.3), (0.45, 0.6, 0.9), AHEAD, 0.8),
        Side((0.68, -0.1, 0.45), (0.85, 0.1, 0.65), AHEAD, 0.4),
    ),
}


def draw(
    arm: Arm, setting: Setting, checker: CollisionChecker, random: Any
) -> tuple[Points, Pose, Points]:
    """A start and a goal that are free and within reach, and the goal's nearest free solution."""

    def free(side: Side, near: Points) -> tuple[Pose, Points]:
        while True:
            pose = np.eye(4)
            tilt = random.uniform(-side.tilt, side.tilt, 3)
            pose[:3, :3] = matrix_from_rpy(np.array(side.facing)) @ matrix_from_rpy(tilt)
            pose[:3, 3] = random.uniform(np.array(side.low), np.array(side.high)) * arm.reach
            found = [q for q in arm.ikine_all(pose) if checker.free(q)]
            if found:
                return Pose.from_matrix(pose), min(found, key=lambda q: np.abs(q - near).sum())

    home = np.array([0.0, 0.0, 0.5 * np.pi, 0.0, -0.5 * np.pi, 0.0])
    start = free(setting.start, home)[1]
    return start, *free(setting.goal, start)


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


def compared(plan: Plan) -> float:
    """The duration on the path of a plan, to the best under the jerk limit."""
    q = plan.trajectory.positions
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
    rows = np.unique(np.searchsorted(length, np.arange(0.0, length[-1], 0.01)))
    rows = np.append(rows[length[rows] < length[-1] - 5e-3], len(q) - 1)
    curve = BSpline.through(length[rows], q[rows])
    usual = float(timed(curve, plan.limits).times[-1])
    finer = patch.multiple(timing, _TICK=0.002)
    with finer, patch.multiple(time_law, _HARD=2e-4, _ENOUGH=4e-4):
        best = min(float(timed(curve, plan.limits).times[-1]), usual)
    return usual / best


def measure(arm: Arm, setting: Setting, number: int) -> dict[str, Any]:
    """One scene and one arm."""
    random = np.random.default_rng(7)

    def scaled(share: Triple) -> Triple:
        x, y, z = share
        return x * arm.reach, y * arm.reach, z * arm.reach

    boxes = setting.boxes.items()
    things = [Box(at=scaled(at), size=scaled(size), name=name) for name, (at, size) in boxes]
    scene = Scene(arm, things)
    checker = scene.checker()
    world = World(arm, scene=mjcf_of(things, free=False))

    def untouched(q: Points) -> bool:
        return not scene.collides(Joints.of(q))

    took: list[float] = []
    shares: list[float] = []
    late = obstructed = touched = collided = dropped = 0
    with Planner(scene) as planner, Planner(scene, seed=2) as other:
        planner.plan_blocking(Joints.of([0.0] * 6), Joints.of([0.1] + [0.0] * 5))  # starts it
        done = 0
        while done < number:
            start, goal, direct = draw(arm, setting, checker, random)
            plan = None
            for each in (planner, other):
                with contextlib.suppress(NoPathFound):
                    plan = each.plan_blocking(start, goal, v=V, a=A, timeout=PATIENCE)
                    break
            if plan is None:
                dropped += 1
                continue
            done += 1
            late += each is other or plan.searching + plan.timing > 1.0
            took.append(plan.searching + plan.timing)
            if done % SOME == 1:
                shares.append(compared(plan))
            obstructed += not plan.check(scene)
            touched += bool(touches(world, plan))
            collided += not straight(untouched, start, direct, 0.001)
    return {
        "queries": number,
        "solved_in_1_s_percent": round(100.0 * (number - late) / number, 1),
        "not_known_to_be_solvable": dropped,
        "with_times_p50_ms": round(percentile(took, 50) * 1e3, 1),
        "with_times_p95_ms": round(percentile(took, 95) * 1e3, 1),
        "fails_the_dense_check": obstructed,
        "touches_in_the_simulator": touched,
        "movej2_collides_percent": round(100.0 * collided / number, 1),
        "with_jerk_limit_of_the_best_p50": round(percentile(shares, 50), 3),
        "with_jerk_limit_of_the_best_p95": round(percentile(shares, 95), 3),
    }


def main() -> None:
    options = parser(__doc__).parse_args()
    figures = {
        f"{name}, {model}": measure(arm_of(model), setting, 5 if options.quick else 100)
        for name, setting in SCENES.items()
        for model in ARMS
    }
    report(options, "planning", {"planning": figures})


if __name__ == "__main__":
    main()
