"""Base of all handlers: access to the simulation, and the answer to a call that makes a task."""

from __future__ import annotations

import functools
import inspect
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

from aioduco._wire.rpc import Functions
from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.sim import trial
from aioduco.sim.cabinet import Cabinet
from aioduco.sim.refusal import Forgiving, Rejected

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import Arm
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.runtime import SimulationRuntime


T = TypeVar("T")
#: functions of 1.3.7, whose first note says that they return 0 for an argument out of its range;
#: the last two are on the wire, not in the manual, and are assumed to do the same
ZERO_OUT_OF_RANGE = frozenset(
    (
        "set_digital_output_mode",
        "set_standard_digital_out",
        "set_tool_digital_out",
        "set_standard_analog_voltage_out",
        "set_standard_analog_current_out",
        "write_bool_reg",
        "write_word_reg",
        "write_float_reg",
        "set_wobj_offset",
        "set_tool_data",
        "speed",
        "set_load_data",
        "start_record_track",
        "collision_detect",
        "set_teach_speed",
        "switch_mode",
        "set_wobj",
        "set_analog_output_mode",
    )
)


@dataclass(frozen=True, slots=True)
class HandlerContext:
    """The parts of the simulation that handlers use.

    Attributes:
        arm: the arm's dimensions and kinematics.
        runtime: the running simulation.
        controller: its controller, which is changed only within a command.
        serial: the arm's serial number.
        cabinet: the other state of the controller: variables, ports, files.
        forgiving: decides whether a call that deviates from the manual is accepted.
        mounting: pose of the base in the world.
        home: joints at the start [rad].
        period: time between two updates of the arm's readings [s]; 0 for one in each cycle.
    """

    arm: Arm
    runtime: SimulationRuntime
    controller: Controller
    serial: str
    cabinet: Cabinet = field(default_factory=Cabinet)
    forgiving: Forgiving = field(default_factory=Forgiving)
    mounting: Pose = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # noqa: RUF009 - a tuple of numbers
    home: tuple[float, ...] = (0.0,) * 6
    period: float = 0.0


class QueueFull(Exception):
    """The points do not fit into a queue; none of them was taken."""


class HandlerSection:
    """Base of the handlers of one section."""

    def __init__(self, context: HandlerContext) -> None:
        self._arm = context.arm
        self._runtime = context.runtime
        self._cycle = context.runtime.cycle
        self._controller = context.controller
        self._signals = context.controller.signals
        self._frames = context.controller.frames
        self._cabinet = context.cabinet
        self._forgiving = context.forgiving
        self._context = context

    def _task(self, name: str, block: bool, command: Callable[[Controller], int | None]) -> int:
        """Give the controller a command that makes a task.

        Args:
            name: name of the function.
            block: whether to wait for the end of the task.
            command: returns the id of its task; None if what it did is finished, by a task of its
                own.

        Returns:
            The state in which the task ended, or the task's id when the call does not block; 0
            for an argument out of its range where the manual says so.
        """
        with self._runtime.command() as controller:
            try:
                made = command(controller)
                id_ = controller.finish(name) if made is None else made
            except Rejected as exc:
                id_ = controller.reject(name, exc.state, str(exc))
                if exc.state is TaskState.PARAMETER_MISMATCH and name in ZERO_OUT_OF_RANGE:
                    return 0
        if not block:
            return id_
        with trial.waiting():
            return int(self._runtime.wait(id_))

    def _enqueue(self, name: str, block: bool, put: Callable[[Controller], bool]) -> int:
        """Make a task that puts points into a queue: all of them, or none; then return -1.

        Args:
            name: name of the function.
            block: whether to wait for the end of the task.
            put: puts the points in, and returns whether they fit.
        """

        def command(controller: Controller) -> None:
            if not put(controller):
                raise QueueFull

        try:
            return self._task(name, block, command)
        except QueueFull:
            return -1

    def _invalid_arguments(self, name: str, reason: Exception, answer: T) -> T:
        """Answer a call that makes no task and has wrong arguments.

        The reason is added to the error list, like that of a rejected task.
        """
        with self._runtime.command() as controller:
            controller.note_error(f"{name}: {reason}")
        return answer


def task(*, block: bool = True) -> Callable[[Callable[..., int | None]], Callable[..., int]]:
    """Make a handler of a command to the controller: it makes a task, as `_task` does.

    The command has the function's name, and takes the controller and the function's arguments,
    except `block`.

    Args:
        block: whether the call waits for the end of the task, if no argument says so.
    """

    def handler_of(command: Callable[..., int | None]) -> Callable[..., int]:
        name = command.__name__
        names = arguments_of(name)

        def answer(self: HandlerSection, *values: Any) -> int:
            given = dict(zip(names, values, strict=True))
            waits = given.pop("block", block)
            return self._task(name, waits, lambda c: command(self, c, **given))

        return as_on_the_wire(command, answer)

    return handler_of


def as_on_the_wire(
    function: Callable[..., object], answer: Callable[..., int]
) -> Callable[..., int]:
    """A handler with the signature of the wire, and the description of a function."""
    handler = functools.wraps(getattr(Functions, function.__name__))(answer)
    handler.__doc__ = function.__doc__
    return handler


def arguments_of(name: str) -> list[str]:
    """The names of a function's arguments, in their order on the wire."""
    return list(inspect.signature(getattr(Functions, name)).parameters)[1:]
