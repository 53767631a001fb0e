"""Requests to a planner: values that are sent from process to process."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from aioduco.errors import ParameterError
from aioduco.models.pose import Joints, Pose
from aioduco.models.ranges import POSE
from aioduco.models.rules import FARTHEST, Number, Vector

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning.motion_limits import MotionLimits

    Points = NDArray[np.float64]


_SIZES = Vector(Number(0.0, unit="m", plausible=FARTHEST, source="this package"), length=3)
_TURNS = Vector(Number(0.0, 2 * math.pi, "rad", source="this package"), length=3)


@dataclass(frozen=True, slots=True)
class Region:
    """Poses around a given one: positions in a box, and turns by up to given angles.

    Attributes:
        at: the pose of the tool in the middle, in the base frame [m, rad].
        size: whole lengths of the box along the axes of `at` [m].
        turn: largest turns about them, to either side, 0 to 2π [rad].
    """

    at: Pose
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", Pose.of(self.at))
        for name, rule in (("size", _SIZES), ("turn", _TURNS)):
            object.__setattr__(self, name, tuple(rule(name, getattr(self, name))))


Goal: TypeAlias = Joints | Pose | Region
GoalLike: TypeAlias = "Goal | Sequence[Goal]"
"""Where to: joints, a pose of the tool, a region of poses, or any of several of these."""


def goals_of(goal: GoalLike) -> tuple[Goal, ...]:
    """Make a tuple of one goal or several.

    Raises:
        ParameterError: something else was given, such as six numbers that could be either, or a
            pose is out of range.
    """
    if isinstance(goal, Joints | Pose | Region):
        return (_in_range(goal),)
    given = tuple(goal) if isinstance(goal, Iterable) else ()
    if not given or not all(isinstance(each, Joints | Pose | Region) for each in given):
        raise ParameterError("goal", goal, "Joints, a Pose, a Region, or several of these")
    return tuple(map(_in_range, given))


def _in_range(goal: Goal) -> Goal:
    """Check the pose of a goal as motions do: turned by 180 rad, it is one in degrees."""
    if not isinstance(goal, Joints):
        POSE("goal", goal.at if isinstance(goal, Region) else goal)
    return goal


class WorkerScene(NamedTuple):
    """The scene of the problems that follow.

    Attributes:
        model: MuJoCo model.
        positions: positions of the loose things in it.
    """

    model: Any
    positions: Points


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningProblem:
    """Start, goals, constraints and limits of a plan.

    Attributes:
        start: configuration of the arm [rad]. Shape (6,).
        goals: goals, of which any is enough.
        shape: "free" for any path; "line" or "arc" for the tool's path to the last pose.
        limits: limits of the joints.
        tip: the tool's tip in the flange's frame. Shape (4, 4).
        upright: whether the tool may only turn about the vertical.
        up: the vertical in the base's frame. Shape (3,).
        partial: whether a part of a line or arc is enough.
        rate: largest speed of the tool along a line or arc [m/s].
        padding: distance to keep [m].
        timeout: time-out of the search [s].
    """

    arm: Arm
    start: Points
    goals: tuple[Goal, ...]
    limits: MotionLimits
    tip: Points
    up: Points
    shape: str = "free"
    upright: bool = False
    partial: bool = False
    rate: float = float("inf")
    padding: float = 0.005
    timeout: float = 5.0
