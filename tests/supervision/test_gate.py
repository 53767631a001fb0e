"""The gate: what was asked for before a stop is not sent after it, whatever it waited for."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Awaitable, Callable
from typing import Any

import anyio
import pytest
from client.bench import HOME, POSE, Bench, under_way
from moments import on_another_thread

import aioduco
import aioduco.sync
from aioduco import Outcome
from aioduco.envelope import Envelope, Zone
from aioduco.errors import (
    HeartbeatLost,
    ParameterError,
    RobotStateError,
    StopUnconfirmed,
    TaskStopped,
)
from aioduco.supervision.gate import Gate, PermitEnding
from aioduco.testing import eventually_async

ASIDE = [0.1, 0.0, 1.5, 0.0, -1.5, 0.0]


def beating(now: float = 0.0) -> Gate:
    """A gate whose heartbeat of 1 s was answered."""
    gate = Gate(1.0, 2.0, now)
    gate.beaten(now)
    return gate


# -- the machine -----------------------------------------------------------------------------------


def test_a_permit_ends_with_the_next_stop() -> None:
    gate = beating()
    before = gate.ask("movej2", 0.1)
    with gate.stop():
        meanwhile = gate.ask("movel", 0.2)
        assert gate.waits(meanwhile, 0.2)
        with pytest.raises(TaskStopped, match="is being stopped"):
            gate.check(meanwhile, 0.2)
    gate.check(meanwhile, 0.3)
    with pytest.raises(TaskStopped, match="movej2 was not sent, since the arm was stopped"):
        gate.check(before, 0.3)


def test_a_permit_shows_whether_it_is_valid_and_what_ended_it() -> None:
    gate = beating()
    permit = gate.ask("movej2", 0.1)
    assert repr(permit) == "<Permit movej2 valid>"
    with gate.stop():
        assert repr(permit) == "<Permit movej2 stopped>"


def test_a_program_that_was_silent_for_just_the_limit_does_not_count_as_hung() -> None:
    gate = Gate(None, 2.0, 0.0)
    permit = gate.ask("movel", 1.0)
    gate.look(2.0)
    gate.check(permit, 2.0)
    gate.look(2.25)
    with pytest.raises(RobotStateError):
        gate.check(permit, 2.25)


def test_only_a_gate_that_failed_takes_no_keep_alive_any_more() -> None:
    for ending, counts in ((PermitEnding.LEFT, True), (PermitEnding.FAILED, False)):
        gate = beating()
        gate.close("it is over", ending)
        assert gate.alive(0.1) == counts


def test_keep_alives_keep_a_program_from_counting_as_hung() -> None:
    gate = Gate(None, 2.0, 0.0)
    permit = gate.ask("movel", 0.0)
    for now in (1.5, 3.0, 4.5):
        assert gate.alive(now)
    gate.look(6.0)
    gate.check(permit, 6.0)


def test_a_beat_whose_answer_came_late_does_not_shorten_the_lease() -> None:
    gate = beating()
    gate.beaten(0.6)
    gate.beaten(0.5)
    assert gate.lease == 1.6


def test_what_waits_for_a_stop_that_is_not_confirmed_is_refused_once() -> None:
    gate = beating()
    with contextlib.suppress(StopUnconfirmed), gate.stop():
        waiting = gate.ask("movej2", 0.1)
        raise StopUnconfirmed("no stop was accepted")
    with pytest.raises(StopUnconfirmed, match="Press the emergency stop"):
        gate.waits(waiting, 0.2)
    gate.check(gate.ask("movej2", 0.2), 0.2)  # the program was told, and decides


def test_a_stop_within_a_stop_does_not_open_the_gate() -> None:
    gate = beating()
    with gate.stop():
        with gate.stop():
            pass
        assert gate.stopping
    assert not gate.stopping


def test_a_heartbeat_that_lapsed_ends_permits_even_if_it_beats_again() -> None:
    gate = beating()
    permit = gate.ask("movej2", 0.5)
    gate.alive(0.9)
    gate.beaten(1.4)  # 0.4 s too late
    with pytest.raises(HeartbeatLost, match="after the program had asked"):
        gate.check(permit, 1.5)
    gate.check(gate.ask("movej2", 1.5), 1.5)


def test_a_lapse_that_nothing_reported_is_seen_at_the_last_check() -> None:
    gate = beating()
    permit = gate.ask("movej2", 0.5)
    gate.check(permit, 1.0)
    with pytest.raises(HeartbeatLost, match="does not answer"):
        gate.check(permit, 1.01)


def test_a_program_that_stood_still_is_told_first() -> None:
    ended: list[PermitEnding] = []
    gate = Gate(1.0, 2.0, 0.0, ended.append)
    gate.beaten(0.0)
    permit = gate.ask("movej2", 0.5)
    assert not gate.alive(5.0)  # it thaws
    gate.beaten(5.1)
    for asked in (lambda: gate.check(permit, 5.2), lambda: gate.ask("movej2", 5.2)):
        with pytest.raises(HeartbeatLost, match="rearm_heartbeat"):
            asked()
    assert not gate.alive(5.3)
    assert ended == [PermitEnding.HUNG, PermitEnding.LAPSED]
    gate.rearm(5.4)
    assert gate.alive(5.5)
    gate.check(gate.ask("movej2", 5.5), 5.5)


def test_without_a_heartbeat_a_standstill_ends_permits_and_closes_nothing() -> None:
    gate = Gate(None, 2.0, 0.0)
    permit = gate.ask("movej2", 1.0)
    gate.alive(9.0)
    with pytest.raises(RobotStateError, match="after the program had asked"):
        gate.check(permit, 9.0)
    gate.check(gate.ask("movej2", 9.0), 9.0)


def test_a_pause_ends_what_was_not_sent_and_no_undertaking() -> None:
    gate = beating()
    motion, block = gate.ask("movej2", 0.1), gate.ask("pick", 0.1, lasting=True)
    with gate.stop(PermitEnding.PAUSED):
        pass
    with pytest.raises(TaskStopped, match="the arm was paused"):
        gate.check(motion, 0.2)
    gate.check(gate.ask("movej2", 0.2, within=block), 0.2)
    gate.end(PermitEnding.STOPPED)
    with pytest.raises(TaskStopped, match="the arm was stopped"):
        gate.ask("movej2", 0.3, within=block)


def test_a_closed_gate_gives_no_permit() -> None:
    gate = beating()
    permit = gate.ask("movej2", 0.1)
    gate.close("the robot is being closed")
    for asked in (lambda: gate.check(permit, 0.2), lambda: gate.ask("movej2", 0.2)):
        with pytest.raises(RobotStateError, match="the robot is being closed"):
            asked()


def test_what_needs_no_beat_is_sent_before_the_first_one_and_after_a_lapse() -> None:
    ended: list[PermitEnding] = []
    gate = Gate(1.0, 20.0, 0.0, ended.append)
    gate.check(gate.ask("power_on", 0.1, moves=False), 0.2)
    gate.beaten(0.3)
    gate.look(1.4)
    gate.check(gate.ask("power_on", 1.5, moves=False), 1.6)
    assert ended == [PermitEnding.LAPSED]


def test_a_gate_shows_why_it_is_shut() -> None:
    gate = beating()
    assert repr(gate) == "<Gate open, 0 stops>"
    assert not gate.resumed
    with gate.stop():
        assert repr(gate) == "<Gate stopping, 1 stops>"
    gate.look(2.1)
    gate.close("the robot is being closed")
    assert repr(gate) == "<Gate closed, hung, 1 stops>"


def test_what_was_resumed_is_the_programs_until_it_was_seen_standing_for_a_while() -> None:
    gate = beating()
    gate.resume()
    gate.seen(0.1, standing=True)  # it has not begun to move
    gate.seen(0.2, standing=False)
    gate.seen(3.0, standing=True)
    gate.seen(3.4, standing=True)
    assert gate.resumed
    gate.seen(3.5, standing=True)
    assert not gate.resumed


def test_what_was_seen_before_it_was_resumed_does_not_count_and_a_stop_ends_it() -> None:
    gate = beating()
    gate.seen(3.0, standing=True)
    gate.resume()
    gate.seen(3.6, standing=True)
    assert gate.resumed
    with gate.stop():
        pass
    assert not gate.resumed


# -- the robot -------------------------------------------------------------------------------------


async def outcome(work: Awaitable[Any]) -> str:
    try:
        return str(await work)
    except aioduco.DucoError as exc:
        return type(exc).__name__


@contextlib.asynccontextmanager
async def held_robot(bench: Bench, read: str, answer: Any) -> Any:
    """A robot with an envelope, one of whose reads hangs until the event is set."""
    bench.motion_time = 30.0
    bench.answer("get_wobj", [0.0] * 6)
    bench.answer("get_tcp_offset", [0.0] * 6)
    held = bench.hold(read, answer)
    async with aioduco.connect(bench.host, bench.port) as robot:
        robot.envelope = Envelope("gcr5_910", Zone.plane((0, 0, -5.0), (0, 0, 1)))
        yield robot, held


ASKS: list[Callable[[aioduco.Robot], Awaitable[Any]]] = [
    lambda robot: robot.motion.movej2(HOME, v=1.0, a=1.0),
    lambda robot: robot.motion.movej2(ASIDE, v=1.0, a=1.0).start(),
    lambda robot: robot.motion.run(robot.motion.movej2(HOME, v=1.0, a=1.0)),
]
STOPS: list[Callable[[aioduco.Robot], Awaitable[Any]]] = [
    lambda robot: robot.stop(),
    lambda robot: robot.abort(),
    lambda robot: anyio.to_thread.run_sync(robot.stop_now),
    lambda robot: aioduco.stop_all([robot]),
]


@pytest.mark.parametrize("stop", STOPS, ids=["stop", "abort", "stop_now", "stop_all"])
async def test_motions_awaited_before_a_stop_are_not_sent_after_it(
    bench: Bench, stop: Callable[[aioduco.Robot], Awaitable[Any]]
) -> None:
    async with (
        held_robot(bench, "get_tcp_offset", [0.0] * 6) as (robot, held),
        anyio.create_task_group() as tg,
    ):
        outcomes: list[str] = []

        async def ask(index: int) -> None:
            outcomes.append(await outcome(ASKS[index](robot)))

        for index in range(len(ASKS)):
            tg.start_soon(ask, index)
        await eventually_async(lambda: bool(bench.received("get_tcp_offset")))
        await stop(robot)
        held.set()
        await eventually_async(lambda: len(outcomes) == len(ASKS))
        assert set(outcomes) <= {"TaskStopped", "RobotStateError"}
        assert "movej2" not in bench.commands


async def test_a_motion_behind_a_lost_one_is_not_sent_after_the_stop(bench: Bench) -> None:
    bench.motion_time = 30.0
    held = bench.hold("movej2", -1)
    async with (
        aioduco.connect(bench.host, bench.port, call_timeout=0.3) as robot,
        anyio.create_task_group() as tg,
    ):
        outcomes: list[str] = []

        async def ask(motion: Any) -> None:
            outcomes.append(await outcome(motion))

        tg.start_soon(ask, robot.motion.movej2(HOME, v=1.0, a=1.0))
        await eventually_async(lambda: bool(bench.received("movej2")))
        tg.start_soon(ask, robot.motion.movel(POSE, v=0.1, a=0.1))
        await eventually_async(lambda: bool(bench.received("stop")))
        held.set()
        await eventually_async(lambda: len(outcomes) == 2)
        assert sorted(outcomes) == ["OutcomeUnknown", "TaskStopped"]
        assert not bench.received("movel")


async def test_a_motion_asked_while_a_stop_is_confirmed_waits_for_the_standstill(
    bench: Bench,
) -> None:
    bench.motion_time, bench.braking_time = 0.1, 0.3
    async with aioduco.connect(bench.host, bench.port) as robot:
        bench.motion_time = 30.0
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        bench.motion_time = 0.05
        stood: list[bool] = []
        start = bench._answers["movel"]

        def begun(*args: Any) -> Any:
            stood.append(not bench.moving())
            return start(*args)

        bench.answer("movel", begun)
        async with anyio.create_task_group() as tg:
            tg.start_soon(robot.stop)
            await eventually_async(lambda: bool(bench.received("stop")))
            await robot.motion.movel(POSE, v=0.1, a=0.1)
        assert stood == [True]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stop", "later"),
    [
        (STOPS[0], lambda robot: robot.motion.movel(POSE, v=0.1, a=0.1)),
        (STOPS[2], lambda robot: robot.motion.movel(POSE, v=0.1, a=0.1)),
        (STOPS[0], lambda robot: robot.blocking.movel(POSE, v=0.1, a=0.1)),
    ],
    ids=["stop", "stop_now", "stop and a blocking call"],
)
async def test_a_later_motion_does_not_keep_a_stopped_one_from_its_end(
    bench: Bench,
    stop: Callable[[aioduco.Robot], Awaitable[Any]],
    later: Callable[[aioduco.Robot], Awaitable[Any]],
) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.1
    begun, polled = threading.Event(), bench._answers["get_noneblock_taskstate"]
    start = bench._answers["movel"]

    def polled_late(*args: Any) -> Any:
        if bench.received("stop"):
            assert begun.wait(10.0)
        return polled(*args)

    def begin(*args: Any) -> Any:
        begun.set()
        return start(*args)

    bench.answer("get_noneblock_taskstate", polled_late)
    bench.answer("movel", begin)
    async with aioduco.connect(bench.host, bench.port) as robot:
        stopped = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        async with anyio.create_task_group() as tg:
            tg.start_soon(outcome, stop(robot))
            await eventually_async(lambda: bool(bench.received("stop")))
            tg.start_soon(outcome, later(robot))
            with pytest.raises(TaskStopped) as caught:
                await stopped
            assert bench.moving()
            assert caught.value.__cause__ is None
            await robot.stop()


async def test_a_resume_asked_before_a_stop_is_not_sent_after_it(bench: Bench) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.3
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        outcomes: list[str] = []

        async def resume() -> None:
            outcomes.append(await outcome(robot.resume()))

        async with anyio.create_task_group() as tg:
            tg.start_soon(robot.stop)
            await eventually_async(lambda: bool(bench.received("stop")))
            tg.start_soon(resume)
            await anyio.lowlevel.checkpoint()
            tg.start_soon(robot.stop)
        assert outcomes == ["TaskStopped"]
        assert not bench.received("resume")


async def test_a_program_that_resumed_a_motion_stops_it_when_it_leaves(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port) as first:
        await under_way(bench, first, on_cancel="detach")
        await first.pause()
        async with aioduco.connect(bench.host, bench.port) as second:
            await second.resume()
            assert bench.moving()
        assert not bench.moving()


async def test_nothing_of_a_block_is_sent_after_a_stop(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        with pytest.raises(ParameterError, match="name is 3"):
            robot.permit(3)  # type: ignore[arg-type]  # that is the test
        with robot.permit("pick"):
            assert await robot.motion.movej2(HOME, v=1.0, a=1.0)
            await robot.pause()
            await robot.resume()
            assert await robot.motion.movej2(HOME, v=1.0, a=1.0)
            await robot.stop()
            with pytest.raises(TaskStopped, match="was not sent"):
                await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert await robot.motion.movej2(HOME, v=1.0, a=1.0)  # a new command
    assert bench.commands.count("movej2") == 3


async def test_nothing_of_a_block_is_sent_after_another_programs_stop(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        with robot.permit("pick"):
            task = await under_way(bench, robot)
            bench._stop(False)
            assert await task.wait() is Outcome.STOPPED
            with pytest.raises(TaskStopped, match="was not sent"):
                await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert len(bench.received("movej2")) == 1
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()  # a new command


def test_a_block_of_the_blocking_face_ends_with_a_stop_of_another_thread(bench: Bench) -> None:
    with aioduco.sync.connect(bench.host, bench.port) as robot, robot.permit("pick"):
        robot.motion.movej2(HOME, v=1.0, a=1.0)
        on_another_thread(robot.stop)
        with pytest.raises(TaskStopped):
            robot.motion.movej2(HOME, v=1.0, a=1.0)


async def test_points_for_an_arm_that_follows_are_not_sent_after_a_stop(bench: Bench) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.3
    bench.answer("start_realtime_mode", 4)
    bench.answer("end_realtime_mode", 4)
    bench.answer("realtime_data_enqueue", 4)
    point = aioduco.RealtimePoint.joint_position(HOME)
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.realtime.start_realtime_mode(0)
        outcomes: list[str] = []

        async def enqueue() -> None:
            outcomes.append(await outcome(robot.realtime.realtime_data_enqueue([point])))

        with robot._supervisor.gate.stop():
            async with anyio.create_task_group() as tg:
                tg.start_soon(enqueue)
                await anyio.lowlevel.checkpoint()
                await robot.stop()
        assert outcomes == ["TaskStopped"]
        assert not bench.received("realtime_data_enqueue")
