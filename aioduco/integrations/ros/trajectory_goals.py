"""Goals of FollowJointTrajectory: what is carried out, and what is refused with which code."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco import JointTrajectory, Tolerances
from aioduco.errors import (
    DucoError,
    FirstPointTooFar,
    GoalToleranceViolated,
    ParameterError,
    PathToleranceViolated,
    RobotStateError,
)
from aioduco.kinematics import arm as arm_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = [
    "ArmProfile",
    "CheckedGoal",
    "ErrorCode",
    "GoalPoint",
    "GoalRefused",
    "GoalRules",
    "NamedTolerance",
    "TrajectoryGoal",
    "check_goal",
    "check_start",
    "code_of",
]

#: places in each piece of a curve at which its speed and its reach are looked at
_LOOKS = 16
#: of a number that is compared with a limit that it may have been computed from
_ROUNDING = 1e-3
#: the largest speed that streams take [rad/s], manual section 1.3.5
_FASTEST = 1.25 * math.pi
#: farther than any joint can be from any place [rad]: a tolerance that was erased
_ANYWHERE = 8.0 * math.pi
#: shortest time between two points [s]: what a message's nanoseconds round to is no way
_CLOSEST = 1e-6
#: speed at the end of a trajectory that counts as rest [rad/s]
_REST = 0.01


class ErrorCode(IntEnum):
    """Codes of FollowJointTrajectory's result."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


class GoalRefused(DucoError):
    """A goal was not accepted. Nothing was sent to the arm.

    Attributes:
        code: the code of the result.
    """

    def __init__(self, code: ErrorCode, reason: str) -> None:
        super().__init__(f"{reason}; nothing was sent")
        self.code = code


class GoalPoint(NamedTuple):
    """A point of a trajectory, its numbers in the order of the goal's joints.

    Attributes:
        positions: [rad].
        velocities: [rad/s], or empty.
        accelerations: [rad/s²], or empty.
        effort: or empty; only its length is looked at.
        time: from the trajectory's start [s].
    """

    positions: Sequence[float]
    velocities: Sequence[float] = ()
    accelerations: Sequence[float] = ()
    effort: Sequence[float] = ()
    time: float = 0.0


class NamedTolerance(NamedTuple):
    """How far one joint may be off; 0 for the default, below 0 for any distance.

    Attributes:
        name: of the joint.
        position: [rad].
        velocity: [rad/s]; not looked at, so that one above 0 is refused.
        acceleration: [rad/s²]; the same.
    """

    name: str
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True, slots=True)
class TrajectoryGoal:
    """A goal of FollowJointTrajectory, as it came.

    Attributes:
        joint_names: which joints, in the order of the points' numbers.
        points: the trajectory.
        stamp: when it is to begin, on the middleware's clock [s]; 0: now.
        path_tolerance: on the way.
        goal_tolerance: at the end.
        goal_time_tolerance: how long after the end that may take [s]; 0: the default.
    """

    joint_names: Sequence[str]
    points: Sequence[GoalPoint]
    stamp: float = 0.0
    path_tolerance: Sequence[NamedTolerance] = ()
    goal_tolerance: Sequence[NamedTolerance] = ()
    goal_time_tolerance: float = 0.0


@dataclass(frozen=True, slots=True)
class ArmProfile:
    """The arm of a node: its names and its limits.

    Attributes:
        joint_names: from the base to the flange, six.
        lower: lower joint limits [rad], six.
        upper: upper joint limits [rad], six.
        velocity: largest joint speeds [rad/s], six.
        acceleration: with which the arm follows and comes to rest [rad/s²].
    """

    joint_names: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    velocity: tuple[float, ...]
    acceleration: float

    @classmethod
    def of(
        cls,
        model: str,
        prefix: str = "",
        *,
        joint_names: Sequence[str] = (),
        velocity: float | None = None,
        acceleration: float = 10.0,
    ) -> ArmProfile:
        """The profile of a model of arm.

        Args:
            model: its name, such as "gcr5_910".
            prefix: before each name of a joint.
            joint_names: other names than joint_1 to joint_6.
            velocity: largest speed of each joint [rad/s]; None: the model's.
            acceleration: as in the class.

        Raises:
            ParameterError: there is no such model, the names are not six different ones, or a limit
                is not above 0.
        """
        arm = arm_of(model)
        names = tuple(joint_names) or tuple(f"joint_{number}" for number in range(1, 7))
        if len(set(names)) != 6 or len(names) != 6 or not all(names):
            raise ParameterError("joint_names", names, "six different names")
        for name, limit in (("velocity", velocity), ("acceleration", acceleration)):
            if limit is not None and not (math.isfinite(limit) and limit > 0.0):
                raise ParameterError(name, limit, "a number above 0")
        most = math.inf if velocity is None else velocity
        return cls(
            tuple(prefix + name for name in names),
            arm.lower,
            arm.upper,
            tuple(min(most, own, _FASTEST) for own in arm.velocity),
            min(acceleration, *arm.acceleration),
        )


@dataclass(frozen=True, slots=True)
class GoalRules:
    """What a goal must keep to, besides the arm's limits.

    Attributes:
        path: default tolerance on the way [rad]; 0: none.
        goal: default tolerance at the end [rad].
        goal_time: default time for that after the end [s].
        start: how far a joint may be from a first point that is due at once [rad].
        late: how old a stamp may be [s].
        ahead: how far in the future a stamp may be [s].
        longest: longest trajectory [s].
        most_points: most points of one.
    """

    path: float = 0.1
    goal: float = 0.01
    goal_time: float = 1.0
    start: float = 0.02
    late: float = 1.0
    ahead: float = 60.0
    longest: float = 600.0
    most_points: int = 5000


@dataclass(frozen=True, slots=True)
class CheckedGoal:
    """A goal that may be carried out, if the arm stands where it begins.

    Attributes:
        trajectory: in the arm's order of joints.
        tolerances: with the defaults filled in.
        begin: when it begins, on the middleware's clock [s]; 0: at once.
    """

    trajectory: JointTrajectory
    tolerances: Tolerances
    begin: float


def check_goal(
    goal: TrajectoryGoal, profile: ArmProfile, rules: GoalRules, now: float
) -> CheckedGoal:
    """Check all of a goal that can be told without the arm.

    Args:
        goal: as it came.
        profile: the arm.
        rules: what it must keep to.
        now: the time on the middleware's clock [s].

    Raises:
        GoalRefused: it is not carried out; says why.
    """
    order = _order(goal.joint_names, profile.joint_names)
    _check_points(goal.points, len(profile.joint_names), rules)
    _check_stamp(goal.stamp, rules, now)
    tolerances = Tolerances(
        path=_tolerance("path", goal.path_tolerance, profile, rules.path),
        goal=_tolerance("goal", goal.goal_tolerance, profile, rules.goal),
        goal_time=_goal_time(goal.goal_time_tolerance, rules),
    )

    def column(name: str) -> NDArray[np.float64] | None:
        rows = [getattr(point, name) for point in goal.points]
        return np.array(rows, dtype=np.float64)[:, order] if len(rows[0]) else None

    positions = column("positions")
    assert positions is not None
    _check_positions(positions, profile)
    try:
        trajectory = JointTrajectory(
            positions,
            [point.time for point in goal.points],
            column("velocities"),
            column("accelerations"),
        )
    except ParameterError as error:
        raise GoalRefused(ErrorCode.INVALID_GOAL, str(error)) from error
    last = trajectory.velocities
    if last is not None and np.abs(last[-1]).max() > _REST:
        raise GoalRefused(ErrorCode.INVALID_GOAL, "the last point is not at rest")
    _check_curve(trajectory, positions[0], profile)
    return CheckedGoal(trajectory, tolerances, goal.stamp)


def check_start(
    checked: CheckedGoal, actual: Sequence[float], profile: ArmProfile, rules: GoalRules
) -> None:
    """See that the trajectory begins where the arm is, or leads there slowly enough.

    Args:
        checked: the goal.
        actual: where the arm is [rad]. Shape (6,).
        profile: the arm.
        rules: what goals must keep to.

    Raises:
        GoalRefused: it does not.
    """
    trajectory = checked.trajectory
    here = np.asarray(actual, dtype=np.float64)
    if trajectory.times[0] > 0.0:
        _check_curve(trajectory, here, profile)
        return
    far = np.abs(trajectory.positions[0] - here)
    if not far.max() <= rules.start:
        joint = int(far.argmax())
        raise GoalRefused(
            ErrorCode.INVALID_GOAL,
            f"the trajectory begins elsewhere: {profile.joint_names[joint]} is {far[joint]:.4f} "
            f"rad from there, {rules.start:g} allowed; plan from where the arm is",
        )


def code_of(error: Exception) -> ErrorCode:
    """The code of a result, by the error that ended a goal.

    An arm that something else brought to rest on its way, such as a stop, is off its path.
    """
    if isinstance(error, GoalRefused):
        return error.code
    if isinstance(error, PathToleranceViolated):
        return ErrorCode.PATH_TOLERANCE_VIOLATED
    if isinstance(error, GoalToleranceViolated):
        return ErrorCode.GOAL_TOLERANCE_VIOLATED
    if isinstance(error, (ParameterError, FirstPointTooFar, RobotStateError)):
        return ErrorCode.INVALID_GOAL
    return ErrorCode.PATH_TOLERANCE_VIOLATED


def _order(names: Sequence[str], wanted: tuple[str, ...]) -> list[int]:
    """Where in the goal's numbers each joint of the arm is."""
    for name in names:
        if name not in wanted:
            raise GoalRefused(
                ErrorCode.INVALID_JOINTS, f"no joint is named {name!r}: {', '.join(wanted)}"
            )
    if len(set(names)) != len(names):
        raise GoalRefused(ErrorCode.INVALID_JOINTS, "a joint is named twice")
    missing = [name for name in wanted if name not in names]
    if missing:
        raise GoalRefused(
            ErrorCode.INVALID_JOINTS, f"a goal names all joints; {', '.join(missing)} missing"
        )
    return [list(names).index(name) for name in wanted]


def _check_points(points: Sequence[GoalPoint], count: int, rules: GoalRules) -> None:
    if not points:
        raise GoalRefused(ErrorCode.INVALID_GOAL, "the trajectory has no points")
    if len(points) > rules.most_points:
        raise GoalRefused(
            ErrorCode.INVALID_GOAL, f"{len(points)} points, up to {rules.most_points} allowed"
        )
    before = 0.0
    for number, point in enumerate(points):
        where = f"point {number}"
        for name in ("positions", "velocities", "accelerations", "effort"):
            values: Sequence[float] = getattr(point, name)
            if len(values) != len(getattr(points[0], name)):
                raise GoalRefused(
                    ErrorCode.INVALID_GOAL, f"{name} of {where}: not as many as of point 0"
                )
            if len(values) != count and (name == "positions" or len(values)):
                raise GoalRefused(
                    ErrorCode.INVALID_GOAL, f"{name} of {where}: {len(values)}, not {count}"
                )
            if not all(map(math.isfinite, values)):
                raise GoalRefused(ErrorCode.INVALID_GOAL, f"{name} of {where} are not finite")
        if len(point.accelerations) and not len(point.velocities):
            raise GoalRefused(
                ErrorCode.INVALID_GOAL, f"{where} has accelerations without velocities"
            )
        if not math.isfinite(point.time) or point.time < 0.0:
            raise GoalRefused(ErrorCode.INVALID_GOAL, f"the time of {where} is below 0")
        # A first point is either due at once, or led to from where the arm is.
        if point.time < before + _CLOSEST and not (number == 0 and point.time == 0.0):
            raise GoalRefused(ErrorCode.INVALID_GOAL, f"the time of {where} does not rise")
        before = point.time
    if before > rules.longest:
        raise GoalRefused(
            ErrorCode.INVALID_GOAL, f"it takes {before:.1f} s, up to {rules.longest:g} s allowed"
        )


def _check_stamp(stamp: float, rules: GoalRules, now: float) -> None:
    if stamp == 0.0:
        return
    if not math.isfinite(stamp) or stamp > now + rules.ahead:
        raise GoalRefused(
            ErrorCode.INVALID_GOAL, f"its stamp is more than {rules.ahead:g} s in the future"
        )
    if stamp < now - rules.late:
        raise GoalRefused(
            ErrorCode.OLD_HEADER_TIMESTAMP,
            f"its stamp is {now - stamp:.1f} s old, {rules.late:g} s allowed",
        )


def _tolerance(
    kind: str, given: Sequence[NamedTolerance], profile: ArmProfile, default: float
) -> tuple[float, ...]:
    found = dict.fromkeys(profile.joint_names, default or _ANYWHERE)
    for one in given:
        if one.name not in found:
            raise GoalRefused(
                ErrorCode.INVALID_JOINTS, f"{kind} tolerance: no joint is named {one.name!r}"
            )
        if not math.isfinite(one.position):
            raise GoalRefused(
                ErrorCode.INVALID_GOAL, f"{kind} tolerance of {one.name} is not finite"
            )
        if not (one.velocity <= 0.0 and one.acceleration <= 0.0):
            raise GoalRefused(
                ErrorCode.INVALID_GOAL,
                f"{kind} tolerance of {one.name}: only that of the position is looked at",
            )
        if one.position != 0.0:
            found[one.name] = _ANYWHERE if one.position < 0.0 else one.position
    return tuple(found.values())


def _goal_time(given: float, rules: GoalRules) -> float:
    if not math.isfinite(given) or given < 0.0 or given > rules.longest:
        raise GoalRefused(
            ErrorCode.INVALID_GOAL, f"goal time tolerance {given:g} s, 0 to {rules.longest:g}"
        )
    return given or rules.goal_time


def _check_positions(positions: NDArray[np.float64], profile: ArmProfile) -> None:
    over = (positions < np.array(profile.lower)) | (positions > np.array(profile.upper))
    if over.any():
        point, joint = np.argwhere(over)[0]
        raise GoalRefused(
            ErrorCode.INVALID_GOAL,
            f"point {point}: {profile.joint_names[joint]} at {positions[point, joint]:.4g} rad, "
            f"{profile.lower[joint]:.4g} to {profile.upper[joint]:.4g} allowed",
        )


def _check_curve(
    trajectory: JointTrajectory, actual: NDArray[np.float64], profile: ArmProfile
) -> None:
    """See that the curve through the points is not too fast, and leaves no limit between them."""
    shares = np.linspace(0.0, 1.0, _LOOKS, endpoint=False)
    with np.errstate(all="ignore"):
        curve = trajectory.curve(actual.tolist())
    times = (curve.times[:-1, None] + np.diff(curve.times)[:, None] * shares).ravel()
    times = np.append(times, curve.times[-1])
    with np.errstate(all="ignore"):
        places, speeds = curve.at(times), np.abs(curve.velocity(times))
    if not (np.isfinite(places).all() and np.isfinite(speeds).all()):
        raise GoalRefused(ErrorCode.INVALID_GOAL, "velocities or accelerations too large")
    most = np.array(profile.velocity)
    over = speeds.max(axis=0) - most * (1 + _ROUNDING)
    if over.max() > 0.0:
        joint = int(over.argmax())
        raise GoalRefused(
            ErrorCode.INVALID_GOAL,
            f"{profile.joint_names[joint]} at {speeds[:, joint].max():.4g} rad/s, up to "
            f"{most[joint]:.4g} allowed",
        )
    low, high = np.array(profile.lower) - _ROUNDING, np.array(profile.upper) + _ROUNDING
    if ((places < low) | (places > high)).any():
        raise GoalRefused(
            ErrorCode.INVALID_GOAL, "the curve through the points leaves the joints' limits"
        )
