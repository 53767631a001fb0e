"""A known layout replaces a measurement only of the same layout."""

from __future__ import annotations

import random
import re
import struct
from typing import Any

import pytest
from for_each import for_each
from hypothesis import event, given
from hypothesis import strategies as st
from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TType
from thriftpy2.transport import TCyMemoryBuffer

from aioduco._wire import codec, idl, newer, rpc
from aioduco._wire.framing import Malformed, StructScanner
from aioduco._wire.layout import Layouts
from aioduco._wire.messages import Message, MessageType

from .servers import reply
from .test_framing import FUNCTIONS, answers

STATUS = FUNCTIONS["getRobotStatus"]

#: thriftpy2 ships no types of it
_protocol: Any = TCyBinaryProtocol

#: a list of lists or of structs, or a map
_NESTED = re.compile(r"\(15, 'success', \(|\(13, 'success'")
#: what controllers of manual 4.3 add to a status
ADDED = [
    name for name in newer.RobotStatus.__match_args__ if name not in rpc.RobotStatus.__match_args__
]
_EMPTY: dict[int, Any] = {TType.LIST: [], TType.MAP: {}, TType.STRING: ""}


def stored(function: idl.Function, data: bytes) -> Layouts:
    layouts = Layouts()
    layouts.store(data, function.result)
    return layouts


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
    assert Layouts().find(kept) is None
    layouts = stored(function, kept)
    found = layouts.find(kept)
    event("of numbers" if found else "not of numbers alone")
    if found is None:
        return
    for _ in range(20):
        damaged = bytearray(kept)
        damaged[data.draw(st.integers(0, len(kept) - 1))] = data.draw(st.integers(0, 255))
        assert layouts.find(damaged) is None or measured(function, bytes(damaged))
    assert found == layouts.find(kept + b"\0")  # whatever follows it
    assert found[1] == len(kept)
    assert layouts.find(kept[:-1]) is None


def test_every_byte_that_is_no_value_decides() -> None:
    kept = body(call_of("getRobotStatus"), status(random.Random(1)))
    layouts = stored(STATUS, kept)
    decide = 0
    for at, byte in enumerate(kept):
        damaged = bytearray(kept)
        damaged[at] = byte ^ 0xFF
        if layouts.find(damaged) is None:
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
    assert STATUS.layouts.find(body(call, status(seeded))) is not None


@given(answers())
def test_values_are_those_that_thriftpy2_reads(answer: tuple[Message, Any]) -> None:
    call, value = answer
    function = FUNCTIONS[call.name]
    kept = body(call, value)
    layout = stored(function, kept).find(kept)
    event("by one format" if layout else "field by field")
    if layout is not None:
        theirs = function.result()
        _protocol(TCyMemoryBuffer(kept)).read_struct(theirs)
        ours = layout[0](b"before" + kept, len(b"before"))
        assert repr(ours) == repr(theirs.success)
        assert type(ours) is type(theirs.success)


def test_nearly_all_functions_are_read_at_once() -> None:
    left = set()
    for name, function in FUNCTIONS.items():
        spec = function.result.thrift_spec
        result = function.result()
        if not function.void:
            kind, _, *shape = spec[0]
            result.success = shape[0]() if kind == TType.STRUCT else _EMPTY.get(kind, 0)
        buffer: Any = TCyMemoryBuffer()
        _protocol(buffer).write_struct(result)
        if stored(function, buffer.getvalue()).find(buffer.getvalue()) is None:
            left.add(name)
    others = {
        name
        for name, function in FUNCTIONS.items()
        if function.void or function.texts or _NESTED.search(repr(function.result.thrift_spec))
    }
    assert left == others | {"reach_check"}  # a struct with a list of lists
    assert len(left) < len(FUNCTIONS) / 10


@for_each("length, most", [(5000, 0), (100, 4)])
def test_layouts_are_few_and_short(length: int, most: int) -> None:
    layouts, function = Layouts(), FUNCTIONS["read_raw_data_485"]
    call = call_of(function.name)
    bodies = [body(call, [0] * (length + n)) for n in range(20)]
    for each in bodies:
        layouts.store(each, function.result)
    assert sum(layouts.find(each) is not None for each in bodies) == most


def test_a_newer_status_is_read_at_once_and_keeps_what_is_added(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(STATUS, "layouts", Layouts())
    call, seeded = call_of("getRobotStatus"), random.Random(3)
    present = {name: getattr(status(seeded), name) for name in rpc.RobotStatus.__match_args__}
    sent = STATUS.newer.thrift_spec[0][2](**present, **dict.fromkeys(ADDED, [0.5] * 6))
    data = Message(MessageType.REPLY, call.name, call.seqid, _encoded(sent)).encode()
    seen = []
    for _ in range(2):
        reader = codec.ReplyReader(STATUS, call.seqid)
        assert reader.whole(data)
        seen.append(reader.value(data))
    assert STATUS.layouts.find(data[8 + len(STATUS.head) :]) is not None
    for each in seen:
        assert isinstance(each, newer.RobotStatus)
        assert repr(each) == repr(seen[0])
        assert each.jointExtraTorque == [0.5] * 6


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


def _encoded(sent: newer.RobotStatus) -> bytes:
    """The result struct with a status of manual 4.3."""
    result = STATUS.newer()
    result.success = sent
    buffer: Any = TCyMemoryBuffer()
    _protocol(buffer).write_struct(result)
    encoded: bytes = buffer.getvalue()
    return encoded
