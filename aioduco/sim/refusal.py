"""How a call does not end as hoped: refused by its task's end or by an error, or not ended yet."""

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
    """A call of a program that the controller runs waits for a task, which a cycle must not."""

    def __init__(self, id_: int) -> None:
        super().__init__(f"task {id_} has not ended")
        self.id = id_
