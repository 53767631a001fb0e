"""Buses and variables: what their functions do beyond one call."""

from __future__ import annotations

import pytest

import aioduco
from api.bus_cases import BUSES, DATA
from api.cases import NOBODY, Case
from api.desk import Desk


@pytest.mark.parametrize("case", [case for case in BUSES if case.answer is True], ids=str)
async def test_bytes_that_were_not_written(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    desk.answer(case.name, False)
    with pytest.raises(aioduco.BusError, match=case.name):
        await case.method(robot)(**case.args)


@pytest.mark.parametrize("case", [case for case in BUSES if case.result == DATA], ids=str)
async def test_nothing_has_come(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    desk.answer(case.name, [])
    assert await case.method(robot)(**case.args) == b""


async def test_a_can_frame_without_data_is_written(robot: aioduco.Robot, desk: Desk) -> None:
    for write in (robot.bus.write_raw_data_can, robot.bus.write_data_can):
        desk.answer(write.__name__, True)
        await write(0x80, b"")  # CANopen's SYNC
        (call,) = desk.received(write.__name__)
        assert call.args == (0x80, [])


async def test_no_can_frame_has_come(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("read_raw_data_can", [])
    assert await robot.bus.read_raw_data_can() is None
    desk.answer("read_raw_data_can", [0x23])
    assert await robot.bus.read_raw_data_can() == (0x23, b"")


async def test_a_variable_that_is_not_there(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("set_system_value_double", 1)
    with pytest.raises(aioduco.Refused, match="set_system_value_double"):
        await robot.registers.set_system_value_double("nothing", 1.0)


async def test_pulses_shorter_than_a_millisecond() -> None:
    with pytest.raises(aioduco.ParameterError, match="10 % at 100 Hz"):
        await NOBODY.io.set_digital_output_mode(
            1, aioduco.OutputMode.PULSES, freq=100, duty_cycle=9
        )
