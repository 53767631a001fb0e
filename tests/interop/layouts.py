"""The IDL of clients that send less: made from `robot.thrift`, compiled beside it.

Four services with the wire's own names of functions:

- `Short`: without what the vendor's wrappers leave out: `op`, `def_acc`, `block`, the reference
  joints, tool and work object. Everything that is left out is zero for the controller.
- `Older`, `Oldest` and `First`: what three older generations of the vendor's client send otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from client.older import OLDER
from test_generated import NAMES
from thriftpy2.thrift import TType

from aioduco._wire import idl

#: by generation, the struct of its `Op` where it has one of its own
_OPS = {"oldest": "ShortOp", "first": "FirstOp"}
LEFT_OUT = frozenset(("op", "def_acc", "block", "q_near", "qnear"))
#: names of frames, where they are not what the function is about
FRAMES = frozenset(("tool", "wobj"))
_ABOUT_FRAMES = ("cal_", "get_", "reach_check", "set_wobj")


def _type(spec: Any) -> str:
    kind, extra = spec if isinstance(spec, tuple) else (spec, None)
    if kind == TType.LIST:
        return f"list<{_type(extra)}>"
    if kind == TType.MAP:
        return f"map<{_type(extra[0])}, {_type(extra[1])}>"
    return f"robot.{extra.__name__}" if kind == TType.STRUCT else NAMES[kind]


def left_out(function: str) -> frozenset[str]:
    """The parameters that the short call of a function does without."""
    parameters = frozenset(idl.functions()[function].parameters)
    about_frames = function.startswith(_ABOUT_FRAMES)
    return parameters & (LEFT_OUT if about_frames else LEFT_OUT | FRAMES)


def layouts() -> dict[str, dict[str, list[tuple[int, str, str]]]]:
    """By service and function, what is sent: (id, type, name)."""
    short: dict[str, list[tuple[int, str, str]]] = {}
    for name, function in idl.functions().items():
        out = left_out(name)
        if out:
            fields = function.args.thrift_spec.items()
            sent = [(fid, type_of(field), field[1]) for fid, field in fields]
            short[name] = [field for field in sent if field[2] not in out]
    older = {
        version.capitalize(): {
            name: [_older(version, *each) for each in sent] for name, sent in one["methods"].items()
        }
        for version, one in OLDER.items()
    }
    return {"Short": short} | older


def type_of(field: tuple[Any, ...]) -> str:
    """The type of a field as the IDL writes it."""
    nested = field[0] in (TType.LIST, TType.MAP, TType.STRUCT)
    return _type((field[0], field[2]) if nested else field[0])


def _older(version: str, fid: int, of: str, name: str) -> tuple[int, str, str]:
    return fid, of.replace("Op", _OPS.get(version, "robot.Op")), name


def text() -> str:
    """The IDL."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield 'include "robot.thrift"'
    yield "namespace py clients"
    yield "namespace cpp clients"
    for version, struct in _OPS.items():
        yield f"struct {struct} {{"
        fields = OLDER[version]["structs"]["Op"]
        yield from (f"  {fid}: {of} f{fid}" for fid, of, _name in fields)
        yield "}"
    for service, functions in layouts().items():
        yield f"service {service} {{"
        for name, sent in functions.items():
            args = ", ".join(f"{fid}: {of} {field}" for fid, of, field in sent)
            yield f"  {_returns(name)} {name}({args})"
        yield "}"


def _returns(name: str) -> str:
    function = idl.functions()[name]
    return "void" if function.void else type_of(function.result.thrift_spec[0])


def scalar(name: str) -> bool:
    """Whether a function answers with a number or a truth value."""
    function = idl.functions()[name]
    kind: int = function.result.thrift_spec[0][0]
    return kind not in (TType.LIST, TType.MAP, TType.STRUCT, TType.STRING)
