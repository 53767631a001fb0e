"""Pose of an arm's base in the world."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

from aioduco.models.pose import Pose
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from aioduco.kinematics.arm import Arm
    from aioduco.models.rotation import Array

__all__ = ["GRAVITY", "MountingLike", "base_in_world", "gravity"]

GRAVITY = 9.81
"""Acceleration of gravity [m/s²]."""

MountingLike: TypeAlias = Literal["floor", "wall", "ceiling"] | Sequence[float]
"""Where the arm is: on the floor, at a wall, at the ceiling, or a pose of its base [m, rad]."""


def base_in_world(mounting: MountingLike, arm: Arm) -> Pose:
    """Return the pose of an arm's base in the world, whose z axis is up and whose floor is at 0.

    Args:
        mounting: "floor": at the origin; "wall": at 4/3 of the height that the arm reaches, its z
            axis along the world's x axis; "ceiling": at twice the height that it reaches, turned
            upside down about the x axis; or six numbers [m, rad].
        arm: the arm.

    Raises:
        ParameterError: it is neither a name nor a pose.
    """
    high = arm.reach + arm.geometry.d1
    named = {
        "floor": Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        "wall": Pose(0.0, 0.0, 4.0 / 3.0 * high, 0.0, 0.5 * math.pi, 0.0),
        "ceiling": Pose(0.0, 0.0, 2.0 * high, math.pi, 0.0, 0.0),
    }
    if not isinstance(mounting, str):
        return Pose.of(mounting)
    return named[one_of("mounting", mounting, named, besides="a pose")]


def gravity(mounting: Pose) -> Array:
    """Return the acceleration of gravity along the base's axes [m/s²]. Shape (3,).

    Args:
        mounting: pose of the base in the world [m, rad].
    """
    down: Array = -GRAVITY * mounting.matrix[2, :3]
    return down
