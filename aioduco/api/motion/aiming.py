"""Motions given in another frame than the wire's, rotated by the tool's pose when they are sent."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.errors import ControllerError, StaleState
from aioduco.streaming.shared.turning import place_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.streaming.shared.config import FrameRotation
    from aioduco.streaming.shared.space import Config
    from aioduco.supervision.supervisor import Supervisor
    from aioduco.supervision.task_command import Aim, Command


def tool_aim(
    supervisor: Supervisor,
    rotation: FrameRotation,
    turn: Callable[[Sequence[float], Config], tuple[float, ...]],
) -> Aim:
    """Make what converts the first argument of a motion into the tool's frame.

    Args:
        supervisor: the robot.
        rotation: the reads that give the tool's pose in that frame.
        turn: function that rotates six numbers by the tool's pose.

    Returns:
        The aim. It raises `StaleState`, and nothing is sent, if the controller does not report the
        tool's pose.
    """

    async def arguments(command: Command) -> tuple[Any, ...]:
        supervisor.check_open(command.name)
        given, *others = command.args
        rpc = supervisor.rpc
        poses = [await getattr(rpc, name)(*args) for name, *args in rotation.reads]
        try:
            place = place_of(rotation, poses)
        except ControllerError as exc:
            raise StaleState(f"{command.name} was not sent: {exc}") from exc
        return (list(turn(given, place)), *others)

    return arguments
