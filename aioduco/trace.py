"""One hook that sees what happens on the wire: for loggers, recorders and benchmarks.

A hook is any callable that takes a `TraceEvent`. It runs on a thread of its own and gets the events
one after another, in their order, a little later than they happened: `TraceEvent.at` has the time.
What a hook raises is logged. A hook that blocks delays the next events and the log messages of this
package, and never a call or a stop. Events that wait for too slow a hook are dropped beyond 10,000,
and the log says how many. When a robot has been closed, its events have been given to the hook,
unless that takes longer than a second. Nothing is made or called while no hook is set.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

from aioduco.reporting import BackgroundLogger, reporter

__all__ = [
    "CallFinished",
    "ConnectionEnded",
    "ConnectionOpened",
    "Event",
    "ProcedureFinished",
    "Trace",
    "TraceEvent",
    "emit",
    "tell",
]

T = TypeVar("T")

_log = BackgroundLogger(__name__)


@dataclass(frozen=True, slots=True)
class TraceEvent:
    """Something that happened.

    Attributes:
        at: when, in seconds of `time.monotonic()`.
        lane: the lane on which it happened.
    """

    at: float
    lane: str


@dataclass(frozen=True, slots=True)
class CallFinished(TraceEvent):
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
class ConnectionOpened(TraceEvent):
    """A connection to the controller was opened.

    Attributes:
        peer: address and port of the controller.
        duration: seconds that it took.
    """

    peer: tuple[str, int]
    duration: float


@dataclass(frozen=True, slots=True)
class ConnectionEnded(TraceEvent):
    """A connection is not used any more.

    Attributes:
        peer: address and port of the controller.
        reason: why.
    """

    peer: tuple[str, int]
    reason: str


@dataclass(frozen=True, slots=True)
class ProcedureFinished(TraceEvent):
    """A procedure of several calls is over: the arm is ready, or there is an error.

    Attributes:
        name: `bring_up` or `recover`.
        error: what was raised; None if the arm is ready.
        duration: seconds that it took.
    """

    name: str
    error: BaseException | None
    duration: float


#: the former name of `TraceEvent`, for programs that use it
Event = TraceEvent

Trace = Callable[[TraceEvent], None]


def emit(trace: Trace, event: TraceEvent) -> None:
    """Have the hook called with an event; neither what it raises nor how long it takes matters."""
    reporter.put(lambda: _call(trace, event))


def tell(observers: Iterable[Callable[[T], object]], what: T) -> None:
    """Call the package's own observers here and now; what one raises is logged, and no more."""
    for observer in observers:
        try:
            observer(what)
        except Exception:
            _log.exception("an observer failed at %r", what)


def _call(trace: Trace, event: TraceEvent) -> None:
    try:
        trace(event)
    except BaseException:
        # A hook may even try to end its thread, which is not its own.
        _log.exception("the trace hook failed at %r", event)
