"""Rotating directions from the frame in which a program gives them into that of the wire.

Plain Python without I/O: a worker and a single call use the same functions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.streaming.shared.space import POSE_SPACE, rotated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.streaming.shared.space import Config

__all__ = ["composed", "in_tool", "turned"]

_ORIGIN = (0.0, 0.0, 0.0)


def composed(poses: Sequence[Sequence[float]]) -> Config:
    """The product of poses (x, y, z [m], rx, ry, rz [rad]), as a position and a quaternion."""
    place = POSE_SPACE.decode((0.0,) * 6)
    for pose in poses:
        place = POSE_SPACE.composed(place, POSE_SPACE.decode(pose))
    return place


def turned(twist: Sequence[float], place: Config, *, back: bool) -> tuple[float, ...]:
    """Rotate a velocity into the axes of another frame.

    Args:
        twist: along x, y, z [m/s] and about them [rad/s]. Shape (6,).
        place: pose of one frame in the other.
        back: whether to apply the inverse rotation.
    """
    _, _, _, w, x, y, z = place
    turn = (w, -x, -y, -z) if back else (w, x, y, z)
    return (*rotated(turn, twist[:3]), *rotated(turn, twist[3:]))


def in_tool(offset: Sequence[float], place: Config) -> tuple[float, ...]:
    """Convert an offset along and about the axes of a frame into an offset in the tool's frame.

    Args:
        offset: x, y, z [m], rx, ry, rz [rad]; it turns the tool about its tip. Shape (6,).
        place: pose of the tool in that frame.
    """
    here = (*_ORIGIN, *place[3:])
    there = POSE_SPACE.composed(POSE_SPACE.decode(offset), here)
    return POSE_SPACE.encode(POSE_SPACE.offset(here, there))
