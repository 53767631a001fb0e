"""Calls of older vendor clients, byte by byte: fields left out, shorter structs, other fields."""

from __future__ import annotations

from typing import Any

import pytest
from client.older import OLDER

from aioduco.sim import Simulator
from aioduco.sim.planner.servo_follower import ServoFollower, ServoTuning
from aioduco.testing import eventually

from .frames import EXCEPTION, REPLY, Fields, RawClient

pytestmark = pytest.mark.interop

RUNNING, STOPPED, FINISHED, PARAMETER_MISMATCH = 1, 3, 4, 8
TURNED = [1.0, 0.2, 1.4, 0.1, -1.4, 0.3]
ZEROS: dict[str, Any] = {"bool": False, "i8": 0, "i32": 0, "double": 0.0, "string": ""}


def short_op() -> Fields:
    """The Op of the oldest client: two triggers, twelve fields."""
    op: Fields = [(fid, of, ZEROS[of]) for fid, of, _name in OLDER["oldest"]["structs"]["Op"]]
    assert len(op) == 12
    return op


def first_op(**given: Any) -> Fields:
    """The Op of the first generation: two triggers of five fields, without events."""
    names = ("kind", "output", "value", "time", "distance")
    values = {1: given.get("start", {}), 6: given.get("end", {})}
    return [
        (fid, of, values[1 if fid < 6 else 6].get(names[(fid - 1) % 5], ZEROS[of]))
        for fid, of, _name in OLDER["first"]["structs"]["Op"]
    ]


def zero(of: str, version: str) -> Any:
    if of == "Op":
        return first_op() if version == "first" else short_op()
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


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    "trailing",
    [
        pytest.param([], id="without op and def_acc"),
        pytest.param([(6, "Op", short_op())], id="op of twelve fields, without def_acc"),
        pytest.param([(6, "Op", first_op(start={"output": 1}, end={"output": 1}))], id="first op"),
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


def test_both_triggers_of_the_first_op_fire(sim: Simulator) -> None:
    """Its second trigger stands where a later Op has the event of the first."""
    op = first_op(
        start={"kind": 1, "output": 3, "value": True}, end={"kind": 1, "output": 4, "value": True}
    )
    with RawClient(sim.host, sim.port) as robot:
        bring_up(robot)
        assert robot.call("movej2", [*movej2(block=True), (6, "Op", op)]).value == FINISHED
    assert [n for n in range(1, 17) if sim.get_digital_output(n)] == [3, 4]


def test_gains_of_the_first_servoj_are_not_taken_one_for_another(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has no block, so that kp stands where a later one has that, and kd where it has kp."""
    tunings: list[ServoTuning] = []
    monkeypatch.setattr(ServoFollower, "aim", lambda _self, _target, tuning: tunings.append(tuning))
    call: Fields = [(1, "list<double>", TURNED), (2, "double", 1.0), (3, "double", 5.0)]
    with RawClient(sim.host, sim.port) as robot:
        bring_up(robot)
        robot.call("servoj", [*call, (4, "double", 190.0), (5, "double", 20.0)])
        eventually(lambda: tunings)
    assert tunings[0] == ServoTuning(1.0, 5.0, 190.0, 20.0, 10.0, 1.0)


def test_the_first_tcp_move_has_no_tool(sim: Simulator) -> None:
    before = sim.joints
    call: Fields = [(1, "list<double>", [0.0, 0.0, 0.02, 0.0, 0.0, 0.0])]
    call += [(fid, "double", value) for fid, value in ((2, 0.2), (3, 1.0), (4, 0.0))]
    with RawClient(sim.host, sim.port) as robot:
        bring_up(robot)
        moved = robot.call("tcp_move", [*call, (5, "bool", True), (6, "Op", first_op())])
        assert moved.value == FINISHED
    assert not sim.joints.almost_equal(before, 1e-3)


def test_fc_move_without_block_goes_on_when_it_has_ended(sim: Simulator) -> None:
    """It has no block, and the program goes on with fc_stop: that must not cut it short."""
    on: Fields = [(1, "list<bool>", [False] * 6), (2, "list<double>", [0.0] * 6)]
    on += [(fid, "list<double>", [value] * 6) for fid, value in ((3, 1000.0), (4, 0.1), (5, 0.0))]
    on += [(6, "string", ""), (7, "string", ""), (8, "i32", 0)]
    wait: Fields = [(1, "list<double>", [0.0] * 6), (2, "list<double>", [10.0] * 6)]
    wait += [(3, "bool", False), (4, "i32", 0), (5, "i32", 10_000)]
    with RawClient(sim.host, sim.port) as robot:
        bring_up(robot)
        robot.call("fc_config", on)
        robot.call("fc_start", [])
        robot.call("fc_wait_pos", wait)
        robot.call("fc_wait_logic", [(1, "list<i32>", [1, 0, 0])])
        assert robot.call("fc_move", []).value == FINISHED


def state_of(robot: RawClient, task: int) -> int | None:
    return robot.call("get_noneblock_taskstate", [(1, "i32", task)]).value


@pytest.mark.parametrize(
    ("version", "function"),
    [(version, function) for version, one in OLDER.items() for function in one["methods"]],
)
def test_every_older_layout_is_answered(sim: Simulator, version: str, function: str) -> None:
    """Each call gets an answer of its own, and leaves the connection in step for the next."""
    layout = OLDER[version]["methods"][function]
    with RawClient(sim.host, sim.port) as robot:
        answer = robot.call(function, [(fid, of, zero(of, version)) for fid, of, _name in layout])
        assert answer.kind in {REPLY, EXCEPTION}
        assert robot.call("power_on", [(1, "bool", True)]).value == FINISHED
