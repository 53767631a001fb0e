"""A layout that was met before stands for a measurement, and for nothing else."""

from __future__ import annotations

import random
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aioduco._wire import codec, idl, rpc
from aioduco._wire.framing import Malformed, StructScanner
from aioduco._wire.layout import Layouts
from aioduco.testing.message_parser import Message, MessageType

from .servers import reply
from .test_framing import FUNCTIONS, answers

STATUS = FUNCTIONS["getRobotStatus"]


def body(call: Message, value: Any) -> bytes:
    """The result struct of a reply."""
    return reply(call, value)[8 + len(FUNCTIONS[call.name].head) :]


def measured(function: idl.Function, data: bytes) -> bool:
    """Whether these bytes are the result struct, and nothing behind it, field by field."""
    scanner = StructScanner(function.result.thrift_spec, 0)
    try:
        return scanner.whole(data) and scanner.position == len(data)
    except Malformed:
        return False


@given(answers(), st.data())
def test_what_is_known_would_be_measured_as_whole(
    answer: tuple[Message, Any], data: st.DataObject
) -> None:
    call, value = answer
    function = FUNCTIONS[call.name]
    kept = body(call, value)
    layouts = Layouts()
    assert not layouts.known(kept)
    layouts.keep(kept)
    assert layouts.known(kept)
    for _ in range(20):
        damaged = bytearray(kept)
        damaged[data.draw(st.integers(0, len(kept) - 1))] = data.draw(st.integers(0, 255))
        assert not layouts.known(damaged) or measured(function, bytes(damaged))
    assert not layouts.known(kept + b"\0")
    assert not layouts.known(kept[:-1])


def test_every_byte_that_is_no_value_decides() -> None:
    kept = body(call_of("getRobotStatus"), status(random.Random(1)))
    layouts = Layouts()
    layouts.keep(kept)
    decide = 0
    for at, byte in enumerate(kept):
        damaged = bytearray(kept)
        damaged[at] = byte ^ 0xFF
        if not layouts.known(damaged):
            decide += 1
        else:
            assert measured(STATUS, bytes(damaged))
    # field heads of 3 bytes, lists' heads of 5, and the ends of two structs
    assert decide == 22 * 3 + 16 * 5 + 2


def test_values_are_those_that_were_sent(
    pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the thorough run two million numbers, of any bits that a double may have."""
    monkeypatch.setattr(STATUS, "layouts", Layouts())  # no other test has filled it
    seeded = random.Random(2)
    call = call_of("getRobotStatus")
    for _ in range(20_000 if pytestconfig.getoption("thorough") else 200):
        sent = status(seeded)
        data = reply(call, sent)
        reader = codec.ReplyReader(STATUS, call.seqid)
        assert reader.whole(data)
        assert reader.length == len(data)
        # by their bits, for some are not a number
        assert body(call, reader.value(data)) == body(call, sent)
    assert STATUS.layouts.known(body(call, status(seeded)))


@pytest.mark.parametrize(("length", "most"), [(5000, 0), (100, 4)])
def test_layouts_are_few_and_short(length: int, most: int) -> None:
    layouts = Layouts()
    call = call_of("read_raw_data_485")
    bodies = [body(call, [0] * (length + n)) for n in range(20)]
    for each in bodies:
        layouts.keep(each)
    assert sum(map(layouts.known, bodies)) == most


def call_of(name: str) -> Message:
    return Message(MessageType.CALL, name, 7, b"")


def status(seeded: random.Random) -> rpc.RobotStatus:
    """Of any numbers."""

    def numbers(count: int) -> list[float]:
        return list(struct.unpack(f"!{count}d", seeded.randbytes(8 * count)))

    entries = list(rpc.RobotStatus.thrift_spec.values())
    return rpc.RobotStatus(
        **{entry[1]: numbers(7) for entry in entries[:15]},
        slaveReady=[seeded.random() < 0.5 for _ in range(6)],
        collision=seeded.random() < 0.5,
        collisionAxis=seeded.randrange(-128, 128),
        emcStopSignal=seeded.random() < 0.5,
        robotState=seeded.randrange(-128, 128),
        robotError=seeded.randrange(-(2**31), 2**31),
    )
