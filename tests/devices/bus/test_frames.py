"""Frames of Modbus RTU: examples from the standard, and all that can be wrong with an answer."""

from __future__ import annotations

import hypothesis.strategies as st
import pytest
from for_each import for_each
from hypothesis import given

from aioduco import ModbusGarbled, ModbusRefused
from aioduco.devices.bus import frames
from aioduco.devices.bus.frames import FunctionCode, Request

WORDS = st.integers(0, 0xFFFF)
UNITS = st.integers(1, 247)


def test_the_checksum_of_the_standard() -> None:
    # Modbus over serial line 1.02, appendix B: the frame 02 07 has the checksum 0x1241.
    assert frames.crc16(b"\x02\x07") == 0x1241
    assert frames.framed(b"\x02\x07") == b"\x02\x07\x41\x12"
    assert frames.crc16(b"123456789") == 0x4B37  # the check value of CRC-16/MODBUS


@for_each(
    "request_, frame",
    [
        # application protocol 1.1b3, 6.3, 6.4, 6.6 and 6.12: function and what follows
        (frames.read(17, 0x006B, 3, FunctionCode.READ_HOLDING), "11 03 00 6b 00 03"),
        (frames.read(17, 0x0008, 1, FunctionCode.READ_INPUT), "11 04 00 08 00 01"),
        (frames.write_one(17, 0x0001, 0x0003), "11 06 00 01 00 03"),
        (frames.write(17, 0x0001, [0x000A, 0x0102]), "11 10 00 01 00 02 04 00 0a 01 02"),
    ],
)
def test_a_request(request_: Request, frame: str) -> None:
    assert request_.frame[:-2] == bytes.fromhex(frame)
    assert frames.framed(request_.frame[:-2]) == request_.frame


@given(unit=UNITS, address=WORDS, values=st.lists(WORDS, min_size=1, max_size=125))
def test_an_answer_comes_byte_by_byte(unit: int, address: int, values: list[int]) -> None:
    request = frames.read(unit, address, len(values), FunctionCode.READ_HOLDING)
    data = b"".join(value.to_bytes(2, "big") for value in values)
    whole = frames.framed(bytes((unit, 3, len(data))) + data)
    for length in range(len(whole)):
        assert request.answer(whole[:length]) is None
        assert 0 < request.missing_bytes(whole[:length]) <= len(whole) - length
    assert request.missing_bytes(whole) == 0
    assert request.answer(whole) == tuple(values)


@given(unit=UNITS, address=WORDS, value=WORDS, at=st.integers(0, 63))
def test_no_flipped_bit_passes(unit: int, address: int, value: int, at: int) -> None:
    request = frames.write_one(unit, address, value)
    assert request.answer(request.frame) == ()
    flipped = bytearray(request.frame)
    flipped[at // 8] ^= 1 << at % 8
    with pytest.raises(ModbusGarbled):
        request.answer(bytes(flipped))


@for_each("code, says", [(2, "this register"), (77, "the device's own")])
def test_an_exception(code: int, says: str) -> None:
    request = frames.write(9, 0, [1, 2, 3])
    answer = frames.framed(bytes((9, 0x90, code)))
    assert request.answer(answer[:4]) is None
    with pytest.raises(ModbusRefused, match=says) as caught:
        request.answer(answer)
    assert (caught.value.function, caught.value.code) == (0x10, code)


@for_each(
    "answer, says",
    [
        (frames.framed(b"\x02\x03\x02\x00\x01"), "begins with 2"),
        (frames.framed(b"\x01\x04\x02\x00\x01"), "another function"),
        (frames.framed(b"\x01\x03\x04\x00\x01"), "says 4 bytes instead of 2"),
        (frames.framed(b"\x01\x03\x02\x00\x01") + b"\x00", "8 bytes instead of 7"),
        (b"\x01\x03\x02\x00\x01\x00\x00", "checksum"),
    ],
)
def test_what_is_no_answer(answer: bytes, says: str) -> None:
    with pytest.raises(ModbusGarbled, match=says):
        frames.read(1, 0, 1, FunctionCode.READ_HOLDING).answer(answer)


def test_a_write_that_is_answered_for_another_register() -> None:
    other = frames.framed(b"\x01\x06\x00\x02\x00\x05")
    with pytest.raises(ModbusGarbled, match="other registers"):
        frames.write_one(1, 1, 5).answer(other)
