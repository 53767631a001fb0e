"""Pose of an arm's base in the world."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

from aioduco.models.pose import Pose
from aioduco.models.ranges import POSE
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from aioduco.kinematics.arm import Arm
    from aioduco.models.rotation import Array


GRAVITY = 9.81
"""Acceleration of gravity [m/s²]."""

MountingLike: TypeAlias = Literal["floor", "wall", "ceiling"] | Sequence[float]
"""Where the arm is: on the floor, at a wall, at the ceiling, or a pose of its base [m, rad]."""


def base_in_world(mounting: MountingLike, arm: Arm) -> Pose:
    """Return the pose of an arm's base in the world, whose z axis is up.

    Args:
        mounting: "floor": at the origin; "wall": at 4/3 of the height that the arm reaches, its z
            axis along the world's x axis; "ceiling": at twice the height that it reaches, turned
            upside down about the x axis; or six numbers [m, rad].
        arm: the arm.

    Raises:
        ParameterError: it is neither a name nor a pose, or its angles are beyond ±2π, as degrees
            are.
    """
    high = arm.reach + arm.geometry.d1
    if not isinstance(mounting, str):
        return Pose(*POSE("mounting", mounting))
    heights = {"floor": 0.0, "wall": 4.0 / 3.0 * high, "ceiling": 2.0 * high}
    return _turned(mounting).shifted(z=heights[mounting])


def gravity(mounting: MountingLike) -> Array:
    """Return the acceleration of gravity along the base's axes [m/s²]. Shape (3,).

    Args:
        mounting: "floor", "wall" or "ceiling", or pose of the base in the world [m, rad].

    Raises:
        ParameterError: as of `base_in_world`.
    """
    base = _turned(mounting) if isinstance(mounting, str) else Pose(*POSE("mounting", mounting))
    down: Array = -GRAVITY * base.matrix[2, :3]
    return down


def _turned(mounting: str) -> Pose:
    """Return how the base of an arm that is mounted so is turned, at the world's origin."""
    turns = {"floor": (0.0, 0.0), "wall": (0.0, 0.5 * math.pi), "ceiling": (math.pi, 0.0)}
    about_x, about_y = turns[one_of("mounting", mounting, turns, besides="a pose")]
    return Pose(0.0, 0.0, 0.0, about_x, about_y, 0.0)
