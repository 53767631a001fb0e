"""Every fault that the proxy can inject into a call, each of them quick."""

from __future__ import annotations

from aioduco._wire.messages import Message, MessageType
from aioduco.testing import (
    ApplicationError,
    Cut,
    Delay,
    DropReply,
    DropRequest,
    Ending,
    Fault,
    Garbage,
    HalfOpen,
    HoldReply,
    Place,
    RepeatReply,
    Throttle,
    WrongKind,
    WrongMethod,
    WrongSeqid,
)

from .calls import NO

#: an answer of the right form to a call that nobody made
STRAY = Message(MessageType.REPLY, "speedj", 7, b"\x08\x00\x00\x00\x00\x00\x2a\x00").encode()

MENU: tuple[Fault, ...] = (
    Delay(request=0.001, reply=0.001, jitter=0.003),
    Delay(request=0.02, jitter=0.01),
    Delay(reply=0.02, jitter=0.01),
    Throttle(rate=50_000),
    Throttle(rate=5_000),
    DropRequest(),
    DropReply(),
    HoldReply(),
    HalfOpen(seconds=0.01),
    *(Cut(place, how) for place in Place for how in Ending),
    *(Cut(place, fraction=part) for place in (Place.IN_REQUEST, Place.IN_REPLY) for part in (0, 1)),
    RepeatReply(),
    RepeatReply(3),
    Garbage(),
    Garbage(b"\x00"),
    Garbage(b"\x80\x01\x00\x02\x7f\xff\xff\xff"),
    Garbage(STRAY),
    Garbage(STRAY, reply=True),
    WrongSeqid(),
    WrongSeqid(1),
    WrongSeqid(2**31),
    WrongMethod("get_system_value_double"),
    WrongMethod("no_such_function"),
    WrongKind(),
    ApplicationError(message=NO),
    ApplicationError(code=1, message=NO),
    ApplicationError(message=NO, forward=True),
)
