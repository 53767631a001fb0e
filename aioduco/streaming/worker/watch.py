"""Checks that the controller still follows, by its answers and by polling it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco.errors import ControllerError
from aioduco.streaming.shared.words import Reason

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection

__all__ = ["ControllerWatch", "ended", "newest_error", "refused"]

_ENABLED = 6  # robot state (manual 1.2)
_TASK_STOPPED = 3
_TASK_FAILED = (6, 7, 8)  # error, illegal, parameter mismatch (manual 1.2)


def refused(answer: int) -> bool:
    """Whether an answer means that a call was not carried out; such an answer is no task id."""
    return answer < 0 or answer in _TASK_FAILED


def ended(task: int, state: int) -> tuple[Reason, str]:
    """Why a stream must end because of its task.

    Args:
        task: id of the task.
        state: state of the task, as the controller gave it.

    Returns:
        The reason and a text; the reason is NONE if the stream need not end.
    """
    if state == _TASK_STOPPED:
        return Reason.STOPPED, f"the controller stopped task {task}"
    if state in _TASK_FAILED:
        return Reason.REFUSED, f"task {task} ended in state {state} (manual 1.2)"
    return Reason.NONE, ""


def newest_error(connection: Connection, timeout: float) -> str:
    """The newest text on the controller's error list; empty if there is none.

    Args:
        connection: the worker's connection.
        timeout: time-out of the call [s].
    """
    try:
        errors = connection.call("get_last_error", (), timeout)
    except ControllerError:
        return ""  # this controller does not report them
    return errors[-1] if errors else ""


class ControllerWatch:
    """Polls the controller periodically, to check that it still follows.

    Args:
        connection: the worker's connection.
        every: time between two polls [s]; 0: never.
        timeout: time-out of each call [s].
    """

    def __init__(self, connection: Connection, every: float, timeout: float) -> None:
        self._connection = connection
        self._every = int(every * 1e9)
        self._timeout = timeout
        self._due = time.monotonic_ns() + self._every
        self._task_next = False

    def look(self, task: int) -> tuple[Reason, str]:
        """Poll the controller, if it is time to.

        Args:
            task: the id that the controller returned for the last set-point; 0: none.

        Returns:
            Why the stream must end, and a text; the reason is NONE if it need not.
        """
        now = time.monotonic_ns()
        if not self._every or now < self._due:
            return Reason.NONE, ""
        self._due = now + self._every
        self._task_next = not self._task_next
        if self._task_next and task > 0:
            state = self._connection.call("get_noneblock_taskstate", (task,), self._timeout)
            return ended(task, state)
        robot, *_ = self._connection.call("get_robot_state", (), self._timeout) or [_ENABLED]
        if robot != _ENABLED:
            return Reason.REFUSED, f"the robot is in state {robot}, not enabled (manual 1.2)"
        return Reason.NONE, ""
