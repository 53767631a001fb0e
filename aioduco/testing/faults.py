"""What can go wrong on the wire, as values, and plans that say when.

A fault is placed on one call: the proxy asks its script for each request that arrives. Faults
differ in what the server saw and in what the caller sees; each docstring has both, since a client
must tell "nothing was done" from "it may have been done".
"""

from __future__ import annotations

import enum
import random
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from aioduco.testing.message_parser import Message, MessageType, application_error

__all__ = [
    "ApplicationError",
    "Chaos",
    "Cut",
    "Delay",
    "DropReply",
    "DropRequest",
    "Ending",
    "Fault",
    "Garbage",
    "HalfOpen",
    "HoldReply",
    "Place",
    "Plan",
    "RepeatReply",
    "Script",
    "Throttle",
    "WrongKind",
    "WrongMethod",
    "WrongSeqid",
    "rewritten",
]


class Ending(enum.Enum):
    """How a connection is ended."""

    RESET = "reset"
    """At once, by RST: what lies unsent is thrown away."""
    CLOSE = "close"
    """In order, by FIN, after what was sent."""


class Place(enum.Enum):
    """Where in a call a connection is cut."""

    BEFORE_REQUEST = "before the request"
    """Nothing reaches the server."""
    IN_REQUEST = "in the request"
    """The server gets a part of the request."""
    AFTER_REQUEST = "after the request"
    """The server gets the request; its reply is not waited for."""
    BEFORE_REPLY = "before the reply"
    """The server has replied; the caller gets nothing."""
    IN_REPLY = "in the reply"
    """The caller gets a part of the reply."""
    AFTER_REPLY = "after the reply"
    """The call is whole; the next one finds the connection gone."""


@dataclass(frozen=True, slots=True)
class Delay:
    """Hold the request, the reply, or both back for a time.

    Attributes:
        request: s before the request is passed on.
        reply: s before the reply is passed on.
        jitter: s; up to so much is added to each of the two that is not zero.
    """

    request: float = 0.0
    reply: float = 0.0
    jitter: float = 0.0


@dataclass(frozen=True, slots=True)
class Throttle:
    """Pass the request and the reply on slowly.

    Attributes:
        rate: bytes per second.
    """

    rate: float


@dataclass(frozen=True, slots=True)
class DropRequest:
    """Swallow the request: the server never sees it, the caller gets no reply."""


@dataclass(frozen=True, slots=True)
class DropReply:
    """Swallow the reply: the server has carried the call out, the caller gets no reply."""


@dataclass(frozen=True, slots=True)
class HoldReply:
    """Keep the reply, and send it when the next call is made on the same connection.

    A client that goes on using a connection after a time-out takes it for the next call's.
    """


@dataclass(frozen=True, slots=True)
class HalfOpen:
    """From this request on pass nothing on, in both directions, and keep the sockets.

    Attributes:
        seconds: s until both sides are reset; None for ever.
    """

    seconds: float | None = None


@dataclass(frozen=True, slots=True)
class Cut:
    """End the connection to both sides.

    Attributes:
        at: where in the call.
        how: by a reset or by an orderly close.
        fraction: how much of the message is passed on before, for a cut inside one; at least
            one byte is passed on and at least one is not.
    """

    at: Place
    how: Ending = Ending.RESET
    fraction: float = 0.5


@dataclass(frozen=True, slots=True)
class RepeatReply:
    """Send the reply more than once.

    Attributes:
        times: how many more.
    """

    times: int = 1


@dataclass(frozen=True, slots=True)
class Garbage:
    """Send bytes that are no message in place of the reply.

    Attributes:
        data: the bytes.
        reply: send the reply too, after them.
    """

    data: bytes = b"HTTP/1.1 400 Bad Request\r\n\r\n"
    reply: bool = False


@dataclass(frozen=True, slots=True)
class WrongSeqid:
    """Answer with a sequence id of another call.

    Attributes:
        offset: what is added to the right one.
    """

    offset: int = -1


@dataclass(frozen=True, slots=True)
class WrongMethod:
    """Answer as if another function had been called.

    Attributes:
        name: that function.
    """

    name: str = "get_tcp_pose"


@dataclass(frozen=True, slots=True)
class WrongKind:
    """Answer by a message that is a call."""


@dataclass(frozen=True, slots=True)
class ApplicationError:
    """Answer with a Thrift application error.

    Attributes:
        code: 1 is an unknown method, 6 an internal error.
        message: what went wrong.
        forward: pass the request on to the server all the same.
    """

    code: int = 6
    message: str = "internal error"
    forward: bool = False


Fault = (
    Delay
    | Throttle
    | DropRequest
    | DropReply
    | HoldReply
    | HalfOpen
    | Cut
    | RepeatReply
    | Garbage
    | WrongSeqid
    | WrongMethod
    | WrongKind
    | ApplicationError
)

#: Says for the n-th call since the plan was set, and its method, what is done to it.
Plan = Callable[[int, str], Fault | None]

_SEQID_RANGE: Final = 1 << 32


def rewritten(fault: Fault | None, reply: Message) -> bytes:
    """The bytes that go to the caller in place of a reply.

    Args:
        fault: what is done to the call.
        reply: what the server answered.

    Returns:
        The bytes; those of the reply itself for a fault that does not change it.
    """
    match fault:
        case RepeatReply(times):
            data = reply.encode() * (times + 1)
        case Garbage(noise, also_reply):
            data = noise + (reply.encode() if also_reply else b"")
        case WrongSeqid(offset):
            wrong = (reply.seqid + offset + _SEQID_RANGE // 2) % _SEQID_RANGE - _SEQID_RANGE // 2
            data = replace(reply, seqid=wrong).encode()
        case WrongMethod(name):
            data = replace(reply, name=name).encode()
        case WrongKind():
            data = replace(reply, kind=MessageType.CALL).encode()
        case ApplicationError(code, message):
            data = application_error(reply, code, message).encode()
        case _:
            data = reply.encode()
    return data


class Chaos:
    """A plan that draws faults from a menu; the same seed draws the same ones.

    The draw for a call depends on the seed and on the call's number only, so that a run can be
    repeated as far as the calls come in the same order.
    """

    def __init__(self, seed: int, menu: Sequence[Fault], *, rate: float = 1.0) -> None:
        """Make a plan.

        Args:
            seed: any number.
            menu: what is drawn from, each entry equally often.
            rate: share of the calls that get a fault, 0 to 1.
        """
        self.seed = seed
        self._menu = tuple(menu)
        self._rate = rate

    def __call__(self, index: int, method: str) -> Fault | None:  # noqa: ARG002 - a Plan
        """What is done to the call with this number."""
        draw = random.Random(f"{self.seed}:{index}")
        return draw.choice(self._menu) if draw.random() < self._rate else None


@dataclass(slots=True)
class _Rule:
    fault: Fault
    skip: int
    times: int | None

    def take(self) -> Fault | None:
        if self.skip:
            self.skip -= 1
            return None
        if self.times is not None:
            if not self.times:
                return None
            self.times -= 1
        return self.fault


class Script:
    """What is done to which call. Any thread may change it while calls pass.

    A fault for the call's method comes before one that was queued for the next call, and that
    before the plan.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._queue: deque[Fault] = deque()
        self._rules: dict[str, list[_Rule]] = {}
        self._plan: Plan | None = None
        self._index = 0

    def next(self, *faults: Fault) -> None:
        """Do these to the next calls, one to each, whatever their methods are."""
        with self._lock:
            self._queue.extend(faults)

    def on(self, method: str, fault: Fault, *, times: int | None = 1, skip: int = 0) -> None:
        """Do this to calls of one method.

        Args:
            method: name of the function on the wire.
            fault: what is done.
            times: to how many calls; None for all.
            skip: how many calls of the method pass untouched before.
        """
        with self._lock:
            self._rules.setdefault(method, []).append(_Rule(fault, skip, times))

    def schedule(self, plan: Plan | None) -> None:
        """Let a plan decide on the calls without a fault of their own; None for no plan."""
        with self._lock:
            self._plan = plan
            self._index = 0

    def clear(self) -> None:
        """Remove all faults: calls pass untouched."""
        with self._lock:
            self._queue.clear()
            self._rules.clear()
            self._plan = None

    def decide(self, method: str) -> Fault | None:
        """What is done to a call of this method that arrives now."""
        with self._lock:
            for rule in self._rules.get(method, ()):
                if (fault := rule.take()) is not None:
                    return fault
            if self._queue:
                return self._queue.popleft()
            if self._plan is None:
                return None
            self._index += 1
            return self._plan(self._index - 1, method)
