"""The paths of servo set-points: targets that replace each other while the arm moves.

The arm is somewhere between its last known position and the last target, and each joint goes to the
new target at its own pace: as fast as the set-point allows, until it is there.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from aioduco.envelope.ways import Way, check_way, polyline
from aioduco.errors import Unreachable
from aioduco.models.pose import Pose

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.envelope.checker import EnvelopeChecker
    from aioduco.envelope.limits import Crossing
    from aioduco.envelope.ways import Config, Start
    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array


#: by function of the wire: the indices of tool and work object among its arguments. Its first three
#: arguments are the target, the speed and the acceleration
SERVO: dict[str, tuple[int | None, int | None]] = {
    "servoj": (None, None),
    "servoj_pose": (4, 5),
    "servo_tcp": (3, None),
    "servol": (4, 5),
}
#: those whose v is the tool's in manual 4.3 [m/s]; by manual 3.8 it is the joints' [rad/s]
BY_TOOL = ("servo_tcp", "servol")
#: largest distance of two positions of the arm from which the way to the target is checked [rad]
_APART = 0.02
_SMALL = 2e-4  # turn of a joint that makes no corner of the path [rad]
_MOST = 16  # largest number of these positions


def servo_target(
    arm: Arm, name: str, args: Sequence[Any], start: Start, last: Sequence[float]
) -> Config | None:
    """The target of a set-point as joint angles [rad].

    Args:
        arm: the arm.
        name: the function of the wire, of `SERVO`.
        args: its arguments.
        start: position of the arm, and the frames of the set-point.
        last: the last target; the arm's position if there is none [rad].

    Returns:
        The target; None if it cannot be reached, which the controller then reports.
    """
    if name == "servoj":
        return tuple(args[0])
    base, tip, back = _matrices(start.tool, start.wobj)
    given = Pose.of(args[0]).matrix
    if name == "servo_tcp":
        flange, near = arm.fkine(last) @ tip @ given @ back, last
    else:
        flange, near = base @ given @ back, args[3] or last
    try:
        return tuple(arm.ikine(flange, near).tolist())
    except Unreachable:
        return None


@lru_cache(maxsize=8)  # set-points follow each other with the same frames
def _matrices(tool: Pose, wobj: Pose) -> tuple[Array, Array, Array]:
    """The work object in the base, the tool in the flange, and the flange in the tool."""
    return wobj.matrix, tool.matrix, tool.inverse().matrix


def servo_ways(
    here: Config, last: Config, target: Config, v: float, tool_v: float = 0.0
) -> list[Way]:
    """The paths that the arm may take to a target.

    Args:
        here: last known position of the arm [rad].
        last: the last target; the arm is between the two [rad].
        target: the new target [rad].
        v: largest speed of each joint [rad/s].
        tool_v: largest speed of the tool, if the set-point has that [m/s].
    """
    off = [b - a for a, b in zip(here, last, strict=True)]
    count = min(_MOST, math.ceil(max(map(abs, off)) / _APART))
    starts = [
        tuple([a + number / count * o for a, o in zip(here, off, strict=True)])
        for number in range(1, count)
    ]
    if count:
        starts.append(last)
    return [polyline(_corners(start, target), v, tool_v) for start in (here, *starts)]


def _corners(start: Config, target: Config) -> list[Config]:
    """The points at which another joint is there, if all turn equally fast."""
    way = [b - a for a, b in zip(start, target, strict=True)]

    def reached(turned: float) -> Config:
        return tuple(
            [
                b if abs(w) <= turned else a + math.copysign(turned, w)
                for a, b, w in zip(start, target, way, strict=True)
            ]
        )

    turns = sorted({abs(w) for w in way if abs(w) > _SMALL})
    return [start, *map(reached, turns)] if turns else [start, target]


def braking(here: Config, speeds: Sequence[float], a: float) -> Way:
    """The path on which a moving arm comes to rest, each joint at an acceleration [rad/s²]."""
    rest = tuple([q + v * abs(v) / (2 * a) for q, v in zip(here, speeds, strict=True)])
    return polyline(_corners(here, rest), max(map(abs, speeds)))


def check_servo(
    checker: EnvelopeChecker,
    here: Config,
    last: Config,
    target: Config,
    v: float,
    slowing: Way | None = None,
    tool_v: float = 0.0,
) -> tuple[Crossing | None, float]:
    """Check all paths that the arm may take to a target.

    Args:
        checker: checker for joints.
        here: last known position of the arm [rad].
        last: the last target [rad].
        target: the new target [rad].
        v: largest speed of each joint [rad/s].
        slowing: a path that is checked as well.
        tool_v: largest speed of the tool, if the set-point has that [m/s].

    Returns:
        The limit that a path would cross, or does not lead back from, if any; and the share of the
        speed at which the limits with the action "slow" are kept.
    """
    if slowing is None and checker.begun and not (checker.leaving or checker.times):
        # Nearly always no limit is in reach, whichever way the arm takes.
        reached = checker.may_reach(here, last, target) or checker.may_reach(here, target)
        if not reached:
            return None, 1.0
    share = 1.0
    ways = servo_ways(here, last, target, v, tool_v)
    for way in ways if slowing is None else [*ways, slowing]:
        # Nearly always it begins within the limits: only then it may be taken for known.
        found, slowed = check_way(checker, way, known=True)
        if found is not None:
            found, slowed = check_way(checker, way)
        if found is not None:
            return found, share
        share = min(share, slowed)
    return None, share
