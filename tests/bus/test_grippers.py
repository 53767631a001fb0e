"""The gripper examples, over the wire, with a device behind the tool's port."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from api.desk import Desk

from aioduco.bus import ModbusRtu, Port

from .device import Device

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

EXAMPLES = Path(__file__).parents[2] / "examples"


def load(name: str) -> Any:
    """An example as a module."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def desk() -> Iterator[Desk]:
    with Desk() as desk:
        yield desk


def connect(desk: Desk, device: Device) -> None:
    """Put a device at the tool's port."""

    def write(data: Sequence[int]) -> bool:
        device.take(bytes(value & 0xFF for value in data))
        return True

    def read(count: int) -> list[int]:
        return [value - 256 if value > 127 else value for value in device.give(count)]

    desk.answer("tool_write_raw_data_485", write)
    desk.answer("tool_read_raw_data_485", read)


class Dh(Device):
    """A DH gripper that takes some looks to come to rest, and catches something on its way."""

    looks = 0
    late = True

    def _write(self, address: int, values: list[int] | tuple[int, ...]) -> None:
        super()._write(address, values)
        self.looks = 2
        self.late = address == 0x0103
        if address == 0x0103:
            self.registers[0x0202] = max(400, values[0])

    def _answer(self, request: bytes) -> bytes:
        if request[0] == 3:
            self.looks -= 1
            rest = self.looks < 0
            self.registers[0x0200] = int(rest and (0x0100, 1) in self.written)
            caught = self.registers[0x0202] == 400
            if not self.late:  # the first look tells of the motion before
                self.registers[0x0201] = (2 if caught else 1) if rest else 0
            self.late = False
        return super()._answer(request)


async def test_dh(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    gripper = Dh()
    connect(desk, gripper)
    await load("gripper_dh").main(desk.host, desk.port)
    assert capsys.readouterr().out.splitlines() == [
        "open: REACHED",
        "close: CAUGHT",
        "the fingers are at 0.400",
    ]
    assert gripper.written == [
        (0x0100, 1),
        *((0x0101, 30), (0x0104, 50), (0x0103, 1000)),
        *((0x0101, 30), (0x0104, 50), (0x0103, 0)),
    ]


class Robotiq(Device):
    """A Robotiq gripper; the answer to the first look is that of the motion before."""

    looks = 0

    def _write(self, address: int, values: list[int] | tuple[int, ...]) -> None:
        super()._write(address, values)
        self.looks = 2

    def _answer(self, request: bytes) -> bytes:
        if request[0] == 3:
            self.looks -= 1
            if self.looks < 0:
                act, position = self.registers[0x03E8] >> 8, self.registers[0x03E9]
                grip = (2 if position else 3) if act & 8 else 0
                self.registers[0x07D0] = (grip << 6 | (3 << 4 if act & 1 else 0) | act) << 8
                self.registers[0x07D1] = position
        return super()._answer(request)


async def test_robotiq(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    gripper = Robotiq(unit=9)
    connect(desk, gripper)
    await load("gripper_robotiq").main(desk.host, desk.port)
    assert capsys.readouterr().out.splitlines() == ["close: CAUGHT_CLOSING", "open: REACHED"]
    sent = [frame[7:-2].hex() for frame in gripper.requests if frame[1] == 16]
    assert sent == ["000000000000", "010000000000", "090000ff8040", "090000008040"]


@pytest.mark.parametrize(
    ("name", "kind"), [("gripper_dh", "DhGripper"), ("gripper_robotiq", "Robotiq2F")]
)
async def test_a_wrong_argument_is_not_sent(name: str, kind: str) -> None:

    device = Device()
    gripper = getattr(load(name), kind)(ModbusRtu(Port(device.write, device.read), 1))
    for position in (-1, 256):
        with pytest.raises(ValueError, match="nothing was sent"):
            await gripper.move(position)
    assert device.requests == []


def test_each_is_short() -> None:
    for path in EXAMPLES.glob("gripper_*.py"):
        assert len(path.read_text(encoding="utf-8").splitlines()) < 100
