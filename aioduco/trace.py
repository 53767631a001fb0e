"""One hook that sees what happens on the wire: for loggers, recorders and benchmarks.

A hook is any callable that takes an `Event`. It is called on the thread on which the event
happened, so it must be quick and safe to call from several threads. Nothing is made or called
while no hook is set.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["CallFinished", "ConnectionEnded", "ConnectionOpened", "Event", "Trace", "emit"]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened.

    Attributes:
        at: when, in seconds of `time.monotonic()`.
        lane: the lane on which it happened.
    """

    at: float
    lane: str


@dataclass(frozen=True, slots=True)
class CallFinished(Event):
    """A call is over: it has its answer, or an error, or was cancelled.

    Attributes:
        function: the function of the wire.
        arguments: what was given, in the order of the wire.
        result: what was answered; None after an error.
        error: what was raised, the cancellation included; None after an answer.
        duration: seconds from the begin of the call, waiting for a connection included.
    """

    function: str
    arguments: tuple[Any, ...]
    result: Any
    error: BaseException | None
    duration: float


@dataclass(frozen=True, slots=True)
class ConnectionOpened(Event):
    """A connection to the controller was opened.

    Attributes:
        peer: address and port of the controller.
        duration: seconds that it took.
    """

    peer: tuple[str, int]
    duration: float


@dataclass(frozen=True, slots=True)
class ConnectionEnded(Event):
    """A connection is not used any more.

    Attributes:
        peer: address and port of the controller.
        reason: why.
    """

    peer: tuple[str, int]
    reason: str


Trace = Callable[[Event], None]


def emit(trace: Trace, event: Event) -> None:
    """Call the hook; what it raises is logged, and never disturbs a call."""
    try:
        trace(event)
    except Exception:
        logging.getLogger(__name__).exception("the trace hook failed at %r", event)
