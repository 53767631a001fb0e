"""The loaded IDL: the only link between the typed structs of `rpc` and Thrift."""

from __future__ import annotations

import functools
import struct
from pathlib import Path
from typing import Any

import thriftpy2
from thriftpy2.thrift import TType

from aioduco._wire import rpc
from aioduco._wire.fitting import Check, check_of, type_of

SERVICE = "RPCRobot"

_ZERO: dict[int, Any] = {
    TType.BOOL: lambda: False,
    TType.BYTE: lambda: 0,
    TType.I16: lambda: 0,
    TType.I32: lambda: 0,
    TType.I64: lambda: 0,
    TType.DOUBLE: lambda: 0.0,
    TType.STRING: lambda: "",
    TType.LIST: list,
    TType.MAP: dict,
}
#: results whose fields older controllers number otherwise: the struct's fields, counted from 1
_OLDER = {
    "getRobotIOStatus": (
        "analogCurrentOutputs",
        "analogVoltageOutputs",
        "digitalInputs",
        "digitalOutputs",
        "toolIOIn",
        "toolIOOut",
        "toolButton",
    )
}
_WHOLE = {TType.BYTE, TType.I16, TType.I32, TType.I64}


class Function:
    """One function of the wire: its name, and how its arguments and result are laid out.

    Attributes:
        name: the name on the wire.
        args: class of the argument struct; an instance takes the fields as attributes.
        result: class of the result struct; the value is its attribute `success`.
        older: the same with the fields as older controllers number them; None if they do not.
        parameters: names of the parameters, in the order of their field ids.
        checks: for each parameter the check whether a value fits its type.
        whole: positions of the parameters that are whole numbers.
        void: whether the function returns nothing.
        head: the name as it stands in a message: its length and its text.
        texts: whether the result has strings in it, at any depth.
    """

    __slots__ = (
        "args",
        "checks",
        "head",
        "name",
        "older",
        "parameters",
        "result",
        "texts",
        "void",
        "whole",
        "zeros",
    )

    def __init__(self, service: Any, name: str) -> None:
        self.name: str = name
        self.args: Any = getattr(service, f"{name}_args")
        self.result: Any = getattr(service, f"{name}_result")
        self.older: Any = _older(self.result, _OLDER[name]) if name in _OLDER else None
        entries = list(self.args.thrift_spec.values())
        self.parameters: tuple[str, ...] = tuple(entry[1] for entry in entries)
        self.checks: tuple[Check, ...] = tuple(check_of(*type_of(entry)) for entry in entries)
        self.whole: tuple[int, ...] = tuple(
            index for index, entry in enumerate(entries) if entry[0] in _WHOLE
        )
        self.void: bool = 0 not in self.result.thrift_spec
        self.head: bytes = struct.pack("!i", len(name)) + name.encode()
        self.texts: bool = _has_text(self.result.thrift_spec)
        #: one factory per parameter for the value that a field left out stands for
        self.zeros: tuple[Any, ...] = tuple(
            entry[2] if entry[0] == TType.STRUCT else _ZERO[entry[0]] for entry in entries
        )


def path() -> Path:
    """Where the IDL lies: beside this module in a wheel, in `idl/` in a checkout."""
    packaged = Path(__file__).with_name("robot.thrift")
    if packaged.exists():
        return packaged
    return Path(__file__).parents[2] / "idl" / "robot.thrift"


@functools.cache
def functions() -> dict[str, Function]:
    """Load the IDL, once, and return every function of the wire by name.

    The structs of `rpc` take the place of the classes that thriftpy2 makes, so that what is
    read and written are the typed dataclasses themselves, without a copy in between.
    """
    module = thriftpy2.load(str(path()), module_name="aioduco_robot_thrift")
    service = getattr(module, SERVICE)
    structs = {made.__name__: getattr(rpc, made.__name__) for made in _structs(module)}
    for made in _structs(module):
        typed = structs[made.__name__]
        typed.thrift_spec = {fid: _typed(e, structs) for fid, e in made.thrift_spec.items()}
    for name in service.thrift_services:
        for part in ("args", "result"):
            payload = getattr(service, f"{name}_{part}")
            payload.thrift_spec = {
                fid: _typed(entry, structs) for fid, entry in payload.thrift_spec.items()
            }
    return {name: Function(service, name) for name in service.thrift_services}


def _structs(module: Any) -> list[Any]:
    structs: list[Any] = module.__thrift_meta__["structs"]
    return structs


def _older(result: Any, names: tuple[str, ...]) -> Any:
    """A result class for the fields of a struct in another order.

    What is read into it is an instance of the present struct, too: fields that did not come have
    their zero values.
    """
    kind, name, struct, required = result.thrift_spec[0]
    entries = {entry[1]: entry for entry in struct.thrift_spec.values()}
    spec = {number: entries[each] for number, each in enumerate(names, 1)}
    older = type(struct.__name__, (struct,), {"thrift_spec": spec, "__slots__": ()})
    return type(result.__name__, (result,), {"thrift_spec": {0: (kind, name, older, required)}})


def _has_text(part: Any) -> bool:
    if isinstance(part, dict):
        return any(_has_text(entry) for entry in part.values())
    if isinstance(part, tuple):
        return any(_has_text(inner) for inner in part)
    if isinstance(part, type):
        return _has_text(vars(part)["thrift_spec"])
    return bool(part == TType.STRING)


def _typed(part: Any, structs: dict[str, type]) -> Any:
    """A field's spec with each struct class of thriftpy2 replaced by the dataclass."""
    if isinstance(part, tuple):
        return tuple(_typed(inner, structs) for inner in part)
    if isinstance(part, type):
        return structs[part.__name__]
    return part
