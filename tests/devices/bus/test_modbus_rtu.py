"""Modbus RTU over a port: one request at a time, nothing stale, nothing sent twice."""

from __future__ import annotations

import inspect
from typing import Any

import anyio
import pytest
from for_each import for_each

import aioduco
from aioduco.devices.bus import ModbusRtu, Port
from aioduco.testing import eventually_async

from .device import Device

STALE = b"\x01\x03\x02\x00\x63\xf8\x6d"


def client(device: Device, timeout: float = 5.0) -> ModbusRtu:
    return ModbusRtu(Port(device.write, device.read), device.unit, timeout=timeout, poll=0.001)


async def test_registers() -> None:
    device = Device()
    modbus = client(device)
    await modbus.write_register(0x0103, 500)
    await modbus.write_registers(0x0200, [1, -1, 0x8000])
    assert device.written == [(0x0103, 500), (0x0200, 1), (0x0201, 0xFFFF), (0x0202, 0x8000)]
    assert await modbus.read_registers(0x0200, 3) == (1, 0xFFFF, 0x8000)
    assert await modbus.read_inputs(0x0103) == (500,)
    assert len(device.requests) == 4


async def test_an_answer_in_pieces() -> None:
    device = Device()
    device.chunk = 1
    device.registers[7] = 1234
    assert await client(device).read_registers(7) == (1234,)


async def test_stale_bytes_are_thrown_away() -> None:
    device = Device()
    device.registers[7] = 1234
    device.buffer = STALE
    assert await client(device).read_registers(7) == (1234,)


async def test_the_late_answer_to_a_cancelled_request_reaches_nobody() -> None:
    device = Device()
    modbus = client(device)
    device.registers[7] = 99
    device.spoil = lambda answer: b""  # it is late
    with anyio.move_on_after(0.02) as scope:
        await modbus.read_registers(7)
    assert scope.cancelled_caught
    device.buffer, device.registers[7], device.spoil = STALE, 1234, bytes
    assert await modbus.read_registers(7) == (1234,)


@for_each("taken, timeout", [(0, 30.0), (3, 30.0)])
async def test_an_answer_that_comes_after_the_next_request_reaches_nobody(
    taken: int, timeout: float
) -> None:
    """A read gave another register's value, and a write that was carried out raised an error."""
    device = Device()
    device.registers.update({7: 99, 8: 1})
    polls, left, late = 0, taken, True

    async def read(count: int) -> bytes:
        nonlocal polls, left
        await anyio.lowlevel.checkpoint()
        polls += 1
        given = await device.read(min(count, left) if late else count)
        left -= len(given)
        return given

    async def polled() -> None:
        before = polls
        await eventually_async(lambda: polls > before + 3)

    modbus = ModbusRtu(Port(device.write, read), 1, timeout=timeout, poll=0.001)
    async with anyio.create_task_group() as group:
        group.start_soon(modbus.read_registers, 7)
        await polled()
        group.cancel_scope.cancel()
    read_ = []

    async def ask() -> None:
        read_.append(await modbus.read_registers(8))

    async with anyio.create_task_group() as group:
        group.start_soon(ask)
        await polled()
        late = False
    assert read_ == [(1,)]
    await modbus.write_register(5, 5)
    assert device.written == [(5, 5)]


async def test_no_answer() -> None:
    device = Device()
    device.spoil = lambda answer: answer[:3]
    with pytest.raises(aioduco.ModbusTimeout, match="only 01 06 00 came"):
        await client(device, 0.02).write_register(0, 1)
    assert len(device.requests) == 1  # it is not sent again
    device.spoil = lambda answer: b""
    with pytest.raises(TimeoutError, match="nothing came"):
        await client(device, 0.02).write_register(0, 1)


async def test_a_spoilt_answer() -> None:
    device = Device()
    device.spoil = lambda answer: answer[:-1] + bytes((answer[-1] ^ 1,))
    modbus = client(device, 60.0)
    with pytest.raises(aioduco.ModbusGarbled, match="checksum"):
        await modbus.read_registers(0)
    device.spoil = bytes
    with anyio.fail_after(30.0):  # it has come, and is not waited for
        assert await modbus.read_registers(0) == (0,)


async def test_the_answer_behind_garbled_bytes_reaches_nobody() -> None:
    """Behind a byte of noise, it was taken for the answer to the next read."""
    device = Device()
    device.registers.update({7: 99, 8: 1})
    polls = 0

    async def read(count: int) -> bytes:
        nonlocal polls
        await anyio.lowlevel.checkpoint()
        polls += 1
        if polls == 2:
            return b"\xff"
        return await device.read(count) if polls > 5 else b""

    modbus = ModbusRtu(Port(device.write, read), 1, timeout=30.0, poll=0.001)
    with pytest.raises(aioduco.ModbusGarbled, match="begins with 255"):
        await modbus.read_registers(7)
    assert await modbus.read_registers(8) == (1,)


async def test_a_refusal() -> None:
    device = Device()
    device.busy = 6
    with pytest.raises(aioduco.ModbusRefused, match="it is busy") as caught:
        await client(device).write_register(0, 1)
    assert caught.value.code == 6
    assert isinstance(caught.value, aioduco.ModbusError)


async def test_a_bus_that_does_not_fall_silent() -> None:
    async def chatter(count: int) -> bytes:
        await anyio.lowlevel.checkpoint()
        return b"\x55"

    device = Device()
    modbus = ModbusRtu(Port(device.write, chatter), 1, timeout=0.02)
    with pytest.raises(aioduco.ModbusGarbled, match="nothing was sent"):
        await modbus.read_registers(0)
    assert device.requests == []


@pytest.mark.parametrize("alone", [False, True])
async def test_one_request_at_a_time(alone: bool) -> None:
    """Also of two drivers that were made for the port of a robot, each without the other."""
    at_work: list[bytes] = []
    device = Device()

    async def write(data: bytes) -> None:
        at_work.append(data)
        assert len(at_work) == 1
        await device.write(data)

    async def read(count: int) -> bytes:
        await anyio.lowlevel.checkpoint()
        given = await device.read(count)
        if given and not device.buffer:
            at_work.clear()
        return given

    class ToolBus:
        tool_write_raw_data_485 = staticmethod(write)
        tool_read_raw_data_485 = staticmethod(read)

    bus: Any = ToolBus()
    one, alike = (ModbusRtu(Port.tool(bus), 1, timeout=5.0, poll=0.001) for _ in range(2))
    other = alike if alone else one.device(1)
    async with anyio.create_task_group() as group:
        for number in range(10):
            group.start_soon((one, other)[number % 2].write_register, number, number)
    assert sorted(device.written) == [(number, number) for number in range(10)]


@for_each(
    "method, args, name",
    [
        ("read_registers", (-1,), "address"),
        ("read_registers", (0, 126), "count"),
        ("read_inputs", (0, 0), "count"),
        ("write_register", (0, 65536), "value"),
        ("write_register", (0x10000, 0), "address"),
        ("write_registers", (0, []), "values"),
        ("write_registers", (0, [0] * 124), "values"),
        ("write_registers", (0, [-0x8001]), "values"),
    ],
)
async def test_a_wrong_argument(method: str, args: tuple[object, ...], name: str) -> None:
    device = Device()
    with pytest.raises(aioduco.ParameterError, match=rf"^{name}"):
        await getattr(client(device), method)(*args)
    assert device.requests == []


def test_a_wrong_device() -> None:
    device = Device()
    for unit in (0, 248):
        with pytest.raises(aioduco.ParameterError, match="unit"):
            ModbusRtu(Port(device.write, device.read), unit)
    assert inspect.signature(ModbusRtu).parameters["timeout"].default > 0.15  # it needs to settle


async def test_both_ports_of_a_robot() -> None:
    robot = aioduco.connect("192.0.2.1")
    assert Port.tool(robot.bus).read == robot.bus.tool_read_raw_data_485
    assert Port.cabinet(robot.bus).write == robot.bus.write_raw_data_485
