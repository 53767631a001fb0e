"""Calls of older vendor clients, byte by byte: fields left out, shorter structs, other fields."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from aioduco.testing import eventually

from .frames import EXCEPTION, REPLY, Fields, RawClient

if TYPE_CHECKING:
    from aioduco.sim import Simulator

pytestmark = pytest.mark.interop

RUNNING, STOPPED, FINISHED, PARAMETER_MISMATCH = 1, 3, 4, 8
TURNED = [1.0, 0.2, 1.4, 0.1, -1.4, 0.3]
OLDER: dict[str, Any] = json.loads(
    Path(__file__).with_name("older_clients.json").read_text(encoding="utf-8")
)
ZEROS: dict[str, Any] = {"bool": False, "i8": 0, "i32": 0, "double": 0.0, "string": ""}


def short_op() -> Fields:
    """The Op of the oldest client: two triggers, twelve fields."""
    op: Fields = [(fid, of, ZEROS[of]) for fid, of in OLDER["op"]]
    assert len(op) == 12
    return op


def zero(of: str) -> Any:
    if of == "Op":
        return short_op()
    return ZEROS.get(of, [])


def bring_up(robot: RawClient) -> None:
    assert robot.call("power_on", [(1, "bool", True)]).value == FINISHED
    assert robot.call("enable", [(1, "bool", True)]).value == FINISHED


def movej2(*, block: bool, v: float = 2.0) -> Fields:
    return [
        (1, "list<double>", TURNED),
        (2, "double", v),
        (3, "double", 4.0),
        (4, "double", 0.0),
        (5, "bool", block),
    ]


@pytest.mark.parametrize(
    "trailing",
    [
        pytest.param([], id="without op and def_acc"),
        pytest.param([(6, "Op", short_op())], id="op of twelve fields, without def_acc"),
        pytest.param([(6, "Op", short_op()), (99, "string", "?")], id="a field nobody knows"),
    ],
)
def test_joint_move_with_other_trailing_fields(sim: Simulator, trailing: Fields) -> None:
    with RawClient(sim.host, sim.port) as robot:
        bring_up(robot)
        assert robot.call("movej2", movej2(block=True) + trailing).value == FINISHED


def test_stop_without_block_returns_at_once_and_stops(sim: Simulator) -> None:
    """A `block` that is left out is false: the answer is a task id, not a state."""
    with RawClient(sim.host, sim.port) as robot:
        bring_up(robot)
        move = robot.call("movej2", movej2(block=False, v=0.1)).value
        assert move is not None
        stop = robot.call("stop", []).value
        assert stop is not None
        assert stop > move
        eventually(lambda: state_of(robot, move) != RUNNING)
        assert state_of(robot, move) == STOPPED


def state_of(robot: RawClient, task: int) -> int | None:
    return robot.call("get_noneblock_taskstate", [(1, "i32", task)]).value


@pytest.mark.parametrize(
    ("version", "function"),
    [(version, function) for version, methods in OLDER["versions"].items() for function in methods],
)
def test_every_older_layout_is_answered(sim: Simulator, version: str, function: str) -> None:
    """Each call gets an answer of its own, and leaves the connection in step for the next."""
    layout = OLDER["versions"][version][function]
    with RawClient(sim.host, sim.port) as robot:
        answer = robot.call(function, [(fid, of, zero(of)) for fid, of, _name in layout])
        assert answer.kind in {REPLY, EXCEPTION}
        assert robot.call("power_on", [(1, "bool", True)]).value == FINISHED
