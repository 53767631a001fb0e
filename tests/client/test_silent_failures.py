"""A zero that means a failure on the wire is an error, and a true zero is not."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco.api.section import new_errors
from aioduco.sim import Simulator
from aioduco.sim.cabinet import ModbusSlave

VALUES: dict[str, Any] = {"zero": 0.0, "off": False, "text": "", "none": [], "cell.x": 1.5}


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(speed=math.inf, values=VALUES) as sim:
        sim.cabinet.modbus.slaves["10.0.0.5", 1] = ModbusSlave(registers={0: 0})
        yield sim


@pytest.fixture
async def robot(sim: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(sim.host, sim.port, heartbeat=60.0, loop_stall_limit=60.0) as robot:
        yield robot


async def test_what_cannot_be_read_raises_with_the_reason(robot: aioduco.Robot) -> None:
    registers, modbus, state = robot.registers, robot.modbus, robot.state
    for _ in range(15):  # until the controller's list is full of the same text, and on
        with pytest.raises(aioduco.Refused, match="there is no system value 'nope'"):
            await registers.get_system_value_double("nope")
    with pytest.raises(aioduco.Refused, match="'zero' is a float, not a bool"):
        await registers.get_system_value_bool("zero")
    for read in (
        registers.get_system_value_str,
        registers.get_system_value_list,
        registers.get_system_value_lists,
    ):
        with pytest.raises(aioduco.Refused, match="there is no system value 'nope'"):
            await read("nope")
    with pytest.raises(aioduco.Refused, match=r"answer -1.*no Modbus signal 'nope'"):
        await modbus.modbus_read("nope")
    with pytest.raises(aioduco.Refused, match="no Modbus signal 'nope'"):
        await modbus.modbus_set_frequency("nope", 20)
    with pytest.raises(aioduco.Refused, match="no folder"):
        await robot.program.get_files_list("nope")
    with pytest.raises(aioduco.Refused, match="nope"):
        await state.get_tcp_pose_coord("nope")
    with pytest.raises(aioduco.Refused, match="nope"):
        await state.get_tcp_force_tool("nope")


async def test_a_nought_that_is_true_is_read(sim: Simulator, robot: aioduco.Robot) -> None:
    registers = robot.registers
    for _ in range(2):
        assert await registers.get_system_value_double("zero") == 0.0
        assert await registers.get_system_value_double("cell.x") == 1.5
        assert await registers.get_system_value_bool("off") is False
        assert await registers.get_system_value_str("text") == ""
        assert (await registers.get_system_value_list("none")).tolist() == []
    await robot.modbus.modbus_add_signal("10.0.0.5", 1, 0, 3, "word")
    await robot.modbus.modbus_set_frequency("word", 50)
    assert await robot.modbus.modbus_read("word") == 0
    with aioduco.sync.connect(sim.host, sim.port, heartbeat=60.0) as waiting:
        with pytest.raises(aioduco.Refused, match="no Modbus signal 'nope'"):
            waiting.modbus.modbus_read("nope")
        assert waiting.modbus.modbus_read("word") == 0


@for_each(
    "before, after, new",
    [
        ([], [], []),
        (["a"], ["a"], []),
        (["a"], ["a", "b", "c"], ["b", "c"]),
        (["a", "b", "c"], ["b", "c", "d"], ["d"]),  # the oldest was forgotten
        (["a", "b"], ["c"], ["c"]),  # all of them were, or the list was cleared
        (["a", "b"], [], []),
        (["a", "a"], ["a", "a", "a"], ["a"]),
        (["x: v"] * 3, ["x: v"] * 3, ["x: v"]),  # full of the same
        (["x: w"] * 3, ["x: w"] * 3, []),
        (["modbus_read: v"] * 3, ["modbus_read: v"] * 3, ["modbus_read: v"]),
        (["modbus_write: v"] * 3, ["modbus_write: v"] * 3, []),  # of another function, and old
    ],
)
def test_what_came_onto_the_error_list(before: list[str], after: list[str], new: list[str]) -> None:
    assert list(new_errors(before, after, "modbus_read", "v")) == new
