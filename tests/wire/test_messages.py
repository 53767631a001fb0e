"""Messages are found in a stream as thriftpy2 encodes them, however the stream is cut.

What is no message is refused: `tests/sim/test_message.py` and `test_framing.py`.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from thriftpy2.protocol import binary
from thriftpy2.thrift import TApplicationException, TMessageType, TType
from thriftpy2.transport import memory

from aioduco._wire import idl
from aioduco._wire.messages import Inbox, Message, MessageType, application_error

#: the encoder in pure Python, which has no types of its own
TBinaryProtocol: Any = binary.TBinaryProtocol
TMemoryBuffer: Any = memory.TMemoryBuffer

INT32 = st.integers(-(2**31), 2**31 - 1)
SCALARS: dict[int, st.SearchStrategy[Any]] = {
    TType.BOOL: st.booleans(),
    TType.BYTE: st.integers(-128, 127),
    TType.I16: st.integers(-(2**15), 2**15 - 1),
    TType.I32: INT32,
    TType.I64: st.integers(-(2**63), 2**63 - 1),
    TType.DOUBLE: st.floats(allow_nan=False),
    TType.STRING: st.text(max_size=20),
}


def values(kind: int, extra: Any, *, whole: bool = False) -> st.SearchStrategy[Any]:
    """Values of one type, given as thriftpy2 writes it in a field's spec.

    Args:
        kind: the type.
        extra: what it is made of.
        whole: whether structs have all of their fields.
    """
    if kind in SCALARS:
        return SCALARS[kind]
    if kind == TType.STRUCT:
        return structs(extra, whole=whole)
    if kind == TType.MAP:
        key, value = (values(*parts(part), whole=whole) for part in extra)
        return st.dictionaries(key, value, max_size=4)
    return st.lists(values(*parts(extra), whole=whole), max_size=4)


def parts(spec: Any) -> tuple[int, Any]:
    """The type of an element, and what that is made of."""
    return spec if isinstance(spec, tuple) else (spec, None)


@st.composite
def structs(draw: st.DrawFn, made: type[Any], *, whole: bool = False) -> Any:
    """A struct of which each field may be left out."""
    struct = made()
    for entry in made.thrift_spec.values():
        kind, name, extra = entry[0], entry[1], entry[2] if len(entry) > 3 else None
        value = values(kind, extra, whole=whole)
        setattr(struct, name, draw(value if whole else st.none() | value))
    return struct


@st.composite
def messages(draw: st.DrawFn) -> tuple[Message, bytes]:
    """A message of the wire, and how thriftpy2 encodes it."""
    function = draw(st.sampled_from(sorted(idl.functions().values(), key=lambda f: f.name)))
    kind = draw(st.sampled_from([MessageType.CALL, MessageType.REPLY]))
    seqid = draw(INT32)
    body = draw(structs(function.args if kind is MessageType.CALL else function.result))
    whole, alone = TMemoryBuffer(), TMemoryBuffer()
    protocol = TBinaryProtocol(whole)
    protocol.write_message_begin(function.name, int(kind), seqid)
    protocol.write_struct(body)
    TBinaryProtocol(alone).write_struct(body)
    return Message(kind, function.name, seqid, alone.getvalue()), whole.getvalue()


@st.composite
def cut(draw: st.DrawFn, stream: bytes) -> list[bytes]:
    places = sorted(draw(st.lists(st.integers(0, len(stream)), max_size=30)))
    return [stream[a:b] for a, b in zip([0, *places], [*places, len(stream)], strict=True)]


@given(st.data(), st.lists(messages(), min_size=1, max_size=4))
def test_finds_the_messages_that_were_encoded(
    data: st.DataObject, sent: list[tuple[Message, bytes]]
) -> None:
    inbox = Inbox()
    found: list[Message] = []
    for piece in data.draw(cut(b"".join(encoded for _, encoded in sent))):
        found += inbox.messages(piece)
    assert found == [message for message, _ in sent]
    assert inbox.pending == b""


@given(messages())
def test_gives_a_message_with_its_last_byte_and_not_before(sent: tuple[Message, bytes]) -> None:
    message, encoded = sent
    inbox = Inbox()
    for at in range(len(encoded) - 1):
        assert not [*inbox.messages(encoded[at : at + 1])]
    assert inbox.pending == encoded[:-1]
    assert [*inbox.messages(encoded[-1:])] == [message]


@given(messages())
def test_a_message_encodes_to_the_bytes_it_was_found_in(sent: tuple[Message, bytes]) -> None:
    message, encoded = sent
    assert message.encode() == encoded


def maps(keys: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.dictionaries(keys, st.lists(st.text(max_size=3), max_size=3), max_size=3)


@given(maps(st.text(max_size=3)))
def test_gets_past_maps_of_values_of_no_fixed_size(value: dict[str, list[str]]) -> None:
    spec = {
        1: (TType.MAP, "m", (TType.STRING, (TType.LIST, TType.STRING)), False),
        2: (TType.MAP, "n", (TType.I16, TType.DOUBLE), False),
    }
    struct = SimpleNamespace(thrift_spec=spec, m=value, n=dict.fromkeys(range(len(value)), 0.5))
    out = TMemoryBuffer()
    protocol = TBinaryProtocol(out)
    protocol.write_message_begin("f", TMessageType.CALL, 7)
    protocol.write_struct(struct)
    (found,) = Inbox().messages(out.getvalue())
    assert found.encode() == out.getvalue()


def test_an_application_error_is_what_thriftpy2_reads() -> None:
    error = application_error(Message(MessageType.CALL, "movej2", 9, b"\x00"), 6, "not today")
    protocol = TBinaryProtocol(TMemoryBuffer(error.encode()))
    assert protocol.read_message_begin() == ("movej2", TMessageType.EXCEPTION, 9)
    raised = TApplicationException()
    protocol.read_struct(raised)
    assert (raised.type, raised.message) == (6, "not today")
    assert [*Inbox().messages(error.encode())] == [error]
