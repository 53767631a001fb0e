"""Generate `aioduco/_wire/rpc.py` from `idl/robot.thrift`.

    python idl/generate.py            write the module
    python idl/generate.py --check    compare the whole text with what is committed

The generated module holds one dataclass per struct and one method per function of the wire
(`Functions`), for callers on a thread. `AsyncRpc` and `WireCalls` take each of them over: awaited,
and as a value that was not sent. It imports nothing of Thrift, so that a type checker finds a wrong
call anywhere in the package.
"""

from __future__ import annotations

import argparse
import difflib
import re
import sys
from pathlib import Path
from typing import Any

import thriftpy2
from thriftpy2.thrift import TType

HERE = Path(__file__).resolve().parent
IDL = HERE / "robot.thrift"
TARGET = HERE.parent / "aioduco" / "_wire" / "rpc.py"

SCALARS = {
    TType.BOOL: ("bool", "False"),
    TType.BYTE: ("int", "0"),
    TType.I16: ("int", "0"),
    TType.I32: ("int", "0"),
    TType.I64: ("int", "0"),
    TType.DOUBLE: ("float", "0.0"),
    TType.STRING: ("str", '""'),
}

HEADER = '''"""The controller's interface as Python types: structs, functions, clients.

Generated from `idl/robot.thrift` by `idl/generate.py`; change those, not this. Nothing here
knows Thrift: `aioduco._wire.idl` binds the structs to the loaded IDL.

A field that the other side left out has the zero value of its type, as in the C++ code that
controllers run.
"""

# Here what came over the wire, of any type, becomes what the IDL says it is.
# mypy: disable-error-code="no-any-return"

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Concatenate, Final, Generic, ParamSpec, Protocol, TypeVar
from typing import cast, overload

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)
Spec = dict[int, tuple[Any, ...]]
'''

FUNCTIONS = '''
class Functions(ABC):
    """Every function of the wire, for callers that own a thread."""

    __slots__ = ()

    @abstractmethod
    def _call(self, name: str, args: tuple[Any, ...]) -> Any:
        """Send one call and return what is answered."""
'''

NEWER_FUNCTIONS = '''
class NewerFunctions(Functions):
    """The same, with those that manual 4.3 adds; older controllers do not have them."""

    __slots__ = ()
'''

CLIENTS = '''
class RpcClient(NewerFunctions):
    """Every function of the wire, for callers that own a thread; `call` sends one."""

    __slots__ = ("_send",)

    def __init__(self, call: Callable[[str, tuple[Any, ...]], Any]) -> None:
        self._send = call

    def _call(self, name: str, args: tuple[Any, ...]) -> Any:
        return self._send(name, args)


@dataclass(frozen=True, slots=True)
class WireCall(Generic[R_co]):
    """A call of the wire as a value; `R_co` is the type of its answer.

    Attributes:
        name: the function.
        args: one value per parameter.
    """

    name: str
    args: tuple[Any, ...]


class WireFunction(Protocol[P, R_co]):
    """A function of the wire, as type checkers see it in `AsyncRpc` and in `WireCalls`."""

    @overload
    def __get__(
        self, client: AsyncRpc, kind: type | None = None
    ) -> Callable[P, Coroutine[Any, Any, R_co]]: ...

    @overload
    def __get__(
        self, client: WireCalls, kind: type | None = None
    ) -> Callable[P, WireCall[R_co]]: ...


def taken_over(function: Callable[Concatenate[NewerFunctions, P], R]) -> WireFunction[P, R]:
    """The same function: it returns what `_call` of its new class returns."""
    return cast("WireFunction[P, R]", function)


class _TakenOver:
    """Every function of the wire, for classes whose `_call` returns something else."""

    __slots__ = ()
'''


TAKEN_OVER = '''

class AsyncRpc(_TakenOver):
    """Every function of the wire, awaited; `call` is a coroutine function."""

    __slots__ = ("_call",)

    def __init__(self, call: Callable[[str, tuple[Any, ...]], Coroutine[Any, Any, Any]]) -> None:
        self._call = call

    def send(self, call: WireCall[R]) -> Coroutine[Any, Any, R]:
        """Send a call that was made as a value."""
        return self._call(call.name, call.args)


class WireCalls(_TakenOver):
    """Every function of the wire, as a value: it checks the types, and sends nothing."""

    __slots__ = ()
    _call = WireCall


calls: Final = WireCalls()'''


def py_type(spec: Any, container: str) -> str:
    """The annotation of one thrift type, given as thriftpy2 writes it in a field's spec."""
    kind, extra = spec if isinstance(spec, tuple) else (spec, None)
    if kind in SCALARS:
        return SCALARS[kind][0]
    if kind == TType.LIST:
        return f"{container}[{py_type(extra, container)}]"
    if kind == TType.MAP:
        return f"dict[{py_type(extra[0], container)}, {py_type(extra[1], container)}]"
    return str(extra.__name__)


def field_spec(entry: tuple[Any, ...]) -> Any:
    return (entry[0], entry[2]) if len(entry) > 3 else entry[0]


def default(spec: Any) -> str:
    kind, extra = spec if isinstance(spec, tuple) else (spec, None)
    if kind in SCALARS:
        return SCALARS[kind][1]
    if kind == TType.LIST:
        return "field(default_factory=list)"
    if kind == TType.MAP:
        return "field(default_factory=dict)"
    return f"field(default_factory={extra.__name__})"


def comments(text: str) -> dict[str, str]:
    """The one-line comment above each struct and function of the IDL, by name."""
    found: dict[str, str] = {}
    pattern = r"/\*\* (.+?) \*/\n\s*(?:struct (\w+)|[\w<>,]+ (\w+)\()"
    for match in re.finditer(pattern, text):
        found[match[2] or match[3]] = match[1]
    return found


def signature(name: str, entries: list[tuple[Any, ...]], returns: str) -> str:
    args = [f"{entry[1]}: {py_type(field_spec(entry), 'Sequence')}" for entry in entries]
    line = f"    def {name}({', '.join(['self', *args])}) -> {returns}:"
    if len(line) <= 96:
        return line
    body = "".join(f"        {arg},\n" for arg in ["self", *args])
    return f"    def {name}(\n{body}    ) -> {returns}:"


def call(name: str, entries: list[tuple[Any, ...]]) -> str:
    names = ", ".join(entry[1] for entry in entries) + ("," if len(entries) == 1 else "")
    line = f'        return self._call("{name}", ({names}))'
    if len(line) <= 100:
        return line
    flat = f"            ({names}),"
    if len(flat) > 100:
        inner = "".join(f"                {entry[1]},\n" for entry in entries)
        flat = f"            (\n{inner}            ),"
    return f'        return self._call(\n            "{name}",\n{flat}\n        )'


def generate() -> str:
    """The whole text of the module."""
    text = IDL.read_text(encoding="utf-8")
    notes = comments(text)
    module = thriftpy2.load(str(IDL), module_name="aioduco_idl_generate_thrift")
    out = [HEADER]

    for struct in module.__thrift_meta__["structs"]:
        out.append("\n@dataclass(slots=True)")
        out.append(f"class {struct.__name__}:")
        out.append(f'    """{notes[struct.__name__]}"""\n')
        out.append("    thrift_spec: ClassVar[Spec] = {}")
        for entry in struct.thrift_spec.values():
            spec = field_spec(entry)
            out.append(f"    {entry[1]}: {py_type(spec, 'list')} = {default(spec)}")
        out.append("")

    written: dict[str, str] = {}
    for head, service in ((FUNCTIONS, module.RPCRobot), (NEWER_FUNCTIONS, module.RPCRobotNewer)):
        out.append(head)
        owner = head.split("class ")[1].split("(")[0]
        for name in service.thrift_services:
            if name in written:
                continue  # of the service that it extends
            written[name] = owner
            entries = list(getattr(service, f"{name}_args").thrift_spec.values())
            returns = result_type(service, name)
            out.append(signature(name, entries, returns))
            out.append(f'        """{notes[name]}"""')
            out.append(call(name, entries) + "\n")
    out.append(CLIENTS)
    out += [f"    {name}: Final = taken_over({owner}.{name})" for name, owner in written.items()]
    out.append(TAKEN_OVER)
    return "\n".join(out) + "\n"


def result_type(service: Any, name: str) -> str:
    spec = getattr(service, f"{name}_result").thrift_spec
    return py_type(field_spec(spec[0]), "list") if 0 in spec else "None"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail if the module is out of date")
    options = parser.parse_args()
    text = generate()
    if not options.check:
        TARGET.write_text(text, encoding="utf-8")
        return 0
    committed = TARGET.read_text(encoding="utf-8") if TARGET.exists() else ""
    diff = list(
        difflib.unified_diff(
            committed.splitlines(), text.splitlines(), str(TARGET), "generated", lineterm=""
        )
    )
    if diff:
        print("\n".join(diff[:80]))
        print("rpc.py is out of date: run python idl/generate.py")
        return 1
    print("rpc.py is up to date")
    return 0


if __name__ == "__main__":
    sys.exit(main())
