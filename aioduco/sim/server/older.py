"""Calls of older clients, told by the fields that come.

Four generations of the wire are known by the clients that public repositories carry. Most of what
the older ones send is a beginning of what the present one does, so that fields are absent at the
end. Here is the rest: fields that stand elsewhere, and fields that are absent and not zero.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, NamedTuple

from thriftpy2.thrift import TPayload, gen_init

from aioduco._wire import rpc

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["ABSENT", "OlderLayout", "layouts"]

#: by function and parameter, what an absent one stands for, where that is not zero: what the
#: client that has no such field does by it, or the manual's default
ABSENT: dict[str, dict[str, Any]] = {
    "fc_move": {"block": True},
    "servoj": {"kp": 200.0, "kd": 25.0, "smooth_vel": 10.0, "smooth_acc": 1.0},
    "servoj_pose": {"kp": 200.0, "kd": 25.0, "smooth_vel": 10.0, "smooth_acc": 1.0},
    "servo_tcp": {"kp": 200.0, "kd": 25.0, "smooth_vel": 10.0, "smooth_acc": 1.0},
}

#: by function, which parameters the first generation lacks in the middle; those behind move up
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
    """How an older generation lays a function's arguments out.

    Attributes:
        args: class of the argument struct; its Op is an instance of the present one.
        told: whether what was read into it came so: a field has this type in no other layout.
    """

    args: Any
    told: Callable[[Any], bool]


@functools.cache
def layouts(name: str, present: Any) -> tuple[OlderLayout, ...]:
    """The older layouts of a function that are no beginning of the present one.

    Args:
        name: of the function.
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
    """A parameter as the first generation has it."""
    return (*entry[:2], _first_op(marked), *entry[3:]) if entry[2] is rpc.Op else entry


@functools.cache
def _first_op(marked: bool) -> Any:
    """The first generation's Op; marked, its second trigger is of kind None if it did not come."""
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
