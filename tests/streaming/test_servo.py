"""Servo streams, from the program to the wire, in a thread and in a process."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import math
import threading
import time
from collections.abc import AsyncIterator
from dataclasses import replace
from functools import partial
from typing import Any

import anyio
import numpy as np
import pytest

from aioduco import kinematics
from aioduco.api.streams.servo import OffsetStream, Servo
from aioduco.envelope import Envelope, Zone
from aioduco.errors import (
    ParameterError,
    SetPointTooFar,
    StreamClosed,
    StreamLeavesEnvelope,
    StreamStopped,
)
from aioduco.models.pose import Pose
from aioduco.streaming.shared.config import CheckedEnvelope
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import Reason, StreamState
from aioduco.streaming.stream import Stream
from aioduco.testing import eventually_async, no_leaks

from .conftest import HERE, THREAD, Controller, near, workers


@pytest.mark.cases(1)
@workers
async def test_every_set_point_arrives_in_order_and_the_stream_ends_at_the_last(
    controller: Controller, options: WorkerOptions
) -> None:
    sent = [near(0.01 * (1 - math.cos(math.pi * n / 300))) for n in range(301)]
    # The second one is answered when all are on their way: a late one would lead the arm to a hold.
    on_their_way, count = threading.Event(), itertools.count()
    controller.server.answer(
        "servoj", lambda *_: 1001 if next(count) == 0 or on_their_way.wait(20.0) else -1
    )
    options = replace(options, timeout=20.0)
    async with no_leaks():
        async with controller.servo.joints(
            v=1.0, a=5.0, rate=1000, ahead=len(sent), options=options
        ) as stream:
            for point in sent:
                await stream.send(point)
            on_their_way.set()
        statistics = stream.statistics()
    points = controller.points()
    # A tick without a new set-point repeats the last one.
    fresh = [point for point, _ in itertools.groupby(points)]
    assert fresh == sent
    assert statistics.sent == len(points)
    assert statistics.state is StreamState.ENDED
    assert statistics.reason is Reason.CLOSED
    assert statistics.round_trip.samples == len(points)
    assert controller.server.received("servoj")[0].args[1:] == (
        1.0, 5.0, False, 200.0, 25.0, 10.0, 1.0,
    )  # fmt: skip
    assert not controller.server.received("stop")


@workers
@pytest.mark.parametrize("latest", [False, True])
async def test_a_task_that_sends_on_does_not_hold_the_block_open(
    controller: Controller, options: WorkerOptions, latest: bool
) -> None:
    sent, errors = anyio.Event(), list[str]()

    async def send_on(stream: Stream) -> None:
        try:
            while True:
                await stream.send(HERE)
                sent.set()
        except StreamClosed as exc:
            errors.append(str(exc))

    async with anyio.create_task_group() as group:
        with anyio.fail_after(20.0):
            async with controller.servo.joints(
                v=1.0, a=5.0, rate=100, latest=latest, options=options
            ) as stream:
                group.start_soon(send_on, stream)
                await sent.wait()
    assert stream.statistics().reason is Reason.CLOSED
    assert errors == ["the stream was closed, and takes no set-points any more"]


@workers
async def test_a_whole_array_is_played_by_its_times(
    controller: Controller, options: WorkerOptions
) -> None:
    trajectory = np.array([near(0.0), near(0.05), near(0.0)])
    async with controller.servo.joints(v=1.0, a=50.0, rate=500, options=options) as stream:
        await stream.play(trajectory, [0.0, 0.2, 0.4])
    points = np.array(controller.points())
    # 0.4 s at 500 Hz, and what it takes to meet the last point; a late program ends it later
    under_way = np.flatnonzero(np.abs(points - HERE).max(axis=1) > 1e-9)[-1] + 2
    assert 201 - stream.statistics().missed <= under_way <= 210
    assert points[:, 0].max() == pytest.approx(HERE[0] + 0.05, abs=2e-3)
    np.testing.assert_allclose(points[-1], HERE, atol=1e-9)


async def test_an_iterator_is_followed_to_its_end(controller: Controller) -> None:
    async def source() -> AsyncIterator[list[float]]:
        for n in range(20):
            yield near(1e-5 * n * n)

    async with controller.servo.joints(v=1.0, a=50.0, options=THREAD) as stream:
        await stream.follow(source())
    assert controller.points()[-1] == pytest.approx(near(1e-5 * 19 * 19))


async def test_ticks_carry_the_time_and_end_with_the_stream(controller: Controller) -> None:
    stream = controller.servo.joints(v=1.0, a=5.0, latest=True, options=THREAD)

    async def program() -> None:
        async with stream:
            before = -1.0
            async for tick in stream.ticks(200.0):
                assert tick.time > before
                assert tick.dt > 0
                before = tick.time
                if tick.number == 20:
                    stream.halt()
                await stream.send(HERE)

    with pytest.raises(StreamStopped):
        await program()


async def test_latest_wins_and_send_does_not_wait(controller: Controller) -> None:
    async with controller.servo.joints(
        v=1.0, a=50.0, rate=50, latest=True, options=THREAD
    ) as stream:
        await stream.send(HERE)
        for n in range(400):
            await stream.send(near(1e-5 * n))
    assert stream.statistics().overwritten > 300
    assert controller.points()[-1] == pytest.approx(near(1e-5 * 399))


async def test_send_waits_while_enough_are_queued(controller: Controller) -> None:
    async with controller.servo.joints(v=1.0, a=50.0, rate=200, ahead=3, options=THREAD) as stream:
        for _ in range(30):
            await stream.send(HERE)
            assert stream.statistics().queued <= 3


@pytest.mark.slow
async def test_low_rate_targets_are_brought_up_within_the_limits(controller: Controller) -> None:
    async with controller.servo.joints(
        v=2.0, a=15.0, jerk=300.0, rate=500, source_rate=30, upsample="ruckig", options=THREAD
    ) as stream:
        for n in range(20):
            await stream.send(near(0.05 * (1 - math.cos(0.3 * n))))
    places = np.array(controller.points())
    steps = np.vstack([np.zeros((3, 6)), np.diff(places, axis=0)])
    assert len(places) > 19 * 500 / 30
    assert np.abs(np.diff(steps, n=2, axis=0)).max() * 500**3 <= 300.0 * 1.01
    np.testing.assert_allclose(places[-1], near(0.05 * (1 - math.cos(0.3 * 19))), atol=1e-8)


# -- poses and offsets -------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["pose", "linear"])
async def test_poses_turn_the_shorter_way_and_carry_tool_and_work_object(
    controller: Controller, kind: str
) -> None:
    start = [0.5, 0.1, 0.4, 3.0, 0.0, 1.0]
    opened = getattr(controller.servo, kind)(
        v=1.0, a=5.0, tool="gripper", wobj="table", rate=200, source_rate=50, upsample="linear",
        q_near=HERE, options=THREAD,
    )  # fmt: skip
    async with opened as stream:
        for n in range(10):
            await stream.send([0.5 + 1e-4 * n, 0.1, 0.4, 3.0 + 0.03 * n, 0.0, 1.0])
    assert controller.server.received("get_tcp_pose_coord")[0].args == ("gripper", "table")
    name = "servoj_pose" if kind == "pose" else "servol"
    calls = controller.server.received(name)
    assert calls[0].args[3:7] == (HERE, "gripper", "table", False)
    poses = np.array([call.args[0] for call in calls])
    np.testing.assert_allclose(poses[0][:3], start[:3], atol=1e-3)
    # 3.0 + 0.27 is beyond π: the angle that is sent goes on at the other end of its range
    assert poses[-1][3] == pytest.approx(3.27 - 2 * math.pi, abs=1e-9)
    assert np.abs(np.diff(poses[:, 0])).max() < 1e-3


@pytest.mark.cases(1)
@pytest.mark.parametrize("latest", [False, True])
async def test_each_offset_is_carried_out_once_within_the_limits(
    controller: Controller, latest: bool
) -> None:
    opened = controller.servo.tcp_offset(
        v=1.0, a=5.0, velocity=(0.1, 0.5), acceleration=(1.0, 5.0), rate=200, latest=latest,
        options=THREAD,
    )  # fmt: skip
    offset = [0.01, 0.0, 0.0, 0.0, 0.0, 0.05]
    async with opened as stream:
        for _ in range(5):
            await stream.send(offset)
        with pytest.raises(SetPointTooFar):
            await stream.send([0.06, 0.0, 0.0, 0.0, 0.0, 0.0])
    steps = [call.args[0] for call in controller.server.received("servo_tcp")]
    lengths = np.linalg.norm(np.array(steps)[:, :3], axis=1) * 200
    assert lengths.max() <= 0.1 * (1 + 1e-6)
    assert np.abs(np.diff(lengths)).max() <= 1.0 / 200 * (1 + 1e-6)
    # The steps, one after the other in the tool's frame, lead where the offsets lead.
    reached, wanted = np.eye(4), np.eye(4)
    for step in steps:
        reached = reached @ Pose.of(step).matrix
    for _ in range(5):
        wanted = wanted @ Pose.of(offset).matrix
    np.testing.assert_allclose(reached, wanted, atol=1e-9)
    assert not np.any(steps[-1])


@pytest.mark.parametrize(
    "wrong", [[0.0, 0.0, "up", 0.0, 0.0, 0.0], [0.06, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0] * 5]
)
async def test_of_offsets_with_a_wrong_one_none_is_carried_out(
    controller: Controller, wrong: Any
) -> None:
    """Its message says that nothing was sent."""
    offset = [0.01, 0.0, 0.0, 0.0, 0.0, 0.0]
    async with controller.servo.tcp_offset(v=1.0, a=5.0, options=THREAD) as stream:
        await stream.play([offset])
        sent = stream.taken
        with pytest.raises(ParameterError, match=r"trajectory\[3\].*nothing was sent"):
            await stream.play([offset] * 3 + [wrong])
        with pytest.raises(ParameterError, match="trajectory is 5"):
            await stream.play(5)
        assert stream.taken == sent
        await stream.play(np.array([offset]))  # the stream goes on
    steps = np.array([call.args[0] for call in controller.server.received("servo_tcp")])
    assert steps[:, 0].sum() == pytest.approx(0.02)


async def test_offsets_of_two_tasks_add_up(controller: Controller) -> None:
    """Each is relative to the one before, whoever has sent that, also if they wait for room."""
    opened = controller.servo.tcp_offset(v=1.0, a=5.0, rate=200, ahead=1, options=THREAD)

    async def send(stream: OffsetStream, *, whole: bool) -> None:
        offsets = [[0.001, 0.0, 0.0, 0.0, 0.0, 0.0]] * 10
        if whole:
            await stream.play(offsets)
        for offset in () if whole else offsets:
            await stream.send(offset)

    async with opened as stream, anyio.create_task_group() as tasks:
        for whole in (False, False, True):
            tasks.start_soon(partial(send, stream, whole=whole))
    steps = np.array([call.args[0] for call in controller.server.received("servo_tcp")])
    assert steps[:, 0].sum() == pytest.approx(0.03)


@pytest.mark.parametrize("whole", [False, True])
async def test_the_largest_step_of_two_tasks_is_from_what_was_sent_last(
    controller: Controller, whole: bool
) -> None:
    """Also if another task has sent meanwhile, while this one waited for room."""
    opened = controller.servo.joints(v=1.0, a=5.0, rate=100, ahead=1, max_step=0.01, options=THREAD)
    async with opened as stream:

        async def send_on() -> None:
            if whole:
                await stream.play([near(0.009 - 1e-6 * n) for n in range(400)])
            else:
                await stream.send(near(0.009))

        async def send_both() -> None:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(send_on)
                for n in range(400):
                    await stream.send(near(-0.009 + 1e-6 * n))

        await stream.send(HERE)
        with pytest.raises(ExceptionGroup) as refused:
            await send_both()
        assert refused.group_contains(SetPointTooFar)
    points = np.array(controller.points())
    assert np.ptp(points[:, 0]) < 0.01


async def test_of_two_tasks_that_wait_for_room_each_is_woken(controller: Controller) -> None:
    """The one that waits longer must not wait until the arm has nothing to follow."""
    opened = controller.servo.joints(v=1.0, a=5.0, rate=20, ahead=20, options=THREAD)
    async with opened as stream:
        for n in range(10):
            await stream.send(near(1e-4 * n))
        levels: list[int] = []

        async def wait_for(level: int) -> None:
            await opened._session.until_level(level)
            levels.append(stream.statistics().queued)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(wait_for, 3)
            tasks.start_soon(wait_for, 6)
        assert levels == [6, 3]
        assert stream.state is StreamState.FOLLOWING


async def test_sending_to_a_stream_that_has_ended_lets_others_run(controller: Controller) -> None:
    """A program that goes on in spite of the error hung its event loop."""
    async with controller.servo.joints(v=1.0, a=5.0, options=THREAD) as stream:
        await stream.send(HERE)
    others: list[None] = []
    asyncio.get_running_loop().call_soon(others.append, None)
    with pytest.raises(StreamClosed):
        await stream.send(HERE)
    assert others


async def test_leaving_waits_until_the_arm_stands(controller: Controller) -> None:
    looks = itertools.count()
    async with controller.servo.joints(v=1.0, a=5.0, options=THREAD) as stream:
        await stream.send(HERE)
        controller.server.answer("robotmoving", lambda: next(looks) < 5)
    assert next(looks) >= 7


async def test_commanded_is_what_the_worker_sent_last(controller: Controller) -> None:
    async with controller.servo.joints(v=1.0, a=5.0, rate=200, options=THREAD) as stream:
        assert stream.commanded is None
        await stream.send(near(0.0))
        await stream.send(near(1e-4))
        await eventually_async(lambda: stream.commanded == tuple(near(1e-4)))


@workers
async def test_chunks_are_sent_counted_and_refused_when_they_are_wrong(
    controller: Controller, options: WorkerOptions
) -> None:
    options = replace(options, timeout=30.0)
    async with no_leaks():
        async with controller.servo.joints(
            v=1.0, a=5.0, source_rate=30, upsample="cubic", chunks=True, hold=5.0, options=options
        ) as stream:
            await stream.send_chunk([near(0.001 * k) for k in range(12)])
            now = time.monotonic()
            with pytest.raises(SetPointTooFar, match="actions"):
                await stream.send_chunk([near(0.5)] * 3)
            with pytest.raises(SetPointTooFar, match=r"actions\[1\]"):
                await stream.send_chunk([near(0.0), near(0.3)])
            with pytest.raises(ParameterError, match="monotonic"):
                await stream.send_chunk([near(0.0)], at=now + 1e6)
            wrong: tuple[Any, ...] = ([], 5, None, "up")
            for nothing in wrong:
                with pytest.raises(ParameterError, match="1 to 1000"):
                    await stream.send_chunk(nothing)
            with pytest.raises(ParameterError, match="chunks"):
                await stream.play([near(0.0)] * 3)
            await stream.send_chunk([near(0.0)] * 5, at=now - 30)
            await stream.send_chunk([near(0.005)] * 4, at=time.monotonic())
            await eventually_async(lambda: stream.taken == 21)
        found = stream.statistics()
    assert controller.points()[-1] == pytest.approx(near(0.005))
    assert (found.chunks, found.chunks_dropped) == (3, 1)
    assert found.chunks_late >= 1
    assert found.actions_late >= 5
    assert "3 chunks" in repr(found)


async def test_chunks_that_waited_for_room_are_compared_with_those_before_them(
    controller: Controller,
) -> None:
    goes_on, count = threading.Event(), itertools.count()
    controller.server.answer(
        "servoj", lambda *_: 1001 if next(count) == 0 or goes_on.wait(20.0) else -1
    )
    options = replace(THREAD, timeout=20.0, away_limit=30.0)
    stream = controller.servo.joints(
        v=1.0, a=5.0, source_rate=30, upsample="cubic", chunks=True, hold=5.0, options=options
    )
    with contextlib.suppress(StreamClosed):  # as it is not left before all are followed
        async with stream:
            await stream.send_chunk([HERE])
            await eventually_async(lambda: len(controller.points()) == 2)  # the worker waits
            for _ in range(2):
                await stream.send_chunk([HERE] * 1000)
            apart = [[near(way)] * 1000 for way in (0.15, -0.15)]
            both = [asyncio.create_task(stream.send_chunk(each)) for each in apart]
            await anyio.wait_all_tasks_blocked()
            goes_on.set()
            first, second = await asyncio.gather(*both, return_exceptions=True)
            await stream._session.close(at_once=True)
    assert first is None
    assert isinstance(second, SetPointTooFar)


async def test_a_stream_says_what_chunks_need(controller: Controller) -> None:
    servo = controller.servo
    refused: dict[str, Any] = {
        "latest": {"latest": True, "source_rate": 30, "upsample": "cubic"},
        "source_rate": {"upsample": "cubic"},
        "upsample": {"source_rate": 30},
    }
    for name, wrong in refused.items():
        with pytest.raises(ParameterError, match=name):
            servo.joints(v=1.0, a=5.0, chunks=True, **wrong)
    async with servo.joints(v=1.0, a=5.0, options=THREAD) as stream:
        with pytest.raises(ParameterError, match="chunks=True"):
            await stream.send_chunk([near(0.0)])


@workers
async def test_an_envelope_of_as_many_limits_as_are_allowed(
    controller: Controller, options: WorkerOptions
) -> None:
    """Each is turned, and has a name that takes six bytes for each of its letters."""
    zones = [
        Zone.box([3.1 + n / 7, 1 / 3, 1 / 7, 0.3, 0.7, 0.1], [1 / 3] * 3, name=f"{'区' * 61}{n}")
        for n in range(100)
    ]

    async def envelope(_: object) -> CheckedEnvelope:
        return Envelope("gcr5_910", *zones).packed([0.0] * 6), [0.0] * 6, 0.1

    servo = Servo(replace(controller.endpoint, envelope=envelope))
    async with servo.joints(v=1.0, a=5.0, options=options) as stream:
        await stream.send(HERE)
    assert controller.points()[-1] == pytest.approx(HERE)


@pytest.mark.slow
@pytest.mark.parametrize("then", ["refuses a set-point", "refuses the stop"])
async def test_the_envelope_stays_the_reason_whatever_fails_after_it(
    controller: Controller, then: str
) -> None:
    """The arm brakes before a wall, and the controller refuses something meanwhile."""
    step = 1e-3
    wall = Zone.plane((0, 0.1, 0), (0, -1, 0), bodies=("tool",), name="wall")
    packed = Envelope("gcr5_910", wall).packed([0.0] * 6)
    arm = kinematics.arm("gcr5_910")
    begin = [0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0]
    begin[0] = -math.atan2(*arm.fkine(begin)[[1, 0], 3]) - 0.1
    controller.server.answer("get_actual_joints_position", begin)

    async def envelope(_: object) -> CheckedEnvelope:
        return packed, [0.0] * 6, 0.1

    places: list[float] = []
    # The second one is answered when all are on their way: a late one would lead the arm to a hold.
    on_their_way = threading.Event()

    def servoj(joints: list[float], *_: object) -> int:
        places.append(joints[0])
        if len(places) == 2:
            assert on_their_way.wait(20.0)
        braking = len(places) > 100 and places[-1] - places[-2] < 0.9 * step
        return -1 if braking and then == "refuses a set-point" else 1001

    def stop(_: bool) -> int:
        assert then != "refuses the stop"
        return 4

    controller.server.answer("servoj", servoj)
    controller.server.answer("stop", stop)

    async def program() -> None:
        opened = Servo(replace(controller.endpoint, envelope=envelope)).joints(
            v=1.0, a=5.0, rate=500, ahead=2000, options=replace(THREAD, timeout=20.0)
        )
        async with opened as stream:
            # It is raised again, with the last word of the worker, when the stream is left.
            with contextlib.suppress(StreamLeavesEnvelope):
                for n in range(2000):
                    way = 5e-6 * n * n if n < 100 else 0.05 + step * (n - 100)
                    await stream.send([begin[0] + way, *begin[1:]])
                on_their_way.set()
                await stream.ended()

    with pytest.raises(StreamLeavesEnvelope, match="'wall': tool") as caught:
        await program()
    assert caught.value.limit == "wall"
    assert ("it is not known that the arm stands" in str(caught.value)) == (
        then == "refuses the stop"
    )
