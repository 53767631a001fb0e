"""The frame in which a program gives velocities and offsets, and how they are rotated."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.streaming.shared.config import FrameRotation

__all__ = ["MotionFrame", "into_tool", "into_wobj"]

#: the robot's base, the tool, or a work object
MotionFrame: TypeAlias = Literal["base", "tool", "wobj"]


def _checked(frame: str, wobj: str) -> str:
    if frame not in get_args(MotionFrame):
        known = ", ".join(f'"{name}"' for name in get_args(MotionFrame))
        raise ParameterError("frame", frame, f"one of {known}")
    name = ranges.FRAME("wobj", wobj)
    if name and frame != "wobj":
        raise ParameterError("wobj", wobj, 'left out, or frame="wobj" given with it')
    return name


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
