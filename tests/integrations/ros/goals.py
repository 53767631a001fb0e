"""Goals, valid and invalid, and clients that record the results."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from aioduco.integrations.ros.trajectory_goals import (
    ErrorCode,
    GoalPoint,
    NamedLimits,
    NamedTolerance,
    TrajectoryGoal,
)
from aioduco.integrations.ros.trajectory_server import GoalProgress

NOW = 1000.0
PROFILE = NamedLimits.of("gcr5_910")
NAMES = PROFILE.joint_names
START = (0.0, 0.3, 1.2, 0.1, -1.5, 0.0)


def way(share: float, way: float = 0.3) -> tuple[float, ...]:
    """A place on the way from START, each joint by as much."""
    smooth = share * share * (3.0 - 2.0 * share)
    return tuple(q + way * smooth for q in START)


def goal(count: int = 5, duration: float = 1.0, far: float = 0.3, **changes: Any) -> TrajectoryGoal:
    """A goal from START, that is right unless something of it is changed."""
    shares = [number / (count - 1) for number in range(count)]
    points = [GoalPoint(way(share, far), time=share * duration) for share in shares]
    return replace(TrajectoryGoal(NAMES, points), **changes)


def changed(number: int, **changes: Any) -> Callable[[], TrajectoryGoal]:
    """A goal with one point that is otherwise."""

    def make() -> TrajectoryGoal:
        right = goal()
        points = list(right.points)
        points[number] = points[number]._replace(**changes)
        return replace(right, points=points)

    return make


def all_points(**changes: Any) -> Callable[[], TrajectoryGoal]:
    """A goal with all points otherwise."""
    right = goal()
    return lambda: replace(right, points=[point._replace(**changes) for point in right.points])


def off(number: int, by: float) -> tuple[float, ...]:
    return tuple(q + by for q in goal().points[number].positions)


INVALID, JOINTS = ErrorCode.INVALID_GOAL, ErrorCode.INVALID_JOINTS
#: goals that are wrong wherever the arm is, with the code that tells so
WRONG: dict[str, tuple[Callable[[], TrajectoryGoal], ErrorCode]] = {
    "partial": (lambda: goal(joint_names=NAMES[:5]), JOINTS),
    "wrong name": (lambda: goal(joint_names=(*NAMES[:5], "elbow")), JOINTS),
    "twice": (lambda: goal(joint_names=(*NAMES[:5], NAMES[0])), JOINTS),
    "no names": (lambda: goal(joint_names=()), JOINTS),
    "seven names": (lambda: goal(joint_names=(*NAMES, "joint_7")), JOINTS),
    "empty": (lambda: goal(points=()), INVALID),
    "nan": (changed(2, positions=(math.nan, *START[1:])), INVALID),
    "infinite": (changed(2, positions=(math.inf, *START[1:])), INVALID),
    "short": (changed(2, positions=START[:5]), INVALID),
    "long": (changed(2, positions=(*START, 0.0)), INVALID),
    "no positions": (all_points(positions=()), INVALID),
    "velocities of one": (changed(2, velocities=(0.0,) * 6), INVALID),
    "short velocities": (all_points(velocities=(0.0,) * 5), INVALID),
    "velocities nan": (all_points(velocities=(math.nan,) * 6), INVALID),
    "accelerations alone": (all_points(accelerations=(0.0,) * 6), INVALID),
    "short effort": (all_points(effort=(0.0,) * 5), INVALID),
    "same time": (changed(2, time=0.25), INVALID),
    "back in time": (changed(2, time=0.1), INVALID),
    "negative time": (changed(0, time=-0.1), INVALID),
    "time nan": (changed(4, time=math.nan), INVALID),
    "time infinite": (changed(4, time=math.inf), INVALID),
    "endless": (changed(4, time=1e6), INVALID),
    "beyond the limits": (changed(4, positions=(6.5, *START[1:])), INVALID),
    "too fast": (lambda: goal(duration=0.05), INVALID),
    "too fast by velocities": (all_points(velocities=(0.0, 9.0, 0.0, 0.0, 0.0, 0.0)), INVALID),
    "not at rest": (all_points(velocities=(0.1,) * 6), INVALID),
    "times too close": (changed(1, time=5e-324), INVALID),
    "old": (lambda: goal(stamp=NOW - 5.0), ErrorCode.OLD_HEADER_TIMESTAMP),
    "far ahead": (lambda: goal(stamp=NOW + 3600.0), INVALID),
    "tolerance of none": (lambda: goal(path_tolerance=[NamedTolerance("elbow", 0.1)]), JOINTS),
    "tolerance nan": (lambda: goal(goal_tolerance=[NamedTolerance(NAMES[0], math.nan)]), INVALID),
    "tolerance of acceleration": (
        lambda: goal(path_tolerance=[NamedTolerance(NAMES[0], 0.1, acceleration=0.1)]),
        INVALID,
    ),
    "tolerance of speed nan": (
        lambda: goal(goal_tolerance=[NamedTolerance(NAMES[0], velocity=math.nan)]),
        INVALID,
    ),
    "goal time": (lambda: goal(goal_time_tolerance=-1.0), INVALID),
    "many points": (lambda: goal(count=6000, duration=60.0), INVALID),
}


@dataclass
class Client:
    """A goal's handle that remembers."""

    goal: TrajectoryGoal
    here: bool = True
    told: list[str] = field(default_factory=list)
    code: ErrorCode | None = None
    text: str = ""
    seen: list[GoalProgress] = field(default_factory=list)
    on_feedback: Callable[[GoalProgress], object] | None = None

    @property
    def done(self) -> bool:
        return any(word != "accepted" for word in self.told)

    def alive(self) -> bool:
        return self.here

    def accepted(self) -> None:
        self.told.append("accepted")

    def feedback(self, feedback: GoalProgress) -> None:
        self.seen.append(feedback)
        if self.on_feedback is not None:
            self.on_feedback(feedback)

    def succeeded(self) -> None:
        self.told.append("succeeded")

    def cancelled(self, text: str) -> None:
        self.told.append("cancelled")
        self.text = text

    def rejected(self, code: ErrorCode, text: str) -> None:
        self.told.append("rejected")
        self.code, self.text = code, text

    def aborted(self, code: ErrorCode, text: str) -> None:
        self.told.append("aborted")
        self.code, self.text = code, text
