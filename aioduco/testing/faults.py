"""Faults on the wire, as values, and plans that choose the calls that get them.

A fault applies to one call: for each request that arrives, the proxy asks its script. Faults differ
in what the server receives and in what the caller receives. Each docstring says both, since a
client must distinguish "nothing was done" from "it may have been done".
"""

from __future__ import annotations

import enum
import random
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from aioduco._process.copying import Uncopied
from aioduco._wire import idl
from aioduco._wire.messages import Message, MessageType, application_error
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.rules import Integer, Number, stored
from aioduco.models.similar import did_you_mean

_SEQID_RANGE: Final = 1 << 32
_SHARE: Final = Number(0.0, 1.0, source="this package")
_TIMES: Final = Integer(0, 2**31 - 1, source="this package")


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
        request: seconds before the request is forwarded.
        reply: seconds before the reply is forwarded.
        jitter: seconds; up to this time is added to each of the two that is not zero.
    """

    request: float = 0.0
    reply: float = 0.0
    jitter: float = 0.0

    def __post_init__(self) -> None:
        stored(self, request=ranges.WAIT, reply=ranges.WAIT, jitter=ranges.WAIT)


@dataclass(frozen=True, slots=True)
class Throttle:
    """Forward the request and the reply slowly.

    Attributes:
        rate: bytes per second.
    """

    rate: float

    def __post_init__(self) -> None:
        stored(self, rate=ranges.ABOVE)


@dataclass(frozen=True, slots=True)
class DropRequest:
    """Drop the request: the server never receives it, the caller gets no reply."""


@dataclass(frozen=True, slots=True)
class DropReply:
    """Drop the reply: the server has carried out the call, the caller gets no reply."""


@dataclass(frozen=True, slots=True)
class HoldReply:
    """Keep the reply, and send it when the next call is made on the same connection.

    A client that continues to use a connection after a time-out takes it for the reply to its next
    call.
    """


@dataclass(frozen=True, slots=True)
class HalfOpen:
    """From this request on forward nothing in either direction, but keep the sockets open.

    Attributes:
        seconds: seconds until both sides are reset; None for never.
    """

    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.seconds is not None:
            stored(self, seconds=ranges.WAIT)


@dataclass(frozen=True, slots=True)
class Cut:
    """End the connection to both sides.

    Attributes:
        at: where in the call.
        how: by a reset or by an orderly close.
        fraction: share of the message that is forwarded before a cut inside it; at least one
            byte is forwarded and at least one is not.
    """

    at: Place
    how: Ending = Ending.RESET
    fraction: float = 0.5

    def __post_init__(self) -> None:
        stored(self, fraction=_SHARE)
        if not isinstance(self.at, Place):
            raise ParameterError("at", self.at, "a Place")
        if not isinstance(self.how, Ending):
            raise ParameterError("how", self.how, "an Ending")


@dataclass(frozen=True, slots=True)
class RepeatReply:
    """Send the reply more than once.

    Attributes:
        times: number of repetitions.
    """

    times: int = 1

    def __post_init__(self) -> None:
        stored(self, times=_TIMES)


@dataclass(frozen=True, slots=True)
class Garbage:
    """Send bytes that are not a message in place of the reply.

    Attributes:
        data: the bytes.
        reply: whether the reply is sent after them.
    """

    data: bytes = b"HTTP/1.1 400 Bad Request\r\n\r\n"
    reply: bool = False


@dataclass(frozen=True, slots=True)
class WrongSeqid:
    """Answer with the sequence id of another call.

    Attributes:
        offset: number that is added to the right id.
    """

    offset: int = -1

    def __post_init__(self) -> None:
        stored(self, offset=Integer(1 - _SEQID_RANGE, _SEQID_RANGE - 1, source="this package"))


@dataclass(frozen=True, slots=True)
class WrongMethod:
    """Answer as if another function had been called.

    Attributes:
        name: name of that function.
    """

    name: str = "get_tcp_pose"


@dataclass(frozen=True, slots=True)
class WrongKind:
    """Answer with a message of the type of a call."""


@dataclass(frozen=True, slots=True)
class ApplicationError:
    """Answer with a Thrift application error.

    Attributes:
        code: 1 is an unknown method, 6 an internal error.
        message: text of the error.
        forward: whether the request is forwarded to the server all the same.
    """

    code: int = 6
    message: str = "internal error"
    forward: bool = False

    def __post_init__(self) -> None:
        stored(self, code=ranges.INT_32, message=ranges.TEXT, forward=ranges.FLAG)


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

#: Returns the fault for the n-th call since the plan was set, from n and the call's method.
Plan = Callable[[int, str], Fault | None]


def _fault(given: object) -> Fault:
    if not isinstance(given, Fault):
        raise ParameterError("fault", given, "a fault, such as Cut(Place.BEFORE_REPLY)")
    return given


def rewritten(fault: Fault | None, reply: Message) -> bytes:
    """Make the bytes that are sent to the caller in place of a reply.

    Args:
        fault: the fault of the call.
        reply: the server's reply.

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

    The draw for a call depends only on the seed and on the call's number. So a run can be repeated
    as long as the calls come in the same order.
    """

    def __init__(self, seed: int, menu: Sequence[Fault], *, rate: float = 1.0) -> None:
        """Make a plan.

        Args:
            seed: any number.
            menu: faults to draw from, each equally often.
            rate: share of the calls that get a fault, 0 to 1.

        Raises:
            ParameterError: the menu has no fault, or something else; or the rate is out of range.
        """
        if not isinstance(menu, Sequence) or not menu:
            raise ParameterError("menu", menu, "a list with a fault or more")
        self.seed = seed
        self._menu = tuple(map(_fault, menu))
        self._rate = _SHARE("rate", rate)

    def __call__(self, index: int, method: str) -> Fault | None:  # noqa: ARG002 - a Plan
        """Draw the fault for the call with this number; None for no fault."""
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


class Script(Uncopied):
    """Chooses the fault for each call. Any thread may change it while calls pass.

    A fault for the call's method takes precedence over one that was queued for the next call, and
    that over the plan.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._queue: deque[Fault] = deque()
        self._rules: dict[str, list[_Rule]] = {}
        self._plan: Plan | None = None
        self._index = 0

    def next(self, *faults: Fault) -> None:
        """Apply these faults to the next calls, one to each, whatever their methods are."""
        checked = [*map(_fault, faults)]
        with self._lock:
            self._queue.extend(checked)

    def on(self, method: str, fault: Fault, *, times: int | None = 1, skip: int = 0) -> None:
        """Apply a fault to calls of one method.

        Args:
            method: name of the function on the wire.
            fault: the fault.
            times: number of calls to which it is applied; None for all.
            skip: number of calls of the method that pass unchanged before.

        Raises:
            ParameterError: there is no such function or fault, or a number is out of range.
        """
        known = idl.names()
        if method not in known:
            expected = f"a function of the wire{did_you_mean(str(method), known)}"
            raise ParameterError("method", method, expected)
        rule = _Rule(
            _fault(fault), _TIMES("skip", skip), None if times is None else _TIMES("times", times)
        )
        with self._lock:
            self._rules.setdefault(method, []).append(rule)

    def schedule(self, plan: Plan | None) -> None:
        """Let a plan decide on the calls without a fault of their own; None for no plan."""
        with self._lock:
            self._plan = plan
            self._index = 0

    def clear(self) -> None:
        """Remove all faults: calls pass unchanged."""
        with self._lock:
            self._queue.clear()
            self._rules.clear()
            self._plan = None

    def decide(self, method: str) -> Fault | None:
        """Choose the fault for a call of this method that arrives now; None for no fault."""
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
