"""Whatever passes a tap, it goes on, and the calls before it are told."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from aioduco.recording.tap.conversation import Conversation, TapNote, TappedCall
from aioduco.recording.tap.relay import CopyKind

from .test_conversation import answer, call

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
