"""External axes that move together with the arm (外部轴, manual 1.3.14).

They share the motion's path: the position of each axis is linear in the distance along it. So one
time law moves arm and axes; they start and end together, and stay synchronous through pauses, stops
and changes of the global speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.motion_limits import SHARE, axes_limits
from aioduco.sim.planner.path import Path

if TYPE_CHECKING:
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.timing import PathLimits


@dataclass(frozen=True, slots=True, eq=False)
class ExternalAxesMove:
    """Movement of external axes during a motion, in the unit of each: rad or m.

    Attributes:
        numbers: numbers of the axes.
        start: positions at the start. Shape (n,).
        end: positions at the end. Shape (n,).
        velocity: highest speeds [1/s]. Shape (n,).
        acceleration: highest accelerations [1/s²]. Shape (n,).
        braking: accelerations that their drives can do, which a stop uses [1/s²]. Shape (n,).
        path: positions over the distance along the motion's path; None before `segments.carry`.
    """

    numbers: tuple[int, ...]
    start: Array
    end: Array
    velocity: Array
    acceleration: Array
    braking: Array
    path: Path | None = None

    def limits(self, path: Path, nodes: Array, share: float = SHARE) -> PathLimits:
        """Give the limits along the path from the axes' speeds and accelerations."""
        speeds, rates, ways = self.velocity, self.acceleration, path.sample(nodes)
        return axes_limits(nodes, ways, speeds, rates, self.braking, share)


def blended(first: ExternalAxesMove, second: ExternalAxesMove, leave: float, enter: float) -> Path:
    """Give the path of the axes through a blend: the sum of their movements in both motions.

    Args:
        first: movement in the motion before the blend.
        second: movement in the motion behind it; the same axes.
        leave: distance on the first motion where the blend begins.
        enter: distance on the second motion where it ends.
    """
    assert first.path is not None
    assert second.path is not None
    # Like the arm: the first motion decelerates evenly to rest, while the second accelerates.
    left = first.end - first.path.sample(np.array([leave]))[0, 0]
    gone = second.path.sample(np.array([enter]))[0, 0] - second.start
    coefficients = np.zeros((6, len(left)))
    coefficients[0] = first.end - left
    coefficients[1] = 2.0 * left
    coefficients[2] = gone - left
    return Path.of_one(coefficients, 2.0 * enter)
