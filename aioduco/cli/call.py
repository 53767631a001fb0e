"""`aioduco call`: one function of the manual, by its name."""

from __future__ import annotations

import dataclasses
import enum
import inspect
import json as json_module
import re
from typing import Annotated, Any

import numpy as np
import typer

__all__ = ["call", "function_of"]


def call(
    name: Annotated[str, typer.Argument(help="The function, as the manual or the wire names it.")],
    words: Annotated[
        list[str] | None,
        typer.Argument(help="Its arguments as JSON or words, in order or as name=value."),
    ] = None,
    host: Annotated[str, typer.Option(help="Address of the controller.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port of the controller.")] = 7003,
    describe: Annotated[
        bool, typer.Option("--describe", help="Say what it takes and does, and call nothing.")
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Do not ask before a call that changes something.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Call one function of the manual and print what it returns.

    A call that changes something, as all motions do, is shown first and asks.

    aioduco call get_tcp_pose

    aioduco call movej2 "[0, -0.2, 1.8, 0, -1.57, 0]" v=0.5 a=1
    """
    import aioduco.sync  # noqa: PLC0415 - for this command alone
    from aioduco._wire.idempotence import call_kind  # noqa: PLC0415
    from aioduco.models.names import SPELLINGS, place  # noqa: PLC0415

    where = place(name)
    if where is None:
        raise typer.BadParameter(
            f"no function of the robot is called {name}; docs/functions.md lists all of them"
        )
    robot = aioduco.sync.connect(host, port)
    if describe:
        function = function_of(robot, where)
        # annotations are texts, which a signature shows in quotes
        signature = re.sub(r"(: |-> )'([^']+)'", r"\1\2", str(inspect.signature(function)))
        typer.echo(f"{where}{signature}\n\n{inspect.getdoc(function)}")
        return
    positional, named = _arguments(words or [])
    shown = [*map(repr, positional), *(f"{key}={value!r}" for key, value in named.items())]
    if not call_kind(SPELLINGS.get(name, name)).repeatable and not yes:
        typer.confirm(f"{where}({', '.join(shown)}) on {host}:{port}. Go on?", abort=True)
    try:
        with robot:
            result = function_of(robot, where)(*positional, **named)
    except (aioduco.DucoError, TypeError) as error:
        typer.echo(f"{name}: {error}", err=True)
        raise typer.Exit(1) from None
    if json:
        typer.echo(json_module.dumps(_plain(result)))
    elif result is not None:
        typer.echo(result)


def function_of(robot: Any, where: str) -> Any:
    """What an expression such as `robot.motion.movel` stands for."""
    found = robot
    for part in where.split(".")[1:]:
        found = getattr(found, part)
    return found


def _arguments(words: list[str]) -> tuple[list[Any], dict[str, Any]]:
    positional: list[Any] = []
    named: dict[str, Any] = {}
    for word in words:
        key, equals, value = word.partition("=")
        if equals and key.isidentifier():
            named[key] = _value(value)
        else:
            positional.append(_value(word))
    return positional, named


def _value(word: str) -> Any:
    """What a word stands for: JSON, or itself."""
    try:
        return json_module.loads(word)
    except ValueError:
        return word


def _plain(value: Any) -> Any:
    """A result in the types that JSON knows."""
    if isinstance(value, enum.Enum):
        return value.name
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)
        }
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(each) for each in value]
    return value if isinstance(value, str | int | float | bool | None) else str(value)
