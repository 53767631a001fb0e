"""A hook that observes the calls on the wire: for loggers, recorders and benchmarks.

A hook is any callable that takes a `TraceEvent`. It runs on a separate thread and gets the events
one after another, in their order, shortly after they happened: `TraceEvent.at` has the time. It
gets the context variables of the call's caller, such as the current span of OpenTelemetry. The
first exception of a hook is logged, with its traceback. A hook that blocks delays the next events
and the log messages of this package, but never a call or a stop. If a hook is too slow, up to
10,000 events wait; further ones are dropped, and the log says how many. When a robot has been
closed, the hook has got all of its events, unless that takes longer than a second. While no hook is
set, no events are made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

from aioduco._process.reporting import BackgroundLogger, reporter

__all__ = [
    "CallFinished",
    "ConnectionEnded",
    "ConnectionOpened",
    "ProcedureFinished",
    "Trace",
    "TraceEvent",
    "emit",
    "guarded",
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
    """A call has ended: with an answer, with an error, or by a cancellation.

    Attributes:
        function: the function of the wire.
        arguments: its arguments, in the order of the wire.
        result: the answer; None after an error.
        error: the exception, also a cancellation; None after an answer.
        duration: seconds from the start of the call, the wait for a connection included.
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
        reason: why it ended.
    """

    peer: tuple[str, int]
    reason: str


@dataclass(frozen=True, slots=True)
class ProcedureFinished(TraceEvent):
    """A procedure of several calls has ended: the arm is ready, or there is an error.

    Attributes:
        name: `bring_up` or `recover`.
        error: the exception; None if the arm is ready.
        duration: seconds that it took.
    """

    name: str
    error: BaseException | None
    duration: float


Trace = Callable[[TraceEvent], None]


def guarded(trace: Trace) -> Trace:
    """The hook without its exceptions, of which the first is logged: there are many events."""
    failed = False

    def call(event: TraceEvent) -> None:
        nonlocal failed
        try:
            trace(event)
        except BaseException:
            # A hook may even try to end the thread, which others need.
            if not failed:
                _log.exception(
                    "the trace hook failed at %r; should it fail again, that is not logged", event
                )
            failed = True

    return call


def emit(trace: Trace, event: TraceEvent) -> None:
    """Queue a call of a guarded hook with an event; its duration does no harm."""
    reporter.put(lambda: trace(event))


def tell(observers: Iterable[Callable[[T], object]], what: T) -> None:
    """Call the package's own observers at once; an exception of an observer is only logged."""
    for observer in observers:
        try:
            observer(what)
        except Exception:
            _log.exception("an observer failed at %r", what)
