"""Plans are free and within the limits; without one there is a typed error."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import scipy
from for_each import for_each
from interpreter import python

from aioduco import (
    GoalInCollision,
    GoalOutOfReach,
    Joints,
    NoPathFound,
    ParameterError,
    PathIncomplete,
    Pose,
    StartInCollision,
)
from aioduco.kinematics import arm
from aioduco.kinematics.forward import singular_values
from aioduco.planning import Plan, Planner, Region, Scene
from aioduco.planning.problem import goals_of
from aioduco.planning.spaces import UprightPathSpace
from aioduco.sim.scene import Box, Rod

LEFT = Joints.deg(35, -15, 105, 0, -90, 0)
RIGHT = Joints.deg(-50, -15, 105, 0, -90, 0)
INSIDE = Joints.deg(0, 20, 70, 0, -90, 0)
WALL = Box(at=(0.55, 0, 0.35), size=(0.5, 0.04, 0.7), name="wall")


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene("gcr5_910", [WALL])


@pytest.fixture(scope="module")
def planner(scene: Scene) -> Iterator[Planner]:
    with Planner(scene) as made:
        yield made


def straight_collides(scene: Scene, one: Joints, two: Joints) -> bool:
    shares = np.linspace(0.0, 1.0, 200)[:, None]
    return any(scene.collides(Joints.of(q)) for q in one.array + shares * (two.array - one.array))


def excess(plan: Plan) -> float:
    """The largest share of a limit, by differences of what will be sent."""
    step = 0.0005
    q = plan.trajectory.curve(plan.start).at(np.arange(0.0, plan.duration, step))
    return max(
        float((np.abs(np.diff(q, order, axis=0)) / step**order / limit).max())
        for order, limit in enumerate(plan.limits.arrays, start=1)
    )


def free(scene: Scene, plan: Plan) -> bool:
    """By another way than the plan's own check: every millisecond, by the scene."""
    times = np.arange(0.0, plan.duration, 0.004)
    return not any(
        scene.collides(Joints.of(q)) for q in plan.trajectory.curve(plan.start).at(times)
    )


def test_a_way_round_a_wall(scene: Scene, planner: Planner) -> None:
    assert straight_collides(scene, LEFT, RIGHT)
    plan = planner.plan_blocking(LEFT, RIGHT, v=1.5, a=3.0)
    assert plan.start == pytest.approx(LEFT, abs=1e-9)
    assert plan.end == pytest.approx(RIGHT, abs=1e-9)
    found = plan.check(scene)
    assert found, str(found)
    assert found.clearance.distance >= 0.9 * plan.padding
    assert plan.clearance >= 0.9 * plan.padding
    assert free(scene, plan)
    assert excess(plan) <= 1.0
    assert plan.trajectory.velocities is not None
    assert np.abs(plan.trajectory.velocities[[0, -1]]).max() < 1e-9


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.cases(2)
def test_limits_are_kept_for_any_of_them(scene: Scene, planner: Planner, seed: int) -> None:
    random = np.random.default_rng(seed)
    v, a = random.uniform(0.3, 3.0, 6), random.uniform(0.5, 8.0, 6)
    plan = planner.plan_blocking(LEFT, RIGHT, v=v, a=a, jerk=a * random.uniform(4.0, 60.0))
    assert excess(plan) <= 1.0
    assert plan.check(scene)


@pytest.mark.slow
def test_a_pose_behind_a_slot_is_reached_by_whole_turns_and_close_to_things() -> None:
    """The nearest turns have no way, or the goals that have one are closer than the padding."""
    r = arm("gcr3_618").reach
    x, thick, middle, gap, wide, high = 0.62 * r, 0.03 * r, 0.55 * r, 0.4 * r, 1.8 * r, 1.4 * r
    low, top, side = middle - 0.5 * gap, high - middle - 0.5 * gap, 0.5 * (wide - gap)
    slot = [
        Box(at=(x, 0, 0.5 * low), size=(thick, wide, low), name="below"),
        Box(at=(x, 0, high - 0.5 * top), size=(thick, wide, top), name="above"),
        Box(at=(x, 0.5 * (gap + side), middle), size=(thick, side, gap), name="left"),
        Box(at=(x, -0.5 * (gap + side), middle), size=(thick, side, gap), name="right"),
    ]
    scene = Scene("gcr3_618", slot, padding=0.005)
    queries = {
        Joints.deg(-113.6, -18.8, 115.1, 84.8, -75.8, -51.0): Pose(
            0.366348, 0.011659, 0.237652, -2.497639, 1.121128, -2.640692
        ),
        Joints.deg(-144.3, -7.6, 57.8, 130.9, -72.2, -119.0): Pose(
            0.394438, 0.009809, 0.301401, 0.538378, 1.250145, 0.25326
        ),
    }
    with Planner(scene) as planner:
        for start, goal in queries.items():
            plan = planner.plan_blocking(start, goal, v=1.0, a=5.0, timeout=60.0)
            np.testing.assert_allclose(
                scene.arm.fkine(plan.trajectory.positions[-1]), goal.matrix, atol=1e-6
            )
            assert plan.check(scene).ok


SEARCH = """
import sys
from aioduco import Joints
from aioduco.planning import Planner, Scene
from aioduco.planning.collision import CollisionChecker
from aioduco.planning.search import seed
from aioduco.planning.solver import solve
from aioduco.sim.scene import Box

board = Box(at=(0.55, 0, 0.35), size=(0.7, 0.04, 0.7))
roof = Box(at=(0.55, 0, 0.85), size=(0.7, 0.3, 0.04))
behind = Box(at=(-0.5, 0, 0.5), size=(0.5, 0.05, 1.0))
scene = Scene("gcr5_910", [board, roof, behind])
start, goal = Joints.deg(50, 0, 90, 0, -90, 0), Joints.deg(-50, 0, 90, 0, -90, 0)
free = CollisionChecker.free


def later(checker, q, work=range(int(sys.argv[1]))):
    for _ in work:
        pass
    return free(checker, q)


CollisionChecker.free = later
seed(2)
print(solve(Planner(scene)._free(start, goal, timeout=60.0).problem, scene.checker()).corners)
"""


@pytest.mark.slow
def test_a_seed_gives_the_same_path_however_fast_the_computer_is() -> None:
    """Searches were started anew by the clock: a slower computer found another path."""
    fast, slow = (python("-c", SEARCH, work).stdout for work in ("0", "5000"))
    assert fast == slow
    assert "[" in fast


def test_one_of_several_goals_is_enough(scene: Scene, planner: Planner) -> None:
    beyond = Joints(0, 0, 0, 0, 0, 6.4)
    plan = planner.plan_blocking(LEFT, [Pose(3, 0, 0, 0, 0, 0), beyond, INSIDE, RIGHT])
    assert plan.end == pytest.approx(RIGHT, abs=1e-9)
    with pytest.raises(GoalOutOfReach, match="beyond the joint limits"):
        planner.plan_blocking(LEFT, [beyond])


def test_of_the_goals_of_an_upright_tool_those_that_tilt_it_are_none(planner: Planner) -> None:
    here = Pose.from_matrix(planner.scene.arm.fkine(RIGHT))
    near = Joints.of(RIGHT.array + np.deg2rad([10, 0, 0, 0, 0, 0]))
    tilted = here @ Pose(0, 0, 0, 0.3, 0, 0)
    plan = planner.plan_blocking(near, [tilted, here], upright=True)
    assert plan.pose(plan.duration).almost_equal(here)
    plan = planner.plan_blocking(near, Region(here, turn=(0.3, 0.3, 0.0)), upright=True)
    assert plan.pose(plan.duration).almost_equal(here, rotation=1e-3)
    with pytest.raises(GoalOutOfReach, match="tilted"):
        planner.plan_blocking(near, tilted, upright=True)


def test_an_upright_tool_does_not_end_a_whole_turn_from_its_goal(planner: Planner) -> None:
    turned = Joints.of(RIGHT.array + np.array([0.1, 0, 0, 0, 0, 4.0]))
    with pytest.raises(GoalOutOfReach, match=r"joint 6 is 4\.000 rad from the start"):
        planner.plan_blocking(RIGHT, turned, upright=True)


def test_a_region_is_reached_within_its_bounds(scene: Scene, planner: Planner) -> None:
    middle = Pose.from_matrix(scene.arm.fkine(RIGHT))
    plan = planner.plan_blocking(LEFT, Region(middle, (0.1, 0.06, 0.02), (0.0, 0.0, 3.0)))
    off = np.linalg.inv(middle.matrix) @ scene.arm.fkine(plan.end)
    assert (np.abs(off[:3, 3]) <= np.array([0.05, 0.03, 0.01]) + 1e-9).all()
    assert off[2, 2] == pytest.approx(1.0)


@pytest.mark.slow
def test_a_tool_that_is_kept_upright_never_tilts() -> None:
    scene = Scene("gcr5_910", [Box(at=(0.45, 0, 0.15), size=(0.3, 0.04, 0.3), name="low wall")])
    with Planner(scene, tool=(0.0, 0.0, 0.1, 0.0, 0.0, 0.0)) as planner:
        plan = planner.plan_blocking(LEFT, RIGHT, upright=True)
        assert plan.upright
        assert plan.check(scene)
        first = scene.arm.fkine(LEFT)[:3, :3]
        for time in np.linspace(0.0, plan.duration, 60):
            # By another maker's rotations: what is left after the turn about the vertical.
            turn = scipy.spatial.transform.Rotation.from_matrix(
                scene.arm.fkine(plan.at(time))[:3, :3] @ first.T
            )
            assert np.hypot(*turn.as_rotvec()[:2]) < 1e-4
        with pytest.raises(GoalOutOfReach, match="tilted"):
            planner.plan_blocking(LEFT, Joints.deg(-50, -15, 105, 20, -90, 0), upright=True)


def test_a_line_is_straight(scene: Scene, planner: Planner) -> None:
    begin = Pose.from_matrix(scene.arm.fkine(LEFT))
    to = Pose(begin.x, begin.y + 0.1, begin.z - 0.2, begin.rx, begin.ry, begin.rz)
    plan = planner.line_blocking(LEFT, to, speed=0.1)
    assert plan.fraction == 1.0
    assert plan.check(scene)
    assert excess(plan) <= 1.0
    times = np.linspace(0.0, plan.duration, 400)
    points = np.array([plan.pose(time)[:3] for time in times])
    way = np.array(to[:3]) - begin[:3]
    off = np.cross(points - begin[:3], way / np.linalg.norm(way))
    assert np.abs(off).max() < 1e-6
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(times)
    assert 0.09 < speeds.max() <= 0.1 * 1.001
    assert plan.pose(plan.duration).matrix == pytest.approx(to.matrix, abs=1e-9)


def test_an_arc_is_round(scene: Scene, planner: Planner) -> None:
    begin = Pose.from_matrix(scene.arm.fkine(LEFT))
    turn = begin[3:]
    via = Pose(begin.x, begin.y + 0.06, begin.z - 0.06, *turn)
    to = Pose(begin.x, begin.y, begin.z - 0.12, *turn)
    plan = planner.line_blocking(LEFT, to, via=via)
    centre = np.array([begin.x, begin.y, begin.z - 0.06])
    points = np.array([plan.pose(time)[:3] for time in np.linspace(0, plan.duration, 200)])
    assert np.linalg.norm(points - centre, axis=1) == pytest.approx(0.06, abs=1e-6)
    assert np.linalg.norm(points - via[:3], axis=1).min() < 2e-3
    with pytest.raises(ParameterError, match="via"):
        planner.line_blocking(LEFT, to, via=Pose(begin.x, begin.y, begin.z - 0.06, *turn))


def test_a_line_into_a_wall_says_how_far_it_comes(scene: Scene, planner: Planner) -> None:
    begin = Pose.from_matrix(scene.arm.fkine(LEFT))
    to = Pose(0.5, -0.2, begin.z, begin.rx, begin.ry, begin.rz)
    with pytest.raises(PathIncomplete, match="wall") as caught:
        planner.line_blocking(LEFT, to)
    assert 0.1 < caught.value.fraction < 0.9
    assert caught.value.pair is not None
    assert caught.value.pair[1] == "wall"
    plan = planner.line_blocking(LEFT, to, partial=True)
    assert plan.fraction == pytest.approx(caught.value.fraction)
    assert plan.check(scene)
    assert "% of the way" in repr(plan)


def test_errors_name_bodies_and_place(planner: Planner) -> None:
    with pytest.raises(StartInCollision, match=r"cannot begin at .* deep in wall") as start:
        planner.plan_blocking(INSIDE, LEFT)
    assert start.value.pair is not None
    assert start.value.pair[1] == "wall"
    assert start.value.joints == pytest.approx(INSIDE)
    with pytest.raises(GoalInCollision, match="deep in wall"):
        planner.plan_blocking(LEFT, INSIDE)
    with pytest.raises(GoalInCollision, match=r"each of 8 configurations"):
        planner.plan_blocking(LEFT, Pose(0.5, 0, 0.35, math.pi, 0, 0))
    with pytest.raises(GoalOutOfReach, match="out of the reach"):
        planner.plan_blocking(LEFT, Pose(3, 0, 0, 0, 0, 0))
    with pytest.raises(ParameterError, match="goal"):
        planner.plan_blocking(LEFT, [0.0] * 6)  # type: ignore[list-item] # what a user may give


@pytest.mark.slow
def test_where_there_is_no_way_none_is_found() -> None:
    """Two curtains from close beside the base: the shoulder, 14 cm off the axis, cannot pass."""
    curtains = [
        Box(at=(side * 0.87, 0.0, 1.5), size=(1.5, 0.02, 3.0), name=f"curtain{side}")
        for side in (-1, 1)
    ]
    scene = Scene("gcr5_910", curtains)
    start, goal = Joints.deg(22, 0, 90, 0, -90, 0), Joints.deg(202, 0, 90, 0, -90, 0)
    assert not scene.collides(start)
    assert not scene.collides(goal)
    with Planner(scene) as planner, pytest.raises(NoPathFound, match=r"within 0\.3 s"):
        planner.plan_blocking(start, goal, timeout=0.3)


@pytest.mark.slow
def test_joints_at_a_limit_are_not_reached_by_another_turn() -> None:
    """As the wire rounds a whole turn, it is a little more: the plan then led to 0."""
    curtain = Box(at=(-0.8, 0.0, 1.0), size=(1.3, 0.02, 2.0), name="curtain")
    goal = Joints(float(np.float32(2 * np.pi)), *INSIDE[1:])
    with Planner(Scene("gcr5_910", [curtain])) as planner, pytest.raises(NoPathFound):
        planner.plan_blocking(Joints.deg(20, 20, 70, 0, -90, 0), goal, timeout=0.8)


def test_a_plan_to_where_the_arm_is_takes_no_time(planner: Planner) -> None:
    plan = planner.plan_blocking(LEFT, LEFT)
    assert plan.duration == 0.0
    assert plan.waypoints() == [(LEFT, 1.0, 0.0)]


def test_waypoints_for_blends_stay_within_the_padding(scene: Scene, planner: Planner) -> None:
    plan = planner.plan_blocking(LEFT, RIGHT)
    found = plan.waypoints()
    assert found[-1][::2] == (plan.end, 0.0)
    corners = [plan.start.array, *(q.array for q, *_ in found)]
    for one, two in itertools.pairwise(corners):
        shares = np.linspace(0.0, 1.0, 30)[:, None]
        assert not any(scene.collides(Joints.of(q)) for q in one + shares * (two - one))


def test_waypoints_along_a_line_keep_to_the_speed_of_the_tool(
    scene: Scene, planner: Planner
) -> None:
    plan = planner.line_blocking(RIGHT, raised(scene, RIGHT, 0.2, 0, 0), speed=0.05)
    here, fastest = RIGHT.array, 0.0
    for q, v, _ in plan.waypoints():
        tips = scene.arm.fkine(np.linspace(here, q, 50))[:, :3, 3]
        way = np.linalg.norm(np.diff(tips, axis=0), axis=1).max() * 49
        fastest = max(fastest, float(way * v / np.abs(q - here).max()))
        here = q.array
    assert fastest == pytest.approx(0.05, rel=0.15)


@pytest.mark.slow
def test_nothing_is_printed_and_importing_loads_nothing_of_the_extra() -> None:
    code = (
        "import sys\n"
        "from aioduco import Joints\n"
        "from aioduco.planning import Planner, Scene\n"
        "heavy = {'ompl', 'mujoco'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "with Planner(Scene()) as planner:\n"
        "    start = Joints.deg(0, 0, 90, 0, -90, 0)\n"
        "    planner.plan_blocking(start, Joints.deg(9, 0, 90, 0, -90, 0))\n"
        "assert 'ompl' not in sys.modules\n"
    )
    done = python("-W", "error", "-c", code)
    assert (done.stdout, done.stderr, done.returncode) == ("", "", 0)


def test_a_branch_is_that_of_the_kinematics_singular_values(scene: Scene) -> None:
    """The search has the same signs of numbers alone, which takes a hundredth of the time."""
    start = RIGHT.array
    space = UprightPathSpace(scene.arm, scene.checker(), start, np.array([0, 0, 1.0]), np.eye(4))
    signs = np.sign(singular_values(scene.arm.geometry, start))
    configurations = np.random.default_rng(1).uniform(-np.pi, np.pi, (200, 6))
    same = [space.same_branch(q.tolist()) for q in configurations]
    found = np.sign(singular_values(scene.arm.geometry, configurations))
    assert same == (found == signs).all(axis=1).tolist()
    assert 0 < sum(same) < len(same)


def near(gap: float, tool: list[Rod] | None = None) -> Scene:
    """A scene with a box below the flange, or the tool, at RIGHT."""
    scene = Scene("gcr5_910", [Box(at=(0, 0, -1), size=(0.1, 0.1, 0.1), name="box")], tool=tool)
    x, y, z = scene.arm.fkine(RIGHT)[:3, 3]
    low, high = z - 0.6, z - 0.05
    for _ in range(60):
        middle = 0.5 * (low + high)
        scene.move("box", (x, y, middle))
        low, high = (middle, high) if scene.clearance(RIGHT).distance > gap else (low, middle)
    scene.move("box", (x, y, low))
    assert scene.clearance(RIGHT).distance == pytest.approx(gap, abs=1e-8)
    return scene


def raised(scene: Scene, q: Joints, *by: float) -> Pose:
    pose = scene.arm.fkine(q)
    pose[:3, 3] += by
    return Pose.from_matrix(pose)


@pytest.mark.slow
@pytest.mark.parametrize("gap", [3e-4, 2e-4, 1e-5, 0.0])
def test_ends_that_nearly_touch_something_are_left_and_reached(gap: float) -> None:
    scene = near(gap, [Rod(length=0.1, radius=0.01)] if gap in (3e-4, 1e-5) else None)
    here, up = raised(scene, RIGHT, 0, 0, 0), raised(scene, RIGHT, 0, 0, 0.1)
    above = Joints.of(scene.arm.ikine(up, RIGHT))
    turned = Joints.of(RIGHT.array + np.array([0, 0, 0, 0, 0, 1.0]))
    aside = raised(scene, RIGHT, 0.02, 0, 0)
    with Planner(scene) as planner:
        free, line = planner.plan_blocking, planner.line_blocking
        ways: list[tuple[Callable[..., Plan], Any, Any]] = [
            *((free, LEFT, RIGHT), (free, LEFT, here), (free, RIGHT, LEFT)),
            *((free, LEFT, Region(here, (0.001, 0.001, 0.0))), (free, RIGHT, turned)),
            *((line, RIGHT, aside), (line, above, here), (line, RIGHT, up)),
        ]
        for how, start, end in ways:
            plan = how(start, end, timeout=20)
            assert plan.fraction == 1.0
            assert plan.check(scene), plan.check(scene)
            assert plan.padding <= max(gap, 1e-6)
            assert not any(scene.collides(q) for q, *_ in plan.waypoints())


@pytest.mark.slow
def test_away_from_a_near_end_all_of_the_padding_is_kept() -> None:
    scene = near(2e-4)
    with Planner(scene) as planner:
        plan = planner.plan_blocking(RIGHT, LEFT, timeout=20)
    steps = np.abs(plan.trajectory.positions - RIGHT.array) @ plan.radii
    for q, away in zip(plan.trajectory.positions, steps, strict=True):
        least = min(scene.padding, 1.8e-4 + 0.1 * max(away - 0.01, 0.0))
        assert scene.clearance(Joints.of(q)).distance >= 0.99 * least


@pytest.mark.slow
def test_a_gripper_leaves_the_part_between_its_fingers_and_comes_back() -> None:
    gap = 2e-4
    fingers = [
        Box(at=(side * (0.03 + gap), 0, 0.05), size=(0.01, 0.02, 0.1)) for side in (-1.0, 1.0)
    ]
    scene = Scene("gcr5_910", tool=fingers)
    pose = scene.arm.fkine(RIGHT)
    pose[:3, 3] += 0.09 * pose[:3, 2]
    scene.add(Box(at=tuple(Pose.from_matrix(pose)), size=(0.05, 0.05, 0.05), name="part"))
    assert 0.0 < scene.clearance(RIGHT).distance < 3e-4
    with Planner(scene) as planner:
        for plan in (
            planner.plan_blocking(RIGHT, LEFT, timeout=60),
            planner.plan_blocking(LEFT, RIGHT, timeout=60),
        ):
            assert plan.check(scene), plan.check(scene)


@for_each("goal", [None, 3, "home", (), [0.0] * 6])
def test_what_is_no_goal_is_refused(goal: Any) -> None:
    with pytest.raises(ParameterError, match="Joints, a Pose, a Region, or several of these"):
        goals_of(goal)


def test_a_pose_in_degrees_or_millimetres_and_what_is_no_scene_are_refused(scene: Scene) -> None:
    turned = Pose(0.4, 0.1, 0.4, 180.0, 0.0, 0.0)
    wrong: list[Any] = [turned, [RIGHT, turned], Region(turned)]
    for goal in wrong:
        with pytest.raises(ParameterError, match=r"goal\[3\] is 180"):
            goals_of(goal)
    with Planner(scene) as planner:
        with pytest.raises(ParameterError, match=r"to\[0\] is 400"):
            planner.line_blocking(RIGHT, Pose(400.0, 0.1, 0.4, math.pi, 0.0, 0.0))
        plan = planner.plan_blocking(RIGHT, LEFT, v=1.5, a=3.0)
    for it in ("gcr5_910", None):
        with pytest.raises(ParameterError, match="a Scene"):
            Planner(it)  # type: ignore[arg-type]  # the wrong type is the point
        with pytest.raises(ParameterError, match="a Scene"):
            plan.check(it)  # type: ignore[arg-type]  # the wrong type is the point
    with pytest.raises(ParameterError, match="a Scene of the plan's arm, gcr5_910"):
        plan.check(Scene("gcr16_960"))
    with pytest.raises(ParameterError, match="seed is 'one'"):
        Planner(scene, seed="one")  # type: ignore[arg-type]  # the wrong type is the point
