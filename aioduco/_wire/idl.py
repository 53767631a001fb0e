"""The loaded IDL: the only link between the typed structs of `rpc` and Thrift.

This module parses it, and not thriftpy2: the tables of that parser take 12 MB, and most of the time
that a program, or a stream's worker, needs to start. thriftpy2 reads and writes the structs by
their `thrift_spec`; it is not loaded here.
"""

from __future__ import annotations

import functools
import re
import struct
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar

from aioduco._wire import newer, rpc
from aioduco._wire.framing import TType
from aioduco._wire.layout import Layouts, packer
from aioduco._wire.type_checks import Check, check_of, type_of

#: the functions of manual 3.8, and those that manual 4.3 adds
SERVICE, NEWER_SERVICE = "RPCRobot", "RPCRobotNewer"

#: factories for the value that a missing field has
_ZERO: dict[int, Any] = {
    **dict.fromkeys((TType.BYTE, TType.I16, TType.I32, TType.I64), int),
    TType.BOOL: bool,
    TType.DOUBLE: float,
    TType.STRING: str,
    TType.LIST: list,
    TType.MAP: dict,
}
#: what `getRobotIOStatus` returns on older controllers: fields that have other numbers there
_OLDER_IO = (
    "1: list<double> analogCurrentOutputs 2: list<double> analogVoltageOutputs "
    "3: list<bool> digitalInputs 4: list<bool> digitalOutputs 5: list<bool> toolIOIn "
    "6: list<bool> toolIOOut 7: list<bool> toolButton"
)
#: functions whose result other controllers return with other fields under the same numbers
_INSTEAD = {"getRobotIOStatus": (rpc.IOStatus, _OLDER_IO), **newer.INSTEAD}
_Spec = dict[int, tuple[Any, ...]]

#: patterns of all that the file may contain: comments, structs, services, fields, functions
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_STRUCT = re.compile(r"\bstruct (\w+) \{(.*?)\}", re.DOTALL)
_SERVICE = re.compile(r"\bservice (\w+)(?: extends \w+)? \{(.*?)\}", re.DOTALL)
_FIELD = re.compile(r"(\d+):\s*([\w<>,]+) (\w+)")
_FUNCTION = re.compile(r"([\w<>,]+) (\w+)\((.*?)\)", re.DOTALL)
_CONTAINER = re.compile(r"(list|map)<(.+)>")
_TYPES: dict[str, int] = {
    name: getattr(TType, name.upper())
    for name in ("bool", "byte", "i16", "i32", "i64", "double", "string")
}


class Function:
    """One function of the wire: its name, and the layout of its arguments and result.

    Attributes:
        name: the name on the wire.
        args: class of the argument struct; an instance takes the fields as attributes.
        result: class of the result struct; the value is its attribute `success`.
        other: class of the result struct with the fields that older or newer controllers have
            under the same numbers; None if these are the same.
        newer: class of the result struct with the fields that newer controllers add; None if they
            add none.
        parameters: names of the parameters, in the order of their field ids.
        checks: for each parameter, the function that checks whether a value fits its type.
        packed: function that encodes the arguments; None if they need thriftpy2.
        void: whether the function returns nothing.
        head: the name in the encoding of a message: its length and its text.
        texts: whether the result contains strings, at any depth.
        listed: the function with the arguments of manual 4.3, if its schemes of external axes come
            in lists there; None for all others.
        layouts: layouts of replies that were received.
    """

    def __init__(self, name: str, args: _Spec, result: _Spec) -> None:
        self.name: str = name
        self.args: Any = payload(f"{name}_args", args)
        self.result: Any = payload(f"{name}_result", result)
        self.other: Any = None
        self.newer: Any = None
        if name in newer.ADDED:
            self.newer = _with(self.result, *newer.ADDED[name], added=True)
        if name in _INSTEAD:
            self.other = _with(self.result, *_INSTEAD[name], added=False)
        entries = list(self.args.thrift_spec.values())
        self.parameters: tuple[str, ...] = tuple(entry[1] for entry in entries)
        self.checks: tuple[Check, ...] = tuple(check_of(*type_of(entry)) for entry in entries)
        self.packed: Callable[[tuple[Any, ...]], bytes] | None = packer(self.args.thrift_spec)
        self.void: bool = 0 not in self.result.thrift_spec
        self.head: bytes = struct.pack("!i", len(name)) + name.encode()
        self.texts: bool = _has_text(self.result.thrift_spec)
        self.listed: Function | None = None
        self.layouts: Layouts = Layouts()
        #: for each parameter, a factory for the value that a missing field has
        self.zeros: tuple[Any, ...] = tuple(map(zero, entries))


class Functions(Mapping[str, Function]):
    """The functions of the wire by name; each `Function` is made when it is first used.

    Those that manual 4.3 adds can be had by name, and are no part of the wire of 3.8, which is
    listed.

    A stream's worker calls ten of them. Any thread may use the mapping; all get the same objects.

    Attributes:
        newer: those that manual 4.3 adds, which take no arguments: by name what they return.
    """

    __slots__ = ("_lines", "_made", "newer")

    def __init__(self, service: str, newer_service: str) -> None:
        self._made: dict[str, Function] = {}
        #: by name, the return type and the parameters, as written in the IDL
        self._lines = {
            name: (returned, arguments) for returned, name, arguments in _FUNCTION.findall(service)
        }
        self.newer: dict[str, str] = {
            name: returned for returned, name, _ in _FUNCTION.findall(newer_service)
        }

    def __getitem__(self, name: str) -> Function:
        made = self._made.get(name)
        if made is None:
            returned, arguments = self._lines.get(name) or (self.newer[name], "")
            spec = fields_of(arguments)
            function = Function(name, spec, _result(returned))
            if name in newer.SCHEMES:
                function.listed = Function(name, listed(name, spec), _result(returned))
            made = self._made.setdefault(name, function)
        return made

    def __contains__(self, name: object) -> bool:
        return name in self._lines

    def __iter__(self) -> Iterator[str]:
        return iter(self._lines)

    def __len__(self) -> int:
        return len(self._lines)


def path() -> Path:
    """Return the path of the IDL: beside this module in a wheel, in `idl/` in a checkout."""
    packaged = Path(__file__).with_name("robot.thrift")
    if packaged.exists():
        return packaged
    return Path(__file__).parents[2] / "idl" / "robot.thrift"


@functools.cache
def functions() -> Functions:
    """Load the IDL, once, and return every function of the wire by name.

    Structs are read into and written from the typed dataclasses of `rpc`, without a copy.
    """
    text = _COMMENT.sub("", path().read_text("utf-8"))
    for name, fields in _STRUCT.findall(text):
        getattr(rpc, name).thrift_spec = fields_of(fields)
    services = dict(_SERVICE.findall(text))
    return Functions(services[SERVICE], services[NEWER_SERVICE])


def names() -> set[str]:
    """Return the names of all functions, those included that manual 4.3 adds."""
    return {*functions(), *functions().newer}


def payload(name: str, spec: _Spec) -> Any:
    """Make a class for the arguments or the result of a function, as thriftpy2 expects it."""
    return type(name, (_Payload,), {"__module__": __name__, "thrift_spec": spec})


class _Payload:
    """Arguments or result of a function; a field without a value is None, and is not sent."""

    thrift_spec: ClassVar[_Spec] = {}

    def __init__(self, *values: object, **named: object) -> None:
        names = [entry[1] for entry in self.thrift_spec.values()]
        self.__dict__ = {**dict.fromkeys(names), **dict(zip(names, values, strict=False)), **named}


def _result(returned: str) -> _Spec:
    return {} if returned == "void" else {0: _entry(returned, "success")}


def zero(entry: tuple[Any, ...]) -> Any:
    """Return what makes the value of a field that did not come."""
    return entry[2] if entry[0] == TType.STRUCT else _ZERO[entry[0]]


def fields_of(text: str) -> _Spec:
    """Return the fields of a struct, from their text as in the IDL."""
    return {int(number): _entry(kind, name) for number, kind, name in _FIELD.findall(text)}


def listed(name: str, spec: _Spec) -> _Spec:
    """Return the fields of a motion with external axes, its schemes in lists as in manual 4.3."""
    first = newer.SCHEMES[name]
    lists = {
        number: _entry(kind, spec[number][1]) for number, kind in enumerate(newer.IN_LISTS, first)
    }
    return {**spec, **lists}


def _entry(kind: str, name: str) -> tuple[Any, ...]:
    """thriftpy2's tuple for a field: its type, its name, perhaps its shape, never required."""
    number, *shape = _type(kind)
    return (number, name, *shape, False)


def _type(text: str) -> tuple[Any, ...]:
    """The number of a type, followed by a container's element type or a struct's class."""
    if text in _TYPES:
        return (_TYPES[text],)
    container = _CONTAINER.fullmatch(text)
    if container is None:
        return TType.STRUCT, getattr(rpc, text)
    if container[1] == "map":
        return TType.MAP, tuple(map(_part, container[2].split(",", 1)))
    return TType.LIST, _part(container[2])


def _part(text: str) -> Any:
    found = _type(text)
    return found[0] if len(found) == 1 else found


def _with(result: Any, kind: type, fields: str, *, added: bool) -> Any:
    """Make a result class with another struct, alone or as the element of a list.

    The struct that is read is also an instance of the present struct; fields that were not sent
    have their zero values, or those of `kind`.

    Args:
        result: the result class.
        kind: class of the struct: the present one, or one that inherits from it.
        fields: fields of the struct, as in the IDL.
        added: whether they come behind those of the present struct, and not in their place.
    """
    number, name, shape, required = result.thrift_spec[0]
    listed = number == TType.LIST
    present = shape[1] if listed else shape
    spec = fields_of(fields)
    made: Any = type(
        kind.__name__,
        (kind,),
        {"thrift_spec": {**present.thrift_spec, **spec} if added else spec, "__slots__": ()},
    )
    entry = (number, name, (TType.STRUCT, made) if listed else made, required)
    return type(result.__name__, (result,), {"thrift_spec": {0: entry}})


def _has_text(part: Any) -> bool:
    if isinstance(part, dict):
        return any(_has_text(entry) for entry in part.values())
    if isinstance(part, tuple):
        return any(_has_text(inner) for inner in part)
    if isinstance(part, type):
        return _has_text(vars(part)["thrift_spec"])
    return bool(part == TType.STRING)
