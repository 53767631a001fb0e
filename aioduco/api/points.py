"""Checks of lists of points: of a spline, of the track pool, of the realtime queue."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import Described, ParameterError
from aioduco.models.op import PointOp
from aioduco.models.rules import listed

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.models.pose import Joints, Pose
    from aioduco.models.rules import Integer


def points_with_outputs(
    name: str, points: Iterable[PointOp], count: Integer, *kinds: type[Joints] | type[Pose]
) -> list[PointOp]:
    """Check points that have outputs.

    Args:
        name: the parameter's name, for errors.
        points: the points.
        count: allowed number of points.
        kinds: allowed types of the positions; all points must have the same one.

    Raises:
        ParameterError: an element is not such a point, or their number is out of range.
    """
    expected = f"{count.low} to {count.high} points, each a PointOp"
    given = listed(name, points, expected)
    if not count.low <= len(given) <= count.high:
        raise ParameterError(name, Described(f"{len(given)} points"), expected)
    for number, point in enumerate(given):
        if not isinstance(point, PointOp) or type(point.pos) not in kinds:
            words = " or a ".join(kind.__name__ for kind in kinds)
            raise ParameterError(f"{name}[{number}]", point, f"a PointOp with a {words}")
        if type(point.pos) is not type(given[0].pos):
            raise ParameterError(f"{name}[{number}]", point, "of the same kind as the first one")
    return given
