"""Messages are measured before they are decoded: whole ones pass, all others are refused."""

from __future__ import annotations

import struct

import pytest
from for_each import for_each
from hypothesis import example, given
from hypothesis import strategies as st

from aioduco._wire import idl, rpc
from aioduco._wire.framing import Malformed
from aioduco._wire.messages import Message
from aioduco.sim.server.processor import CALL, MAX_DEPTH, MAX_ELEMENTS, MAX_MESSAGE, CallInbox

from .raw import encode

HEAD = b"\x80\x01\x00\x01\x00\x00\x00\x04stop\x00\x00\x00\x07"
STOP = HEAD + b"\x02\x00\x01\x01\x00"


def call(name: str, *args: object) -> bytes:
    return encode(name, 7, *args)


def field(kind: int, value: bytes, fid: int = 1) -> bytes:
    return struct.pack(">bh", kind, fid) + value


LONGEST = call(
    "spline_op",
    [rpc.PointOp([0.1] * 6, rpc.Op(trig_event_1="spray")) for _ in range(50)],
    0.1,
    1.0,
    "default",
    "default",
    False,
    rpc.Op(),
    0.0,
    False,
)


@for_each("name", sorted(idl.functions()))
def test_each_function_of_the_wire_is_measured_exactly(name: str) -> None:
    function = idl.functions()[name]
    encoded = call(name, *(zero() for zero in function.zeros))
    inbox = CallInbox()
    inbox.feed(encoded + STOP)
    message = inbox.take()
    assert message is not None
    assert (message.name, message.seqid) == (name, 7)
    assert encoded.endswith(message.body)
    assert inbox.take() == Message(CALL, "stop", 7, STOP[len(HEAD) :])
    assert inbox.take() is None


@for_each("size", [1, 2, 7, 1000])
def test_a_message_that_comes_in_pieces_is_the_same(size: int) -> None:
    inbox = CallInbox()
    found = []
    for at in range(0, 2 * len(LONGEST), size):
        inbox.feed((LONGEST * 2)[at : at + size])
        message = inbox.take()
        if message is not None:
            found.append(message)
    assert [message.name for message in found] == ["spline_op"] * 2
    assert all(message.body == LONGEST[len(LONGEST) - len(message.body) :] for message in found)


def test_a_thousand_points_of_a_track_pass() -> None:
    inbox = CallInbox()
    inbox.feed(call("trackEnqueueOp", [rpc.PointOp([0.1] * 6) for _ in range(1000)], False))
    assert inbox.take() is not None


@for_each(
    "data, reason",
    [
        (b"\x00\x00\x00\x20\x80\x01\x00\x01", "strict binary"),
        (b"GET / HTTP/1.1\r\n\r\n", "strict binary"),
        (b"\x80\x01\x00\x02\x00\x00\x00\x04stop\x00\x00\x00\x07\x00", "type 2"),
        (b"\x80\x01\x00\x01\x7f\xff\xff\xff", "name of 2147483647 bytes"),
        (b"\x80\x01\x00\x01\xff\xff\xff\xff", "name of -1 bytes"),
        (b"\x80\x01\x00\x01\x00\x00\x00\x00", "name of 0 bytes"),
        (b"\x80\x01\x00\x01\x00\x00\x00\x04st\xffp\x00\x00\x00\x07", "ASCII"),
        (HEAD + field(11, b"\x7f\xff\xff\xff"), "string of 2147483647 bytes"),
        (HEAD + field(11, b"\xff\xff\xff\xff"), "string of -1 bytes"),
        (HEAD + field(15, b"\x04\x7f\xff\xff\xff"), "container of 2147483647"),
        (HEAD + field(15, b"\x0c\x00\x01\x00\x01"), "container of 65537"),
        (HEAD + field(13, b"\x0b\x0b\xff\xff\xff\xff"), "container of -1"),
        (HEAD + field(14, b"\x02\x7f\xff\xff\xff"), "container of 2147483647"),
        (HEAD + field(9, b""), "type 9"),
        (HEAD + field(15, b"\x63\x00\x00\x00\x01"), "type 99"),
        (HEAD + field(12, b"") * (MAX_DEPTH + 1), "nested deeper"),
        (HEAD + field(15, b"\x0f\x00\x00\x00\x01" * (MAX_DEPTH + 1)), "nested deeper"),
    ],
)
def test_what_no_client_sends_is_refused_before_it_is_waited_for(data: bytes, reason: str) -> None:
    inbox = CallInbox()
    inbox.feed(data)
    with pytest.raises(Malformed, match=reason):
        inbox.take()


def test_a_message_beyond_the_limit_is_refused_although_each_part_is_small() -> None:
    text = field(11, struct.pack(">i", 1000) + bytes(1000))
    inbox = CallInbox()
    inbox.feed(HEAD)
    for _ in range(MAX_MESSAGE // len(text)):
        inbox.feed(text)
        assert inbox.take() is None
    inbox.feed(text)
    with pytest.raises(Malformed, match=f"more than {MAX_MESSAGE}"):
        inbox.take()


def test_small_lists_of_lists_add_up_to_the_limit_of_elements() -> None:
    inner = b"\x0c" + struct.pack(">i", MAX_ELEMENTS // 2) + bytes(MAX_ELEMENTS // 2)
    inbox = CallInbox()
    inbox.feed(HEAD + field(15, b"\x0f\x00\x00\x00\x02" + inner + inner))
    with pytest.raises(Malformed, match="elements"):
        inbox.take()


@given(data=st.binary(max_size=200), cut=st.integers(0, 200))
@example(data=STOP, cut=3)
def test_any_bytes_pass_whole_or_are_refused(data: bytes, cut: int) -> None:
    def messages(parts: list[bytes]) -> list[Message | None]:
        inbox, found = CallInbox(), list[Message | None]()
        try:
            for part in parts:
                inbox.feed(part)
                while (message := inbox.take()) is not None:
                    found.append(message)
        except Malformed:
            found.append(None)
        return found

    for prefix in (b"", HEAD):
        whole = prefix + data
        assert messages([whole]) == messages([whole[:cut], whole[cut:]])


@given(st.integers(0, len(LONGEST) - 1), st.integers(0, 255))
def test_a_changed_byte_never_reads_beyond_the_message(at: int, byte: int) -> None:
    data = bytearray(LONGEST)
    data[at] = byte
    inbox = CallInbox()
    inbox.feed(bytes(data))
    try:
        message = inbox.take()
    except Malformed:
        return
    if message is not None:
        # The body is what follows the head, and may end early; it is never longer than what came.
        assert message.body in bytes(data)
        assert len(message.body) < len(data)
