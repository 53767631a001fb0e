"""Every prototype of the manual, called with what it prints as required, in three dialects."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import nullcontext
from typing import Any

import pytest
import pytest_asyncio
from interop import table
from interop.session import FINISHED, HOME, READY, far
from interop.test_every_function import simulator

import aioduco
import aioduco.sync
from aioduco import Outcome, compat
from aioduco._wire import rpc
from aioduco.sim import Simulator
from aioduco.sim.cabinet.modbus import ModbusSlave
from aioduco.supervision.command import HeldMotion, MotionCommand
from aioduco.testing import eventually

from .prototypes import (
    BY_ITSELF,
    FUNCTIONS,
    ON_WIRE,
    as_printed,
    in_wire_order,
    inputs,
    mapped,
    ours,
    whole,
)

CALLED = sorted(ON_WIRE)
#: each ends what it is called on, now or later: it has a controller of its own
APART = {"shutdown", "restart", "rpc_heartbeat"}
#: these have a robot of their own: it remembers points in the pool, and what moved the arm
ALONE = APART | {"trackJointMotion", "simulation"}
AWAITED = sorted(set(CALLED) - BY_ITSELF)
#: the CAN bus and the Modbus signals of the table have a device here
ANSWERS = {
    "write_raw_data_can": True,
    "modbus_read": 7,
    "modbus_write": 4,
    "modbus_write_multiple_regs": 4,
    "modbus_write_multiple_coils": 4,
}
#: what the manual's text and prototype say of a default, where our classes have it otherwise
OTHERWISE = {
    f"{name}.def_acc": "the text turns the flag round: true is the acceleration that is given"
    for name in ("move_eaxis", "movej2_eaxis", "movej2_pose_eaxis", "move1_eaxis", "movec_eaxis")
}
#: defaults that are our choice, and not the manual's: see the functions
DEFAULTS: dict[str, Any] = {
    # -1, no end, in the manual: the arm would go on if the program hangs
    "speedj.time": 1.0,
    "speedl.time": 1.0,
}


class Node:
    """A device at the CAN bus, which acknowledges every frame."""

    def receive(self, id: int, data: bytes, /) -> list[tuple[int, bytes]]:  # noqa: A002 - CAN's
        return []


@pytest.fixture(scope="module")
def shared() -> Iterator[Simulator]:
    with simulator() as running:
        running.cabinet.can.peer = Node()
        yield running


@pytest.fixture
def sim(request: pytest.FixtureRequest, name: str) -> Iterator[Simulator]:
    if name not in APART:
        yield request.getfixturevalue("shared")
        return
    with simulator() as running:
        yield running


@pytest.fixture(scope="module")
def waiting(shared: Simulator) -> Iterator[aioduco.sync.Robot]:
    with aioduco.sync.connect(shared.host, shared.port, heartbeat=None) as robot:
        yield robot


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def awaited(shared: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(shared.host, shared.port, heartbeat=None) as robot:
        yield robot


@pytest.fixture
def arm(sim: Simulator, name: str) -> Iterator[compat.DucoCobot]:
    """The vendor's class, with the arm enabled at home and what the table has as setup done."""
    row = table.FUNCTIONS[FUNCTIONS[name]["wire"]]
    slave = ModbusSlave(coils={0: False, 1: False}, registers={0: 7, 1: 0})
    sim.cabinet.modbus.slaves["127.0.0.1", 1] = slave
    with compat.DucoCobot(sim.host, sim.port) as robot:
        bring_home(robot)
        carry_out(robot, row.get("setup", ()))
        yield robot
        if name not in APART:
            carry_out(robot, row.get("after", ()))


def bring_home(robot: compat.DucoCobot) -> None:
    robot.stop(True)
    if robot.get_robot_state() != READY:
        robot.switch_mode(1)
        assert [robot.power_off(True), robot.power_on(True), robot.enable(True)] == [FINISHED] * 3
    if far(robot.get_actual_joints_position(), HOME) > 1e-3:
        assert robot.movej2(HOME, 3.0, 20.0, 0.0, True) == FINISHED


def carry_out(robot: compat.DucoCobot, calls: Iterable[tuple[str, dict[str, Any]]]) -> None:
    """Make calls of the table, each when the task of the one before has ended."""
    for name, args in calls:
        answer = getattr(robot, name)(*in_wire_order(name, args))
        if table.is_id(name, answer):
            ended(robot, answer)


def ended(robot: compat.DucoCobot, task: int) -> int:
    """The state in which a task ended."""
    states: list[int] = []

    def over() -> bool:
        states.append(robot.get_noneblock_taskstate(task))
        return states[-1] > 2

    eventually(over)
    return states[-1]


def answers_as_the_table_says(
    robot: compat.DucoCobot, name: str, args: list[Any], kwargs: dict[str, Any]
) -> None:
    wire = FUNCTIONS[name]["wire"]
    expected = ANSWERS.get(wire, table.FUNCTIONS[wire].get("answer"))
    answer = getattr(robot, name)(*args, **kwargs)
    if type(answer) is int and answer >= 1000:
        answer, expected = ended(robot, answer), FINISHED
    if expected == "struct":
        answer = {field[1]: getattr(answer, field[1]) for field in answer.thrift_spec.values()}
    assert table.fits(expected, answer), (answer, robot.get_last_error()[-2:])


@pytest.mark.parametrize("name", CALLED)
def test_in_the_vendors_class(arm: compat.DucoCobot, name: str) -> None:
    answers_as_the_table_says(arm, name, *as_printed(name))


@pytest.mark.parametrize("name", [one for one in CALLED if inputs(one)])
def test_in_the_vendors_class_with_every_name_that_is_printed(
    arm: compat.DucoCobot, name: str
) -> None:
    answers_as_the_table_says(arm, name, [], whole(name))


def compared(name: str, robot: compat.DucoCobot, answer: Any) -> None:
    """The answer of ours says the same as that of the vendor's class; these two tell more."""
    if name not in {"pause", "resume"} and isinstance(answer, (bool, int, float, str)):
        by_position, by_name = as_printed(name)
        assert getattr(robot, name)(*by_position, **by_name) == pytest.approx(answer)


@pytest.mark.cases(6)
@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("name", AWAITED)
async def test_awaited(
    sim: Simulator, arm: compat.DucoCobot, awaited: aioduco.Robot, name: str
) -> None:
    case = ours()[FUNCTIONS[name]["wire"]]
    given = mapped(name, case)
    own = aioduco.connect(sim.host, sim.port, heartbeat=None)
    async with own if name in ALONE else nullcontext(awaited) as robot:
        made = case.method(robot)(**given)
        if isinstance(made, HeldMotion) and "time" not in case.parameters:
            async with made:
                pass
        elif isinstance(made, MotionCommand):
            assert await made is Outcome.FINISHED
        else:
            compared(name, arm, await made)


@pytest.mark.cases(7)
@pytest.mark.parametrize("name", AWAITED)
def test_in_plain_scripts(
    sim: Simulator, arm: compat.DucoCobot, waiting: aioduco.sync.Robot, name: str
) -> None:
    case = ours()[FUNCTIONS[name]["wire"]]
    given = mapped(name, case)
    own = aioduco.sync.connect(sim.host, sim.port, heartbeat=None)
    with own if name in ALONE else nullcontext(waiting) as robot:
        function = getattr(getattr(robot, case.section) if case.section else robot, case.name)
        if name == "teach_mode":
            function.start(**given).end()
            return
        answer = function(**given)
        if isinstance(answer, Outcome):
            assert answer is Outcome.FINISHED
        else:
            compared(name, arm, answer)


def stated(one: dict[str, Any]) -> Any:
    """A default as Python has it; the text's where the prototype has another."""
    if "default" in one:
        return one["default"]
    return {"op_": rpc.Op(), "{}": [], "0": 0, "false": False}[one["prototype_default"]]


def test_our_defaults_are_the_manuals() -> None:
    wrong = []
    seen = 0
    for name, function in ON_WIRE.items():
        case = ours().get(function["wire"])
        if case is None:
            assert name in BY_ITSELF
            continue
        for parameter, of in case.parameters.items():
            one = next((p for p in inputs(name) if p["name"] == case.manual_name(parameter)), None)
            if one is None or not (one.get("optional") or "default" in one):
                continue
            if f"{name}.{one['name']}" in OTHERWISE:
                continue
            seen += 1
            empty = of.default in (None, ()) and "default" not in one
            if not empty and of.default != DEFAULTS.get(f"{name}.{parameter}", stated(one)):
                wrong.append(f"{name}.{parameter}: {of.default}, not {stated(one)}")
    assert wrong == []
    assert seen > 50
