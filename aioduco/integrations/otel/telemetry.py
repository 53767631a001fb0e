"""Spans and metrics from the trace hook and the events of a robot."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import AsyncIterator, Collection, Iterable
from contextlib import asynccontextmanager
from inspect import signature
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import anyio
from opentelemetry import metrics, trace
from opentelemetry.context import Context
from opentelemetry.trace import Span, SpanKind, StatusCode, TracerProvider

import aioduco
from aioduco import ParameterError, Robot, RobotStateError, TaskState, events
from aioduco._process.copying import Uncopied
from aioduco._process.reporting import reporter
from aioduco.models.trace import CallFinished, ConnectionOpened, ProcedureFinished, TraceEvent
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from opentelemetry.metrics import CallbackOptions, MeterProvider, Observation

    from aioduco import StreamStatistics, Subscription


_NAME: Final = "aioduco"
#: lanes whose calls are reported
_LANES: Final = ("stop", "control", "poll", "motion", "feed", "call", "blocking")
#: lanes of which no call is the program's: they belong to no span of it
_OF_THE_PACKAGE: Final = ("poll", "feed")
#: the lanes on which motions are started, the second by calls that are answered at their end, and
#: the function that polls their state
_MOTIONS: Final = ("motion", "blocking")
_ASK: Final = "get_noneblock_taskstate"
#: in place of the id of a task of which only the end was told
_END: Final = 0


def _buckets(*bounds: float) -> dict[str, Any]:
    """Advice for the buckets of a histogram [s]; the SDK's own are made for milliseconds."""
    return {"explicit_bucket_boundaries_advisory": bounds} if _TAKES_ADVICE else {}


#: whether the interface of OpenTelemetry takes advice for buckets; it does from 1.30 on
_TAKES_ADVICE: Final = (
    "explicit_bucket_boundaries_advisory" in signature(metrics.Meter.create_histogram).parameters
)
_TICKS: Final = _buckets(1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0)
_CALLS: Final = _buckets(
    5e-4, 1e-3, 2.5e-3, 5e-3, 1e-2, 2.5e-2, 5e-2, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0
)
_MOTION_TIMES: Final = _buckets(0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 25.0, 50.0, 100.0, 250.0)


#: ends of a motion that are errors, and their descriptions
_BAD_ENDS: Final = {
    "error": "the controller ended the motion with an error",
    "illegal": "the motion is not allowed in the state that the robot was in",
    "parameter_mismatch": "the controller found a parameter wrong",
}


#: difference of the clocks from which on the wall clock was set, or the computer slept [ns]
_CLOCK_SET: Final = 100_000_000


class _TimedSpan(NamedTuple):
    """A span, and the time of the wall clock when the monotonic clock is 0 at its start [ns]."""

    span: Span
    epoch: int


class _Motion(NamedTuple):
    timed: _TimedSpan
    function: str
    began: float


class Telemetry(Uncopied):
    """Spans and metrics of one robot.

        telemetry = Telemetry("arm-1")
        async with aioduco.connect(host, trace=telemetry) as robot, telemetry.watching(robot):
            ...

    As a trace hook it runs on the thread of the hooks, so that it does not delay calls and stops.

    Args:
        robot: name of the arm: the attribute `duco.robot` of all spans and metrics.
        without_lanes: lanes whose calls make no span, such as `feed` and `poll`, which send many
            calls a second; their latency is measured nevertheless. Heartbeats and the set-points of
            streams make none in any case.
        tracer_provider: provider for spans; None for OpenTelemetry's global one.
        meter_provider: provider for metrics; None for OpenTelemetry's global one.

    Raises:
        ParameterError: there is no such lane.
    """

    def __init__(
        self,
        robot: str = "",
        *,
        without_lanes: Collection[str] = (),
        tracer_provider: TracerProvider | None = None,
        meter_provider: MeterProvider | None = None,
    ) -> None:
        self._robot = robot
        if isinstance(without_lanes, str) or not isinstance(without_lanes, Collection):
            raise ParameterError("without_lanes", without_lanes, 'names, such as ("feed", "poll")')
        self._without = frozenset(one_of("without_lanes", each, _LANES) for each in without_lanes)
        version = aioduco.__version__
        self._tracer = trace.get_tracer(_NAME, version, tracer_provider=tracer_provider)
        meter = metrics.get_meter(_NAME, version, meter_provider=meter_provider)
        self._latency = meter.create_histogram(
            "duco.call.duration", "s", "from begin to answer", **_CALLS
        )
        self._tasks = meter.create_counter("duco.tasks", "{task}", "motions that have ended")
        self._times = meter.create_histogram(
            "duco.task.duration", "s", "from start to end", **_MOTION_TIMES
        )
        self._stops = meter.create_counter("duco.stops", "{stop}", "stops that were sent")
        self._opened = meter.create_counter("duco.connections", "{connection}", "opened")
        self._reconnects = meter.create_counter(
            "duco.reconnects", "{reconnect}", "times at which the controller answered again"
        )
        self._stalls = meter.create_histogram(
            "duco.loop.stall", "s", "times in which the event loop did not run", **_CALLS
        )
        self._lateness = meter.create_histogram(
            "duco.stream.lateness",
            "s",
            "p99 of how late a stream's ticks began, one per stream",
            **_TICKS,
        )
        self._missed = meter.create_counter(
            "duco.stream.missed", "{tick}", "ticks of streams that were skipped"
        )
        #: the controller's address by OpenTelemetry's names, once a connection was opened
        self._server: dict[str, str | int] = {}
        self._watched: Robot | None = None
        meter.create_observable_gauge(
            "duco.heartbeat.longest_gap",
            [self._longest_gap],
            "s",
            "longest time between two answered beats",
        )
        #: as of the newest span
        self._epoch = _epoch()
        #: motions that have not ended, by task id
        self._motions: dict[int, _Motion] = {}
        self._lock = threading.Lock()

    def __call__(self, event: TraceEvent) -> None:
        """Take a trace event. `connect(trace=...)` calls this on the thread of the hooks."""
        if isinstance(event, CallFinished):
            self._call(event)
        elif isinstance(event, ConnectionOpened):
            host, port = event.peer
            self._server = {"server.address": host, "server.port": port}
            self._opened.add(1, {**self._named(lane=event.lane), **self._server})
        elif isinstance(event, ProcedureFinished):
            timed = self._span(f"duco.{event.name}", event.at - event.duration)
            self._end(timed, event.at, _outcome(event.error), event.error)

    @asynccontextmanager
    async def watching(self, robot: Robot) -> AsyncIterator[None]:
        """Measure stalls, reconnects and the heartbeat of an open robot during the block.

        Motions that still run at the end get their span then, with the outcome `unknown`. An error
        of the block leaves it as it is.

        Raises:
            ParameterError: this is no robot that `aioduco.connect` returned.
            RobotStateError: the robot was closed.
        """
        if not isinstance(robot, Robot):
            raise ParameterError("robot", robot, "a robot that `aioduco.connect` returned")
        with robot.events.subscribe() as subscribed:
            self._watched = robot
            tasks = await anyio.create_task_group().__aenter__()
            tasks.start_soon(self._follow, subscribed)
            try:
                yield
            finally:
                self._watched = None
                tasks.cancel_scope.cancel()
                # without the error, which a group of tasks would wrap
                await tasks.__aexit__(None, None, None)
                # behind the events that the hooks' thread has not passed on yet
                reporter.put(self.close)

    def stream_ended(self, statistics: StreamStatistics, name: str = "") -> None:
        """Record the statistics of a stream: `telemetry.stream_ended(stream.statistics())`."""
        attributes = self._named(stream=name)
        self._lateness.record(statistics.lateness.p99, attributes)
        self._missed.add(statistics.missed, attributes)

    def close(self) -> None:
        """End the spans of motions whose end was not observed, with the outcome `unknown`."""
        with self._lock:
            left, self._motions = self._motions, {}
        for motion in left.values():
            self._record(motion, time.monotonic(), "unknown")

    async def _follow(self, subscribed: Subscription[events.Event]) -> None:
        with contextlib.suppress(RobotStateError):  # the robot was closed
            async for event in subscribed:
                if isinstance(event, events.LoopBlocked):
                    self._stalls.record(event.seconds, self._named())
                elif isinstance(event, events.ConnectionBack):
                    self._reconnects.add(1, self._named())

    def _longest_gap(self, _: CallbackOptions) -> Iterable[Observation]:
        beat = None if self._watched is None else self._watched.heartbeat
        return [] if beat is None else [metrics.Observation(beat.longest_gap, self._named())]

    def _call(self, event: CallFinished) -> None:
        outcome = _outcome(event.error)
        attributes = self._named(function=event.function, lane=event.lane, outcome=outcome)
        attributes |= self._server
        if event.error is not None:
            attributes["error.type"] = outcome
        self._latency.record(event.duration, attributes)
        if event.function == "stop":
            self._stops.add(1, self._named(outcome=outcome))
        began = event.at - event.duration
        motion = self._begun(event, began)
        if event.lane not in self._without:
            within = None
            if event.lane in _OF_THE_PACKAGE:
                within = Context()
            elif motion is not None:
                within = trace.set_span_in_context(motion.timed.span)
            timed = self._span(f"duco.{event.function}", began, within, SpanKind.CLIENT)
            timed.span.set_attributes({"duco.lane": event.lane, **self._server})
            self._end(timed, event.at, outcome, event.error)
        if event.function == _ASK and event.arguments:
            self._ended(int(event.arguments[0]), event)
        elif _tells_end(event):
            self._ended(_END, event)

    def _begun(self, event: CallFinished, began: float) -> _Motion | None:
        """The motion that a call started."""
        number = event.result
        if event.lane not in _MOTIONS or type(number) is not int or number <= 0:
            return None
        timed = self._span(f"duco.motion {event.function}", began)
        if _tells_end(event):
            number = _END
        else:
            timed.span.set_attribute("duco.task.id", number)
        motion = _Motion(timed, event.function, began)
        with self._lock:
            before = self._motions.pop(number, None)
            self._motions[number] = motion
        if before is not None:
            self._record(before, began, "unknown")
        return motion

    def _ended(self, number: int, event: CallFinished) -> None:
        try:
            state = TaskState(event.result)
        except ValueError:
            return
        if not state.ended:
            return
        with self._lock:
            motion = self._motions.pop(number, None)
        if motion is not None:
            self._record(motion, event.at, state.name.lower())

    def _record(self, motion: _Motion, at: float, outcome: str) -> None:
        attributes = self._named(function=motion.function, outcome=outcome)
        if outcome in _BAD_ENDS:
            attributes["error.type"] = outcome
        self._tasks.add(1, attributes)
        self._times.record(at - motion.began, attributes)
        self._end(motion.timed, at, outcome, None)

    def _span(
        self,
        name: str,
        began: float,
        within: Context | None = None,
        kind: SpanKind = SpanKind.INTERNAL,
    ) -> _TimedSpan:
        """Begin a span, in the caller's own one if no other context is given."""
        epoch = _epoch()
        if abs(epoch - self._epoch) > _CLOCK_SET:
            self._epoch = epoch
        span = self._tracer.start_span(
            name, within, kind, attributes=self._named(), start_time=self._epoch + int(began * 1e9)
        )
        return _TimedSpan(span, self._epoch)

    def _end(self, timed: _TimedSpan, at: float, outcome: str, error: BaseException | None) -> None:
        span, epoch = timed
        span.set_attribute("duco.outcome", outcome)
        if error is not None or outcome in _BAD_ENDS:
            span.set_attribute("error.type", outcome)
            told = _BAD_ENDS[outcome] if error is None else str(error)
            span.set_status(StatusCode.ERROR, told)
        span.end(epoch + int(at * 1e9))

    def _named(self, **attributes: Any) -> dict[str, Any]:
        return {
            "duco.robot": self._robot,
            **{f"duco.{name}": value for name, value in attributes.items()},
        }


def _epoch() -> int:
    """The time of the wall clock when the monotonic clock is 0 [ns]."""
    return time.time_ns() - time.monotonic_ns()


def _tells_end(event: CallFinished) -> bool:
    """Whether a call was answered with the end of its motion, and not with the id of a task."""
    answer = event.result
    return event.lane == _MOTIONS[1] and type(answer) is int and 0 < answer <= max(TaskState)


def _outcome(error: BaseException | None) -> str:
    """How a call or a procedure ended: `ok`, or the class of its error."""
    return "ok" if error is None else type(error).__name__
