"""The wire of each generation of controllers: which functions are served, by which layouts.

A controller skips fields that it does not know, or that have another type, and takes zero for those
that did not come. One of the present generation also answers the calls of older clients.
Those of the other generations know their own layouts only.

The numbers of fields that manual 4.3 adds are inferred from the order in which it prints them. They
are served, and never sent; lists in place of single values are both.
"""

from __future__ import annotations

import dataclasses
import functools
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, TypeAlias, get_args

from thriftpy2.thrift import TPayload, gen_init

from aioduco._wire import idl, newer, rpc

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


#: by function and parameter: the value of an absent parameter, where it is not zero. It is the
#: behaviour of the clients without the field, or the manual's default
_ABSENT: dict[str, dict[str, Any]] = {
    "fc_move": {"block": True},
    "set_wobj_offset": {"active": True},
    "servoj": {"kp": 200.0, "kd": 25.0, "smooth_vel": 10.0, "smooth_acc": 1.0},
    "servoj_pose": {"kp": 200.0, "kd": 25.0, "smooth_vel": 10.0, "smooth_acc": 1.0},
    "servo_tcp": {"kp": 200.0, "kd": 25.0, "smooth_vel": 10.0, "smooth_acc": 1.0},
}

#: by function: the parameters in the middle that the first generation lacks; later ones move up
_LACKING = {
    "servoj": {"block"},
    "servoj_pose": {"block"},
    "tcp_move": {"tool"},
    "tcp_move_2p": {"tool", "wobj"},
}

#: fields of the first generation's Op, which has no events: two triggers of five fields
_FIRST_OP = (
    *("time_or_dist_1", "trig_io_1", "trig_value_1", "trig_time_1", "trig_dist_1"),
    *("time_or_dist_2", "trig_io_2", "trig_value_2", "trig_time_2", "trig_dist_2"),
)


class OlderLayout(NamedTuple):
    """Layout of a function's arguments in an older generation.

    Attributes:
        args: class of the argument struct; its Op is a subclass of the present one.
        matches: tells whether a struct came in this layout, in which one field has a type that it
            has in no other.
    """

    args: Any
    matches: Callable[[Any], bool]


@functools.cache
def _older_layouts(name: str, present: Any) -> tuple[OlderLayout, ...]:
    """The older layouts of a function that differ from the present one before their end.

    Args:
        name: name of the function.
        present: class of its present argument struct.
    """
    spec: dict[int, tuple[Any, ...]] = present.thrift_spec
    op = next((fid for fid, entry in spec.items() if entry[2] is rpc.Op), None)
    found = []
    if name in _LACKING:
        kept = [entry for entry in spec.values() if entry[1] not in _LACKING[name]]
        moved = next(entry[1] for fid, entry in enumerate(kept, 1) if entry[0] != spec[fid][0])
        args = _struct(
            name, {fid: _first(entry, marked=False) for fid, entry in enumerate(kept, 1)}
        )
        found.append(OlderLayout(args, lambda came: getattr(came, moved) is not None))
    if op is not None:
        args = _struct(name, {fid: _first(entry, marked=True) for fid, entry in spec.items()})
        found.append(OlderLayout(args, _has_first_op))
    return tuple(found)


def _first(entry: tuple[Any, ...], *, marked: bool) -> tuple[Any, ...]:
    """Give a parameter in the form of the first generation."""
    return (*entry[:2], _first_op(marked), *entry[3:]) if entry[2] is rpc.Op else entry


@functools.cache
def _first_op(marked: bool) -> Any:
    """The first generation's Op. If `marked`, an absent second trigger has the kind None."""
    entries = {entry[1]: entry for entry in rpc.Op.thrift_spec.values()}
    fields = {fid: entries[field] for fid, field in enumerate(_FIRST_OP, 1)}

    class FirstOp(rpc.Op):
        __slots__ = ()
        thrift_spec = fields

        def __init__(self) -> None:
            super().__init__()
            if marked:
                self.time_or_dist_2: Any = None

    return FirstOp


def _has_first_op(args: Any) -> bool:
    return args.op is not None and args.op.time_or_dist_2 is not None


def _struct(name: str, spec: dict[int, tuple[Any, ...]]) -> Any:
    made = type(f"{name}_first_args", (TPayload,), {"__module__": __name__})
    return gen_init(made, spec, [(entry[1], None) for entry in spec.values()])


Generation: TypeAlias = Literal["first", "oldest", "older", "3.8", "4.3"]
GENERATIONS: Final[tuple[Generation, ...]] = get_args(Generation)

_OLDER_WIRES = Path(__file__).with_name("older_wires.json")
_Spec: TypeAlias = "dict[int, tuple[Any, ...]]"


class Served(NamedTuple):
    """A function as a controller serves it.

    Attributes:
        args: class of the struct of arguments.
        others: further layouts of the arguments, recognized by what came.
        missing: for each parameter of the handler, what makes its value if none came.
        result: class of the struct of the result.
        struct: class of a struct in the result that is not the present one's; None if it is.
        void: whether it returns nothing.
    """

    args: Any
    others: tuple[OlderLayout, ...]
    missing: Mapping[str, Callable[[], Any]]
    result: Any
    struct: Any
    void: bool

    def values(self, args: Any) -> list[Any]:
        """Return the handler's arguments, from a struct that came."""
        came = ((getattr(args, name, None), missing) for name, missing in self.missing.items())
        return [missing() if value is None else value for value, missing in came]

    def answer(self, value: Any) -> Any:
        """Return the struct of the result, for what a handler returned."""
        result = self.result()
        if not self.void:
            result.success = value if self.struct is None else _as(self.struct, value)
        return result


class Wire:
    """The functions that a controller of one generation serves.

    Args:
        lacks: functions that it does not have.
        args: by function, the fields of its arguments where they are other ones.
        structs: by struct, its class where it has other fields.
        recognizes: whether calls of other generations are recognized by their fields.
        newer: whether its answers have what manual 4.3 adds.
    """

    def __init__(
        self,
        *,
        lacks: frozenset[str] = frozenset(),
        args: Mapping[str, _Spec] | None = None,
        structs: Mapping[str, Any] | None = None,
        recognizes: bool = False,
        newer: bool = False,
    ) -> None:
        self._lacks = lacks
        self._args = args or {}
        self._structs = {getattr(rpc, name): kind for name, kind in (structs or {}).items()}
        self._recognizes = recognizes
        self._newer = newer
        self._served: dict[str, Served] = {}

    def get(self, name: str) -> Served | None:
        """Return a function; None if the controller does not have it."""
        served = self._served.get(name)
        if served is None and self.has(name):
            served = self._served.setdefault(name, self._made(name))
        return served

    def has(self, name: str) -> bool:
        """Whether the controller has a function; of those of manual 4.3, its handlers decide."""
        return name in idl.names() and name not in self._lacks

    def _made(self, name: str) -> Served:
        function = idl.functions()[name]
        usual = dict(zip(function.parameters, function.zeros, strict=True))
        fixed = _ABSENT.get(name, {})
        missing = {each: _constant(fixed[each]) if each in fixed else usual[each] for each in usual}
        args: Any = function.args
        others: tuple[OlderLayout, ...] = ()
        if self._recognizes:
            others = _older_layouts(name, function.args)
        elif name in self._args or self._structs:
            spec: Any = self._args.get(name, function.args.thrift_spec)
            args = idl.payload(f"{name}_args", _with(self._structs, spec))
            # what only this generation has comes behind the present parameters
            added = {entry[1]: idl.zero(entry) for entry in spec.values() if entry[1] not in usual}
            missing |= added
        result = self._result(function)
        struct = None if result is function.result else _struct_of(result)
        return Served(args, others, missing, result, struct, function.void)

    def _result(self, function: idl.Function) -> Any:
        if self._newer and (function.newer or function.name == "reach_check"):
            return function.newer or function.other
        if rpc.IOStatus in self._structs and function.name == "getRobotIOStatus":
            return function.other
        return function.result


@functools.cache
def wire_of(generation: Generation) -> Wire:
    """Return the wire of a generation of controllers."""
    if generation == "3.8":
        return Wire(recognizes=True)
    if generation == "4.3":
        return Wire(args=dict(_newer_arguments()), newer=True)
    versions = json.loads(_OLDER_WIRES.read_text("utf-8"))["versions"]
    version = versions[generation]
    structs = {name: _older_struct(name, fields) for name, fields in version["structs"].items()}
    args = {name: _spec(fields) for name, fields in version["methods"].items()}
    return Wire(lacks=frozenset(version["lacks"]), args=args, structs=structs)


def _newer_arguments() -> Any:
    functions = idl.functions()
    for name in newer.SCHEMES:
        yield name, idl.listed(name, functions[name].args.thrift_spec)
    # an arc may have a fixed radius, and reach_check takes the tool before the work object
    yield "movec", {**functions["movec"].args.thrift_spec, **idl.fields_of("13: double arc_rad")}
    present = functions["reach_check"].args.thrift_spec
    yield "reach_check", {**present, 2: present[3], 3: present[2]}


def _older_struct(name: str, fields: list[tuple[int, str, str]]) -> Any:
    kind = getattr(rpc, name)
    return type(name, (kind,), {"thrift_spec": _spec(fields), "__slots__": ()})


def _spec(fields: list[tuple[int, str, str]]) -> _Spec:
    text = " ".join(f"{fid}: {of.replace('i8', 'byte')} {name}" for fid, of, name in fields)
    return idl.fields_of(text)


def _with(structs: Mapping[Any, Any], spec: Any) -> Any:
    """Return fields, with other classes for some structs."""
    if isinstance(spec, dict):
        return {fid: _with(structs, entry) for fid, entry in spec.items()}
    if isinstance(spec, tuple):
        return tuple(_with(structs, part) for part in spec)
    return structs.get(spec, spec) if isinstance(spec, type) else spec


def _struct_of(result: Any) -> Any:
    shape = result.thrift_spec[0][2]
    return shape[1] if isinstance(shape, tuple) else shape


def _as(kind: Any, value: Any) -> Any:
    """Return a struct, or a list of structs, as another class that has their fields."""
    if isinstance(value, list):
        return [_as(kind, each) for each in value]
    return kind(**{each.name: getattr(value, each.name) for each in dataclasses.fields(value)})


def _constant(value: Any) -> Callable[[], Any]:
    return lambda: value
