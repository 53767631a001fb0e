"""External axes that go along with a motion of the arm (外部轴, manual 1.3.14).

They share the motion's path: each is a straight line over the distance along it. So one time law
moves arm and axes; they start and end together, and stay together through pauses, stops and
changes of the global speed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.limits import SHARE, axes_limits
from aioduco.sim.planner.path import Path

if TYPE_CHECKING:
    from collections.abc import Mapping

    from aioduco.models.rotation import Array
    from aioduco.sim.planner.segments import Segment
    from aioduco.sim.planner.timing import Limits

__all__ = ["AxesMove", "blended", "carry"]


@dataclass(frozen=True, slots=True, eq=False)
class AxesMove:
    """What external axes do during a motion, in the unit of each: rad or m.

    Attributes:
        numbers: of the axes.
        start: where they begin. Shape (n,).
        end: where they go to. Shape (n,).
        velocity: highest speeds [1/s]. Shape (n,).
        acceleration: highest accelerations [1/s²]. Shape (n,).
        braking: what their drives can do; a stop uses it [1/s²]. Shape (n,).
        path: over the distance along the motion's path; None before `carry`.
    """

    numbers: tuple[int, ...]
    start: Array
    end: Array
    velocity: Array
    acceleration: Array
    braking: Array
    path: Path | None = None

    def limits(self, path: Path, nodes: Array, share: float = SHARE) -> Limits:
        """Give what the axes' speeds and accelerations leave along their path."""
        speeds, rates = self.velocity, self.acceleration
        return axes_limits(nodes, path.sample(nodes), speeds, rates, self.braking, share=share)


def carry(segment: Segment, before: Mapping[int, float]) -> Segment:
    """Let the external axes of a motion go along with it.

    Args:
        segment: the motion, with what its axes shall do.
        before: where the motions before it leave external axes, by number.

    Returns:
        The motion, whose limits are those of the arm and of the axes. If the arm stays where it
        is, the path is that of the axes alone, and one long.
    """
    move = segment.axes
    assert move is not None
    start = np.array([before.get(n, at) for n, at in zip(move.numbers, move.start, strict=True)])
    move = replace(move, start=start)
    path, limits = segment.path, segment.limits
    if path is None:
        if np.array_equal(start, move.end):
            return replace(segment, axes=move)
        path = Path.straight(segment.q_start, segment.q_start, 1.0)
    move = replace(move, path=Path.straight(start, move.end, path.end))
    assert move.path is not None
    nodes = np.array(limits.nodes if limits is not None else path.bounds)
    axes = move.limits(move.path, nodes)
    return replace(
        segment, path=path, limits=axes if limits is None else limits.least(axes), axes=move
    )


def blended(first: AxesMove, second: AxesMove, leave: float, enter: float) -> Path:
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
