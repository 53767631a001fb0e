"""External axes that go along with a motion of the arm (外部轴, manual 1.3.14).

They share the motion's path: each is a straight line over the distance along it. So one time law
moves arm and axes; they start and end together, and stay together through pauses, stops and
changes of the global speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.limits import SHARE, axes_limits
from aioduco.sim.planner.path import Path
from aioduco.sim.planner.slices import no_turn

if TYPE_CHECKING:
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.slices import Turn
    from aioduco.sim.planner.timing import PathLimits

__all__ = ["ExternalAxesMove", "blended"]


@dataclass(frozen=True, slots=True, eq=False)
class ExternalAxesMove:
    """What external axes do during a motion, in the unit of each: rad or m.

    Attributes:
        numbers: of the axes.
        start: where they begin. Shape (n,).
        end: where they go to. Shape (n,).
        velocity: highest speeds [1/s]. Shape (n,).
        acceleration: highest accelerations [1/s²]. Shape (n,).
        braking: what their drives can do; a stop uses it [1/s²]. Shape (n,).
        path: over the distance along the motion's path; None before `segments.carry`.
    """

    numbers: tuple[int, ...]
    start: Array
    end: Array
    velocity: Array
    acceleration: Array
    braking: Array
    path: Path | None = None

    def limits(
        self, path: Path, nodes: Array, share: float = SHARE, turn: Turn = no_turn
    ) -> PathLimits:
        """Give what the axes' speeds and accelerations leave along their path."""
        speeds, rates, ways = self.velocity, self.acceleration, path.sample(nodes, turn)
        return axes_limits(nodes, ways, speeds, rates, self.braking, share, turn=turn)


def blended(first: ExternalAxesMove, second: ExternalAxesMove, leave: float, enter: float) -> Path:
    """Give the way of the axes through a blend, which adds up what both motions move them.

    Args:
        first: of the motion before the blend.
        second: of the motion behind it; the same axes.
        leave: distance on the first motion where the blend begins.
        enter: distance on the second motion where it ends.
    """
    assert first.path is not None
    assert second.path is not None
    # As the arm: the first comes evenly to rest, while the second sets off from it.
    left = first.end - first.path.sample(np.array([leave]))[0, 0]
    gone = second.path.sample(np.array([enter]))[0, 0] - second.start
    coefficients = np.zeros((6, len(left)))
    coefficients[0] = first.end - left
    coefficients[1] = 2.0 * left
    coefficients[2] = gone - left
    return Path([0.0, 2.0 * enter], [0.0], [0.5 / enter], [coefficients])
