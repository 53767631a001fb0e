"""What is asked of a planner, and what it answers: values that go from process to process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from aioduco.errors import ParameterError
from aioduco.models.pose import Joints, Pose

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning.motion_limits import MotionLimits

    Points = NDArray[np.float64]

__all__ = [
    "Goal",
    "GoalLike",
    "PlanningProblem",
    "Region",
    "Solution",
    "WorkerScene",
    "goals_of",
]


@dataclass(frozen=True, slots=True)
class Region:
    """Poses around one: anywhere in a box, and turned by up to some angles.

    Attributes:
        at: the pose of the tool in the middle, in the base frame [m, rad].
        size: whole lengths of the box along the axes of `at` [m].
        turn: largest turns about them, to either side [rad].
    """

    at: Pose
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", Pose.of(self.at))
        for name in ("size", "turn"):
            given = tuple(float(each) for each in getattr(self, name))
            if len(given) != 3 or not all(0.0 <= each < float("inf") for each in given):
                raise ParameterError(name, given, "three finite numbers, 0 or more")
            object.__setattr__(self, name, given)


Goal: TypeAlias = Joints | Pose | Region
GoalLike: TypeAlias = "Goal | Sequence[Goal]"
"""Where to: joints, a pose of the tool, a region of poses, or any of several of these."""


def goals_of(goal: GoalLike) -> tuple[Goal, ...]:
    """Take one goal or several.

    Raises:
        ParameterError: something else was given, such as six numbers that could be either.
    """
    given = (goal,) if isinstance(goal, Joints | Pose | Region) else tuple(goal)
    if not given or not all(isinstance(each, Joints | Pose | Region) for each in given):
        raise ParameterError("goal", goal, "Joints, a Pose, a Region, or several of these")
    return given


class WorkerScene(NamedTuple):
    """The scene of the problems that follow.

    Attributes:
        model: of MuJoCo.
        positions: of what is loose in it.
    """

    model: Any
    positions: Points


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningProblem:
    """From where to where, how, and how fast.

    Attributes:
        start: where the arm is [rad]. Shape (6,).
        goals: any of which will do.
        shape: "free" for any way; "line" or "arc" for the tool's way to the last pose.
        limits: of the joints.
        tip: of the tool in the flange's frame. Shape (4, 4).
        upright: whether the tool may only turn about the vertical.
        up: the vertical in the base's frame. Shape (3,).
        partial: whether a part of a line or arc will do.
        rate: largest speed of the tool along a line or arc [m/s].
        padding: distance to keep [m].
        timeout: for the search [s].
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """What was found.

    Attributes:
        times, positions, velocities, accelerations: of the joints [s, rad].
        corners: configurations between which the way is about straight [rad]. Shape (n, 6).
        looked: times at which the clearance was measured [s].
        clearances: the distance to the nearest thing then, at most 0.1 [m].
        radii: how far a turn of each joint can move a point [m/rad]. Shape (6,).
        padding: distance that was kept [m].
        fraction: how much of a line or arc it is.
        searching: processor time for the path [s].
        timing: and for its times [s].
    """

    times: Points
    positions: Points
    velocities: Points
    accelerations: Points
    corners: Points
    looked: Points
    clearances: Points
    radii: Points
    padding: float
    fraction: float
    searching: float
    timing: float
