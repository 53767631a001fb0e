"""The controller's states (manual 1.2), and the outcomes of tasks.

A controller newer than the manual may send a value that is not listed here. Such a value becomes a
member named `UNKNOWN_<value>` and not an error: reading a state must never fail because of its
value.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, NoReturn, Self

from aioduco.errors import MotionCarriedOut
from aioduco.models.named_int import NamedInt


class _WireEnum(NamedInt):
    """An integer of the wire with names for the values that the manual lists."""

    @classmethod
    def _missing_(cls, value: object) -> _WireEnum | None:
        if not isinstance(value, int):
            return None
        member = int.__new__(cls, value)
        member._name_ = f"UNKNOWN_{value}"
        member._value_ = value
        return member

    def __reduce_ex__(self, _protocol: object) -> tuple[type[Self], tuple[int]]:
        # By value: Python 3.11.2 pickles members by name, which does not work for unlisted values.
        return type(self), (int(self),)

    @property
    def known(self) -> bool:
        """Whether the manual lists this value."""
        return self._name_ in type(self).__members__


class RobotState(_WireEnum):
    """State of the robot (机器人状态, manual 1.2)."""

    START = 0
    INITIALIZE = 1
    LOGOUT = 2
    LOGIN = 3
    POWER_OFF = 4
    DISABLE = 5
    ENABLE = 6
    UPDATE = 7


class ProgramState(_WireEnum):
    """State of the program (程序状态, manual 1.2)."""

    STOPPED = 0
    STOPPING = 1
    RUNNING = 2
    PAUSED = 3
    PAUSING = 4
    TASK_RUNNING = 5


class OperationMode(_WireEnum):
    """Operation mode (操作模式, manual 1.2)."""

    MANUAL = 0
    AUTO = 1
    REMOTE = 2


class FileKind(_WireEnum):
    """Kind of an entry in a list of files (文件类型, manual 1.3.4)."""

    FOLDER = 0
    FILE = 1


class OutputMode(NamedInt):
    """Signal type of a digital output (IO 输出信号类型, manual 1.3.7)."""

    LEVEL = 0
    PULSES = 1


class SafetyState(_WireEnum):
    """State of the safety controller (安全控制器状态, manual 1.2)."""

    INIT = 0
    WAIT = 2
    CONFIG = 3
    POWER_OFF = 4
    RUN = 5
    RECOVERY = 6
    STOP2 = 7
    STOP1 = 8
    STOP0 = 9
    MODEL = 10
    REDUCE = 12
    BOOT = 13
    FAIL = 14
    UPDATE = 99


class TaskState(_WireEnum):
    """State of a task (任务状态, manual 1.2)."""

    IDLE = 0
    RUNNING = 1
    PAUSED = 2
    STOPPED = 3
    FINISHED = 4
    INTERRUPT = 5
    ERROR = 6
    ILLEGAL = 7
    PARAMETER_MISMATCH = 8

    @property
    def ended(self) -> bool:
        """Whether a task in this state has ended."""
        return TaskState.STOPPED <= self <= TaskState.PARAMETER_MISMATCH


#: what a program asks of an outcome if it takes it for the motion, or for its task
_OF_MOTIONS = frozenset({"start", "prepare", "states", "wait", "cancel", "pause", "resume"})


class Outcome(Enum):
    """How a task ended."""

    FINISHED = "finished"
    """It reached its end."""
    BLENDED = "blended"
    """It passed into the motion started after it, as its blend radius asked for."""
    STOPPED = "stopped"
    """A stop ended it."""
    INTERRUPTED = "interrupted"
    """It was interrupted, other than by blending."""
    FAILED = "failed"
    """The controller ended it with an error."""
    ILLEGAL = "illegal"
    """It is not allowed in the state that the robot was in."""
    PARAMETER_MISMATCH = "parameter mismatch"
    """The controller found a parameter wrong."""
    UNKNOWN = "unknown"
    """It was lost sight of: it may have ended, or may be running."""

    @property
    def success(self) -> bool:
        """Whether the arm completed the task."""
        return self in {Outcome.FINISHED, Outcome.BLENDED}

    if not TYPE_CHECKING:  # type checkers report these uses by themselves

        def __getattr__(self, name: str) -> NoReturn:
            told = f": {self._carried_out()}" if name in _OF_MOTIONS else ""
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}{told}")

        def __enter__(self) -> NoReturn:
            raise self._carried_out()

        def __exit__(self, *_: object) -> None:
            """Nothing: its block is never entered."""

        def _carried_out(self) -> MotionCarriedOut:
            return MotionCarriedOut(
                "this",
                self,
                "To go on beside a motion, write robot.motion.movel.start(…) in aioduco.sync, and "
                "await robot.motion.movel(…).start() in a program that awaits",
            )
