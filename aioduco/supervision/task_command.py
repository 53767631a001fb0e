"""A command that becomes a task, as a value: what is sent, and how it is shown."""

from __future__ import annotations

import inspect
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.supervision.task_state import ContinuousMotion, JointEta

#: makes the arguments of a command in the frame of the wire
Aim: TypeAlias = "Callable[[Command], Awaitable[tuple[Any, ...]]]"


@dataclass(frozen=True, slots=True)
class Command:
    """A call that the controller answers with the id of a task.

    Attributes:
        name: the function of the wire.
        args: its arguments, checked and converted, with block false; see `blocking`.
        motion: whether it moves the arm.
        blends: whether it asks to blend into the next motion, or to be replaced by it.
        continuous: how it ends, if it is a continuous motion.
        eta: its target and speed, if they are known for the joints.
        sense: direction of a jog, 1 or -1, whose number on the wire depends on the controller.
        frame: the frame in which it is given, if that is not the wire's.
        aim: returns its arguments when it is sent: in the frame of the wire, by the tool's pose; or
            raises if what is there then does not fit it.
    """

    name: str
    args: tuple[Any, ...]
    motion: bool = True
    blends: bool = False
    continuous: ContinuousMotion | None = None
    eta: JointEta | None = None
    sense: int = 0
    frame: str = ""
    aim: Aim | None = None


def shown(command: Command) -> str:
    """Format a command as a call: its first argument, and the others that are not zero or empty.

    The others have their names of the wire.
    """
    texts = [
        _short(value) if number == 0 else f"{name}={_short(value)}"
        for number, (name, value) in enumerate(_named(command))
        if number == 0 or not _empty(value)
    ]
    return f"{command.name}({', '.join(texts)})"


def blocking(command: Command) -> Command:
    """Return the same command with block true: it is answered when it has ended."""
    args = (name == "block" or value for name, value in _named(command))
    return replace(command, args=tuple(args))


def _named(command: Command) -> list[tuple[str, Any]]:
    """The arguments of a command, with their names of the wire."""
    from aioduco._wire.rpc import AsyncRpc  # noqa: PLC0415  # only when it is needed

    _, *names = inspect.signature(getattr(AsyncRpc, command.name)).parameters
    return list(zip(names, command.args, strict=False))


def _empty(value: Any) -> bool:
    """Whether a value counts as absent on the wire: zero, false, or empty."""
    if is_dataclass(value):
        return all(_empty(getattr(value, field.name)) for field in fields(value))
    return not value


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_short(each) for each in value)}]"
    if is_dataclass(value):
        given = {field.name: getattr(value, field.name) for field in fields(value)}
        parts = [f"{name}={_short(each)}" for name, each in given.items() if not _empty(each)]
        return f"{type(value).__name__}({', '.join(parts)})"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
