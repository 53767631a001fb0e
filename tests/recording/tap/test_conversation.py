"""Calls and answers from bytes that passed, however they are split."""

from __future__ import annotations

from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco._wire.codec import encode, message
from aioduco._wire.idl import functions
from aioduco._wire.messages import Message, MessageType, application_error
from aioduco.recording.tap.conversation import Conversation, TapNote, TappedCall
from aioduco.recording.tap.relay import CopyKind

REQUEST, ANSWER = CopyKind.REQUEST, CopyKind.ANSWER


def call(name: str, seqid: int, *args: object) -> bytes:
    function = functions()[name]
    return message(function, seqid, encode(function, args))


def answer(name: str, seqid: int, state: bytes = b"\x08\x00\x00\x00\x00\x03\xe8\x00") -> bytes:
    return Message(MessageType.REPLY, name, seqid, state).encode()


def items(*copies: tuple[float, CopyKind, bytes]) -> list[TappedCall | TapNote]:
    conversation = Conversation()
    return [item for at, kind, data in copies for item in conversation.feed(at, 0, kind, data)]


def test_a_call_is_told_with_its_answer_and_its_time() -> None:
    (found,) = items(
        (1.0, REQUEST, call("power_on", 7, False)), (1.25, ANSWER, answer("power_on", 7))
    )
    assert found == TappedCall(0, "power_on", {"block": False}, 1000, "", 1.0, 0.25)
    assert str(found) == "#0 power_on(block=False) -> 1000  250.00 ms"


@given(cuts=st.lists(st.integers(0, 400), max_size=12).map(sorted), count=st.integers(1, 4))
def test_however_the_bytes_are_cut_the_same_is_told(cuts: list[int], count: int) -> None:
    said = b"".join(call("get_noneblock_taskstate", n, 1000 + n) for n in range(count))
    told = b"".join(answer("get_noneblock_taskstate", n) for n in reversed(range(count)))
    copies = [
        (1.0, kind, data[begin:end])
        for kind, data in ((REQUEST, said), (ANSWER, told))
        for begin, end in zip([0, *cuts], [*cuts, len(data)], strict=True)
    ]
    found = [item for item in items(*copies) if isinstance(item, TappedCall)]
    assert [(each.arguments, each.answer) for each in found] == [
        ({"id": 1000 + n}, 1000) for n in reversed(range(count))
    ]


def test_of_equal_numbers_the_oldest_call_is_answered() -> None:
    """As the vendor's client numbers them: all 0."""
    found = items(
        (1.0, REQUEST, call("power_on", 0, True)),
        (2.0, REQUEST, call("enable", 0, True)),
        (3.0, ANSWER, answer("power_on", 0)),
    )
    assert [item.function for item in found if isinstance(item, TappedCall)] == ["power_on"]


def test_what_the_controller_says_instead_of_an_answer_is_its_error() -> None:
    said = Message(MessageType.CALL, "power_on", 3, b"\0")
    (found,) = items(
        (1.0, REQUEST, said.encode()), (2.0, ANSWER, application_error(said, 6, "no!").encode())
    )
    assert isinstance(found, TappedCall)
    assert found.answer is None
    assert "no!" in found.error


def test_a_function_that_the_wire_does_not_have_has_its_bytes() -> None:
    (found,) = items(
        (1.0, REQUEST, Message(MessageType.CALL, "fly", 3, b"\0").encode()),
        (2.0, ANSWER, answer("fly", 3)),
    )
    assert isinstance(found, TappedCall)
    assert (found.arguments, found.answer) == ({"body": "00"}, "080000000003e800")


@for_each(
    "body, error", [(b"\x0b\x00\x00\x00\x00\x00\x01A\x00", "none"), (b"\0", "without a result")]
)
def test_an_answer_that_is_none_is_said(body: bytes, error: str) -> None:
    (found,) = items(
        (1.0, REQUEST, call("power_on", 3, True)), (2.0, ANSWER, answer("power_on", 3, body))
    )
    assert isinstance(found, TappedCall)
    assert error in found.error
    assert found.duration == 1.0


def test_a_call_without_an_answer_is_told_when_its_connection_ends() -> None:
    opened, lost, closed = items(
        (1.0, CopyKind.OPENED, b"127.0.0.1:5"),
        (2.0, REQUEST, call("power_on", 3, True)),
        (3.0, CopyKind.CLOSED, b"controller"),
    )
    assert opened == TapNote(0, 1.0, "opened by 127.0.0.1:5")
    assert isinstance(lost, TappedCall)
    assert (lost.error, lost.duration) == ("no answer: closed by the controller", None)
    assert closed == TapNote(0, 3.0, "closed by the controller")


def test_a_controller_that_is_not_reached() -> None:
    assert items((1.0, CopyKind.REFUSED, b"Connection refused")) == [
        TapNote(0, 1.0, "the controller was not reached: Connection refused")
    ]


def test_an_answer_without_a_call_is_said() -> None:
    (note,) = items((1.0, ANSWER, answer("power_on", 3)))
    assert note == TapNote(0, 1.0, "an answer of power_on that no call waits for")


def test_names_of_the_wire_control_no_terminal() -> None:
    lost = Message(MessageType.CALL, "go\x1b[2J", 1, b"\x00").encode()
    stray = Message(MessageType.REPLY, "\x00", 7, b"\x00").encode()
    found = items((1.0, REQUEST, lost), (2.0, ANSWER, stray), (3.0, CopyKind.CLOSED, b"client"))
    assert [str(each) for each in found] == [
        r"#0 an answer of \x00 that no call waits for",
        r"#0 go\x1b[2J(body='00') !! no answer: closed by the client",
        "#0 closed by the client",
    ]


def test_bytes_that_are_no_message_end_what_is_read_of_their_side() -> None:
    found = items(
        (1.0, REQUEST, call("power_on", 3, True)),
        (2.0, REQUEST, b"GET / HTTP/1.1\r\n"),
        (3.0, REQUEST, call("power_on", 4, True)),
        (4.0, ANSWER, answer("power_on", 3)),
    )
    note, told = found
    assert isinstance(note, TapNote)
    assert "the client says what is no message" in note.text
    assert isinstance(told, TappedCall)


def test_copies_that_were_left_out_end_what_is_read() -> None:
    (note,) = items((1.0, CopyKind.MISSED, b"70000"), (2.0, REQUEST, call("power_on", 3, True)))
    assert isinstance(note, TapNote)
    assert note.text.startswith("70000 bytes passed unseen")


@for_each("copy", [(CopyKind.MISSED, b"70000"), (ANSWER, b"HTTP/1.1 200 OK\r\n")])
def test_of_a_call_whose_answer_is_not_read_it_is_not_said_that_there_is_none(
    copy: tuple[CopyKind, bytes],
) -> None:
    begun, ended = (1.0, REQUEST, call("power_on", 3, True)), (4.0, CopyKind.CLOSED, b"client")
    _, told, _ = items(begun, (2.0, *copy), (3.0, ANSWER, answer("power_on", 3)), ended)
    assert isinstance(told, TappedCall)
    assert told.error == "not known whether it was answered: closed by the client"


@given(
    name=st.sampled_from(sorted(functions())),
    body=st.binary(max_size=60),
    reply=st.binary(max_size=60),
)
def test_any_bodies_of_a_function_are_taken(name: str, body: bytes, reply: bytes) -> None:
    said = Message(MessageType.CALL, name, 1, body + b"\0").encode()
    told = Message(MessageType.REPLY, name, 1, reply + b"\0").encode()
    items((1.0, REQUEST, said), (2.0, ANSWER, told), (3.0, CopyKind.CLOSED, b"client"))


CALLS = (call("power_on", 7, False), answer("power_on", 7))
kinds = st.sampled_from((CopyKind.REQUEST, CopyKind.ANSWER))


@st.composite
def nearly_right(draw: st.DrawFn) -> bytes:
    """A message of which some bytes are others."""
    data = bytearray(draw(st.sampled_from(CALLS)))
    for at, value in draw(
        st.lists(st.tuples(st.integers(0, len(data) - 1), st.integers(0, 255)), max_size=6)
    ):
        data[at] = value
    return bytes(data[: draw(st.integers(0, len(data)))])


@given(
    st.lists(
        st.tuples(st.integers(0, 3), kinds, st.binary(max_size=200) | nearly_right()), max_size=20
    )
)
def test_whatever_bytes_pass_on_some_connections_another_one_is_told(
    copies: list[tuple[int, CopyKind, bytes]],
) -> None:
    conversation = Conversation()
    for connection, kind, data in copies:
        for item in conversation.feed(1.0, connection, kind, data):
            assert isinstance(item, TappedCall | TapNote)
            assert str(item).isprintable()
    (told,) = [
        item
        for kind, data in zip((CopyKind.REQUEST, CopyKind.ANSWER), CALLS, strict=True)
        for item in conversation.feed(2.0, 9, kind, data)
    ]
    assert isinstance(told, TappedCall)
    assert told.answer == 1000
    for connection in range(10):
        for item in conversation.feed(3.0, connection, CopyKind.CLOSED, b"\xff\x1b[2J"):
            assert isinstance(item, TappedCall | TapNote)
