"""Lines and arcs of the tool: poses along the path, and configurations on one branch."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.errors import ParameterError, Unreachable
from aioduco.sim.planner.curves import Curve, Orientation, StraightLine, arc_through
from aioduco.sim.planner.path import PlanError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm

    Points = NDArray[np.float64]


_STEP, _TURN = 0.004, 0.02  # between two poses [m, rad]
_LEVER = 0.2  # length that a turn counts as, for a tool that turns more than it moves [m/rad]
_JUMP = 0.2  # largest turn of a joint between two poses on one branch [rad]


class ToolPath(NamedTuple):
    """Poses of the tool's tip along a path, at equal distances.

    Attributes:
        length: length of the path [m].
        poses: in the base frame. Shape (n, 4, 4).
    """

    length: float
    poses: Points


def poses_along(start: Points, via: Points | None, end: Points) -> ToolPath:
    """Give the poses on a line, or on an arc if `via` is given.

    The tool turns evenly from the first orientation to the last.

    Args:
        start: the first pose. Shape (4, 4).
        via: a pose whose position is on the arc; its orientation is not used.
        end: the last pose. Shape (4, 4).

    Raises:
        ParameterError: the three points are on a line.
    """
    curve: Curve
    if via is None:
        curve = StraightLine.between(start, end)
        moved = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
    else:
        try:
            curve = arc_through(start, via, end, Orientation.TO_TARGET)
        except PlanError:
            raise ParameterError(
                "via", via[:3, 3].tolist(), "off the line from the start to the end [m]"
            ) from None
        moved = curve.length
    count = max(int(np.ceil(max(moved / _STEP, curve.turning / _TURN))), 8)
    poses = np.tile(start, (count + 1, 1, 1))
    if curve.length:
        poses = curve.poses(np.linspace(0.0, curve.length, count + 1))
    return ToolPath(max(moved, _LEVER * curve.turning), poses)


def followed(arm: Arm, poses: Points, back: Points, start: Points) -> tuple[Points, str]:
    """Give the configurations along a path, on the branch of the start, as far as there are any.

    Args:
        arm: the arm.
        poses: poses of the tool's tip. Shape (n, 4, 4).
        back: the flange in the tip's frame. Shape (4, 4).
        start: the first configuration [rad]. Shape (6,).

    Returns:
        Joints [rad] of the first poses, as many as can be followed, and why not all can be.
    """
    found = [start]
    for pose in poses[1:]:
        try:
            found.append(arm.ikine(pose @ back, found[-1], max_jump=_JUMP))
        except Unreachable as error:
            return np.array(found), str(error)
    return np.array(found), ""
