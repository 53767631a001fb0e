"""Spans and metrics of a robot, as OpenTelemetry's SDK gets them."""

from __future__ import annotations

import asyncio
import threading
import time
from typing import TYPE_CHECKING, Any

import anyio
import pytest
from for_each import for_each
from interpreter import python
from opentelemetry.sdk.metrics import MeterProvider
from opentelemetry.sdk.metrics.export import InMemoryMetricReader
from opentelemetry.sdk.trace import TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import StatusCode

import aioduco
import aioduco.sync
from aioduco.integrations.otel import Telemetry
from aioduco.models.trace import (
    CallFinished,
    ConnectionEnded,
    ConnectionOpened,
    ProcedureFinished,
    TraceEvent,
)
from aioduco.supervision.events import ConnectionBack, LoopBlocked
from aioduco.testing import eventually_async

if TYPE_CHECKING:
    from opentelemetry.sdk.trace import ReadableSpan

    from aioduco.sim import Simulator


class Backend:
    """What the SDK would send."""

    def __init__(self) -> None:
        self.exporter = InMemorySpanExporter()
        self.tracers = TracerProvider()
        self.tracers.add_span_processor(SimpleSpanProcessor(self.exporter))
        self.reader = InMemoryMetricReader()
        self.meters = MeterProvider([self.reader])

    def telemetry(self, **options: Any) -> Telemetry:
        return Telemetry(
            "arm-1", tracer_provider=self.tracers, meter_provider=self.meters, **options
        )

    def spans(self, name: str) -> list[ReadableSpan]:
        return [span for span in self.exporter.get_finished_spans() if span.name == name]

    def points(self, name: str) -> list[Any]:
        data = self.reader.get_metrics_data()
        return [
            point
            for resource in ([] if data is None else data.resource_metrics)
            for scope in resource.scope_metrics
            for metric in scope.metrics
            if metric.name == name
            for point in metric.data.data_points
        ]


def called(function: str, result: Any, *arguments: Any, **more: Any) -> CallFinished:
    options = {"lane": "motion", "error": None, "duration": 0.25, "at": time.monotonic(), **more}
    return CallFinished(function=function, result=result, arguments=arguments, **options)


@pytest.mark.cases(1)
@pytest.mark.parametrize("blocking", [False, True])
async def test_what_the_program_asks_for_is_in_its_own_span(
    duco_simulator: Simulator, blocking: bool
) -> None:
    backend = Backend()
    address = (duco_simulator.host, duco_simulator.port)
    tracer = backend.tracers.get_tracer("program")
    clock = duco_simulator.clock

    async def run() -> None:
        async with aioduco.connect(*address, trace=backend.telemetry(), clock=clock) as robot:
            await robot.feed.latest()  # the feed begins outside
            with tracer.start_as_current_span("job"):
                await robot.bring_up()
                await robot.motion.movej2([0.1] * 6, 1.0, 1.0)

    def run_blocking() -> None:
        with aioduco.sync.connect(*address, trace=backend.telemetry(), clock=clock) as robot:
            robot.feed.latest()
            with tracer.start_as_current_span("job"):
                robot.bring_up()
                robot.motion.movej2([0.1] * 6, 1.0, 1.0)

    await (asyncio.to_thread(run_blocking) if blocking else run())

    def parents(name: str) -> set[int | None]:
        spans = backend.spans(name)
        assert spans, name
        return {span.parent.span_id if span.parent else None for span in spans}

    def number(name: str) -> Any:
        (span,) = backend.spans(name)
        assert span.context is not None
        return span.context.span_id

    assert parents("duco.motion movej2") == parents("duco.bring_up") == {number("job")}
    assert parents("duco.movej2") == {number("duco.motion movej2")}
    assert parents("duco.get_noneblock_taskstate") == {None}


@for_each("lanes", [("fed",), ("heartbeat",), "feed", None, 3])
def test_a_lane_that_is_none_is_refused(lanes: Any) -> None:
    with pytest.raises(aioduco.ParameterError, match="without_lanes is"):
        Backend().telemetry(without_lanes=lanes)


async def test_calls_motions_and_recoveries_of_a_robot(duco_simulator: Simulator) -> None:
    backend = Backend()
    telemetry = backend.telemetry(without_lanes=("feed", "poll"))
    robot = aioduco.connect(
        duco_simulator.host,
        duco_simulator.port,
        heartbeat=3.0,
        trace=telemetry,
        clock=duco_simulator.clock,
    )
    async with robot, telemetry.watching(robot):
        await robot.bring_up()
        await robot.motion.movej2([0.1] * 6, 1.0, 1.0)
        moving = await robot.motion.movej2([1.0] * 6, 0.1, 1.0).start()
        await robot.stop()
        await moving.wait()
        await robot.recover()
        robot._supervisor.events.tell(LoopBlocked(0.0, 1e6, "here"))
        robot._supervisor.events.tell(ConnectionBack(0.0, 2.0))
        await eventually_async(lambda: bool(backend.points("duco.reconnects")))
        assert len(backend.points("duco.heartbeat.longest_gap")) == 1
        # from the second beat on
        await eventually_async(lambda: backend.points("duco.heartbeat.longest_gap")[0].value > 0)
    motions = backend.spans("duco.motion movej2")
    outcomes = [(span.attributes or {})["duco.outcome"] for span in motions]
    assert outcomes == ["finished", "stopped"]
    starts = backend.spans("duco.movej2")
    parents = [span.parent.span_id for span in starts if span.parent]
    assert parents == [span.context.span_id for span in motions if span.context]
    assert [(span.attributes or {})["duco.outcome"] for span in backend.spans("duco.recover")] == [
        "ok"
    ]
    assert len(backend.spans("duco.bring_up")) == 1
    assert not backend.spans("duco.get_noneblock_taskstate")
    assert backend.points("duco.loop.stall")[0].max == 1e6
    assert backend.points("duco.stops")[0].value >= 1
    tasks = {
        point.attributes["duco.outcome"]: point.value for point in backend.points("duco.tasks")
    }
    assert tasks == {"finished": 1, "stopped": 1}
    lanes = {point.attributes["duco.lane"] for point in backend.points("duco.call.duration")}
    assert {"motion", "poll", "stop"} <= lanes


def test_a_call_has_its_time_and_its_error() -> None:
    backend = Backend()
    telemetry = backend.telemetry()
    wall = time.time()
    telemetry(called("movel", None, error=aioduco.CallTimeout("movel: too late")))
    (span,) = backend.spans("duco.movel")
    assert span.status.status_code is StatusCode.ERROR
    assert (span.attributes or {})["duco.outcome"] == "CallTimeout"
    assert span.start_time is not None
    assert span.end_time is not None
    assert span.end_time - span.start_time == pytest.approx(0.25e9, abs=1000)
    assert span.end_time * 1e-9 == pytest.approx(wall, abs=60.0)
    assert not backend.spans("duco.motion movel")


def test_a_wall_clock_that_was_set_moves_later_spans_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    backend, day, now = Backend(), 86_400 * 10**9, time.time_ns
    telemetry = backend.telemetry()
    telemetry(called("movel", 7))
    monkeypatch.setattr(time, "time_ns", lambda: now() + day)
    telemetry(called("movej", 8))
    for task in (7, 8):
        telemetry(called("get_noneblock_taskstate", 4, task, lane="poll"))
    (before,), (after,) = (backend.spans(f"duco.motion {name}") for name in ("movel", "movej"))
    for span, step in ((before, 0), (after, day)):
        assert span.start_time is not None
        assert span.end_time is not None
        assert span.start_time == pytest.approx(now() + step, abs=60e9)
        assert span.end_time - span.start_time < 60e9


def test_errors_and_the_controller_have_opentelemetrys_names() -> None:
    backend = Backend()
    telemetry = backend.telemetry()
    telemetry(ConnectionOpened(1.0, "motion", ("192.168.1.10", 7003), 0.01))
    telemetry(called("movel", 7))
    telemetry(called("get_noneblock_taskstate", aioduco.TaskState.ILLEGAL, 7, lane="poll"))
    telemetry(called("movel", None, error=aioduco.CallTimeout("movel: too late")))
    good, late = backend.spans("duco.movel")
    assert (good.attributes or {})["server.address"] == "192.168.1.10"
    assert (good.attributes or {})["server.port"] == 7003
    assert "error.type" not in (good.attributes or {})
    assert (late.attributes or {})["error.type"] == "CallTimeout"
    assert late.status.description == "movel: too late"
    (motion,) = backend.spans("duco.motion movel")
    assert (motion.attributes or {})["error.type"] == "illegal"
    assert "not allowed" in str(motion.status.description)
    calls = {
        (point.attributes["duco.outcome"], point.attributes.get("error.type"))
        for point in backend.points("duco.call.duration")
    }
    assert calls == {("ok", None), ("CallTimeout", "CallTimeout")}
    assert all(
        point.attributes["server.address"] == "192.168.1.10"
        for point in backend.points("duco.call.duration")
    )
    (task,) = backend.points("duco.tasks")
    assert task.attributes["error.type"] == "illegal"


def test_a_blocking_call_has_a_motion_that_ends_with_its_answer() -> None:
    """It was a call that went well, and no task, although its motion had failed."""
    backend = Backend()
    telemetry = backend.telemetry()
    telemetry(called("movel", int(aioduco.TaskState.ERROR), lane="blocking", duration=2.0))
    telemetry(called("replay", 1007, lane="blocking"))  # some controllers answer with its task
    telemetry(called("get_noneblock_taskstate", aioduco.TaskState.FINISHED, 1007, lane="poll"))
    (motion,) = backend.spans("duco.motion movel")
    assert (motion.attributes or {})["duco.outcome"] == "error"
    assert "duco.task.id" not in (motion.attributes or {})
    (call,) = backend.spans("duco.movel")
    assert call.parent is not None
    assert call.parent.span_id == motion.context.span_id
    ends = {point.attributes["duco.outcome"]: point.sum for point in
            backend.points("duco.task.duration")}  # fmt: skip
    assert ends == {"error": pytest.approx(2.0), "finished": pytest.approx(0.25, abs=0.1)}


def test_a_motion_whose_end_was_not_seen_is_told_so() -> None:
    backend = Backend()
    telemetry = backend.telemetry()
    telemetry(called("movel", 7))
    telemetry(called("get_noneblock_taskstate", 1, 7, lane="poll"))
    telemetry(TraceEvent(0.0, "motion"))
    assert not backend.spans("duco.motion movel")
    telemetry(called("movel", 7))  # a controller that was started anew counts from 1 again
    telemetry.close()
    outcomes = [
        (span.attributes or {})["duco.outcome"] for span in backend.spans("duco.motion movel")
    ]
    assert outcomes == ["unknown", "unknown"]


async def test_an_end_that_the_hook_has_not_heard_of_yet_is_seen(
    duco_simulator: Simulator,
) -> None:
    """The last motion of a program was told as one whose end is unknown, now and then."""
    backend, gate = Backend(), threading.Event()
    telemetry = backend.telemetry()

    def late(event: TraceEvent) -> None:
        if isinstance(event, CallFinished) and event.function == "get_noneblock_taskstate":
            gate.wait(60.0)
        telemetry(event)

    address = (duco_simulator.host, duco_simulator.port)
    async with aioduco.connect(*address, trace=late, clock=duco_simulator.clock) as robot:
        async with telemetry.watching(robot):
            await robot.bring_up()
            await robot.motion.movej2([0.1] * 6, 1.0, 1.0)
        gate.set()
        await eventually_async(lambda: bool(backend.spans("duco.motion movej2")))
    motions = [
        each
        for name in ("power_on", "enable", "movej2")
        for each in backend.spans(f"duco.motion {name}")
    ]
    assert {(each.attributes or {})["duco.outcome"] for each in motions} == {"finished"}


@pytest.mark.slow
async def test_nothing_is_made_where_it_is_not_asked_for(
    duco_simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a hook a call makes no event, and asks for no time beyond its own."""

    def none_asked(*_: object, **__: object) -> None:
        raise AssertionError("an event was made, and nobody asked for it")

    kinds = (CallFinished, ConnectionOpened, ConnectionEnded, ProcedureFinished)
    for kind in kinds:
        monkeypatch.setattr(kind, "__init__", none_asked)
    async with aioduco.connect(
        duco_simulator.host, duco_simulator.port, clock=duco_simulator.clock
    ) as robot:
        await robot.bring_up()
        await robot.motion.movej2([0.1] * 6, 1.0, 1.0)
        await robot.stop()
        await robot.recover()


@pytest.mark.slow
def test_nothing_is_loaded_where_it_is_not_asked_for() -> None:
    program = (
        "import sys, aioduco, aioduco.sync, aioduco.robot; aioduco.connect('127.0.0.1');"
        "print([name for name in sys.modules if name.startswith(('opentelemetry', 'zenoh',"
        " 'aioduco.integrations', 'aioduco.integrations.fleet'))])"
    )
    done = python("-c", program)
    assert done.stdout.strip() == "[]", done.stderr


@pytest.mark.parametrize("kind", [ValueError, KeyboardInterrupt, aioduco.errors.DucoError])
async def test_an_error_of_the_watched_block_leaves_it_as_it_is(
    duco_simulator: Simulator, kind: type[BaseException]
) -> None:
    telemetry = Backend().telemetry()
    host, port = duco_simulator.host, duco_simulator.port
    async with aioduco.connect(host, port, trace=telemetry) as robot:
        with pytest.raises(kind) as left:
            async with telemetry.watching(robot):
                raise kind("of the block")
        assert type(left.value) is kind
        with anyio.move_on_after(0.05) as scope:
            async with telemetry.watching(robot):
                await anyio.sleep_forever()
        assert scope.cancelled_caught


async def test_what_is_no_robot_or_a_closed_one_is_not_watched(duco_simulator: Simulator) -> None:
    """And the error is that of the argument, not a group of errors from inside."""
    telemetry = Backend().telemetry()
    strangers: list[Any] = ["no robot", None, aioduco.sync.connect(duco_simulator.host)]
    for stranger in strangers:
        with pytest.raises(aioduco.ParameterError, match=r"robot is .* `aioduco.connect` returned"):
            async with telemetry.watching(stranger):
                pytest.fail("watched")
    robot = aioduco.connect(duco_simulator.host, duco_simulator.port)
    async with robot:
        pass
    with pytest.raises(aioduco.RobotStateError, match="is closed"):
        async with telemetry.watching(robot):
            pytest.fail("watched")


def test_histograms_in_seconds_have_buckets_for_seconds() -> None:
    backend = Backend()
    telemetry = backend.telemetry()
    for seconds in (0.005, 4.0):
        telemetry(called("movej2", 0, duration=seconds))
    data = backend.reader.get_metrics_data()
    assert data is not None
    scopes = [scope for each in data.resource_metrics for scope in each.scope_metrics]
    assert {scope.scope.version for scope in scopes} == {aioduco.__version__}
    (point,) = backend.points("duco.call.duration")
    assert sorted(count for count in point.bucket_counts if count) == [1, 1], "not in one bucket"
