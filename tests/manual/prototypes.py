"""The manual's prototypes as calls: the arguments that each prints as required, and their values.

Prototypes, required parameters and defaults are those of `tests/data/manual-3.8.json`; values are
those of the calls in `tests/interop/calls.json`, which an enabled arm at home can carry out.
"""

from __future__ import annotations

from typing import Any

from api.cases import DATA, Case, cases
from interop import table

from aioduco import Jog, PointOp, RealtimePoint
from aioduco._wire import idl, rpc

FUNCTIONS: dict[str, dict[str, Any]] = {one["name"]: one for one in DATA["functions"]}
ON_WIRE = {name: one for name, one in FUNCTIONS.items() if one["wire"]}

#: what `aioduco` does by itself, or by the connection
BY_ITSELF = {"rpc_heartbeat"}
#: parameters that ours do without: an await takes the place of `block`; a list knows its length
WITHOUT = {"block", "len"}

#: structs of the wire, by function and parameter of the wire
_STRUCTS: dict[tuple[str, str], Any] = {
    ("move_jog", "param"): rpc.MoveJogTaskParam,
    ("spline_op", "pose_list"): rpc.PointOp,
    ("trackEnqueueOp", "track"): rpc.PointOp,
    ("realtime_data_enqueue", "realtime_data"): rpc.RealTimeControlData,
    ("combine_motion_config", "op_list"): rpc.Op,
}
#: ours in seconds, the manual's in milliseconds
_SECONDS = {"time", "duration", "timeout"}


def inputs(name: str) -> list[dict[str, Any]]:
    """The parameters of a function that a Python program gives: those that are no output."""
    return [one for one in FUNCTIONS[name]["parameters"] if not one.get("out")]


def value(wire: str, parameter: str | None) -> Any:
    """A value for a parameter of the wire, as `aioduco.compat` takes it."""
    if parameter is None:
        return True  # move_eaxis.def_acc, which is not sent
    return _made(wire, parameter, table.FUNCTIONS[wire]["args"][parameter])


def _made(wire: str, parameter: str, given: Any) -> Any:
    """A value of the table with its structs."""
    if parameter == "op":
        return rpc.Op(**given)
    struct = _STRUCTS.get((wire, parameter))
    if struct is None:
        return given
    if isinstance(given, dict):
        return struct(**given)
    return [struct(**{k: rpc.Op(**v) if k == "op" else v for k, v in one.items()}) for one in given]


def as_printed(name: str) -> tuple[list[Any], dict[str, Any]]:
    """What a prototype requires: by position, and by name what stands behind an optional one."""
    wire = FUNCTIONS[name]["wire"]
    by_position: list[Any] = []
    by_name: dict[str, Any] = {}
    gap = False
    for one in inputs(name):
        if one.get("optional"):
            gap = True
        elif gap:
            by_name[one["name"]] = value(wire, one["wire"])
        else:
            by_position.append(value(wire, one["wire"]))
    return by_position, by_name


def whole(name: str) -> dict[str, Any]:
    """Every parameter that a prototype prints, by its printed name."""
    wire = FUNCTIONS[name]["wire"]
    return {one["name"]: value(wire, one["wire"]) for one in inputs(name)}


def in_wire_order(wire: str, args: dict[str, Any]) -> list[Any]:
    """Arguments by the wire's names, for a call by position."""
    return [
        rpc.Op() if one == "op" else _made(wire, one, args[one])
        for one in idl.functions()[wire].parameters
    ]


def ours() -> dict[str, Case]:
    """By function of the wire, its place and parameters in `aioduco` and `aioduco.sync`."""
    wires = {one["wire"] for one in ON_WIRE.values()}
    return {case.name: case for case in cases() if case.name in wires}


def mapped(name: str, case: Case) -> dict[str, Any]:
    """What a prototype requires, by our names and in our units."""
    wire = FUNCTIONS[name]["wire"]
    required = {one["name"]: one for one in inputs(name) if not one.get("optional")}
    found: dict[str, Any] = {}
    for parameter in case.parameters:
        one = required.pop(case.manual_name(parameter) or "", None)
        if one is None:
            continue
        found[parameter] = _as_ours(wire, one["wire"], parameter)
    assert set(required) <= WITHOUT, f"{name}: {sorted(required)} have no place in ours"
    return found


def _as_ours(wire: str, parameter: str, our_name: str) -> Any:
    given = table.FUNCTIONS[wire]["args"][parameter]
    if (wire, parameter) == ("move_jog", "param"):
        return Jog.joint(
            given["axis_num"], given["jog_direction"], given["vel"], step=given["step_jointValue"]
        )
    if (wire, parameter) == ("realtime_data_enqueue", "realtime_data"):
        return [RealtimePoint.joint_position(one["joint_pos_cmd"]) for one in given]
    if _STRUCTS.get((wire, parameter)) is rpc.PointOp:
        return [PointOp(one["pos"]) for one in given]
    if our_name in _SECONDS:
        return [one / 1000 for one in given] if isinstance(given, list) else given / 1000
    return given
