"""Spaces in which paths are searched: the arm's joints, or the tool's motions under a constraint.

A space's unit is the metre: a step of one metre moves no point of the arm by much more than that.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from aioduco.kinematics.single import nearest_turns, solutions
from aioduco.models.rotation import matrix_from_rotvec, rotvec_from_matrix, transform

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning.collision import CollisionChecker

    Points = NDArray[np.float64]


_UPRIGHT = 0.02  # largest tilt of the tool at a goal, against the start [rad]


class JointPathSpace:
    """The joints, each scaled by how far it moves the arm."""

    def __init__(self, arm: Arm, checker: CollisionChecker) -> None:
        self._checker = checker
        self._radii = checker.radii
        self._inverse: list[float] = (1.0 / checker.radii).tolist()
        self.lower: Points = np.array(arm.lower) * self._radii
        self.upper: Points = np.array(arm.upper) * self._radii
        self.margin: Points = np.pi * self._radii
        self.looks: int = 0

    def free(self, point: Any) -> bool:
        """Tell whether the arm touches nothing at a point."""
        self.looks += 1
        a, b, c, d, e, f = self._inverse
        return self._checker.free(
            (point[0] * a, point[1] * b, point[2] * c, point[3] * d, point[4] * e, point[5] * f)
        )

    def point(self, q: Points) -> Points:
        """The point of a configuration [rad]."""
        return q * self._radii

    def joints(self, points: Points) -> Points:
        """The configurations of points."""
        return points / self._radii


class UprightPathSpace:
    """Positions of the tool, and its turns about the vertical: the tool is never tilted.

    The arm keeps its branch, and no joint moves further than half a turn from the start.

    Args:
        arm: the arm.
        checker: collision checker of its scene.
        start: configuration at the start [rad]. Shape (6,).
        up: the vertical in the base's frame. Shape (3,).
        tip: the tool's tip in the flange's frame. Shape (4, 4).
    """

    def __init__(
        self, arm: Arm, checker: CollisionChecker, start: Points, up: Points, tip: Points
    ) -> None:
        self._arm, self._checker, self._up = arm, checker, up
        self._near: list[float] = start.tolist()
        self._branch = self._branch_of(self._near)
        self._tip, self._back = tip, np.linalg.inv(tip)
        self._turn: Points = (arm.fkine(start) @ tip)[:3, :3]
        #: a turn counts as the length by which it moves a point at this distance from the axis [m]
        self._radius = float(np.linalg.norm(tip[:3, 3])) + 0.5 * arm.reach
        reach = arm.reach + arm.geometry.d5 + arm.geometry.d6 + float(np.linalg.norm(tip[:3, 3]))
        middle = np.array([0.0, 0.0, arm.geometry.d1, 0.0])
        span = np.array([reach, reach, reach, np.pi * self._radius])
        self.lower: Points = middle - span
        self.upper: Points = middle + span
        self.margin: Points = 2.0 * span
        self.looks: int = 0

    def point(self, q: Points) -> Points:
        """The point of a configuration [rad]."""
        place, about, _ = self._parts(q)
        return np.append(place, about * self._radius)

    def why_not(self, q: Points) -> str:
        """Tell why no path of this space ends at a configuration [rad]; empty if one can."""
        if not self.same_branch(q.tolist()):
            return (
                "an upright tool keeps its branch (shoulder, elbow, wrist), and no goal has the "
                "start's: go there without `upright`, or by joints"
            )
        _, _, tilt = self._parts(q)
        if tilt > _UPRIGHT:
            return f"the tool is tilted by {tilt:.3f} rad against the start, and is to stay upright"
        far = np.abs(q - np.array(self._near))
        if far.max() > np.pi:
            return (
                f"joint {int(far.argmax()) + 1} is {far.max():.3f} rad from the start; with an "
                "upright tool no joint goes further than half a turn"
            )
        return ""

    def _parts(self, q: Points) -> tuple[Points, float, float]:
        """The tool's place [m], its turn about the vertical, and its tilt, from the start [rad]."""
        pose = self._arm.fkine(q) @ self._tip
        turn = rotvec_from_matrix(pose[:3, :3] @ self._turn.T)
        about = float(turn @ self._up)
        return pose[:3, 3], about, float(np.linalg.norm(turn - about * self._up))

    def same_branch(self, q: Sequence[float]) -> bool:
        """Tell whether a configuration has the start's branch."""
        return self._branch_of(q) == self._branch

    def free(self, point: Any) -> bool:
        """Tell whether the arm reaches a point on its branch, and touches nothing at it."""
        self.looks += 1
        q = self._solve((point[0], point[1], point[2], point[3]))
        return q is not None and self._checker.free(q)

    def joints(self, points: Points) -> Points | None:
        """The configurations of consecutive points; None if a point has none."""
        found = np.empty((len(points), 6))
        for row, point in enumerate(points):
            q = self._solve(point)
            if q is None or (row and np.abs(q - found[row - 1]).max() > 0.5):
                return None
            found[row] = q
        return found

    def _solve(self, point: Points | Sequence[float]) -> list[float] | None:
        turn = matrix_from_rotvec(self._up * (point[3] / self._radius)) @ self._turn
        pose = transform(turn, np.asarray(point[:3]))
        arm = self._arm
        for q in solutions(arm.geometry, (pose @ self._back).tolist()):
            if self._branch_of(q) == self._branch:
                return nearest_turns(q, self._near, arm.lower, arm.upper)
        return None

    def _branch_of(self, q: Sequence[float]) -> tuple[bool, bool, bool]:
        """Signs of the values that are zero at the singularities of shoulder, elbow and wrist."""
        g, q23 = self._arm.geometry, q[1] + q[2]
        ahead = g.a2 * math.sin(q[1]) + g.a3 * math.sin(q23) + g.d5 * math.sin(q23 + q[3])
        return ahead > 0.0, math.sin(q[2]) > 0.0, math.sin(q[4]) > 0.0


PathSpace: TypeAlias = JointPathSpace | UprightPathSpace
"""A space in which a path is searched.

It has the bounds of its points, `lower` and `upper`; `margin` is the distance beyond start and
goals to which a search is limited. `looks` counts the points at which `free` was asked.
"""
