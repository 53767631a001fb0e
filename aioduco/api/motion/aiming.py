"""Motions given in another frame than the wire's, rotated by the tool's pose when they are sent."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from aioduco.errors import StaleState
from aioduco.streaming.shared.turning import composed, turned
from aioduco.supervision.task_command import Aim

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.streaming.shared.config import FrameRotation
    from aioduco.streaming.shared.space import Config
    from aioduco.supervision.supervisor import Supervisor
    from aioduco.supervision.task_command import Command

__all__ = ["tool_aim", "twist_in_tool"]


def tool_aim(
    supervisor: Supervisor,
    frame: str,
    turning: FrameRotation,
    turn: Callable[[Sequence[float], Config], tuple[float, ...]],
) -> Aim:
    """Make what converts the first argument of a motion into the tool's frame.

    Args:
        supervisor: the robot.
        frame: frame in which the motion is given.
        turning: the reads that give the tool's pose in that frame.
        turn: function that rotates six numbers by the tool's pose.

    Returns:
        The aim. It raises `StaleState`, and nothing is sent, if the controller does not report the
        tool's pose.
    """

    async def arguments(command: Command) -> tuple[Any, ...]:
        supervisor.check_open(command.name)
        given, *others = command.args
        poses: list[Sequence[float]] = []
        for name, *args in turning.reads:
            pose: Sequence[float] = await getattr(supervisor.retrying.rpc, name)(*args)
            if len(pose) != 6 or not all(map(math.isfinite, pose)):
                asked = f"({', '.join(map(repr, args))})"
                raise StaleState(
                    f"{command.name} was not sent: {name}{asked} answered {list(pose)}: "
                    "it is not known how to turn it; is there a tool or work object of that name?"
                )
            poses.append(pose)
        return (list(turn(given, composed(poses))), *others)

    return Aim(frame, arguments)


def twist_in_tool(twist: Sequence[float], place: Config) -> tuple[float, ...]:
    """Convert a velocity to one along and about the tool's axes [m/s, rad/s]."""
    return turned(twist, place, back=True)
