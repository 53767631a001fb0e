"""The camera of a picture of the simulated arm, and marks in the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.models import ranges
from aioduco.models.rules import Number, Vector, stored

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.pose import Pose


_TARGET = Vector(Number(unit="m", source="this package"), length=3)


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureMark:
    """A ball that is drawn into a picture, but does not exist in the simulation.

    Attributes:
        at: its centre, in the world's frame [m].
        radius: radius of the ball [m].
        colour: red, green, blue, 0 to 1.
    """

    at: Sequence[float]
    radius: float = 0.02
    colour: tuple[float, float, float] = (0.9, 0.2, 0.15)


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """A camera that looks at a point.

    Attributes:
        target: the point, in the world's frame [m].
        distance: distance from the point [m].
        azimuth: direction in which it looks, about the world's z axis from its x axis [rad].
        elevation: angle of that direction above the horizon; below zero it looks down [rad].
    """

    target: Sequence[float] = (0.3, 0.0, 0.4)
    distance: float = 2.0
    azimuth: float = math.radians(130.0)
    elevation: float = math.radians(-18.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "target", tuple(_TARGET("target", self.target)))
        stored(self, distance=ranges.ABOVE, azimuth=ranges.FINITE, elevation=ranges.FINITE)

    def put(self, view: Any) -> None:
        """Set a free camera of MuJoCo, which uses degrees, to this view."""
        view.lookat[:] = self.target
        view.distance = self.distance
        view.azimuth = math.degrees(self.azimuth)
        view.elevation = math.degrees(self.elevation)


def towards(arm: Arm, mounting: Pose) -> Camera:
    """Give a camera that sees the whole arm, wherever it reaches in front of its base."""
    middle = np.array([0.3 * arm.reach, 0.0, 0.5 * arm.reach, 1.0])
    target = (mounting.matrix @ middle)[:3]
    return Camera(target=tuple(target.tolist()), distance=2.3 * arm.reach)
