"""Turning what a program gives in one frame into another: which frames, by which poses, and how.

Plain Python without clock, except for `Directions`: streams and single motions use the same
functions. Who reads the poses from the controller stands elsewhere: a worker does it by
`Directions`, a motion when it is sent.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from aioduco.errors import ParameterError
from aioduco.models.quaternions import inverse, rotated
from aioduco.streaming.shared.config import FrameRotation
from aioduco.streaming.shared.space import POSE_SPACE, Config, read_six, six_numbers

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence


#: the robot's base, the tool, or a work object
MotionFrame: TypeAlias = Literal["base", "tool", "wobj"]

_ORIGIN = (0.0, 0.0, 0.0)
_FRESH = 10_000_000  # ns for which a pose is used after it was read


def place_of(rotation: FrameRotation, poses: Iterable[Sequence[float]]) -> Config:
    """The pose of one frame in the other.

    Args:
        rotation: how directions are rotated.
        poses: what the controller answered to each of its `reads`.

    Raises:
        ControllerError: it gave no pose, or has no such frame.
    """
    return composed(list(map(six_numbers, rotation.reads, poses)))


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
    turn = inverse(place[3:]) if back else place[3:]
    return (*rotated(turn, twist[:3]), *rotated(turn, twist[3:]))


def in_tool(offset: Sequence[float], place: Config) -> tuple[float, ...]:
    """Convert an offset along and about the axes of a frame into an offset in the tool's frame.

    Args:
        offset: x, y, z [m], rx, ry, rz [rad]; it turns the tool about its tip. Shape (6,).
        place: pose of the tool in that frame.
    """
    return POSE_SPACE.encode(POSE_SPACE.in_axes(POSE_SPACE.decode(offset), (*_ORIGIN, *place[3:])))


def into_tool(frame: str, wobj: str = "", tool: str = "") -> FrameRotation | None:
    """The rotation of directions into the tool's frame.

    Args:
        frame: frame in which the directions are given.
        wobj: name of the work object, for frame="wobj"; empty for the one in use.
        tool: name of the tool; empty for the one in use.

    Returns:
        The rotation; None if the directions are given in the tool's frame.

    Raises:
        ParameterError: there is no such frame, or a work object is given for another frame.
    """
    name = _checked(frame, wobj)
    if frame == "tool":
        return None
    if frame == "wobj":
        return FrameRotation(reads=[["get_tcp_pose_coord", tool, name]])
    if not tool:
        return FrameRotation(reads=[["get_tcp_pose"]])
    return FrameRotation(reads=[["get_wobj"], ["get_tcp_pose_coord", tool, ""]])


def into_wobj(frame: str) -> FrameRotation | None:
    """The rotation of directions into the frame of the work object in use.

    Args:
        frame: frame in which the directions are given.

    Returns:
        The rotation; None if the directions are given in that frame.

    Raises:
        ParameterError: there is no such frame.
    """
    _checked(frame, "")
    if frame == "wobj":
        return None
    if frame == "base":
        return FrameRotation(reads=[["get_wobj"]])
    return FrameRotation(reads=[["get_tcp_pose_coord", "", ""]], back=False)


def _checked(frame: str, wobj: str) -> str:
    from aioduco.models.ranges import FRAME  # noqa: PLC0415 - not in a worker
    from aioduco.models.words import one_of  # noqa: PLC0415 - not in a worker

    one_of("frame", frame, get_args(MotionFrame))
    name = FRAME("wobj", wobj)
    if name and frame != "wobj":
        raise ParameterError("wobj", wobj, 'left out, or frame="wobj" given with it')
    return name


class Directions:
    """Rotates velocities into the frame of the wire, by a pose that was read at most 10 ms ago.

    Args:
        rotation: how directions are rotated; None: not at all.
        call: calls the controller: function of the wire, its arguments, time-out.
        timeout: time-out of each call [s].
    """

    def __init__(
        self,
        rotation: FrameRotation | None,
        call: Callable[[str, tuple[str, ...], float], Any],
        timeout: float,
    ) -> None:
        self._rotation = rotation
        self._call = call
        self._timeout = timeout
        self._place: Config = ()
        self._read_at = 0

    def turned(self, twist: tuple[float, ...]) -> tuple[float, ...]:
        """A velocity, rotated into the frame of the wire [m/s, rad/s]."""
        if self._rotation is None:
            return twist
        now = time.monotonic_ns()
        if not self._place or now - self._read_at > _FRESH:
            self._place, self._read_at = self.place(self._rotation), now
        return turned(twist, self._place, back=self._rotation.back)

    def place(self, rotation: FrameRotation) -> Config:
        """Read the pose of one frame in the other.

        Raises:
            ControllerError: the controller gives no pose, or has no such frame.
        """
        return composed([read_six(self._call, read, self._timeout) for read in rotation.reads])
