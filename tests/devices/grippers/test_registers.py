"""The register maps, byte by byte against the examples that the makers print."""

from __future__ import annotations

import pytest
from for_each import for_each

from aioduco.devices.bus import frames
from aioduco.devices.grippers import dh_registers as dh
from aioduco.devices.grippers import robotiq_registers as robotiq
from aioduco.devices.grippers.robotiq_registers import Activation, RobotiqGrip

#: Robotiq, 2F-85 & 2F-140 instruction manual, section 4.7 (example with Modbus RTU); the Hand-E's
#: manual prints the same frames
ROBOTIQ_REQUESTS = [
    (robotiq.activation(), "09 10 03 E8 00 03 06 01 00 00 00 00 00 72 E1"),
    (robotiq.reset(), "09 10 03 E8 00 03 06 00 00 00 00 00 00 73 30"),
    (robotiq.request(255, 255, 255), "09 10 03 E8 00 03 06 09 00 00 FF FF FF 42 29"),
    (robotiq.request(0, 255, 255), "09 10 03 E8 00 03 06 09 00 00 00 FF FF 72 19"),
]


@for_each("words, printed", ROBOTIQ_REQUESTS)
def test_robotiq_requests(words: list[int], printed: str) -> None:
    request = frames.write(9, robotiq.COMMAND, words)
    assert request.frame == bytes.fromhex(printed)
    assert request.answer(bytes.fromhex("09 10 03 E8 00 03 01 30")) == ()


#: what the manual prints as answers to 09 04 07 D0 00 03 B1 CE, and what it says they mean
ROBOTIQ_ANSWERS = [
    ("09 04 06 39 00 00 00 BB 10 71 06", RobotiqGrip.MOVING, 0, 0xBB, 0.16),
    ("09 04 06 B9 00 00 FF BD 00 5C 9A", RobotiqGrip.CAUGHT_CLOSING, 0xFF, 0xBD, 0.0),
    ("09 04 06 F9 00 00 00 0D 00 17 AA", RobotiqGrip.REACHED, 0, 0x0D, 0.0),
]


@for_each("printed, grip, requested, position, current", ROBOTIQ_ANSWERS)
def test_robotiq_answers(
    printed: str, grip: RobotiqGrip, requested: int, position: int, current: float
) -> None:
    request = frames.read(9, robotiq.STATUS, robotiq.STATUS_COUNT, frames.FunctionCode.READ_INPUT)
    assert request.frame == bytes.fromhex("09 04 07 D0 00 03 B1 CE")
    registers = request.answer(bytes.fromhex(printed))
    assert registers is not None
    status = robotiq.status(registers)
    assert status[:4] == (True, True, Activation.ACTIVE, grip)
    assert status[4:7] == (0, requested, position)
    assert status.current == pytest.approx(current)


@for_each(
    "printed, activation",
    [("09 03 02 11 00 55 D5", Activation.ACTIVATING), ("09 03 02 31 00 4C 15", Activation.ACTIVE)],
)
def test_robotiq_activation(printed: str, activation: Activation) -> None:
    request = frames.read(9, robotiq.STATUS, 1, frames.FunctionCode.READ_HOLDING)
    assert request.frame == bytes.fromhex("09 03 07 D0 00 01 85 CF")
    registers = request.answer(bytes.fromhex(printed))
    assert registers is not None
    assert robotiq.status((*registers, 0, 0)).activation is activation


def test_robotiq_refuses_what_is_no_byte() -> None:
    for wrong in ((256, 0, 0), (0, -1, 0), (0, 0, 256)):
        with pytest.raises(ValueError, match="0 to 255"):
            robotiq.request(*wrong)


#: DH-Robotics, PGE series and AG-95 short manuals (Modbus-RTU), section 2.3. The manual's frame for
#: a force of 30 lacks a byte, by its checksum 00 before 1E: this is the whole one
DH_REQUESTS = [
    (dh.INITIALIZE, 1, "01 06 01 00 00 01 49 F6"),
    (dh.FORCE, 30, "01 06 01 01 00 1E 59 FE"),
    (dh.POSITION, 500, "01 06 01 03 01 F4 78 21"),
]


@for_each("address, value, printed", DH_REQUESTS)
def test_dh_requests(address: int, value: int, printed: str) -> None:
    request = frames.write_one(1, address, value)
    assert request.frame == bytes.fromhex(printed)
    assert request.answer(bytes.fromhex(printed)) == ()


def test_dh_answers() -> None:
    one = frames.read(1, dh.POSITION, 1, frames.FunctionCode.READ_HOLDING)
    assert one.frame == bytes.fromhex("01 03 01 03 00 01 75 F6")
    # Table of basic control registers: 0x0200, 0x0201, 0x0202 and 0x0104.
    assert (dh.STATE, dh.STATE_COUNT, dh.SPEED, dh.OPEN) == (0x0200, 3, 0x0104, 1000)
    assert [ready.name for ready in dh.Initialization] == ["NONE", "DONE", "UNDER_WAY"]
    assert [grip.name for grip in dh.DhGrip] == ["MOVING", "REACHED", "CAUGHT", "DROPPED"]
    assert dh.state((1, 2, 400)) == (dh.Initialization.DONE, dh.DhGrip.CAUGHT, 400)
    with pytest.raises(ValueError, match="7"):
        dh.state((1, 7, 400))


@for_each(
    "register, position",
    [(0, 0), (1000, 1000), (1003, 1000), (1100, 1000), (0xFFFF, 0), (0xFFF0, 0)],
)
def test_a_position_beyond_an_end_of_the_stroke_is_that_end(register: int, position: int) -> None:
    assert dh.state((1, 1, register)).position == position


@for_each("register", [1101, 5000, 0x7FFF, 0x8000, 0xFF00])
def test_a_register_that_is_no_position_is_refused(register: int) -> None:
    with pytest.raises(ValueError, match="is no position"):
        dh.state((1, 1, register))
