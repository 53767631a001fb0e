"""`aioduco call`: one function of the manual, by its name."""

from __future__ import annotations

import inspect
import json as json_module
import re
from typing import Annotated, Any, Final

import typer

from aioduco.cli.addresses import CellFile, HostOption, Port, robot_at
from aioduco.cli.exit_codes import fail, say_error
from aioduco.cli.options import Json, refuse_unused
from aioduco.cli.output import print_json, say
from aioduco.cli.questions import ask
from aioduco.cli.sessions import control_session, observing_session
from aioduco.models.similar import did_you_mean

#: function of the manual that is no call here -> what a user of commands has instead
_INSTEAD: Final = {
    **dict.fromkeys(("DucoCobot", "open", "close"), "each command connects and disconnects itself"),
    "rpc_heartbeat": "each command sends it by itself while it moves the arm",
    "get_version": "`aioduco --version` shows it",
    "move_jog": "`aioduco jog` carries it out",
    "resume": "`aioduco resume` does it; what a call sets moving is stopped as the call ends",
}
#: function that moves the arm, besides those that can be started as tasks
_MOVES: Final = "robot.motion.replay"
#: words that a signature shows, which JSON writes otherwise
_PYTHON: Final = {"True": True, "False": False, "None": None}


def _functions(incomplete: str) -> list[str]:
    """Names of functions, for the shell's completion."""
    from aioduco._wire import idl  # noqa: PLC0415
    from aioduco.models.names import SPELLINGS  # noqa: PLC0415

    names = {*SPELLINGS, *idl.names()} - _INSTEAD.keys()
    return sorted(name for name in names if name.startswith(incomplete))


def call(
    context: typer.Context,
    name: Annotated[str, typer.Argument(autocompletion=_functions)],
    words: Annotated[list[str] | None, typer.Argument()] = None,
    host: HostOption = None,
    port: Port = None,
    cell: CellFile = None,
    describe: bool = False,
    yes: Annotated[bool, typer.Option("--yes", "-y")] = False,
    json: Json = False,
) -> None:
    """Call one function of the manual and print what it returns.

    A call that changes something, such as a motion, is shown first and must be confirmed.

    aioduco call get_tcp_pose

    aioduco call movej2 "[0, -0.2, 1.8, 0, -1.57, 0]" v=0.5 a=1

    aioduco call movel --describe

    Exit codes: 0 called; 1 it failed, or no controller; 2 wrong options; 3 not confirmed; 4 it is
    not known that the arm stands; 130, 143 Ctrl-C or SIGTERM: what it moved was stopped.

    Args:
        name: The function, as the manual or the wire names it.
        words: Its arguments as JSON or words, in order or as name=value.
        describe: Show its parameters and purpose, and call nothing.
        yes: Do not ask before a call that changes something.
    """
    import aioduco.sync  # noqa: PLC0415 - for this command alone
    from aioduco._wire.idempotence import call_kind  # noqa: PLC0415
    from aioduco.models.enums import ProgramState  # noqa: PLC0415
    from aioduco.models.names import SPELLINGS, place  # noqa: PLC0415

    where = place(name)
    if name in _INSTEAD and not (describe and where):
        raise typer.BadParameter(f"{name} is not called here: {_INSTEAD[name]}")
    if where is None:
        if {".", ":"} & set(name):
            raise typer.BadParameter(f"{name} is no function; --host gives the arm's address")
        raise typer.BadParameter(
            f"no function of the robot is called {name}; docs/functions.md lists all of them"
            f"{did_you_mean(name, _functions(''))}"
        )
    address = robot_at(host, port, cell)
    robot = aioduco.sync.connect(address.host, address.port, lag_limit=None)
    function = function_of(robot, where)
    if describe:
        refuse_unused(context, "a call, without --describe", "json")
        # annotations are strings, which a signature shows in quotes
        signature = re.sub(r"(: |-> )'([^']+)'", r"\1\2", str(inspect.signature(function)))
        say(f"{where}{signature}\n\n{inspect.getdoc(function) or ''}".rstrip())
        return
    positional, named = _arguments(words or [])
    try:
        inspect.signature(function).bind(*positional, **named)
    except TypeError as error:
        raise typer.BadParameter(
            f"{name}: {error}; `aioduco call {name} --describe` shows what it takes. A list is one "
            "argument: '[0, 0, 1.57, 0, -1.57, 0]'"
        ) from None
    shown = [*map(repr, positional), *(f"{key}={value!r}" for key, value in named.items())]
    if not call_kind(SPELLINGS.get(name, name)).repeatable:
        ask(f"{where}({', '.join(shown)}) on {address}", "Go on?", yes=yes)
    moves = hasattr(function, "start") or where == _MOVES
    session = control_session if moves else observing_session
    try:
        with session(address) as robot:
            if moves and robot.state.get_robot_state().program is ProgramState.PAUSED:
                arm = address.where
                say_error(
                    f"the arm at {address} is paused, and what is called waits: "
                    f"`aioduco resume {arm}` goes on, `aioduco stop {arm}` ends it"
                )
            result = function_of(robot, where)(*positional, **named)
    except TypeError as error:
        fail(f"{name}: {error}")
    if json:
        print_json(result)
    elif result is not None:
        say(result)


def function_of(robot: Any, where: str) -> Any:
    """The function that an expression such as `robot.motion.movel` names."""
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
            if key in named:
                raise typer.BadParameter(f"{key} is given twice: {named[key]!r} and {value}")
            named[key] = _value(value)
        else:
            positional.append(_value(word))
    return positional, named


def _value(word: str) -> Any:
    """Value of a word: parsed as JSON, or the word itself; True, False and None are Python's."""
    if word in _PYTHON:
        return _PYTHON[word]
    try:
        return json_module.loads(word)
    except ValueError:
        return word
