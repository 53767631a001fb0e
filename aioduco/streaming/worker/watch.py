"""What the controller's answers say: whether it was not carried out, and why a stream must end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.models.enums import ProgramState, RobotState, TaskState
from aioduco.streaming.shared.words import Reason

if TYPE_CHECKING:
    from collections.abc import Sequence


_TASK_FAILED = (TaskState.ERROR, TaskState.ILLEGAL, TaskState.PARAMETER_MISMATCH)


def refused(answer: int) -> bool:
    """Whether an answer means that a call was not carried out; such an answer is no task id."""
    return answer < 0 or answer in _TASK_FAILED


def ended(task: int, state: int, *, waits: bool = False) -> tuple[Reason, str]:
    """Why a stream must end because of its task.

    Args:
        task: id of the task.
        state: state of the task, as the controller gave it.
        waits: whether the stream goes on when a task that was paused is resumed. Else it has gone
            on meanwhile, and the arm would move by all of that when somebody resumes it.

    Returns:
        The reason and a text; the reason is NONE if the stream need not end.
    """
    if state == TaskState.STOPPED:
        return Reason.STOPPED, f"the controller stopped task {task}"
    if state in _TASK_FAILED:
        return Reason.REFUSED, f"task {task} ended as {TaskState(state)} (manual 1.2)"
    if state == TaskState.PAUSED and not waits:
        return Reason.REFUSED, f"task {task} was paused: by a person, or by another program"
    return Reason.NONE, ""


def disabled(states: Sequence[int], *, waits: bool = False) -> tuple[Reason, str]:
    """Why a stream must end because of the robot's state.

    Args:
        states: the states, as the controller gave them; none: it does not report them.
        waits: as for `ended`.

    Returns:
        As `ended`.
    """
    robot = RobotState(states[0]) if states else RobotState.ENABLE
    if robot != RobotState.ENABLE:
        return Reason.REFUSED, f"the robot is in state {robot}, not ENABLE (manual 1.2)"
    if not waits and states[1:2] and states[1] in (ProgramState.PAUSED, ProgramState.PAUSING):
        return Reason.REFUSED, "the arm is paused: by a person, or by another program"
    return Reason.NONE, ""
