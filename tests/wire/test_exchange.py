"""Calls of one connection, and the bytes of their answers, however these are split."""

from __future__ import annotations

from for_each import for_each

from aioduco._wire import codec, idl
from aioduco._wire.messages import Inbox

from .servers import exception, reply

FUNCTIONS = idl.functions()
NAMES = ("get_tcp_pose", "get_robot_version", "robotmoving")
NOTHING = b"\x00"


@for_each("size", [1, 7, 10_000])
def test_answers_to_a_batch_are_told_apart_in_one_piece_and_in_many(size: int) -> None:
    exchange = codec.Exchange(lambda: 1.5)
    further = [(FUNCTIONS[name], NOTHING) for name in NAMES[1:]]
    calls = [*Inbox().messages(exchange.begin(FUNCTIONS[NAMES[0]], NOTHING, further))]
    assert [call.name for call in calls] == [*NAMES]
    data = reply(calls[0], [0.5] * 6) + exception(calls[1], 6, "busy") + reply(calls[2], True)
    pieces = [data[at : at + size] for at in range(0, len(data), size)]
    for piece in pieces[:-1]:
        assert not exchange.receive(piece)
        assert exchange.expects
    assert exchange.receive(pieces[-1])
    assert not exchange.expects
    assert not exchange.surplus
    pose, version, moving = exchange.take().value
    assert (pose.value, moving.value, pose.at) == ([0.5] * 6, True, 1.5)
    assert "busy" in str(version.error)


def test_bytes_behind_the_last_answer_are_surplus() -> None:
    exchange = codec.Exchange(lambda: 0.0)
    (call,) = Inbox().messages(exchange.begin(FUNCTIONS["robotmoving"], NOTHING))
    assert exchange.receive(reply(call, True) + b"\x00")
    assert exchange.surplus


def test_what_is_forgotten_is_not_expected() -> None:
    exchange = codec.Exchange(lambda: 0.0)
    exchange.begin(FUNCTIONS["robotmoving"], NOTHING)
    exchange.forget()
    assert not exchange.expects


def test_no_two_connections_begin_with_the_same_number() -> None:
    first = set()
    for _ in range(3):
        message = codec.Exchange(lambda: 0.0).begin(FUNCTIONS["robotmoving"], NOTHING)
        first |= {each.seqid for each in Inbox().messages(message)}
    assert max(first) > 1_000
    assert len(first) == 3
