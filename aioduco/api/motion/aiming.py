"""Motions given in another frame than the wire's, rotated by the tool's pose when they are sent."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from aioduco.errors import StaleState
from aioduco.streaming.shared.turning import composed, turned

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.streaming.shared.config import FrameRotation
    from aioduco.streaming.shared.space import Config
    from aioduco.supervision.command import Command
    from aioduco.supervision.supervisor import Supervisor

__all__ = ["ToolAim", "twist_in_tool"]


class ToolAim:
    """Converts the first argument of a motion into the tool's frame.

    Args:
        supervisor: the robot.
        frame: frame in which the motion is given.
        turning: the reads that give the tool's pose in that frame.
        turn: function that rotates six numbers by the tool's pose.
    """

    __slots__ = ("_supervisor", "_turn", "_turning", "frame")

    def __init__(
        self,
        supervisor: Supervisor,
        frame: str,
        turning: FrameRotation,
        turn: Callable[[Sequence[float], Config], tuple[float, ...]],
    ) -> None:
        self._supervisor = supervisor
        self._turning = turning
        self._turn = turn
        self.frame: str = frame

    async def arguments(self, command: Command) -> tuple[Any, ...]:
        """Read the tool's pose, and return the arguments with the first one converted.

        Raises:
            StaleState: the controller does not report the tool's pose; nothing was sent.
        """
        self._supervisor.check_open(command.name)
        given, *others = command.args
        poses: list[Sequence[float]] = []
        for name, *args in self._turning.reads:
            pose: Sequence[float] = await getattr(self._supervisor.retrying.rpc, name)(*args)
            if len(pose) != 6 or not all(map(math.isfinite, pose)):
                asked = f"({', '.join(map(repr, args))})"
                raise StaleState(
                    f"{command.name} was not sent: {name}{asked} answered {list(pose)}: "
                    "it is not known how to turn it; is there a tool or work object of that name?"
                )
            poses.append(pose)
        return (list(self._turn(given, composed(poses))), *others)


def twist_in_tool(twist: Sequence[float], place: Config) -> tuple[float, ...]:
    """Convert a velocity to one along and about the tool's axes [m/s, rad/s]."""
    return turned(twist, place, back=True)
