"""How servo streams end: by their program, by the controller, and by others."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import socket
import threading
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from typing import Any

import anyio
import numpy as np
import pytest

from aioduco._wire.rpc import RobotStatus
from aioduco.api.streams.servo import Servo
from aioduco.errors import (
    ParameterError,
    RobotStateError,
    SetPointTooFar,
    StreamClosed,
    StreamLost,
    StreamRefused,
    StreamStarved,
    StreamStopped,
)
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import Reason, StreamState
from aioduco.streaming.stream import Stream
from aioduco.testing import eventually_async, no_leaks

from .conftest import HERE, THREAD, UNWATCHED, Controller, at, came_to_rest, fed, near, workers


@workers
async def test_starving_brings_the_arm_to_rest_and_stops_it(
    controller: Controller, options: WorkerOptions
) -> None:
    stream = controller.servo.joints(v=1.0, a=5.0, rate=500, hold=0.05, options=options)
    with pytest.raises(StreamStarved, match="longer than the hold time"):
        await fed(stream, (near(5e-6 * n * n) for n in range(100)), stream.ended)
    assert came_to_rest(controller, 500, 5.0, stream.statistics().missed)
    assert controller.names()[-1] == "stop"
    assert stream.statistics().starved > 0


async def test_a_source_that_gives_no_more_does_not_hide_the_end(controller: Controller) -> None:
    """Its program waits for it, as for a camera, and would not learn that the arm was stopped."""
    closed = anyio.Event()

    async def source() -> AsyncIterator[list[float]]:
        try:
            yield HERE
            await anyio.sleep_forever()
        finally:
            closed.set()

    async def program() -> None:
        async with controller.servo.joints(v=1.0, a=5.0, hold=0.05, options=THREAD) as stream:
            await stream.follow(source())

    with pytest.raises(StreamStarved):
        await program()
    assert closed.is_set()
    assert controller.names()[-1] == "stop"


async def test_a_source_that_is_in_a_scope_of_its_own_hides_no_end(controller: Controller) -> None:
    stream = controller.servo.joints(v=1.0, a=5.0, options=THREAD)

    async def source() -> AsyncIterator[list[float]]:
        with anyio.CancelScope():
            yield HERE
            stream.halt()
            while True:
                yield HERE

    async def program() -> None:
        async with stream:
            await stream.follow(source())

    with pytest.raises(StreamStopped):
        await program()


@pytest.mark.parametrize("error", [ZeroDivisionError(), ExceptionGroup("two", [KeyError()] * 2)])
async def test_an_error_of_a_source_is_its_own(controller: Controller, error: Exception) -> None:
    async def source() -> AsyncIterator[list[float]]:
        yield HERE
        raise error

    with pytest.raises(type(error)) as raised:
        async with controller.servo.joints(v=1.0, a=5.0, options=THREAD) as stream:
            await stream.follow(source())
    assert raised.value is error


@workers
async def test_an_error_in_the_program_decelerates_the_arm(
    controller: Controller, options: WorkerOptions
) -> None:
    stream = controller.servo.joints(v=1.0, a=5.0, rate=500, options=options)
    with pytest.raises(ZeroDivisionError):
        await fed(stream, (near(5e-6 * n * n) for n in range(100)), lambda: 1 / 0)
    assert came_to_rest(controller, 500, 5.0, stream.statistics().missed)
    assert stream.statistics().reason is Reason.ABORTED


@workers
async def test_cancellation_decelerates_the_arm_before_it_goes_on(
    controller: Controller, options: WorkerOptions
) -> None:
    stream = controller.servo.joints(v=1.0, a=5.0, rate=500, options=options)
    async with no_leaks():
        with anyio.CancelScope() as scope:
            async with stream:
                for n in range(1000):
                    if n == 100:
                        scope.cancel()
                    await stream.send(near(5e-6 * n * n))
        assert stream.statistics().reason is Reason.ABORTED
    assert came_to_rest(controller, 500, 5.0, stream.statistics().missed)


@workers
async def test_a_cancelled_play_leaves_a_standing_arm_and_an_ended_stream(
    controller: Controller, options: WorkerOptions
) -> None:
    """Also if the program handles the cancellation in the stream's block, and goes on there."""
    stream = controller.servo.joints(v=1.0, a=5.0, rate=500, options=options)
    points = [near(5e-6 * n * n) for n in range(400)]

    async def program() -> None:
        async with stream:
            playing = asyncio.create_task(stream.play(points))
            await eventually_async(lambda: len(controller.points()) > 100)
            playing.cancel()
            with pytest.raises(asyncio.CancelledError):
                await playing
            sent.append(len(controller.points()))
            with pytest.raises(StreamClosed):
                await stream.send(points[-1])

    sent: list[int] = []
    async with no_leaks():
        with pytest.raises(StreamClosed, match="the arm was braked"):
            await program()
    assert [len(controller.points())] == sent
    assert controller.points()[-1] == controller.points()[-2]


async def test_a_play_that_is_cancelled_while_it_is_sampled_ends_the_stream(
    controller: Controller,
) -> None:
    async def program() -> None:
        async with controller.servo.joints(v=1.0, a=5.0, options=THREAD) as stream:
            playing = asyncio.create_task(stream.play([near(0.0)] * 1000))
            await asyncio.sleep(0.0)  # it has checked a part of them
            playing.cancel()
            with pytest.raises(asyncio.CancelledError):
                await playing
            with pytest.raises(StreamClosed):
                await stream.send(near(0.0))

    with pytest.raises(StreamClosed):
        await program()
    assert controller.points() == []


@pytest.mark.parametrize("chunks", [False, True])
async def test_a_cancelled_first_set_point_is_not_followed(
    controller: Controller, chunks: bool
) -> None:
    looked, go_on = threading.Event(), threading.Event()

    def where() -> list[float]:
        looked.set()
        go_on.wait(20.0)
        return HERE

    controller.server.answer("get_actual_joints_position", where)
    kind: dict[str, Any] = (
        {"source_rate": 30, "upsample": "cubic", "chunks": True} if chunks else {}
    )
    stream = controller.servo.joints(v=1.0, a=5.0, **kind, options=replace(THREAD, timeout=20.0))

    async def program() -> None:
        async with stream:
            sending = asyncio.create_task(stream.send(near(0.01)))
            await eventually_async(looked.is_set)
            sending.cancel()
            await anyio.wait_all_tasks_blocked()
            go_on.set()
            with pytest.raises(asyncio.CancelledError):
                await sending
            assert stream.state is StreamState.ENDED

    with pytest.raises(StreamClosed, match="the arm was braked"):
        await program()
    # but for the step of the tick in which the worker was
    assert all(abs(point[0] - HERE[0]) < 1e-4 for point in controller.points())


async def test_a_cancelled_offset_is_not_followed(controller: Controller) -> None:
    """Else a program that sends it again would move the arm twice as far."""
    moved = [0.001, 0.0, 0.0, 0.0, 0.0, 0.0]
    async with controller.servo.tcp_offset(v=1.0, a=5.0, options=THREAD) as stream:
        await stream.send(moved)
        with anyio.CancelScope() as scope:
            scope.cancel()
            await stream.send(moved)
        assert scope.cancelled_caught
        await stream.send(moved)
    assert np.array(controller.points("servo_tcp"))[:, 0].sum() == pytest.approx(0.002)


async def test_a_cancelled_chunk_is_not_followed(controller: Controller) -> None:
    stream = controller.servo.joints(
        v=1.0, a=5.0, source_rate=30, upsample="cubic", chunks=True, hold=0.2, options=THREAD
    )
    async with stream:
        await stream.send_chunk([HERE])
        sending = asyncio.create_task(stream.send_chunk([near(0.002 * n) for n in range(30)]))
        await anyio.lowlevel.checkpoint()
        sending.cancel()
        with pytest.raises(asyncio.CancelledError):
            await sending
    assert np.abs(np.array(controller.points())[:, 0] - HERE[0]).max() < 1e-6


@workers
async def test_a_halt_ends_the_stream_at_once_and_sends_no_stop_of_its_own(
    controller: Controller, options: WorkerOptions
) -> None:
    endpoint = controller.endpoint
    counts: list[int] = []
    stream = Servo(endpoint).joints(v=1.0, a=5.0, rate=500, options=options)

    async def program() -> None:
        async with stream:
            await stream.send(HERE)
            (opened,) = endpoint.streams
            opened.halt()
            with anyio.fail_after(5.0):
                await opened.ended()
            counts.append(len(controller.points()))
            with pytest.raises(StreamStopped):
                await stream.send(HERE)

    with pytest.raises(StreamStopped):
        await program()
    assert [len(controller.points())] == counts
    assert not controller.server.received("stop")
    assert not endpoint.streams


async def test_a_step_too_large_is_refused_and_the_stream_goes_on(controller: Controller) -> None:
    async with controller.servo.joints(v=1.0, a=5.0, max_step=0.1, options=THREAD) as stream:
        await stream.send(HERE)
        said = r"joint 1: 0\.2 rad away, where 0\.1 rad are allowed"
        with pytest.raises(SetPointTooFar, match=said):
            await stream.send(near(0.2))
        for wrong in (3, None, 0.5):
            with pytest.raises(ParameterError, match="source"):
                await stream.follow(wrong)  # type: ignore[arg-type]  # the wrong type is the point
        with pytest.raises(SetPointTooFar):
            await stream.play([near(0.0), near(0.05), near(0.2)])
        with pytest.raises(ParameterError):
            await stream.send([0.0] * 5)
        with pytest.raises(ParameterError):
            await stream.send([float("nan")] * 6)
        await stream.send(near(0.001))
    assert controller.points()[-1] == pytest.approx(near(0.001))


@pytest.mark.slow
@workers
async def test_a_refused_set_point_ends_the_stream_and_stops_the_robot(
    controller: Controller, options: WorkerOptions
) -> None:
    stream = controller.servo.joints(v=1.0, a=5.0, rate=200, options=options)
    with pytest.raises(StreamRefused, match="servoj answered -1"):
        await fed(stream, at(20, lambda: controller.server.answer("servoj", -1)))
    assert controller.names()[-1] == "stop"


async def test_a_first_set_point_without_a_result_stops_the_robot(controller: Controller) -> None:
    controller.server.answer("servoj", None)
    options = WorkerOptions(run_in="thread")
    stream = controller.servo.joints(v=1.0, a=5.0, options=options)
    with pytest.raises(StreamRefused, match="without a result"):
        await fed(stream, at(20, lambda: None))
    assert controller.names()[-1] == "stop"


@pytest.mark.parametrize(
    ("function", "answer", "error", "stops"),
    [
        ("get_robot_state", [5, 0, 9, 1], StreamRefused, True),
        ("get_noneblock_taskstate", 7, StreamRefused, True),
        ("get_noneblock_taskstate", 3, StreamStopped, False),
        ("get_noneblock_taskstate", 2, StreamRefused, True),
    ],
)
async def test_the_worker_sees_when_the_controller_does_not_follow_any_more(
    controller: Controller, function: str, answer: object, error: type[Exception], stops: bool
) -> None:
    options = WorkerOptions(run_in="thread", watch=0.02)
    stream = controller.servo.joints(v=1.0, a=5.0, options=options)
    with pytest.raises(error):
        await fed(stream, at(20, lambda: controller.server.answer(function, answer)))
    assert bool(controller.server.received("stop")) == stops


async def test_a_collision_is_told_with_the_refusal_after_it(controller: Controller) -> None:
    """Neither the state nor the newest error, of a set-point that was refused since, says it."""
    controller.server.answer("getRobotStatus", RobotStatus(collision=True, collisionAxis=3))
    controller.server.answer("get_last_error", ["an older one", "servoj: STOP2"])
    options = WorkerOptions(run_in="thread", watch=0.02, timeout=30.0)
    stream = controller.servo.joints(v=1.0, a=5.0, options=options)
    disabled = at(20, lambda: controller.server.answer("get_robot_state", [5, 0, 9, 1]))
    said = r"DISABLE.*a collision was detected at joint 3; .*error list: servoj: STOP2"
    with pytest.raises(StreamRefused, match=said):
        await fed(stream, disabled)


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("states", "stopped"),
    [([1, 1, 3], True), ([3], True), ([5], False), ([2, 4], False), ([0], False)],
    ids=["stopped after a brake", "stopped", "replaced", "paused, then finished", "forgotten"],
)
async def test_a_task_of_another_caller_may_be_a_stop(
    controller: Controller, states: list[int], stopped: bool
) -> None:
    """Its number is missing: the task before it is polled until it has ended."""
    ids, answers = itertools.count(1000), itertools.chain(states, itertools.repeat(5))
    polled: list[int] = []

    def point(*_: object) -> int:
        id_ = next(ids)
        return next(ids) if id_ == 1020 else id_

    def state(task: int) -> int:
        polled.append(task)
        return next(answers) if task == 1019 else 4

    controller.server.answer("servoj", point)
    controller.server.answer("get_noneblock_taskstate", state)
    told = pytest.raises(StreamStopped, match="the controller stopped task 1019")
    with told if stopped else contextlib.nullcontext():
        async with controller.servo.joints(v=1.0, a=5.0, options=UNWATCHED) as stream:
            for _ in range(100):
                await stream.send(HERE)
    assert polled[: len(states)] == [1019] * len(states)
    assert len(controller.server.received("stop")) == stopped
    if stopped:
        assert len(controller.points()) == 20 + len(states)


def set_points(*missing: int) -> Callable[..., int]:
    """Gives the ids of set-points; other callers have the missing ones."""
    ids = (id_ for id_ in itertools.count(1000) if id_ not in missing)
    return lambda *_: next(ids)


async def sent_to_the_end(stream: Stream, count: int, error: type[Exception] | None = None) -> None:
    """Send set-points, and leave the stream when the worker has taken them all, or by an error."""
    async with stream:
        for _ in range(count):
            await stream.send(HERE)
        await stream._taken()
        if error is not None:
            raise error


@pytest.mark.parametrize("error", [None, KeyError])
async def test_a_stop_shortly_before_the_end_is_noticed(
    controller: Controller, error: type[Exception] | None
) -> None:
    """The last set-points are sent while the arm still brakes: it must not follow them then."""
    answers = itertools.chain([1] * 20, itertools.repeat(3))
    controller.server.answer("servoj", set_points(1018))
    controller.server.answer("get_noneblock_taskstate", lambda _: next(answers))
    stream = controller.servo.joints(v=1.0, a=5.0, options=UNWATCHED)
    with pytest.raises(error or StreamStopped):
        await sent_to_the_end(stream, 20, error)
    assert len(controller.points()) <= 40  # one in each tick until the answer
    assert len(controller.server.received("stop")) == 1


@pytest.mark.parametrize(
    ("state", "error"), [(3, StreamStopped), (5, StreamStopped), (2, StreamRefused)]
)
async def test_an_arm_that_others_stop_or_pause_after_the_last_set_point(
    controller: Controller, state: int, error: type[Exception]
) -> None:
    """It is not where the program has sent it, and must not go there when somebody resumes it."""
    controller.server.answer("servoj", set_points())
    controller.server.answer("get_noneblock_taskstate", state)
    stream = controller.servo.joints(v=1.0, a=5.0, options=UNWATCHED)
    with pytest.raises(error):
        await sent_to_the_end(stream, 20)
    assert len(controller.server.received("stop")) == (error is StreamRefused)


async def test_a_set_point_that_waits_behind_a_motion_that_others_paused(
    controller: Controller,
) -> None:
    """It has not begun when the stream is left: the arm would go there when somebody resumes it."""
    states = itertools.chain([[6, 2, 5, 1]], itertools.repeat([6, 3, 5, 1]))
    controller.server.answer("get_robot_state", lambda: next(states))
    controller.server.answer("get_noneblock_taskstate", 0)
    stream = controller.servo.joints(v=1.0, a=5.0, options=UNWATCHED)
    with pytest.raises(StreamRefused, match="the arm is paused"):
        await sent_to_the_end(stream, 20)
    assert len(controller.server.received("stop")) == 1


@pytest.mark.slow
async def test_a_controller_that_answers_no_more_ends_the_stream_and_is_told_to_stop(
    controller: Controller,
) -> None:
    gate = threading.Event()
    stuck = [20]

    def servoj(*_: object) -> int:
        stuck[0] -= 1
        if stuck[0] < 0:
            gate.wait(2)  # twenty time-outs; until then the worker waits for what is overdue
        return 1001

    controller.server.answer("servoj", servoj)
    options = WorkerOptions(run_in="thread", timeout=0.1)
    stream = controller.servo.joints(v=1.0, a=5.0, options=options)
    try:
        with pytest.raises(StreamLost, match="servoj"):
            await fed(stream, itertools.repeat(HERE))
        assert controller.names()[-1] == "stop"
    finally:
        gate.set()


async def test_no_controller_is_said_before_anything_happens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as closed:
        port = closed.getsockname()[1]
    stream = Servo(StreamEndpoint("127.0.0.1", port)).joints(v=1.0, a=5.0)
    async with no_leaks():
        with pytest.raises(StreamLost, match="cannot connect"):
            async with stream:
                raise AssertionError("entered")


async def test_one_stream_at_a_time(controller: Controller) -> None:
    servo = controller.servo
    async with servo.joints(v=1.0, a=5.0, options=THREAD):
        with pytest.raises(RobotStateError, match="is open on this robot"):
            async with servo.tcp_offset(v=1.0, a=5.0, options=THREAD):
                raise AssertionError("entered")
    async with servo.tcp_offset(v=1.0, a=5.0, options=THREAD):
        pass
    assert not [name for name in controller.names() if name.startswith("servo")]


async def test_a_closed_stream_takes_nothing(controller: Controller) -> None:
    stream = controller.servo.joints(v=1.0, a=5.0, options=THREAD)
    with pytest.raises(StreamClosed, match="not open"):
        await stream.send(HERE)
    async with stream:
        await stream.send(HERE)
    with pytest.raises(StreamClosed):
        await stream.send(HERE)
