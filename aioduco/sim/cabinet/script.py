"""Programs of a simulated controller: calls of the wire, one after the other.

The vendor does not publish how its programs are stored and written. Here a program is a list of
calls. Each call is the name of a function of the wire and its arguments, also in a JSON file:

    [["movej2", [0, 0, 1.57, 0, -1.57, 0], 1.0, 2.0], ["sleep", 0.5], ["stop"]]

A program may also be a generator function that yields such calls and gets their answers:

    def pick():
        while not (yield "get_standard_digital_in", 3):
            yield "sleep", 0.1
        yield "set_standard_digital_out", 1, True

It runs in the controller's cycle, so it must not block.

Arguments at the end may be left out: `block` is then true, and all others are zero. A struct may be
given as a mapping. "sleep" is not a function of the wire: it waits for a number of seconds of
simulated time.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Generator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from aioduco._wire import idl
from aioduco._wire.type_checks import TypeMismatch
from aioduco.models.toml_files import read_text

__all__ = ["Call", "ProgramError", "Script", "checked", "prepared", "read"]

#: a function of the wire and its arguments
Call: TypeAlias = Sequence[Any]
#: a program
Script: TypeAlias = Sequence[Call] | Callable[[], Generator[Call, Any, object]]

SLEEP = "sleep"
#: motions whose r or rad is a blend radius
BLENDING = frozenset(
    {
        *("movej", "movej2", "movej_pose", "movej_pose2", "movel", "movec", "move_circle"),
        *("tcp_move", "tcp_move_2p", "wobj_move", "wobj_move_2p", "spline", "spline_op"),
        *("movej2_eaxis", "movej2_pose_eaxis", "movel_eaxis", "movec_eaxis"),
        "move_circle_eaxis",
    }
)


class ProgramError(Exception):
    """A program cannot continue."""


def read(folder: str | Path) -> dict[str, list[Call]]:
    """Read the programs of a folder: its files "<name>.json".

    Raises:
        ValueError: A file is not a program, or it is a link that leads out of the folder.
        OSError: The folder or a file cannot be read.
    """
    root = Path(folder).resolve(strict=True)
    found: dict[str, list[Call]] = {}
    for file in sorted(root.glob("*.json")):
        if file.resolve(strict=True).parent != root:
            raise ValueError(f"{file} leads out of {root}")
        try:
            calls = json.loads(read_text(file))
        except (ValueError, RecursionError) as exc:
            raise ValueError(f"{file} is no JSON: {exc}") from None
        checked(str(file), calls)
        found[file.stem] = calls
    return found


def checked(name: str, script: Script) -> Script:
    """Check what can be checked before a program runs.

    Raises:
        ValueError: A call is not a valid call of the wire.
    """
    if callable(script):
        return script
    if not isinstance(script, (list, tuple)):
        # It may come from a file: its content is wrong, not its type.
        raise ValueError(f"{name} must be a list of calls, or a generator function")  # noqa: TRY004
    for number, call in enumerate(script, 1):
        try:
            prepared(call)
        except ProgramError as exc:
            raise ValueError(f"{name}, call {number}: {exc}") from None
    return script


def prepared(call: Call) -> tuple[str, tuple[Any, ...]]:
    """Give a call's name, and its arguments as on the wire: motions with a blend radius block."""
    if isinstance(call, str) or not isinstance(call, Sequence) or not call:
        raise ProgramError(f"{call!r} is no call: it must be a name and arguments")
    name, *given = call
    if name == SLEEP:
        if len(given) != 1 or not isinstance(given[0], (int, float)) or not 0 <= given[0] < 1e9:
            raise ProgramError("sleep takes a time in seconds")
        return name, tuple(given)
    function = idl.functions().get(name) if isinstance(name, str) else None
    if function is None:
        raise ProgramError(f"there is no function {name!r}")
    if len(given) > len(function.parameters):
        raise ProgramError(f"{name} takes {len(function.parameters)} arguments, not {len(given)}")
    values: dict[str, Any] = {}
    blends = False
    specs = function.args.thrift_spec.values()
    for index, (_, parameter, spec, *_) in enumerate(specs):
        if index < len(given):
            where = f"{name}: {parameter}"
            values[parameter] = value = _typed(where, spec, given[index])
            try:
                function.checks[index](value)
            except TypeMismatch as exc:
                told = f"{where}{exc.path} is {exc.value!r:.60}, but must be {exc.expected}"
                raise ProgramError(told) from None
        else:
            values[parameter] = True if parameter == "block" else function.zeros[index]()
        if parameter in ("r", "rad") and name in BLENDING:
            radius = values[parameter]
            blends = isinstance(radius, (int, float)) and radius > 0.0
    if blends:
        values["block"] = True
    return name, tuple(values.values())


def _typed(where: str, spec: Any, value: Any) -> Any:
    """Replace each mapping that stands for a struct by the struct, None by one of zeros.

    The field spec of a struct is its class. That of a list is a pair; its second item is the spec
    of the elements.
    """
    if isinstance(spec, type) and not isinstance(value, spec):
        if not isinstance(value, (Mapping, type(None))):
            raise ProgramError(
                f"{where} is {value!r}, but must be a mapping of the fields of {spec.__name__}"
            )
        given = value or {}
        fields = {entry[1]: entry[2] for entry in vars(spec)["thrift_spec"].values()}
        unknown = sorted(set(given) - set(fields))
        if unknown:
            raise ProgramError(f"{spec.__name__} has no {unknown[0]!r}")
        return spec(
            **{name: _typed(f"{where}.{name}", fields[name], each) for name, each in given.items()}
        )
    if isinstance(spec, tuple) and isinstance(value, list):
        return [_typed(f"{where}[{index}]", spec[1], each) for index, each in enumerate(value)]
    return value
