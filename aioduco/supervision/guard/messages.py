"""Messages between a program and its guard: one message, one packet.

They are sent over a pair of SOCK_SEQPACKET sockets. A packet is sent whole or not at all, so any
thread, and a signal handler in the middle of another send, may send without a lock. Times are
those of CLOCK_MONOTONIC, which is the same for all processes of a machine.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence

#: buffer size [bytes], larger than any message
MAX_PACKET: Final = 8192
#: maximum number of characters of a text in a message
_TEXT: Final = 2000


class Watch(NamedTuple):
    """Program to guard: take over a robot's heartbeat, and its stop when the program ends.

    Answered by `Done`.

    Attributes:
        robot: the program's number for the robot.
        token: number that is repeated in the answer.
        host: name or address of the controller.
        port: its TCP port.
        heartbeat: heartbeat time [s]; None for no heartbeat.
        stall_limit: seconds without `Alive` after which no beat is sent.
        connect_timeout: maximum seconds for opening a connection.
        call_timeout: maximum seconds for a call.
    """

    robot: int
    token: int
    host: str
    port: int
    heartbeat: float | None
    stall_limit: float
    connect_timeout: float
    call_timeout: float


class Alive(NamedTuple):
    """Program to guard: the event loop of a robot ran at `stamp`.

    Attributes:
        robot: the program's number for the robot.
        stamp: its last keep-alive that counts [s of `boot_time`].
        moves: whether the program may be moving the arm; sent before anything that moves it.
        modes: of each mode that the program has entered, the function of the wire that ends it,
            and its arguments.
    """

    robot: int
    stamp: float
    moves: bool
    modes: Sequence[Any] = ()


class Rearm(NamedTuple):
    """Program to guard: beat again after a stall of the event loop."""

    robot: int


class Release(NamedTuple):
    """Program to guard: the arm stands, stop supervising it. Answered by `Done`."""

    robot: int
    token: int


class Done(NamedTuple):
    """Guard to program: the result of a request.

    Attributes:
        token: that of the request.
        error: why it failed; empty if it went well.
    """

    token: int
    error: str


class Beat(NamedTuple):
    """Guard to program: state and statistics of a heartbeat, and why the last beat was lost.

    `sent` is when the last beat that was answered was sent [s of `boot_time`].
    """

    robot: int
    state: str
    beats: int
    missed: int
    losses: int
    stalls: int
    longest_gap: float
    error: str
    lapsed: bool
    sent: float


class LogMessage(NamedTuple):
    """Guard to program: a log message of the guard, for the program's log.

    Attributes:
        level: as the levels of `logging`.
        text: the message.
    """

    level: int
    text: str


Message: TypeAlias = Watch | Alive | Rearm | Release | Done | Beat | LogMessage

_KINDS: Final = {
    kind.__name__: kind for kind in (Watch, Alive, Rearm, Release, Done, Beat, LogMessage)
}


def pack(message: Message) -> bytes:
    """Encode a message as a packet."""
    return json.dumps([type(message).__name__, *message]).encode()


def unpack(packet: bytes) -> Message:
    """Decode the message in a packet.

    Raises:
        ValueError: the packet is not one of these messages.
    """
    try:
        name, *fields = json.loads(packet)
        message: Message = _KINDS[name](*fields)
    except (TypeError, KeyError, ValueError) as exc:
        raise ValueError(f"{packet[:80]!r} is no message of a guard") from exc
    return message


def shortened(text: str) -> str:
    """Shorten a text so that it fits into a message."""
    return text if len(text) <= _TEXT else text[: _TEXT - 3] + "..."
