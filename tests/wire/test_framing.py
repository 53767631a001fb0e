"""Replies are measured and checked before they are decoded."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st
from thriftpy2.thrift import TType

from aioduco._wire import codec, idl, rpc
from aioduco._wire.framing import MAX_REPLY, Malformed, StructScanner
from aioduco._wire.messages import Message, MessageType
from aioduco.errors import ControllerError, UnknownFunction

from .servers import exception, reply
from .test_messages import parts, values

FUNCTIONS = idl.functions()
VALUED = sorted(name for name, function in FUNCTIONS.items() if not function.void)


@st.composite
def answers(draw: st.DrawFn) -> tuple[Message, Any]:
    """A call of any function that returns something, and a value that it could return."""
    name = draw(st.sampled_from(VALUED))
    entry = FUNCTIONS[name].result.thrift_spec[0]
    value = draw(values(entry[0], entry[2] if len(entry) > 3 else None, whole=True))
    return Message(MessageType.CALL, name, draw(st.integers(1, 2**31 - 1)), b""), value


@given(answers(), st.data())
def test_a_reply_is_whole_at_its_last_byte_however_it_is_cut_and_whatever_follows(
    answer: tuple[Message, Any], data: st.DataObject
) -> None:
    call, value = answer
    encoded = reply(call, value)
    reader = codec.ReplyReader(FUNCTIONS[call.name], call.seqid)
    cuts = data.draw(st.lists(st.integers(1, len(encoded) - 1), max_size=6))
    for cut in sorted(cuts):
        assert not reader.whole(encoded[:cut])
    more = encoded + data.draw(st.binary(max_size=20))
    assert reader.whole(more)
    assert reader.length == len(encoded)
    assert reader.value(more) == value


@given(answers(), st.data())
def test_damaged_replies_never_hang_or_ask_for_more_than_the_limit(
    answer: tuple[Message, Any], data: st.DataObject
) -> None:
    call, value = answer
    damaged = bytearray(reply(call, value))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        damaged[at] = data.draw(st.integers(0, 255))
    reader = codec.ReplyReader(FUNCTIONS[call.name], call.seqid)
    try:
        whole = reader.whole(damaged)
    except Malformed:
        return
    assert reader.length <= MAX_REPLY
    if whole and not reader.failed:
        # what is let through is what thriftpy2 decodes, and nothing it would have guessed
        try:
            result = reader.value(damaged)
        except ControllerError:
            return
        entry = FUNCTIONS[call.name].result.thrift_spec[0]
        assert fits(result, entry[0], entry[2] if len(entry) > 3 else None)


def fits(value: Any, kind: int, shape: Any) -> bool:
    """Whether a value has a type of the wire, all through."""
    if kind == TType.LIST:
        return isinstance(value, list) and all(fits(item, *parts(shape)) for item in value)
    if kind == TType.MAP:
        return isinstance(value, dict) and all(
            fits(key, *parts(shape[0])) and fits(item, *parts(shape[1]))
            for key, item in value.items()
        )
    if kind == TType.STRUCT:
        return isinstance(value, shape) and all(
            fits(getattr(value, entry[1]), entry[0], entry[2] if len(entry) > 3 else None)
            for entry in shape.thrift_spec.values()
        )
    wanted = {TType.BOOL: bool, TType.DOUBLE: float, TType.STRING: str}.get(kind, int)
    return isinstance(value, wanted)


def result(name: str, body: bytes, seqid: int = 1) -> bytes:
    """A reply with this encoded result struct."""
    return Message(MessageType.REPLY, name, seqid, body).encode()


def value_of(name: str, body: bytes) -> Any:
    """What a whole reply with this encoded result struct returns."""
    data = result(name, body)
    reader = codec.ReplyReader(FUNCTIONS[name], 1)
    assert reader.whole(data)
    return reader.value(data)


DOUBLES = "get_tcp_pose"
TEXTS = "get_last_error"
STRUCTS = "get_eaxis_info"

CLAIMS = {
    "a string of 2 GiB": ("get_robot_version", b"\x0b\x00\x00" + struct.pack("!i", 2**31 - 1)),
    "a string of negative length": ("get_robot_version", b"\x0b\x00\x00" + struct.pack("!i", -1)),
    "2 billion numbers": (DOUBLES, b"\x0f\x00\x00\x04" + struct.pack("!i", 2**31 - 1)),
    "just too many numbers": (DOUBLES, b"\x0f\x00\x00\x04" + struct.pack("!i", MAX_REPLY // 8)),
    "2 billion strings": (TEXTS, b"\x0f\x00\x00\x0b" + struct.pack("!i", 2**31 - 1)),
    "a negative number of strings": (TEXTS, b"\x0f\x00\x00\x0b" + struct.pack("!i", -5)),
    "elements of no type": (TEXTS, b"\x0f\x00\x00\x00" + struct.pack("!i", 2**31 - 1)),
    "elements of another type": (DOUBLES, b"\x0f\x00\x00\x08" + struct.pack("!ii", 1, 7) + b"\x00"),
    "another type": (DOUBLES, b"\x08\x00\x00" + struct.pack("!i", 7) + b"\x00"),
    "another map": (
        "get_files_list",
        b"\x0d\x00\x00\x08\x08" + struct.pack("!iii", 1, 1, 1) + b"\x00",
    ),
    "an unknown field of no type": (DOUBLES, b"\x10\x00\x09" + bytes(9)),
    "an unknown field of endless lists": (
        DOUBLES,
        b"\x0f\x00\x09" + (b"\x0f" + struct.pack("!i", 1)) * 40,
    ),
    "an unknown list of nothing": (
        DOUBLES,
        b"\x0f\x00\x09\x01" + struct.pack("!i", 2**20) + bytes(99),
    ),
}


@for_each("claim", CLAIMS)
def test_what_a_peer_claims_is_neither_waited_nor_allocated_for(claim: str) -> None:
    name, body = CLAIMS[claim]
    with pytest.raises(Malformed):
        codec.ReplyReader(FUNCTIONS[name], 1).whole(result(name, body))


def test_an_empty_list_may_announce_any_type() -> None:
    assert value_of(DOUBLES, b"\x0f\x00\x00\x00" + struct.pack("!i", 0) + b"\x00") == []


def test_unknown_fields_of_every_type_are_passed_over() -> None:
    inner = b"\x0c\x00\x0a" + b"\x02\x00\x01\x01" + b"\x00"
    unknown = (
        b"\x0d\x00\x0b\x0b\x0f" + struct.pack("!i", 1)
        + struct.pack("!i", 1) + b"k" + b"\x0c" + struct.pack("!i", 2) + b"\x00" + b"\x00"
        + b"\x0e\x00\x0c\x06" + struct.pack("!i", 2) + bytes(4)
        + b"\x0a\x00\x0d" + bytes(8)
    )  # fmt: skip
    body = inner + unknown + b"\x08\x00\x00" + struct.pack("!i", 42) + b"\x00"
    data = result("get_global_speed", body)
    for cut in range(len(data)):
        assert not codec.ReplyReader(FUNCTIONS["get_global_speed"], 1).whole(data[:cut])
    assert value_of("get_global_speed", body) == 42


def test_fields_left_out_have_their_zero_values() -> None:
    """A controller with older software sends fewer fields."""
    body = b"\x0c\x00\x00" + b"\x03\x00\x14\x06" + b"\x00" + b"\x00"
    assert value_of("getRobotStatus", body) == rpc.RobotStatus(robotState=6)


@for_each(
    "data, what",
    [
        (b"H", "no reply"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "no reply"),
        (b"\x80\x01\x00\x01\x00\x00\x00\x04", "no reply"),
        (b"\x00\x00\x00\x20\x80\x01\x00\x02", "no reply"),
        (result("get_tcp_speed", b"\x00"), "another function: b'get_tcp_speed"),
        (result(DOUBLES, b"\x00", seqid=2), "another call"),
    ],
)
def test_what_is_no_reply_to_the_call_is_found_by_its_first_bytes(data: bytes, what: str) -> None:
    with pytest.raises(Malformed, match=what):
        codec.ReplyReader(FUNCTIONS[DOUBLES], 1).whole(data)


def test_application_errors() -> None:
    call = Message(MessageType.CALL, "movej2", 9, b"")
    for code, kind in ((1, UnknownFunction), (6, ControllerError)):
        data = exception(call, code, "不行")
        reader = codec.ReplyReader(FUNCTIONS["movej2"], 9)
        assert not reader.whole(data[:-1])
        assert reader.whole(data)
        with pytest.raises(kind, match=r"movej2: .*不行") as raised:
            reader.value(data)
        assert raised.value.code == code


def test_an_application_error_whose_text_is_none_is_no_reply() -> None:
    call = Message(MessageType.EXCEPTION, "movej2", 9, b"\x08\x00\x01\x00\x00\x00\x05\x00")
    with pytest.raises(Malformed, match="message has the type 8"):
        codec.ReplyReader(FUNCTIONS["movej2"], 9).whole(call.encode())


def test_a_reply_without_a_result_is_an_error_and_not_zero() -> None:
    with pytest.raises(ControllerError, match="without a result"):
        value_of("movej2", b"\x00")


def test_text_that_is_not_utf8_is_still_text() -> None:
    bad = "碰撞".encode("gbk")
    body = b"\x0f\x00\x00\x0b" + struct.pack("!ii", 1, len(bad)) + bad + b"\x00"
    assert value_of(TEXTS, body) == ["\\xc5\\xf6ײ"]


def test_text_in_a_struct_that_is_not_utf8_is_still_text() -> None:
    bad = "轨道".encode("gbk")
    name = b"\x0b\x00\x01" + struct.pack("!i", len(bad)) + bad
    (scheme,) = value_of(STRUCTS, b"\x0f\x00\x00\x0c" + struct.pack("!i", 1) + name + b"\x00\x00")
    assert scheme.scheme_name == bad.decode("utf-8", "backslashreplace")


def test_texts_is_known_of_each_result() -> None:
    assert {name for name, function in FUNCTIONS.items() if function.texts} == {
        "get_current_project",
        "get_eaxis_info",
        "get_files_list",
        "get_last_error",
        "get_robot_type",
        "get_robot_version",
        "get_system_value_str",
    }


def test_a_wrong_number_of_arguments_names_the_parameters() -> None:
    with pytest.raises(TypeError, match=r"stop takes 1 arguments \(block\), not 0"):
        codec.encode(FUNCTIONS["stop"], ())


def test_the_scanner_says_where_a_struct_ends_inside_other_bytes() -> None:
    scanner = StructScanner({}, 3)
    assert scanner.whole(b"abc\x00def")
    assert scanner.position == 4
