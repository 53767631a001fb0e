"""A straight way of the tool out of a narrow place, such as a gripper's from a part that it let go.

Random search hardly ever finds such a way: there may be tenths of a millimetre on both sides.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.planning.toolpath import followed, poses_along

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning.collision import CollisionChecker

    Points = NDArray[np.float64]


_FURTHEST = 0.15  # length of a way out, at most [m]
_SHARE = 0.5  # of the distance at the end that may be left on the way out
_ROUNDING = 1e-7  # likewise, less than it [m]
#: axes of the tool along which a way out is tried: back first
_AXES = ((0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1))


def retreat(
    arm: Arm, checker: CollisionChecker, q: Points, tip: Points, up: Points
) -> list[tuple[Points, float]]:
    """Give configurations from one that is close to something to one that is not.

    Args:
        arm: the arm.
        checker: collision checker of the scene, with the padding to reach.
        q: the first configuration [rad]. Shape (6,).
        tip: the tool's tip in the flange's frame. Shape (4, 4).
        up: the vertical in the base's frame. Shape (3,).

    Returns:
        Configurations [rad] on a straight line of the tip, each with its distance to the nearest
        thing [m]; the last is more than the padding away from everything. Empty if no line along
        an axis of the tool, or up, leads there.
    """
    pose: Points = arm.fkine(q) @ tip
    back = np.linalg.inv(tip).astype(np.float64)
    ways = [*(pose[:3, :3] @ axis for axis in np.array(_AXES, dtype=np.float64)), up]
    with checker.looking_within(2.0 * checker.padding) as distance:
        first = distance(q.tolist())
        least = min(_SHARE * first, first - _ROUNDING)
        for way in ways:
            end = pose.copy()
            end[:3, 3] += _FURTHEST * way
            found: list[tuple[Points, float]] = []
            for there in followed(arm, poses_along(pose, None, end).poses, back, q)[0]:
                near = distance(there.tolist())
                if near < least:
                    break
                found.append((there, near))
                if near > checker.padding:
                    return found
    return []
