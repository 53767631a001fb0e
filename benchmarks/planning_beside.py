"""Planning beside tesseract, which installs from PyPI too: the same queries in alternation.

    pip install tesseract-robotics
    python benchmarks/planning_beside.py [--queries 20] [--save]

Scenes, arms and queries are those of `planning.py`. For each query all are asked in one run, one
after the other, and which is first alternates:
- aioduco, pose: the flange's pose; each inverse solution is a goal.
- aioduco, joints: the nearest free inverse solution of it.
- tesseract, joints: the same. As it comes: two RRTConnect on two threads, which end with ten
  solutions or after 5 s; collisions each 0.005 rad, by Bullet. Its package for Python gives no
  access to the solver's settings. Times are from its iterative spline, on the path in steps of
  0.05 rad.
- tesseract, joints, looks each 0.05 rad: the same, with collisions looked for more coarsely.

tesseract gets our URDF and SRDF, the scene's boxes, a floor that links 1 and base may touch, and a
margin of 5 mm, as the scenes here have. All have 5 s, and the same limits of speed and
acceleration; ours keeps a limit of jerk besides (10 times the acceleration, per second), which the
iterative spline does not know, and its path was shortened. tesseract's path is not shortened.

Times of ours are processor time of the planner's process. Those of tesseract are the wall clock's
or the processor time of all its threads, whichever is less. They are from the query to the path,
and to the path with its times, of what was solved. `whole_call` is the wall clock's for both, with
what Python does to ask and to read the answer.

A way is free if nothing touches at each 0.2° and 1 mm of its trajectory, as `Plan.check` looks.
`straight_parts_free` is the same for the path before it has times.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import importlib
import importlib.metadata
import importlib.util
import itertools
import logging
import os
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from _common import percentile, print_table, scheduling, write_results
from planning import ARMS, SCENES, A, Setting, V, draw

from aioduco import Joints, descriptions
from aioduco.errors import PlanningError
from aioduco.kinematics import arm as arm_of
from aioduco.planning import MotionLimits, Plan, Planner, Scene
from aioduco.sim.scene import Box
from aioduco.streaming.joint_trajectory import JointTrajectory

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from numpy.typing import NDArray
    from planning import Query

    from aioduco.kinematics import Arm
    from aioduco.planning.collision import CollisionChecker

    Points = NDArray[np.float64]

PATIENCE = 5.0  # tesseract's own, which cannot be changed from Python [s]
MARGIN = 0.005  # of the scenes [m]
STEP = 0.05  # between points that get times [rad]
COARSE = 0.05  # between looks of tesseract, instead of 0.005 [rad]
PROFILE, PLANNER = "DEFAULT", "OMPLMotionPlannerTask"
PLUGINS = """contact_manager_plugins:
  search_libraries: [tesseract_collision_bullet_factories]
  discrete_plugins:
    default: BulletDiscreteBVHManager
    plugins: {BulletDiscreteBVHManager: {class: BulletDiscreteBVHManagerFactory}}
  continuous_plugins:
    default: BulletCastBVHManager
    plugins: {BulletCastBVHManager: {class: BulletCastBVHManagerFactory}}
"""


FLOOR = Box(at=(0.0, 0.0, -0.05), size=(6.0, 6.0, 0.1), name="floor")


@functools.cache
def texts_of(model: str) -> tuple[str, str]:
    """URDF and SRDF of an arm; which links never touch takes a while to find."""
    return descriptions.urdf(model), descriptions.srdf(model)


def tesseract_modules() -> SimpleNamespace:
    """The modules of tesseract that are needed, by names without what all begin with."""
    names = (
        *("common", "environment", "scene_graph", "geometry", "command_language"),
        *("motion_planners", "motion_planners_ompl", "time_parameterization"),
    )
    package = "tesseract_robotics.tesseract_"
    return SimpleNamespace(**{name: importlib.import_module(package + name) for name in names})


class Found(NamedTuple):
    """A way, and what it took: until the path, until its times, and the whole call [s]."""

    path: float
    with_times: float
    call: float
    corners: Points
    plan: Plan


class Clock:
    """The wall clock's time or the processor's of all threads, whichever is less [s]."""

    def __init__(self) -> None:
        self._begin = time.perf_counter(), time.process_time()

    def read(self) -> float:
        wall, used = self._begin
        return min(time.perf_counter() - wall, time.process_time() - used)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep what a library writes straight to standard output and error out of sight."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    with Path(os.devnull).open("wb") as nowhere:
        for number in (1, 2):
            os.dup2(nowhere.fileno(), number)
    try:
        yield
    finally:
        for number, other in zip((1, 2), kept, strict=True):
            os.dup2(other, number)
            os.close(other)


class Tesseract:
    """tesseract's OMPL planner and iterative spline, for one arm in one scene.

    Args:
        arm: the arm.
        things: boxes of the scene.
        scene: the same, to look at what was found.
        looks: between two looks for collisions [rad]; None for its own.
    """

    def __init__(self, arm: Arm, things: list[Box], scene: Scene, looks: float | None) -> None:
        self._scene, self._radii = scene, scene.checker().radii
        self._lib = lib = tesseract_modules()
        self._locator = lib.common.GeneralResourceLocator()
        self._env = lib.environment.Environment()
        with tempfile.TemporaryDirectory() as folder:
            plugins = Path(folder) / "plugins.yaml"
            plugins.write_text(PLUGINS, encoding="utf-8")
            urdf, srdf = texts_of(arm.name)
            srdf = srdf.replace(
                "</robot>", f'<contact_managers_plugin_config filename="{plugins}"/></robot>'
            )
            if not self._env.init(urdf, srdf, self._locator):
                raise RuntimeError(f"tesseract does not take the description of {arm.name}")
        for thing in [*things, FLOOR]:
            self._box(thing)
        allowed = lib.common.AllowedCollisionMatrix()
        for link in ("base_link", "link_1"):
            allowed.addAllowedCollision("floor", link, "stands there")
        kind = lib.environment.ModifyAllowedCollisionsType_ADD
        self._apply(lib.environment.ModifyAllowedCollisionsCommand(allowed, kind))
        self._apply(lib.environment.ChangeCollisionMarginsCommand(MARGIN))
        self._names = list(self._env.getJointGroup("manipulator").getJointNames())
        self._manipulator = lib.common.ManipulatorInfo()
        self._manipulator.manipulator = "manipulator"
        self._manipulator.tcp_frame, self._manipulator.working_frame = "tool0", "base_link"
        profile = lib.motion_planners_ompl.OMPLRealVectorPlanProfile()
        if looks is not None:
            profile.collision_check_config.longest_valid_segment_length = looks
        self._profiles = lib.command_language.ProfileDictionary()
        self._profiles.addProfile(PLANNER, PROFILE, profile)
        self._planner = lib.motion_planners_ompl.OMPLMotionPlanner(PLANNER)

    def plan(self, query: Query) -> Found | None:
        """Find a way from the start to the nearest free inverse solution of the goal."""
        lib = self._lib
        begin, clock = time.perf_counter(), Clock()
        request = lib.motion_planners.PlannerRequest()
        request.instructions = self._program([query.start.array, query.direct.array], "Joint")
        request.env, request.profiles = self._env, self._profiles
        with quiet():
            answer = self._planner.solve(request)
        if not answer.successful:
            return None
        corners = self._read(answer.results)[0]
        path = clock.read()
        program = self._program(stepped(corners, STEP), "State")
        limits = [np.outer(np.full(6, limit), [-1.0, 1.0]) for limit in (V, A, 10.0 * A)]
        spline = lib.time_parameterization.IterativeSplineParameterization()
        timed = lib.time_parameterization.InstructionsTrajectory(program)
        if not spline.compute(timed, *limits):
            return None
        q, times, qd = self._read(program)
        with_times, call = clock.read(), time.perf_counter() - begin
        trajectory = JointTrajectory(q, times, qd)
        return Found(path, with_times, call, corners, self._as_plan(trajectory, corners))

    def _as_plan(self, trajectory: JointTrajectory, corners: Points) -> Plan:
        """As a plan, so that the same check looks at it."""
        arm = self._scene.arm
        zero = np.zeros(1)
        limits = MotionLimits.of(arm, V, A, None)
        return Plan(arm, trajectory, limits, np.eye(4), corners, zero, zero, self._radii, MARGIN)

    def _apply(self, command: Any) -> None:
        if not self._env.applyCommand(command):
            raise RuntimeError(f"tesseract does not take {type(command).__name__}")

    def _box(self, thing: Box) -> None:
        graph, common = self._lib.scene_graph, self._lib.common
        link = graph.Link(thing.name)
        solid = graph.Collision()
        solid.geometry = self._lib.geometry.Box(*(float(length) for length in thing.size))
        link.collision.append(solid)
        joint = graph.Joint(f"world-{thing.name}")
        joint.parent_link_name, joint.child_link_name = "world", thing.name
        joint.type = graph.JointType_FIXED
        place = common.Isometry3d.Identity() * common.Translation3d(*(float(x) for x in thing.at))
        joint.parent_to_joint_origin_transform = place
        self._apply(self._lib.environment.AddLinkCommand(link, joint))

    def _program(self, points: Iterable[Points], kind: str) -> Any:
        language = self._lib.command_language
        waypoint = getattr(language, f"{kind}Waypoint")
        wrapped = getattr(language, f"{kind}WaypointPoly_wrap_{kind}Waypoint")
        program = language.CompositeInstruction(PROFILE)
        program.setManipulatorInfo(self._manipulator)
        for q in points:
            state = wrapped(waypoint(self._names, np.array(q)))
            move = language.MoveInstruction(state, language.MoveInstructionType_FREESPACE, PROFILE)
            program.appendMoveInstruction(language.MoveInstructionPoly_wrap_MoveInstruction(move))
        return program

    def _read(self, program: Any) -> tuple[Points, Points, Points]:
        """Positions, times and velocities. A thing of it lives only as long as what it is of."""
        language = self._lib.command_language
        rows, times = [], []
        flat = program.flatten()
        for instruction in flat:
            move = language.InstructionPoly_as_MoveInstructionPoly(instruction)
            waypoint = move.getWaypoint()
            state = language.WaypointPoly_as_StateWaypointPoly(waypoint)
            still = np.zeros(6)
            speed = state.getVelocity().flatten()
            rows.append([state.getPosition().flatten(), speed if speed.size else still])
            times.append(state.getTime())
        found = np.array(rows)
        return found[:, 0], np.array(times), found[:, 1]


class Ours:
    """The planner of this package, for one scene.

    Args:
        scene: the scene.
        to_pose: whether it is asked for the goal's pose, instead of its nearest inverse solution.
    """

    def __init__(self, scene: Scene, *, to_pose: bool) -> None:
        self._planner = Planner(scene)
        self._to_pose = to_pose
        self._planner.plan_blocking(Joints.of([0.0] * 6), Joints.of([0.1] + [0.0] * 5))  # starts it

    def plan(self, query: Query) -> Found | None:
        """Find a way from the start to the goal."""
        begin = time.perf_counter()
        goal = query.goal if self._to_pose else query.direct
        try:
            plan = self._planner.plan_blocking(query.start, goal, v=V, a=A, timeout=PATIENCE)
        except PlanningError:
            return None
        call = time.perf_counter() - begin
        return Found(plan.searching, plan.searching + plan.timing, call, plan.corners, plan)

    def close(self) -> None:
        self._planner.close()


def stepped(points: Points, step: float) -> Points:
    """Points on the straight parts between others, at most a step apart, the others among them."""
    parts = [points[:1]]
    for one, other in itertools.pairwise(points):
        count = max(int(np.ceil(np.linalg.norm(other - one) / step)), 1)
        parts.append(one + np.linspace(0.0, 1.0, count + 1)[1:, None] * (other - one))
    return np.concatenate(parts)


def straight_parts_free(checker: CollisionChecker, points: Points) -> bool:
    """Whether nothing touches on straight parts, each 0.2° of a joint and each 1 mm of the arm."""
    padding, checker.padding = checker.padding, 0.0
    try:
        for one, other in itertools.pairwise(points):
            turned = np.abs(other - one)
            closest = max(float(turned @ checker.radii) / 0.001, turned.max() / np.deg2rad(0.2))
            shares = np.linspace(0.0, 1.0, int(np.ceil(closest)) + 1)[:, None]
            if not all(checker.free(q) for q in one + shares * (other - one)):
                return False
        return True
    finally:
        checker.padding = padding


def described(
    asked: int, found: list[Found], free: int, straight: int | None
) -> dict[str, float | int]:
    """One row of the table."""
    row: dict[str, float | int] = {
        "queries": asked,
        "solved_in_1_s_percent": round(100.0 * sum(f.path <= 1.0 for f in found) / asked, 1),
        "solved_in_5_s_percent": round(100.0 * len(found) / asked, 1),
    }
    if not found:
        return row
    lengths = [np.linalg.norm(np.diff(f.plan.trajectory.positions, axis=0), axis=1) for f in found]
    for name, values in (
        ("path", [f.path for f in found]),
        ("with_times", [f.with_times for f in found]),
        ("whole_call", [f.call for f in found]),
    ):
        for share in (50, 95):
            row[f"{name}_p{share}_ms"] = round(percentile(sorted(values), share) * 1e3, 1)
    row["length_p50_rad"] = round(percentile(sorted(float(each.sum()) for each in lengths), 50), 2)
    row["duration_p50_s"] = round(percentile(sorted(f.plan.duration for f in found), 50), 2)
    row["ways"] = len(found)
    row["ways_free"] = free
    if straight is not None:
        row["straight_parts_free"] = straight
    return row


class Tally:
    """What one planner found, of all queries that it was asked."""

    def __init__(self) -> None:
        self.asked = self.free = self.straight = 0
        self.found: list[Found] = []

    def add(self, found: Found | None, scene: Scene, checker: CollisionChecker) -> None:
        self.asked += 1
        if found is not None:
            self.found.append(found)
            self.free += bool(found.plan.check(scene))
            self.straight += straight_parts_free(checker, found.corners)

    def row(self, *, straight: bool) -> dict[str, float | int]:
        return described(self.asked, self.found, self.free, self.straight if straight else None)


def measure(
    arm: Arm, setting: Setting, number: int, whole: dict[str, Tally], *, beside: bool
) -> dict[str, dict[str, float | int]]:
    """One scene and one arm."""
    random = np.random.default_rng(7)
    scene = Scene(arm, setting.things, padding=MARGIN)
    checker = scene.checker()
    ours = {name: Ours(scene, to_pose=name.endswith("pose"))
            for name in ("aioduco, pose", "aioduco, joints")}  # fmt: skip
    asked: dict[str, Callable[[Query], Found | None]] = {n: each.plan for n, each in ours.items()}
    if beside:
        asked["tesseract, joints"] = Tesseract(arm, setting.things, scene, None).plan
        coarse = f"tesseract, joints, looks each {COARSE} rad"
        asked[coarse] = Tesseract(arm, setting.things, scene, COARSE).plan
    here = {name: Tally() for name in asked}
    for turn in range(number):
        query = draw(arm, setting, checker, random)
        for name in list(asked)[:: 1 if turn % 2 else -1]:
            found = asked[name](query)
            for tally in (here[name], whole.setdefault(name, Tally())):
                tally.add(found, scene, checker)
    for each in ours.values():
        each.close()
    return {name: tally.row(straight="tesseract" in name) for name, tally in here.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="2 queries each, for CI")
    parser.add_argument("--queries", type=int, default=20, help="for each scene and arm")
    parser.add_argument(
        "--save", action="store_true", help="write benchmarks/results/planning_beside.json"
    )
    options = parser.parse_args()
    logging.getLogger("toppra").setLevel(logging.ERROR)
    beside = importlib.util.find_spec("tesseract_robotics") is not None
    figures: dict[str, Any] = {"scheduling": scheduling()}
    if beside:
        figures["tesseract"] = importlib.metadata.version("tesseract-robotics")
    else:
        print("tesseract is not installed (pip install tesseract-robotics): it is left out")
    whole: dict[str, Tally] = {}
    rows: list[dict[str, Any]] = []
    for scene, make in SCENES.items():
        for model in ARMS:
            arm = arm_of(model)
            number = 2 if options.quick else options.queries
            found = measure(arm, make(arm.reach), number, whole, beside=beside)
            rows += [{"scene": f"{scene}, {model}", "planner": n} | row for n, row in found.items()]
            print("\n".join(map(str, rows[-len(found) :])), flush=True)
    order = ["aioduco, pose", "aioduco, joints", *(n for n in whole if "tesseract" in n)]
    figures["all_scenes"] = {n: whole[n].row(straight="tesseract" in n) for n in order}
    figures["by_scene"] = rows
    keys = ("solved_in_1_s_percent", "path_p50_ms", "with_times_p50_ms", "length_p50_rad",
            "duration_p50_s", "ways", "ways_free")  # fmt: skip
    table = [[n, *(row.get(k, "") for k in keys)] for n, row in figures["all_scenes"].items()]
    print_table("planning, beside tesseract", ("planner", *keys), table)
    if options.save:
        write_results("planning_beside", figures)


if __name__ == "__main__":
    main()
