"""What all handlers share: the simulation behind them, and how a task is answered."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

from aioduco.models.enums import TaskState
from aioduco.sim.cabinet import Cabinet
from aioduco.sim.handlers.answers import ZERO_OUT_OF_RANGE
from aioduco.sim.refusal import Rejected

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import Arm
    from aioduco.sim.controller import Controller
    from aioduco.sim.frames import Frames
    from aioduco.sim.runtime import Runtime
    from aioduco.sim.signals import Signals


T = TypeVar("T")


def mismatch(message: str) -> Rejected:
    """A parameter is wrong."""
    return Rejected(TaskState.PARAMETER_MISMATCH, message)


@dataclass(frozen=True, slots=True)
class Context:
    """What handlers act on.

    Attributes:
        arm: the arm's dimensions and kinematics.
        runtime: the running simulation.
        signals: inputs and outputs.
        frames: tools and work objects.
        series, model, serial: what get_robot_type tells.
        cabinet: what the controller keeps besides: variables, ports, files.
    """

    arm: Arm
    runtime: Runtime
    signals: Signals
    frames: Frames
    series: str
    model: str
    serial: str
    cabinet: Cabinet = field(default_factory=Cabinet)


class Section:
    """Base of the handlers of one section."""

    def __init__(self, context: Context) -> None:
        self._arm = context.arm
        self._runtime = context.runtime
        self._signals = context.signals
        self._frames = context.frames
        self._cabinet = context.cabinet
        self._context = context

    def _task(self, name: str, block: bool, command: Callable[[Controller], int]) -> int:
        """Give a command that makes a task.

        Returns:
            The state in which the task ended, or the task's id when the call does not block; 0
            for an argument out of its range where the manual says so.
        """
        with self._runtime.command() as controller:
            try:
                id_ = command(controller)
            except Rejected as exc:
                id_ = controller.reject(name, exc.state, str(exc))
                if exc.state is TaskState.PARAMETER_MISMATCH and name in ZERO_OUT_OF_RANGE:
                    return 0
        return int(self._runtime.wait(id_)) if block else id_

    def _senseless(self, name: str, reason: Exception, answer: T) -> T:
        """The answer to arguments that make no sense, where it is no state of a task.

        The reason is put on the error list, as that of a task is.
        """
        with self._runtime.command() as controller:
            controller.note_error(f"{name}: {reason}")
        return answer
