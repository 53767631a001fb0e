"""Lines and arcs of the tool: poses along the path, and configurations on one branch."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.errors import ParameterError, Unreachable
from aioduco.models.rotation import matrix_from_rotvec, rotvec_from_matrix

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm

    Points = NDArray[np.float64]

__all__ = ["ToolPath", "followed", "poses_along"]

_STEP, _TURN = 0.004, 0.02  # between two poses [m, rad]
_LEVER = 0.2  # length that a turn counts as, for a tool that turns more than it moves [m/rad]
_POINT = 1e-6  # points that are nearer to each other are the same [m]
_STRAIGHT = 1e-6  # sine of the angle below which three points are on a line
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
    turn = rotvec_from_matrix(end[:3, :3] @ start[:3, :3].T)
    angle = float(np.linalg.norm(turn))
    origin, way = start[:3, 3], end[:3, 3] - start[:3, 3]
    arc = None if via is None else _arc(origin, via[:3, 3], end[:3, 3])
    moved = float(np.linalg.norm(way)) if arc is None else float(arc[2] * np.linalg.norm(arc[1]))
    length = max(moved, _LEVER * angle)
    count = max(int(np.ceil(max(moved / _STEP, angle / _TURN))), 8)
    poses = np.tile(np.eye(4), (count + 1, 1, 1))
    shares = np.linspace(0.0, 1.0, count + 1)
    poses[:, :3, :3] = matrix_from_rotvec(shares[:, None] * turn) @ start[:3, :3]
    if arc is None:
        poses[:, :3, 3] = origin + shares[:, None] * way
    else:
        centre, spoke, sweep, across = arc
        angles = shares[:, None] * sweep
        poses[:, :3, 3] = centre + np.cos(angles) * spoke + np.sin(angles) * across
    return ToolPath(length, poses)


def _arc(one: Points, two: Points, three: Points) -> tuple[Points, Points, float, Points]:
    """Centre, first radius vector, angle, and the radius vector a quarter further, of an arc."""
    a, b = two - one, three - one
    normal = np.cross(a, b)
    size = float(normal @ normal)
    shortest = min(float(np.linalg.norm(side)) for side in (a, b, three - two))
    # By the angle, as the controller judges it: a small arc is one, too.
    if shortest < _POINT or size < (_STRAIGHT * np.linalg.norm(a) * np.linalg.norm(b)) ** 2:
        raise ParameterError("via", two.tolist(), "off the line from the start to the end [m]")
    centre = one + np.cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * size)
    spoke = one - centre
    across = np.cross(normal / np.sqrt(size), spoke)
    last = three - centre
    sweep = float(np.arctan2(last @ across, last @ spoke)) % (2.0 * np.pi)
    return centre, spoke, sweep, across


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
