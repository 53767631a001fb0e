"""Goals of FollowJointTrajectory: which are carried out, and which are refused with what code."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Final, NamedTuple

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
from aioduco.models.bounds import outside, shown
from aioduco.models.ranges import JOINT_SPEED
from aioduco.models.rules import Number, stored
from aioduco.models.user_terms import in_terms_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


#: number of places in each piece of a curve at which its speed and position are checked
_LOOKS = 16
#: tolerance of comparisons with a limit from which the number may have been computed
_ROUNDING = 1e-3
#: larger than any possible distance of a joint [rad]: stands for no tolerance
_ANYWHERE = 8.0 * math.pi
#: shortest time between two points [s]: less is a rounding error of a message's nanoseconds
_CLOSEST = 1e-6
#: speed at the end of a trajectory that counts as rest [rad/s]
_REST = 0.01


#: function of the robot that errors and advice name -> the service that does the same
_IN_PLACE_OF: Final = {
    **{name: f"~/{name}" for name in ("bring_up", "recover", "stop", "pause", "resume")},
    "rearm_heartbeat": "~/recover",
    "fc_force_set_value": "io_and_status_controller/zero_ftsensor",
}


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


class GoalEnded(DucoError):
    """The driver ended a goal: it was late, or the arm was too fast. The arm was brought to rest.

    Attributes:
        code: the code of the result.
    """

    def __init__(self, code: ErrorCode, reason: str) -> None:
        super().__init__(f"{reason}; the arm was brought to rest")
        self.code = code


class GoalPoint(NamedTuple):
    """A point of a trajectory, its numbers in the order of the goal's joints.

    Attributes:
        positions: joint angles [rad].
        velocities: joint speeds [rad/s]; may be empty.
        accelerations: joint accelerations [rad/s²]; may be empty.
        effort: may be empty; only its length is checked.
        time: time since the start of the trajectory [s].
    """

    positions: Sequence[float]
    velocities: Sequence[float] = ()
    accelerations: Sequence[float] = ()
    effort: Sequence[float] = ()
    time: float = 0.0


class NamedTolerance(NamedTuple):
    """Largest deviation of one joint; 0 for the default, below 0 for any distance.

    Attributes:
        name: name of the joint.
        position: tolerance of the position [rad].
        velocity: tolerance of the speed [rad/s]; 0: not checked.
        acceleration: tolerance of the acceleration [rad/s²]; not supported: the controller's
            accelerations are not those of the joints. A value above 0 is refused.
    """

    name: str
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True, slots=True)
class TrajectoryGoal:
    """A goal of FollowJointTrajectory, as received.

    Attributes:
        joint_names: names of the joints, in the order of the points' numbers.
        points: points of the trajectory.
        stamp: start time, on the middleware's clock [s]; 0: now.
        path_tolerance: tolerances on the way.
        goal_tolerance: tolerances at the end.
        goal_time_tolerance: time after its own end within which the arm must be there [s]; 0: the
            default.
    """

    joint_names: Sequence[str]
    points: Sequence[GoalPoint]
    stamp: float = 0.0
    path_tolerance: Sequence[NamedTolerance] = ()
    goal_tolerance: Sequence[NamedTolerance] = ()
    goal_time_tolerance: float = 0.0


@dataclass(frozen=True, slots=True)
class NamedLimits:
    """Names and limits of a node's arm.

    Attributes:
        joint_names: names from the base to the flange, six.
        lower: lower joint limits [rad], six.
        upper: upper joint limits [rad], six.
        velocity: largest joint speeds [rad/s], six.
        acceleration: acceleration with which the arm follows and comes to rest [rad/s²].
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
    ) -> NamedLimits:
        """Make the profile of an arm's model.

        Args:
            model: name of the model, such as "gcr5_910".
            prefix: prefix of each joint name.
            joint_names: names of the joints; empty for joint_1 to joint_6.
            velocity: largest speed of each joint [rad/s]; None: the model's limits.
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
            tuple(min(most, own, JOINT_SPEED.high) for own in arm.velocity),
            min(acceleration, *arm.acceleration),
        )


@dataclass(frozen=True, slots=True)
class GoalRules:
    """Rules for a goal, besides the arm's limits.

    Attributes:
        path: default tolerance on the way [rad]; 0: none.
        goal: default tolerance at the end [rad].
        goal_time: default time after a goal's own end within which the arm must be there [s].
        start: largest distance of a joint from a first point that is due at once [rad].
        max_stamp_age: largest age of a stamp [s].
        max_stamp_ahead: largest time of a stamp in the future [s].
        max_duration: longest duration of a trajectory [s].
        most_points: largest number of points of a trajectory.

    Raises:
        ParameterError: a number is not finite, below 0 or too large.
    """

    path: float = 0.1
    goal: float = 0.01
    goal_time: float = 2.0
    start: float = 0.02
    max_stamp_age: float = 1.0
    max_stamp_ahead: float = 60.0
    max_duration: float = 600.0
    most_points: int = 5000

    def __post_init__(self) -> None:
        angle = Number(0.0, _ANYWHERE, "rad", source="this package")
        stored(self, path=angle, goal=angle, start=angle)
        time = Number(0.0, 3600.0, "s", source="this package")
        stored(self, goal_time=time, max_stamp_age=time, max_stamp_ahead=time, max_duration=time)


@dataclass(frozen=True, slots=True)
class CheckedGoal:
    """A goal that may be carried out, if the arm stands at its start.

    Attributes:
        trajectory: trajectory in the arm's order of joints.
        tolerances: tolerances, with the defaults filled in.
        begin: start time, on the middleware's clock [s]; 0: at once.
        path_speed: largest differences of the joints' speeds from the path's [rad/s]; None: any.
        goal_speed: largest speeds of the joints at the end [rad/s]; None: any.
    """

    trajectory: JointTrajectory
    tolerances: Tolerances
    begin: float
    path_speed: tuple[float, ...] | None = None
    goal_speed: tuple[float, ...] | None = None


def check_goal(
    goal: TrajectoryGoal, profile: NamedLimits, rules: GoalRules, now: float
) -> CheckedGoal:
    """Check everything in a goal that can be checked without the arm.

    Args:
        goal: the goal, as received.
        profile: names and limits of the arm.
        rules: rules for goals.
        now: the time on the middleware's clock [s].

    Raises:
        GoalRefused: the goal is refused; the message says why.
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
        raise _invalid(str(error)) from error
    last = trajectory.velocities
    if last is not None and np.abs(last[-1]).max() > _REST:
        raise _invalid("the last point is not at rest")
    _check_curve(trajectory, positions[0], profile)
    return CheckedGoal(
        trajectory,
        tolerances,
        goal.stamp,
        _speed_tolerance(goal.path_tolerance, profile),
        _speed_tolerance(goal.goal_tolerance, profile),
    )


def check_start(
    checked: CheckedGoal, actual: Sequence[float], profile: NamedLimits, rules: GoalRules
) -> None:
    """Check that the trajectory begins at the arm's position, or leads from there slowly enough.

    Args:
        checked: the goal.
        actual: position of the arm [rad]. Shape (6,).
        profile: names and limits of the arm.
        rules: rules for goals.

    Raises:
        GoalRefused: the trajectory begins elsewhere, or is too fast.
    """
    trajectory = checked.trajectory
    here = np.asarray(actual, dtype=np.float64)
    if trajectory.times[0] > 0.0:
        _check_curve(trajectory, here, profile)
        return
    far = np.abs(trajectory.positions[0] - here)
    if not far.max() <= rules.start:
        joint = int(far.argmax())
        raise _invalid(
            f"the trajectory begins elsewhere: {profile.joint_names[joint]} is {far[joint]:.4f} "
            f"rad from there, {rules.start:g} allowed; plan from where the arm is"
        )


def said(told: object) -> str:
    """The text of an error or a result, with services and goals in place of what Python has."""
    text = in_terms_of(_IN_PLACE_OF, str(told) or repr(told))
    for verb, other in (("open", "send"), ("Open", "Send")):  # a goal opens its stream itself
        text = text.replace(f"{verb} a new stream", f"{other} a new goal")
    return text


def code_of(error: Exception) -> ErrorCode:
    """The code of a result, for the error that ended a goal.

    If something else stopped the arm on its way, the path tolerance counts as violated.
    """
    if isinstance(error, (GoalRefused, GoalEnded)):
        return error.code
    if isinstance(error, PathToleranceViolated):
        return ErrorCode.PATH_TOLERANCE_VIOLATED
    if isinstance(error, GoalToleranceViolated):
        return ErrorCode.GOAL_TOLERANCE_VIOLATED
    if isinstance(error, (ParameterError, FirstPointTooFar, RobotStateError)):
        return ErrorCode.INVALID_GOAL
    return ErrorCode.PATH_TOLERANCE_VIOLATED


def _invalid(reason: str) -> GoalRefused:
    return GoalRefused(ErrorCode.INVALID_GOAL, reason)


def _order(names: Sequence[str], wanted: tuple[str, ...]) -> list[int]:
    """Index of each joint of the arm in the goal's numbers."""
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
        raise _invalid("the trajectory has no points")
    if len(points) > rules.most_points:
        raise _invalid(f"{len(points)} points, up to {rules.most_points} allowed")
    before = 0.0
    for number, point in enumerate(points):
        where = f"point {number}"
        for name in ("positions", "velocities", "accelerations", "effort"):
            values: Sequence[float] = getattr(point, name)
            if len(values) != len(getattr(points[0], name)):
                raise _invalid(f"{name} of {where}: not as many as of point 0")
            if len(values) != count and (name == "positions" or len(values)):
                raise _invalid(f"{name} of {where}: {len(values)}, not {count}")
            if not all(map(math.isfinite, values)):
                raise _invalid(f"{name} of {where} are not finite")
        if len(point.accelerations) and not len(point.velocities):
            raise _invalid(f"{where} has accelerations without velocities")
        if not math.isfinite(point.time) or point.time < 0.0:
            raise _invalid(f"the time of {where} is below 0")
        # A first point is due at once, or the trajectory leads to it from the arm's position.
        if point.time < before + _CLOSEST and not (number == 0 and point.time == 0.0):
            raise _invalid(f"the time of {where} does not rise")
        before = point.time
    if before > rules.max_duration:
        raise _invalid(f"it takes {before:.1f} s, up to {rules.max_duration:g} s allowed")


def _check_stamp(stamp: float, rules: GoalRules, now: float) -> None:
    if stamp == 0.0:
        return
    if not math.isfinite(stamp) or stamp > now + rules.max_stamp_ahead:
        raise _invalid(f"its stamp is more than {rules.max_stamp_ahead:g} s in the future")
    if stamp < now - rules.max_stamp_age:
        raise GoalRefused(
            ErrorCode.OLD_HEADER_TIMESTAMP,
            f"its stamp is {now - stamp:.1f} s old, {rules.max_stamp_age:g} s allowed",
        )


def _tolerance(
    kind: str, given: Sequence[NamedTolerance], profile: NamedLimits, default: float
) -> tuple[float, ...]:
    found = dict.fromkeys(profile.joint_names, default or _ANYWHERE)
    for one in given:
        if one.name not in found:
            raise GoalRefused(
                ErrorCode.INVALID_JOINTS, f"{kind} tolerance: no joint is named {one.name!r}"
            )
        if not (math.isfinite(one.position) and math.isfinite(one.velocity)):
            raise _invalid(f"{kind} tolerance of {one.name} is not finite")
        if not one.acceleration <= 0.0:
            raise _invalid(f"{kind} tolerance of {one.name}: accelerations are not looked at")
        if one.position != 0.0:
            found[one.name] = _ANYWHERE if one.position < 0.0 else one.position
    return tuple(found.values())


def _speed_tolerance(
    given: Sequence[NamedTolerance], profile: NamedLimits
) -> tuple[float, ...] | None:
    """Tolerances of the joints' speeds, of a list that `_tolerance` has checked; None for none."""
    found = dict.fromkeys(profile.joint_names, math.inf)
    found |= {one.name: one.velocity for one in given if one.velocity > 0.0}
    return tuple(found.values()) if min(found.values()) < math.inf else None


def _goal_time(given: float, rules: GoalRules) -> float:
    if not math.isfinite(given) or given < 0.0 or given > rules.max_duration:
        raise _invalid(f"goal time tolerance {given:g} s, 0 to {rules.max_duration:g}")
    return given or rules.goal_time


def _check_positions(positions: NDArray[np.float64], profile: NamedLimits) -> None:
    over = outside(positions, profile.lower, profile.upper)
    if over.any():
        point, joint = np.argwhere(over)[0]
        raise _invalid(
            f"point {point}: {profile.joint_names[joint]} at {positions[point, joint]:.4g} rad, "
            f"{shown(profile.lower[joint], low=True)} to {shown(profile.upper[joint])} allowed"
        )


def _check_curve(
    trajectory: JointTrajectory, actual: NDArray[np.float64], profile: NamedLimits
) -> None:
    """Check that the curve through the points keeps the limits of speed and position."""
    shares = np.linspace(0.0, 1.0, _LOOKS, endpoint=False)
    with np.errstate(all="ignore"):
        curve = trajectory.curve(actual.tolist())
    times = (curve.times[:-1, None] + np.diff(curve.times)[:, None] * shares).ravel()
    times = np.append(times, curve.times[-1])
    with np.errstate(all="ignore"):
        places, speeds = curve.at(times), np.abs(curve.velocity(times))
    if not (np.isfinite(places).all() and np.isfinite(speeds).all()):
        raise _invalid("velocities or accelerations too large")
    most = np.array(profile.velocity)
    over = speeds.max(axis=0) - most * (1 + _ROUNDING)
    if over.max() > 0.0:
        joint = int(over.argmax())
        raise _invalid(
            f"{profile.joint_names[joint]} at {speeds[:, joint].max():.4g} rad/s, up to "
            f"{shown(most[joint])} allowed"
        )
    low, high = np.array(profile.lower) - _ROUNDING, np.array(profile.upper) + _ROUNDING
    if ((places < low) | (places > high)).any():
        raise _invalid("the curve through the points leaves the joints' limits")
