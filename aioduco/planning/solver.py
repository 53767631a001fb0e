"""From a problem to its solution: goals, search, rounding, times. Runs in the worker's process.

Out of a narrow place, such as a gripper's from a part that it let go, the tool is led straight:
random search hardly ever finds such a way, with tenths of a millimetre on both sides.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.errors import (
    GoalInCollision,
    GoalOutOfReach,
    NoPathFound,
    PathIncomplete,
    StartInCollision,
    Unreachable,
)
from aioduco.kinematics.single import nearest_turns
from aioduco.models.bounds import clipped
from aioduco.models.pose import Joints, Pose
from aioduco.models.rotation import matrix_from_rpy, transform
from aioduco.planning.clearance import TOUCHING, Clearance
from aioduco.planning.curve import is_free, joint_curve, rounded
from aioduco.planning.plan import Plan
from aioduco.planning.search import STEP, Budget, search
from aioduco.planning.spaces import JointPathSpace, PathSpace, UprightPathSpace
from aioduco.planning.spline import BSpline
from aioduco.planning.timing import timed
from aioduco.planning.toolpath import followed, poses_along
from aioduco.streaming.joint_trajectory import JointTrajectory

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning.collision import CollisionChecker
    from aioduco.planning.problem import Goal, PlanningProblem, Region

    Points = NDArray[np.float64]


_FURTHEST = 0.15  # length of a way out, at most [m]
_SHARE = 0.5  # of the distance at the end that may be left on the way out
_ROUNDING = 1e-7  # likewise, less than it [m]
#: axes of the tool along which a way out is tried: back first
_AXES = ((0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1))


def retreat(
    arm: Arm, checker: CollisionChecker, q: Points, tip: Points, up: Points
) -> list[tuple[Points, float]]:
    """Give configurations from one that is close to something to one that is not.

    Args:
        arm: the arm.
        checker: collision checker of the scene, with the padding to reach.
        q: the first configuration [rad]. Shape (6,).
        tip: the tool's tip in the flange's frame. Shape (4, 4).
        up: the vertical in the base's frame. Shape (3,).

    Returns:
        Configurations [rad] on a straight line of the tip, each with its distance to the nearest
        thing [m]; the last is more than the padding away from everything. Empty if no line along
        an axis of the tool, or up, leads there.
    """
    pose: Points = arm.fkine(q) @ tip
    back = np.linalg.inv(tip).astype(np.float64)
    ways = [*(pose[:3, :3] @ axis for axis in np.array(_AXES, dtype=np.float64)), up]
    with checker.looking_within(2.0 * checker.padding) as distance:
        first = distance(q.tolist())
        least = min(_SHARE * first, first - _ROUNDING)
        for way in ways:
            end = pose.copy()
            end[:3, 3] += _FURTHEST * way
            found: list[tuple[Points, float]] = []
            for there in followed(arm, poses_along(pose, None, end).poses, back, q)[0]:
                near = distance(there.tolist())
                if near < least:
                    break
                found.append((there, near))
                if near > checker.padding:
                    return found
    return []


#: growth of the distance that is kept, on the way from an end that is closer: at first, and where
#: no path was found, as in a narrow hole
_OPENING, _NARROW = 0.1, 1e-4
_RETREATS = 16  # goals, at most, for which a straight line away from what is near is tried
_SAMPLES = 24  # poses of a region that are tried
#: looks before goals a turn away, and goals closer to things, are tried too
_SOON = 20_000
#: looks for straight ways out, per second of the time-out: a slow computer's in half of it
_RETREATING = 10_000
_DIRECT = 8  # goals to which the straight path is tried, the nearest first
_CORNERS = 9  # corners to report for a path that has none in joint space
_CLEARANCE_SAMPLES = 40  # measurements of the clearance along the path


def solve(problem: PlanningProblem, checker: CollisionChecker) -> Plan:
    """Find a plan.

    Args:
        problem: the problem.
        checker: collision checker of the scene.

    Raises:
        PlanningError: no plan was found; the subclass says why.
    """
    begin, used = time.monotonic(), time.process_time()
    start = problem.start
    near = checker.clearance(start)
    if near.distance < -TOUCHING:
        raise StartInCollision(
            f"the plan cannot begin at {_degrees(start)}: {near}. Move the arm away by hand or "
            "jog, or allow the contact (Scene.allow)",
            pair=near.pair,
            joints=start.tolist(),
        )
    if problem.shape == "free":
        curve, corners = _free(problem, checker, near, begin + problem.timeout)
        fraction = 1.0
    else:
        curve, fraction = _along(problem, checker, near)
        corners = curve(np.linspace(curve.begin, curve.end, _CORNERS))
    found = time.process_time()
    if curve.end - curve.begin <= 1e-6:
        still = np.zeros((1, 6))
        times, q, qd, qdd = np.zeros(1), start[None, :], still, still
    else:
        times, q, qd, qdd = timed(curve, problem.limits, problem.rate)
    ended = time.process_time()
    samples = np.unique(np.linspace(0, len(times) - 1, _CLEARANCE_SAMPLES).round().astype(int))
    return Plan(
        arm=problem.arm,
        trajectory=JointTrajectory(q, times, qd, qdd),
        limits=problem.limits,
        tip=problem.tip,
        corners=corners,
        looked=times[samples],
        clearances=np.array([checker.clearance(q[i]).distance for i in samples]),
        radii=checker.radii,
        padding=max(min(map(checker.kept, q)), TOUCHING),
        fraction=fraction,
        upright=problem.upright,
        searching=found - used,
        timing=ended - found,
    )


def _free(
    problem: PlanningProblem, checker: CollisionChecker, here: Clearance, deadline: float
) -> tuple[BSpline, Points]:
    """Find a path to any of the goals, as a curve of joints, and its corners.

    `here` is the clearance of the start.
    """
    start, arm = problem.start, problem.arm
    space: PathSpace = JointPathSpace(arm, checker)
    branch = None
    if problem.upright:
        space = branch = UprightPathSpace(arm, checker, start, problem.up, problem.tip)
    reached = _configurations(problem)
    if branch is not None:
        whys = [branch.why_not(q) for q in reached]
        if all(whys):
            own = [branch.same_branch(q.tolist()) for q in reached]
            which = own.index(True) if any(own) else 0
            raise GoalOutOfReach(whys[which], joints=reached[which].tolist())
        reached = [q for q, why in zip(reached, whys, strict=True) if not why]
    clearances = [checker.clearance(q) for q in reached]
    if not any(each.distance >= -TOUCHING for each in clearances):
        raise _goal_in_collision(problem, reached, clearances)
    # The nearest goals, with all of the padding, may have no path where other goals have one.
    exact = [
        clipped(goal, arm.lower, arm.upper) for goal in problem.goals if isinstance(goal, Joints)
    ]
    further = [
        (other, c)
        for q, c in zip(reached, clearances, strict=True)
        if not any(np.array_equal(q, joints) for joints in exact)
        for other in _turned(q, arm)
    ]
    if branch is not None:
        further = [(q, c) for q, c in further if not branch.why_not(q)]
    padding = checker.padding
    near = [
        (q, each.distance)
        for q, each in zip(reached, clearances, strict=True)
        if each.distance >= -TOUCHING
    ]
    far = [(q, distance) for q, distance in near if distance > padding]
    every = near + [(q, each.distance) for q, each in further if each.distance >= -TOUCHING]
    tries = [_Try(far, _SOON), _Try(every)]
    if min(here.distance, *(distance for _, distance in every)) <= padding:
        half = _RETREATING * problem.timeout
        tries[1:] = [
            _Try(every, _SOON),
            _Try(every, half, retreating=True),
            _Try(every, growth=_NARROW),
        ]
    for each in tries:
        checker.padding = padding
        start_out, outs = [start], [[q] for q, _ in each.goals]
        eased = [(start, here.distance), *each.goals]
        if each.retreating:
            ways = [
                retreat(arm, checker, q, problem.tip, problem.up)
                if distance <= padding and number <= _RETREATS
                else []
                for number, (q, distance) in enumerate(eased)
            ]
            start_out, *outs = (
                [p for p, _ in way] or [q] for (q, _), way in zip(eased, ways, strict=True)
            )
            eased += [place for way in ways for place in way]
        checker.ease(eased, each.growth)
        outs.sort(key=lambda way: float(np.abs(way[0] - start).max()))
        if outs and float(np.abs(outs[0][0] - start).max()) < 1e-6:
            still = BSpline.through(np.linspace(0.0, 1e-9, 6), np.tile(start, (6, 1)))
            return still, start[None, :]
        budget = Budget(space, deadline, each.looks)
        found = _way_to(outs, start_out, space, checker, budget) if outs else None
        if found is not None and branch is None:
            curve, corners = found
            return curve, corners / checker.radii
        if found is not None:
            curve, _ = found
            return curve, curve(np.linspace(curve.begin, curve.end, _CORNERS))
    nearest = max(clearances, key=lambda each: each.distance)
    closer = "".join(
        f"; at the {end} {each}, which no straight line of the tool leaves"
        for end, each in (("start", here), ("goal", nearest))
        if each.distance <= padding
    )
    raise NoPathFound(
        f"no path was found within {problem.timeout:g} s from {_degrees(start)} to "
        f"{_named(problem.goals)}, {padding * 1e3:.1f} mm away from everything{closer}: give it "
        "more time (timeout), or less padding"
    )


class _Try(NamedTuple):
    """An attempt to find a path.

    Attributes:
        goals: goals, each with its distance to the nearest thing [rad, m].
        looks: how much is searched, in looks at points; time alone for the last one.
        growth: growth of the distance that is kept, on the way from an end that is closer.
        retreating: whether a straight line of the tool leads away from such an end.
    """

    goals: list[tuple[Points, float]]
    looks: float = math.inf
    growth: float = _OPENING
    retreating: bool = False


def _way_to(
    goals: list[list[Points]],
    start: list[Points],
    space: PathSpace,
    checker: CollisionChecker,
    budget: Budget,
) -> tuple[BSpline, Points] | None:
    """Find a rounded path to any of the goals, and its corners in `space`; None if none is found.

    Start and goals are each a way out: configurations from it to where the search begins.
    """
    begin = np.array([space.point(q) for q in start])
    ends = [np.array([space.point(q) for q in way]) for way in goals]
    points = [end[-1] for end in ends]
    direct, step = _DIRECT, STEP
    while not budget.spent:
        corners = search(space, begin[-1], points, budget, direct=direct, step=step)
        if corners is None:
            return None
        reached = ends[int(np.argmin([np.abs(end - corners[-1]).max() for end in points]))]
        corners = np.concatenate([begin[:-1], corners, reached[-2::-1]])
        curve = rounded(corners, space, checker)
        joints = None if curve is None else joint_curve(curve, space)
        if joints is not None:
            return joints, corners
        direct, step = 0, 0.5 * step  # coarse checks missed a collision: check more finely
    return None


def _configurations(problem: PlanningProblem) -> list[Points]:
    """All configurations that are goals."""
    arm, start = problem.arm, problem.start
    back = np.linalg.inv(problem.tip)
    found: list[Points] = []
    for goal in problem.goals:
        if isinstance(goal, Joints):
            if arm.within_limits(goal):
                found.append(clipped(goal, arm.lower, arm.upper))
            continue
        for pose in _poses(goal):
            for q in arm.ikine_all(pose @ back):
                turned = nearest_turns(q.tolist(), start.tolist(), arm.lower, arm.upper)
                if turned is not None:
                    found.append(np.array(turned))
    if not found:
        first = problem.goals[0]
        if isinstance(first, Joints):
            raise GoalOutOfReach(
                f"{_degrees(first.array)} is beyond the joint limits", joints=first
            )
        pose = _poses(first)[0]
        try:
            arm.ikine(pose @ back, start)
        except Unreachable as error:
            raise GoalOutOfReach(f"no goal can be reached: {error}") from None
    return found


def _turned(q: Points, arm: Arm) -> list[Points]:
    """The same configuration with one joint a whole turn away, within its limits."""
    found: list[Points] = []
    for axis in range(len(q)):
        for turn in (-2 * np.pi, 2 * np.pi):
            other = q.copy()
            other[axis] += turn
            if arm.within_limits(other):
                found.append(clipped(other, arm.lower, arm.upper))
    return found


def _poses(goal: Pose | Region) -> list[Points]:
    if isinstance(goal, Pose):
        return [goal.matrix]
    random = np.random.default_rng(0)
    poses: list[Points] = []
    for _ in range(_SAMPLES):
        # The middle first, then random poses.
        share = random.uniform(-1.0, 1.0, 6) if poses else np.zeros(6)
        offset = transform(matrix_from_rpy(share[3:] * goal.turn), 0.5 * share[:3] * goal.size)
        poses.append(goal.at.matrix @ offset)
    return poses


def _along(
    problem: PlanningProblem, checker: CollisionChecker, here: Clearance
) -> tuple[BSpline, float]:
    """Plan a line or an arc, as far as it is free and within reach.

    `here` is the clearance of the start.
    """
    arm, start = problem.arm, problem.start
    poses = [goal.matrix for goal in problem.goals if isinstance(goal, Pose)]
    way = poses_along(
        arm.fkine(start) @ problem.tip, poses[0] if len(poses) > 1 else None, poses[-1]
    )
    back = np.linalg.inv(problem.tip).astype(np.float64)
    q, why = followed(arm, way.poses, back, start)
    wanted, pair, place = len(way.poses), None, q[-1]
    # Find the last pose that is free. Keep the padding, or less of it if an end is closer.
    last = checker.clearance(q[-1]).distance
    checker.ease([(start, here.distance), *([(q[-1], last)] if last >= -TOUCHING else [])], 0.0)
    space = JointPathSpace(arm, checker)
    at = np.linspace(0.0, way.length, wanted)
    if len(q) >= 6:
        curve = BSpline.through(at[: len(q)], q * checker.radii)
        blocked = next(
            (i for i in range(len(q) - 1) if not is_free(curve, space, checker, at[i], at[i + 1])),
            None,
        )
        if blocked is not None:
            hit = checker.clearance(q[blocked + 1])
            why, pair, place = str(hit), hit.pair, q[blocked + 1]
            q = q[: blocked + 1]
    fraction = (len(q) - 1) / (wanted - 1)
    if fraction < 1.0 and (not problem.partial or len(q) < 6):
        raise PathIncomplete(
            f"the {problem.shape} can be followed for {fraction:.0%} of {way.length:.3f} m: {why}",
            fraction=fraction,
            pair=pair,
            joints=place.tolist(),
        )
    return BSpline.through(at[: len(q)], q), fraction


def _goal_in_collision(
    problem: PlanningProblem, reached: Sequence[Points], clearances: Sequence[Clearance]
) -> GoalInCollision:
    least = int(np.argmax([each.distance for each in clearances]))
    ways = f"each of {len(reached)} configurations collides; at best " if len(reached) > 1 else ""
    return GoalInCollision(
        f"{_named(problem.goals)} cannot be a goal: {ways}{clearances[least]}, at "
        f"{_degrees(reached[least])}. Allow the contact (Scene.allow), or choose another pose",
        pair=clearances[least].pair,
        joints=reached[least].tolist(),
    )


def _named(goals: Sequence[Goal]) -> str:
    first = goals[0]
    more = f" or {len(goals) - 1} others" if len(goals) > 1 else ""
    return (f"{_degrees(first.array)}" if isinstance(first, Joints) else f"{first}") + more


def _degrees(q: Points) -> str:
    return f"({', '.join(f'{angle:.1f}' for angle in np.degrees(q))})°"
