"""Calls of older clients, recognized by the fields that arrive.

Four generations of the wire protocol are known from clients in public repositories. Most messages
of the older ones begin like those of the present one, and only lack fields at the end. This module
handles the rest: fields in other places, and absent fields whose value is not zero.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, NamedTuple

from thriftpy2.thrift import TPayload, gen_init

from aioduco._wire import rpc

if TYPE_CHECKING:
    from collections.abc import Callable


#: by function and parameter: the value of an absent parameter, where it is not zero. It is the
#: behaviour of the clients without the field, or the manual's default
ABSENT: dict[str, dict[str, Any]] = {
    "fc_move": {"block": True},
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
def layouts(name: str, present: Any) -> tuple[OlderLayout, ...]:
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
