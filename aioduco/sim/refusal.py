"""How a handler refuses a call, or says that its task has not ended."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.models.enums import TaskState


class Refusal(Exception):
    """The call is answered with a Thrift application error that carries this text."""


class Rejected(Exception):
    """A task cannot be done: it ends at once, in a state that says why."""

    def __init__(self, state: TaskState, message: str) -> None:
        super().__init__(message)
        self.state = state


class Pending(Exception):
    """The task of a call that a program makes has not ended; the cycle must not wait for it."""

    def __init__(self, id_: int) -> None:
        super().__init__(f"task {id_} has not ended")
        self.id = id_
