"""Where the arm is mounted, and which way its weight pulls then."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from aioduco.errors import ParameterError, SceneError
from aioduco.models.pose import Pose

if TYPE_CHECKING:
    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array

__all__ = ["GRAVITY", "MountingLike", "gravity", "mounting_of"]

MountingLike: TypeAlias = Literal["floor", "wall", "ceiling"] | Sequence[float]
"""Where the arm is: on the floor, at a wall, at the ceiling, or a pose of its base [m, rad]."""

GRAVITY = 9.81
"""Acceleration of gravity [m/s²]."""


def mounting_of(mounting: MountingLike, arm: Arm) -> Pose:
    """Give the pose of an arm's base in the world, whose z axis is up and whose floor is at 0.

    Args:
        mounting: "floor": at the origin; "wall": as high as the arm reaches with a third to
            spare, its z axis along the world's x axis; "ceiling": twice as high as it reaches,
            upside down about the x axis; or six numbers [m, rad].
        arm: the arm.

    Raises:
        SceneError: It is neither a name nor a pose.
    """
    high = arm.reach + arm.geometry.d1
    named = {
        "floor": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        "wall": (0.0, 0.0, 4.0 / 3.0 * high, 0.0, 0.5 * np.pi, 0.0),
        "ceiling": (0.0, 0.0, 2.0 * high, np.pi, 0.0, 0.0),
    }
    if isinstance(mounting, str) and mounting not in named:
        raise SceneError(f"no mounting is called {mounting!r}: floor, wall, ceiling, or a pose")
    try:
        return Pose.of(named[mounting] if isinstance(mounting, str) else mounting)
    except ParameterError as exc:
        raise SceneError(f"mounting is {mounting!r}, but must be {exc.expected}") from None


def gravity(mounting: Pose) -> Array:
    """Give the acceleration of gravity along the base's axes [m/s²]. Shape (3,)."""
    down: Array = -GRAVITY * mounting.matrix[2, :3]
    return down
