"""Exceptions by which a handler refuses a call, or reports that its task has not ended."""

from __future__ import annotations

from aioduco.errors import Portable
from aioduco.models.enums import TaskState


class Refusal(Portable):
    """The call is answered with a Thrift application error that carries this text."""


class SimulationFailed(Refusal, RuntimeError):
    """The simulation has failed, and stands still; for the methods of a simulator, too."""

    def __init__(self, failure: Exception) -> None:
        super().__init__(f"the simulation failed: {failure!r}")


class Rejected(Portable):
    """A task cannot be carried out: it ends at once, in a state that gives the reason."""

    def __init__(self, state: TaskState, message: str) -> None:
        super().__init__(message)
        self.state = state


def mismatch(message: str) -> Rejected:
    """Make the rejection of a task with a wrong parameter."""
    return Rejected(TaskState.PARAMETER_MISMATCH, message)


def illegal(message: str) -> Rejected:
    """Make the rejection of a task that the controller's state does not allow."""
    return Rejected(TaskState.ILLEGAL, message)


class Pending(Portable):
    """The task of a program's call has not ended; the cycle must not wait for it."""

    def __init__(self, id_: int) -> None:
        super().__init__(f"task {id_} has not ended")
        self.id = id_
