"""Check of a list of points before an arm moves there: reach, limits, singularities, branches."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import ParameterError, Unreachable
from aioduco.kinematics.catalogue import arm_given
from aioduco.kinematics.forward import singular_values
from aioduco.models.bounds import least, most, shown
from aioduco.models.pose import Joints, JointsLike, Pose, PoseLike
from aioduco.models.ranges import JOINTS, POSE
from aioduco.models.rules import Number

if TYPE_CHECKING:
    from aioduco.kinematics.arm import Arm


_MOST_TURN = Number(0.0, unit="rad", open_low=True, source="this package")
#: distance from a singularity below which a point is reported, see `Singularity`
_NEAR = 0.05
_BRANCHES = ("shoulder", "elbow", "wrist")


class Problem(Enum):
    """Kind of problem at a point."""

    REACH = "out of reach"
    LIMIT = "joint limit"
    SINGULARITY = "near a singularity"
    BRANCH = "other branch"
    JUMP = "far turn"


@dataclass(frozen=True, slots=True)
class Finding:
    """A problem at one point.

    Attributes:
        index: number of the point, from 0.
        name: its name, or its number as a text.
        problem: kind of problem.
        text: description of the problem.
    """

    index: int
    name: str
    problem: Problem
    text: str

    def __str__(self) -> str:
        return f"{self.name}: {self.problem.value}: {self.text}"


@dataclass(frozen=True, slots=True)
class PointReport:
    """Result of `check`. `print(report)` prints a line for each point and each finding.

    Attributes:
        arm: the model of the arm.
        names: names of the points.
        joints: for each point, the configuration that reaches it; None if there is none.
        findings: problems, in the order of the points.
    """

    arm: str
    names: tuple[str, ...]
    joints: tuple[Joints | None, ...]
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        """Whether no problem was found."""
        return not self.findings

    def __str__(self) -> str:
        width = max(map(len, self.names), default=0)
        lines = []
        for index, (name, q) in enumerate(zip(self.names, self.joints, strict=True)):
            angles = "-" if q is None else " ".join(f"{angle:7.1f}" for angle in q.degrees)
            found = [each for each in self.findings if each.index == index]
            lines.append(f"{name:<{width}}  {'ok' if not found else '!!'}  {angles}")
            lines += [f"{'':<{width}}      {each.problem.value}: {each.text}" for each in found]
        count = len(self.findings)
        total = "nothing found" if not count else f"{count} finding{'s'[: count > 1]}"
        return "\n".join([*lines, f"{self.arm}, {len(self.names)} points: {total}"])


def check(
    points: Mapping[str, Joints | PoseLike] | Iterable[Joints | PoseLike],
    *,
    arm: Arm | str,
    near: JointsLike,
    tool: PoseLike | None = None,
    wobj: PoseLike | None = None,
    singular: float = _NEAR,
    most_turn: float = math.pi,
) -> PointReport:
    """Check a list of points before running it; nothing is sent, and no controller is needed.

    The points are checked in their order. For each pose, the configuration is used that is nearest
    to that of the previous point. Only the points are checked, not the paths between them, the
    controller's own limits, or obstacles around the arm.

    Args:
        points: `Joints` [rad], or poses of the tool in the work object [m, rad]; in a list, or by
            name, as in `TaughtPoints`.
        arm: the arm, or its model.
        near: joint angles at the start [rad].
        tool: pose of the tool's tip in the flange's frame [m, rad]; None for the flange.
        wobj: the work object in the base frame [m, rad]; None for the base.
        singular: distance from a singularity below which a point is reported, 0 to 1.
        most_turn: rotation of one joint between two points above which it is reported, above 0
            [rad].

    Returns:
        The report: the problems, and the joint angles of each point.

    Raises:
        ParameterError: an argument is of the wrong kind or out of range.
    """
    model = arm_given("arm", arm)
    singular = Number(0.0, 1.0, source="this package")("singular", singular)
    most_turn = _MOST_TURN("most_turn", most_turn)
    named = _named(points)
    to_tip = Pose(0, 0, 0, 0, 0, 0) if tool is None else Pose(*POSE("tool", tool))
    base = Pose(0, 0, 0, 0, 0, 0) if wobj is None else Pose(*POSE("wobj", wobj))
    before = Joints(*JOINTS("near", near))
    reached: list[Joints | None] = []
    findings: list[Finding] = []
    for index, (name, point) in enumerate(named.items()):
        q: Joints | None
        if isinstance(point, Joints):
            q, why = point, _outside(model, point)
            found = [(Problem.LIMIT, why)] if why else []
        else:
            flange = base @ Pose(*POSE(f"points[{name!r}]", point)) @ to_tip.inverse()
            q, found = _reached(model, flange, before)
        if q is not None:
            found += _passed(model, before, q, singular, most_turn)
            before = q
        reached.append(q)
        findings += [Finding(index, name, problem, text) for problem, text in found]
    return PointReport(model.name, tuple(named), tuple(reached), tuple(findings))


def _named(points: Any) -> dict[str, Any]:
    if isinstance(points, Mapping):
        return {str(name): point for name, point in points.items()}
    if isinstance(points, (Joints, Pose, str)) or not isinstance(points, Iterable):
        raise ParameterError("points", points, "a list of points, or points by name")
    return {str(number): point for number, point in enumerate(points)}


def _outside(arm: Arm, q: Joints) -> str:
    limits = zip(q, arm.lower, arm.upper, strict=True)
    over = [
        f"joint {axis} at {math.degrees(angle):.1f}°, beyond "
        f"{shown(math.degrees(low), low=True)}° to {shown(math.degrees(high))}°"
        for axis, (angle, low, high) in enumerate(limits, 1)
        if not least(low) <= angle <= most(high)
    ]
    return ", ".join(over)


def _reached(
    arm: Arm, flange: Pose, before: Joints
) -> tuple[Joints | None, list[tuple[Problem, str]]]:
    try:
        return Joints.of(arm.ikine(flange, before)), []
    except Unreachable as exc:
        outside = bool(len(arm.ikine_all(flange)))
        return None, [(Problem.LIMIT if outside else Problem.REACH, str(exc))]


def _passed(
    arm: Arm, before: Joints, q: Joints, singular: float, most_turn: float
) -> list[tuple[Problem, str]]:
    """Return the problems of a configuration that the arm reaches from another one."""
    found: list[tuple[Problem, str]] = []
    distance = arm.singularity(q)
    for name in _BRANCHES:
        if getattr(distance, name) < singular:
            text = f"the {name}'s, at a distance of {getattr(distance, name):.3f}"
            found.append((Problem.SINGULARITY, text))
    signs = np.sign(singular_values(arm.geometry, np.array([before, q])))
    changed = [name for name, a, b in zip(_BRANCHES, *signs.tolist(), strict=True) if a * b < 0]
    if changed:
        what = " and ".join(changed)
        text = f"the {what} bends the other way than before: a line cannot lead here"
        found.append((Problem.BRANCH, text))
    turns = [abs(b - a) for a, b in zip(before, q, strict=True)]
    if max(turns) > most_turn:
        axis = turns.index(max(turns)) + 1
        found.append((Problem.JUMP, f"joint {axis} turns by {math.degrees(max(turns)):.1f}°"))
    return found
