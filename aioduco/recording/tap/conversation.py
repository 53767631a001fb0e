"""Decodes calls and answers from the bytes between clients and a controller. No I/O."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco._wire.codec import ReplyReader, decode_arguments
from aioduco._wire.framing import Malformed
from aioduco._wire.idl import functions
from aioduco._wire.messages import Inbox, Message, MessageType
from aioduco.errors import ControllerError
from aioduco.recording.tap.relay import CopyKind

if TYPE_CHECKING:
    from collections.abc import Iterator


class TappedCall(NamedTuple):
    """A call between client and controller that was answered, or cannot be answered any more.

    Attributes:
        connection: number of its connection, from 0 in the order in which clients connected.
        function: its name on the wire.
        arguments: the arguments by name of the parameter; missing ones are left out. For a function
            that the wire does not have: its bytes in hex, as `body`.
        answer: the controller's answer; None if there is none.
        error: the controller's error, or why there is no answer; empty if there is an answer.
        at: arrival of the call's last byte, by `time.monotonic()` [s].
        duration: time until the arrival of the answer's last byte [s]; None without an answer.
    """

    connection: int
    function: str
    arguments: dict[str, Any]
    answer: Any
    error: str
    at: float
    duration: float | None

    def __str__(self) -> str:
        given = ", ".join(f"{name}={value!r}" for name, value in self.arguments.items())
        ended = f"!! {self.error}" if self.error else f"-> {self.answer!r}"
        took = "" if self.duration is None else f"  {1e3 * self.duration:.2f} ms"
        return _printable(f"#{self.connection} {self.function}({given}) {ended}{took}")


class TapNote(NamedTuple):
    """An event of a connection.

    Attributes:
        connection: number of the connection.
        at: time of the event, by `time.monotonic()` [s].
        text: description of the event, for people.
    """

    connection: int
    at: float
    text: str

    def __str__(self) -> str:
        return _printable(f"#{self.connection} {self.text}")


def _printable(text: str) -> str:
    """A text with what either side has sent: controls are spelled out."""
    return "".join(each if each.isprintable() else ascii(each)[1:-1] for each in text)


@dataclass(slots=True)
class _ConnectionState:
    """The unfinished data of one connection."""

    calls: Inbox = field(
        default_factory=lambda: Inbox(frozenset({MessageType.CALL, MessageType.ONEWAY}))
    )
    answers: Inbox = field(
        default_factory=lambda: Inbox(frozenset({MessageType.REPLY, MessageType.EXCEPTION}))
    )
    #: calls without an answer, oldest first, each with its time of arrival
    open: deque[tuple[float, Message]] = field(default_factory=deque)
    #: directions that cannot be decoded any more
    lost: set[CopyKind] = field(default_factory=set)


class Conversation:
    """Decodes the copies of a relay, whatever the bytes are and however they are split.

    An answer belongs to the oldest open call of its connection with its sequence id. If bytes are
    not a message of the wire, their side of the connection is not decoded any more, and a `TapNote`
    reports this.
    """

    def __init__(self) -> None:
        self._states: dict[int, _ConnectionState] = {}

    def feed(
        self, at: float, connection: int, kind: CopyKind, data: bytes
    ) -> Iterator[TappedCall | TapNote]:
        """Process a copy; iterate over the calls and events that it completes.

        Args:
            at: time of the copy, by `time.monotonic()` [s].
            connection: number of the connection.
            kind: kind of the copy.
            data: the bytes.
        """
        state = self._states.setdefault(connection, _ConnectionState())
        if kind in (CopyKind.REQUEST, CopyKind.ANSWER):
            if kind not in state.lost:
                yield from self._decode(state, at, connection, kind, data)
            return
        text = data.decode("utf-8", "backslashreplace")
        if kind is CopyKind.OPENED:
            yield TapNote(connection, at, f"opened by {text}")
        elif kind is CopyKind.MISSED:
            state.lost |= {CopyKind.REQUEST, CopyKind.ANSWER}
            yield TapNote(
                connection, at, f"{text} bytes passed unseen: from here on it is not read"
            )
        else:
            del self._states[connection]
            refused = kind is CopyKind.REFUSED
            end = f"the controller was not reached: {text}" if refused else f"closed by the {text}"
            unread = CopyKind.ANSWER in state.lost
            why = "not known whether it was answered" if unread else "no answer"
            for came, call in state.open:
                yield _tapped(connection, came, call, None, f"{why}: {end}", None)
            yield TapNote(connection, at, end)

    def _decode(
        self, state: _ConnectionState, at: float, connection: int, kind: CopyKind, data: bytes
    ) -> Iterator[TappedCall | TapNote]:
        inbox = state.calls if kind is CopyKind.REQUEST else state.answers
        try:
            for message in inbox.messages(data):
                if kind is CopyKind.ANSWER:
                    yield from _answered(state, at, connection, message)
                elif message.kind is MessageType.ONEWAY:
                    yield _tapped(connection, at, message, None, "", None)
                else:
                    state.open.append((at, message))
        except Malformed as error:
            state.lost.add(kind)
            side = "client" if kind is CopyKind.REQUEST else "controller"
            yield TapNote(
                connection, at, f"the {side} says what is no message, and is not read on: {error}"
            )


def _answered(
    state: _ConnectionState, at: float, connection: int, message: Message
) -> Iterator[TappedCall | TapNote]:
    for index, (came, call) in enumerate(state.open):
        if call.seqid == message.seqid:
            del state.open[index]
            answer, error = _answer(call, message)
            yield _tapped(connection, came, call, answer, error, at - came)
            return
    yield TapNote(connection, at, f"an answer of {message.name} that no call waits for")


def _answer(call: Message, message: Message) -> tuple[Any, str]:
    known = functions()
    if call.name not in known:
        body = message.body.hex()
        return (body, "") if message.kind is MessageType.REPLY else (None, f"error {body}")
    reader = ReplyReader(known[call.name], call.seqid)
    data = message.encode()
    try:
        if not reader.whole(data):
            return None, "an answer that is cut off"
        return reader.value(data), ""
    except ControllerError as error:
        return None, str(error)
    except Malformed as error:
        return None, f"an answer that is none: {error}"


def _tapped(
    connection: int, at: float, call: Message, answer: Any, error: str, duration: float | None
) -> TappedCall:
    known = functions()
    if call.name in known:
        arguments = decode_arguments(known[call.name], call.body)
    else:
        arguments = {"body": call.body.hex()}
    return TappedCall(connection, call.name, arguments, answer, error, at, duration)
