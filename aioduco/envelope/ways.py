"""The paths of motions, as far as they are known before the motions are sent, and their check.

A joint motion is straight in joint angles. In a linear motion the tool's tip moves straight while
the tool turns at a constant rate about one axis; an arc does the same on a circle. `servo` has the
paths of servo set-points, `velocities` those of motions at a velocity and of jogs. The controller
chooses the path of other motions; they are checked only by the state, while they run, and by the
points through which they lead, if these are known.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.errors import Unreachable
from aioduco.kinematics.forward import singular_values
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, matrix_from_rotvec, rotvec_from_matrix

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.envelope.checker import EnvelopeChecker
    from aioduco.envelope.limits import Crossing
    from aioduco.kinematics import Arm

    Config = tuple[float, ...]
    #: function that returns the poses of the tip at shares of a path, shape (n, 4, 4); and the
    #: number of steps of the path
    _Poses = tuple[Callable[[Sequence[float]], Array], int]


#: by function of the wire: the indices of speed, blend radius, tool and work object among its
#: arguments; and whether speed and radius are in percent
WAYS: dict[str, tuple[int, int, int | None, int | None, bool]] = {
    "movej2": (1, 3, None, None, False),
    "movej": (1, 3, None, None, True),
    "movej_pose2": (1, 3, 5, 6, False),
    "movej_pose": (1, 3, 5, 6, True),
    "movel": (1, 3, 5, 6, False),
    "movec": (2, 4, 7, 8, False),
    "move_circle": (2, 4, 7, 8, False),
    "tcp_move": (1, 3, 4, None, False),
    "wobj_move": (1, 3, None, 4, False),
    # Where a work object moves with an external axis, only the way of the joints is known.
    "movej2_eaxis": (1, 3, None, None, False),
}
#: by function of the wire, for paths that the controller chooses between points: the indices of the
#: points, of the tool and of the work object among its arguments
POINTS: dict[str, tuple[int, int, int]] = {
    "spline": (0, 3, 4),
    "spline_op": (0, 3, 4),
    "move_spiral": (1, 9, 10),
}
_STEP = 0.02  # largest step between two positions of a path [rad, m]
_TURN = 0.05  # largest turn between two orientations [rad]
_MOST = 1000  # largest number of steps
_HALVINGS = 6  # halvings of a step that seems to cross a limit
_LOOKS = 12  # least number of poses on a path at which the joints are computed, if it has as many
_FAR = 1.0  # turn of a joint between two of them that may be another one [rad]
_CLOSEST = 2e-4  # distance of two of them between which none is looked at [share of the path]
_SAME = 1e-6  # distance up to which two positions count as equal [m]
_STRAIGHT = 1e-9  # sine of an angle between three points whose circle is larger than any arm
_CUT = 0.01  # largest step between two sums that a corner is checked at [m]
_CUTS = (4, 24)  # number of these steps on each leg of a corner


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """The start of a motion.

    Attributes:
        joints: joint angles [rad]. Shape (6,).
        tool: pose of the tool's tip in the frame of the flange [m, rad].
        wobj: pose of the work object in the base frame [m, rad].
    """

    joints: tuple[float, ...]
    tool: Pose
    wobj: Pose


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """The path of a motion, from its start to its end.

    Attributes:
        configs: joint angles [rad], or poses of the tip (`checker.Tip`), at equal shares.
        by_tip: whether `configs` are poses of the tip.
        v: requested speed: of the leading joint [rad/s], or of the tip [m/s].
        end: joint angles at the end [rad].
        radius: blend radius at the end [m]; infinite where it is not known.
        at: function that returns the configurations at shares of the path, from 0 to 1.
        tool_v: speed of the tool that is requested besides, of a path of joints [m/s].
    """

    configs: list[Config]
    by_tip: bool
    v: float
    end: Config
    radius: float
    at: Callable[[Sequence[float]], list[Config]]
    tool_v: float = 0.0


def way_of(arm: Arm, name: str, args: Sequence[Any], start: Start) -> Way | None:
    """The path of a motion.

    Args:
        arm: the arm.
        name: the function of the wire.
        args: its arguments.
        start: start of the motion, and its frames.

    Returns:
        The path; None if the pose cannot be reached, which the controller then reports.
    """
    speed, radius, _, _, percent = WAYS[name]
    v, r = float(args[speed]), float(args[radius])
    if percent:
        v *= max(arm.velocity) / 100
        # of the controller's largest radius, which is not known
        r = math.inf if r > 0.0 else 0.0
    if name in ("movej2", "movej", "movej2_eaxis"):
        return joint_way(start.joints, tuple(args[0]), v, r)
    back = start.tool.inverse().matrix
    base, tip = start.wobj.matrix, start.tool.matrix
    here = arm.fkine(start.joints) @ tip
    if name in ("movej_pose2", "movej_pose"):
        near = args[4] or start.joints
        try:
            target = arm.ikine(base @ Pose.of(args[0]).matrix @ back, near)
        except Unreachable:
            return None
        return joint_way(start.joints, tuple(target.tolist()), v, r)
    if name == "movel":
        poses, count = _line(here, base @ Pose.of(args[0]).matrix)
    elif name == "tcp_move":
        poses, count = _line(here, here @ Pose.of(args[0]).matrix)
    elif name == "wobj_move":
        inside = np.linalg.inv(base) @ here
        offset = Pose.of(args[0]).matrix
        moved = inside.copy()
        moved[:3, 3] += offset[:3, 3]
        moved[:3, :3] = offset[:3, :3] @ inside[:3, :3]
        poses, count = _line(here, base @ moved)
    else:
        first, second = (base @ Pose.of(args[n]).matrix for n in (0, 1))
        poses, count = _arc(here, first, second, int(args[5]), full=name == "move_circle")

    end = _followed(arm, (poses, count), back, start.joints)
    return line_way(poses, count, v, end, r)


def points_of(
    arm: Arm, name: str, args: Sequence[Any], start: Start
) -> list[tuple[float, ...]] | None:
    """The poses through which a path leads that the controller chooses, as joint angles [rad].

    Args:
        arm: the arm.
        name: the function of the wire, of `POINTS`.
        args: its arguments.
        start: start of the motion, and its frames.

    Returns:
        The joints; None if a pose cannot be reached, which the controller then reports.
    """
    at = POINTS[name][0]
    given = args[at] if name != "move_spiral" else [args[at]] if args[5] == 1 else []
    base, back = start.wobj.matrix, start.tool.inverse().matrix
    near, found = start.joints, []
    for point in given:
        pose = point.pos if name == "spline_op" else point
        try:
            near = tuple(arm.ikine(base @ Pose.of(pose).matrix @ back, near).tolist())
        except Unreachable:
            return None
        found.append(near)
    return found


def line_way(poses: Any, count: int, v: float, end: Config, r: float = 0.0) -> Way:
    """The path of the tool's tip through poses.

    Args:
        poses: function that returns the poses of the tip at shares of the path.
        count: number of steps of the path.
        v: requested speed of the tip [m/s].
        end: joint angles at the end [rad].
        r: blend radius at the end [m].
    """

    def at(shares: Sequence[float]) -> list[Config]:
        found = poses(shares)
        return [(*m[:3, :3].ravel().tolist(), *m[:3, 3].tolist()) for m in found]

    return Way(at(np.linspace(0.0, 1.0, count + 1).tolist()), True, v, end, r, at)


def _followed(arm: Arm, poses: _Poses, back: Array, q: tuple[float, ...]) -> tuple[float, ...]:
    """The joints at the end of a path of the tip, or at its last pose that can be reached.

    Beside a singularity the nearest configuration for a pose further on may be on another branch,
    which the arm does not get to. So where the branch changes, or a joint turns far, the poses
    between are looked at first.
    """
    at, count = poses
    shares = np.linspace(0.0, 1.0, min(_LOOKS, count) + 1)[1:].tolist()
    here, todo = 0.0, list(zip(shares, at(shares) @ back, strict=True))[::-1]
    while todo:
        share, flange = todo[-1]
        try:
            there = arm.ikine(flange, q)
        except Unreachable:
            break
        before, after = singular_values(arm.geometry, np.array([q, there]))
        far = (before * after < 0.0).any() or np.abs(there - q).max() > _FAR
        if far and share - here > _CLOSEST:
            middle = (here + share) / 2
            todo.append((middle, at([middle])[0] @ back))
        else:
            q, here = tuple(there.tolist()), todo.pop()[0]
    return q


def joint_way(q0: Sequence[float], q1: Sequence[float], v: float, r: float = 0.0) -> Way:
    """The path of a motion that is straight in joint angles [rad], at a speed [rad/s]."""
    start, end = np.array(q0), np.array(q1)
    count = min(_MOST, max(1, math.ceil(float(np.abs(end - start).max()) / _STEP)))

    def at(shares: Sequence[float]) -> list[Config]:
        return [tuple(row) for row in (start + np.outer(shares, end - start)).tolist()]

    configs = at(np.linspace(0.0, 1.0, count + 1).tolist())
    return Way(configs, False, v, configs[-1], r, at)


def polyline(points: Sequence[Config], v: float, tool_v: float = 0.0) -> Way:
    """The path from joint angles to joint angles [rad], straight in between.

    Args:
        points: joint angles [rad].
        v: speed of the leading joint [rad/s].
        tool_v: speed of the tool that is requested besides [m/s].
    """
    configs = [points[0]]
    for there in points[1:]:
        here = configs[-1]
        way = [b - a for a, b in zip(here, there, strict=True)]
        count = min(_MOST, math.ceil(max(map(abs, way)) / _STEP))
        configs += [
            tuple([a + number / count * w for a, w in zip(here, way, strict=True)])
            for number in range(1, count)
        ]
        configs.append(there)
    last = len(configs) - 1

    def at(shares: Sequence[float]) -> list[Config]:
        found = []
        for share in shares:
            number = min(int(share * last), max(0, last - 1))
            a, b, part = configs[number], configs[min(number + 1, last)], share * last - number
            found.append(tuple([x + part * (y - x) for x, y in zip(a, b, strict=True)]))
        return found

    return Way(configs, False, v, configs[-1], 0.0, at, tool_v)


def _count(length: float, turn: float) -> int:
    return min(_MOST, max(1, math.ceil(max(length / _STEP, turn / _TURN))))


def _line(start: Array, end: Array) -> _Poses:
    turn = rotvec_from_matrix(start[:3, :3].T @ end[:3, :3])
    length = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))

    def poses(shares: Sequence[float]) -> Array:
        found = np.tile(np.eye(4), (len(shares), 1, 1))
        found[:, :3, :3] = start[:3, :3] @ matrix_from_rotvec(np.outer(shares, turn))
        found[:, :3, 3] = start[:3, 3] + np.outer(shares, end[:3, 3] - start[:3, 3])
        return found

    return poses, _count(length, float(np.linalg.norm(turn)))


def _arc(start: Array, first: Array, second: Array, mode: int, *, full: bool) -> _Poses:
    """Poses on the circle through three points: to the third point, or the full circle."""
    a, b, c = (pose[:3, 3] for pose in (start, first, second))
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    size = float(normal @ normal)
    around = float(ab @ ab), float(ac @ ac)
    if min(*around, math.dist(b, c) ** 2) < _SAME**2 or size < _STRAIGHT**2 * math.prod(around):
        return _line(start, second)  # no circle within reach: the controller refuses it
    centre = a + (np.cross(normal, ab) * (ac @ ac) + np.cross(ac, normal) * (ab @ ab)) / (2 * size)
    axis = normal / math.sqrt(size)
    x, y = a - centre, np.cross(axis, a - centre)
    to_c = c - centre
    angle = 2 * math.pi if full else math.atan2(float(to_c @ y), float(to_c @ x)) % (2 * math.pi)
    if mode == 2:
        turn = axis * angle
    elif mode == 1 or full:
        turn = np.zeros(3)
    else:
        turn = rotvec_from_matrix(second[:3, :3] @ start[:3, :3].T)
    length = angle * float(np.linalg.norm(x))
    # The deviation of a chord from its arc grows with the square of its angle, so an arc has
    # smaller steps than a line.
    count = max(_count(length, float(np.linalg.norm(turn))), math.ceil(angle / _TURN))

    def poses(shares: Sequence[float]) -> Array:
        found = np.tile(np.eye(4), (len(shares), 1, 1))
        found[:, :3, :3] = matrix_from_rotvec(np.outer(shares, turn)) @ start[:3, :3]
        angles = angle * np.array(shares)[:, None]
        found[:, :3, 3] = centre + np.cos(angles) * x + np.sin(angles) * y
        return found

    return poses, count


def check_way(
    checker: EnvelopeChecker, way: Way, *, known: bool = False
) -> tuple[Crossing | None, float]:
    """Check a path, and compute by how much the motion must be slowed down.

    Args:
        checker: checker for configurations of the path's kind; `seed` is the arm's position.
        way: the path.
        known: whether the start is known to be within the limits. Then only those near the path are
            looked at, which takes a fraction of the time.

    Returns:
        The limit that the path would cross, or does not lead back from, if any; and the share of
        the requested speed at which the limits with the action "slow" are kept.
    """
    share = 1.0
    here = way.configs[0]
    if checker.leaving or not (known and checker.begun):
        checker.begin(here, leaving=True)
    for number, there in enumerate(way.configs[1:]):
        speed = 0.0
        if checker.times:
            speed = way.v
            if not way.by_tip:
                moved = math.dist(checker.places(here)[0], checker.places_ahead(there)[0])
                speed *= moved / max(*(abs(b - a) for a, b in zip(here, there, strict=True)), 1e-12)
                speed = max(speed, way.tool_v if moved > _SAME else 0.0)
            elif math.dist(here[9:], there[9:]) < _SAME:
                speed = 0.0  # it only turns
        while found := checker.too_fast(share * speed) or _sweep(
            checker, way, number, here, there, share * speed
        ):
            if found.action != "slow":
                return found, share
            most = checker.slow_speed(found.limit)
            share *= most / (share * speed) * (1 - 1e-9)
        checker.arrived(there)
        here = there
    return checker.not_left(here), share


def _sweep(
    checker: EnvelopeChecker, way: Way, number: int, here: Config, there: Config, speed: float
) -> Crossing | None:
    """Check a step of a path; if it seems to cross a limit, repeat it in smaller and smaller steps.

    The bound of the bodies' distance from a straight line grows with the square of the joints'
    turns. It is much too large where the arm is nearly stretched.
    """
    steps = len(way.configs) - 1
    todo = [(number / steps, (number + 1) / steps, there, _HALVINGS)]
    while todo:
        begin, end, there, left = todo.pop()
        found = checker.sweep(here, there, speed)
        if found is None:
            here = there
        elif left == 0:
            return found
        else:
            middle = (begin + end) / 2
            todo.append((middle, end, there, left - 1))
            todo.append((begin, middle, way.at([middle])[0], left - 1))
    return None


class Leg(NamedTuple):
    """A path that a blend leaves or enters, and the tool of its motion in the flange's frame."""

    way: Way
    tool: Pose


class CutCorner(NamedTuple):
    """What was found in a blended corner.

    Attributes:
        crossing: the limit that the arm may cross, if any.
        share: share of the speed of the motion after the corner at which the limits with the action
            "slow" are kept.
        watched: whether the tool's speed is not known where such a limit is: the state shows it.
    """

    crossing: Crossing | None
    share: float = 1.0
    watched: bool = False

    def stricter(self, other: CutCorner) -> CutCorner:
        """What both say together."""
        return CutCorner(
            self.crossing or other.crossing,
            min(self.share, other.share),
            self.watched or other.watched,
        )


def cut_corner(checker: EnvelopeChecker, arm: Arm, before: Leg, after: Leg) -> CutCorner:
    """Check a blended corner: wherever the arm may be while it goes on from one leg to the other.

    In a blend the arm does the last part of one motion and the first part of the next one at once.
    How far it does each then is the controller's choice. So all sums of two parts that are together
    not longer than the blend radius are checked. The tool's speed is between those of both motions
    where it goes straight in both. Where the joints do, in one of them, it may be higher.

    Args:
        checker: checker of the sums: of poses of the tip where both motions are those of one tool's
            tip, else of joints.
        arm: the arm.
        before: the path before the corner, with a blend radius.
        after: the path after the corner.
    """
    radius, corner = before.way.radius, before.way.end
    share, watched = 1.0, False
    if radius <= 0.0:
        return CutCorner(None)
    parts = [_part(arm, leg, radius, back=leg is before) for leg in (before, after)]
    count = int(np.clip(math.ceil(max(length for _, length, _ in parts) / _CUT), *_CUTS))
    shares = np.linspace(0.0, 1.0, count + 1)
    legs = []
    for leg, (part, _, _) in zip((before, after), parts, strict=True):
        at = 1.0 - part * shares if leg is before else part * shares
        configs = np.array(leg.way.at(at.tolist()))
        if leg.way.by_tip and not checker.by_tip:
            configs = _joints(arm, leg, configs, corner)
        legs.append(configs)
    coming, going = legs
    coming_speed, going_speed = (speed for _, _, speed in parts)
    checker.seed = corner
    checker.begin(tuple(coming[-1].tolist()), leaving=True)
    for number in range(1, count + 1):
        checker.seed = corner
        sums = _sums(coming[number::-1], going[: number + 1], coming[0], by_tip=checker.by_tip)
        here, *others = map(tuple, sums.tolist())
        for there in others:
            speed = max(coming_speed, share * going_speed) if checker.by_tip else math.inf
            while found := checker.sweep(here, there, speed):
                if found.action != "slow":
                    return CutCorner(found, share)
                if not checker.by_tip:
                    watched, speed = True, 0.0
                    continue
                most = checker.slow_speed(found.limit)
                if coming_speed > most:
                    return CutCorner(found, share)
                share = most / going_speed * (1 - 1e-9)
                speed = max(coming_speed, share * going_speed)
            here = there
    return CutCorner(None, share, watched)


def _part(arm: Arm, leg: Leg, radius: float, *, back: bool) -> tuple[float, float, float]:
    """The share of a path that a blend may take, its length [m], the tool's speed there [m/s]."""
    way = leg.way
    configs = np.array(way.configs[::-1] if back else way.configs)
    tips = configs[:, 9:] if way.by_tip else (arm.fkine(configs) @ leg.tool.matrix)[:, :3, 3]
    outside = np.flatnonzero(np.linalg.norm(tips - tips[0], axis=1) > radius)
    last = int(outside[0]) if len(outside) else len(tips) - 1
    steps = np.linalg.norm(np.diff(tips[: last + 1], axis=0), axis=1)
    length = float(steps.sum())
    return last / (len(tips) - 1), length, way.v if length > _SAME else 0.0  # if it only turns


def _joints(arm: Arm, leg: Leg, tips: Array, near: Sequence[float]) -> Array:
    """The joints of poses of the tip; of one that cannot be reached, those of the one before it."""
    back, found = leg.tool.inverse().matrix, []
    for tip in tips:
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = tip[:9].reshape(3, 3), tip[9:]
        with suppress(Unreachable):
            near = arm.ikine(pose @ back, near).tolist()
        found.append(near)
    return np.array(found)


def _sums(coming: Array, going: Array, corner: Array, *, by_tip: bool) -> Array:
    """Configurations after parts of both motions: the turns and ways of both from the corner."""
    sums: Array = coming + going - corner
    if by_tip:
        one, two, at = (each[..., :9].reshape(-1, 3, 3) for each in (coming, going, corner))
        sums[:, :9] = (one @ at.swapaxes(1, 2) @ two).reshape(-1, 9)
    return sums
