"""How a call is refused: by the state in which its task ends, or by an application error."""

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
