"""A stop that the controller serves before a command that was sent before it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable

import anyio
import anyio.to_thread
import pytest
from client.bench import HOME, Bench, under_way

import aioduco
from aioduco import RealtimeMode
from aioduco.errors import TaskStopped
from aioduco.testing import eventually_async


class Mode:
    """Realtime control, which the controller starts only when it is let."""

    def __init__(self, bench: Bench) -> None:
        self.on = False
        self.let = bench.hold("start_realtime_mode", self._start)
        bench.answer("end_realtime_mode", self.end)

    def _start(self, *_: object) -> int:
        self.on = True
        return 4

    def end(self) -> int:
        self.on = False
        return 4


async def enter(robot: aioduco.Robot) -> None:
    with pytest.raises(TaskStopped):
        await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_POSITION)


async def test_a_mode_that_is_entered_late_is_off_when_the_stop_returns(
    robot: aioduco.Robot, bench: Bench
) -> None:
    mode = Mode(bench)
    async with anyio.create_task_group() as tg:
        tg.start_soon(enter, robot)
        await eventually_async(lambda: bench.received("start_realtime_mode"))

        async def let_late() -> None:
            await eventually_async(lambda: bench.received("end_realtime_mode"))
            mode.let.set()

        tg.start_soon(let_late)
        await robot.stop()
        assert mode.let.is_set()
        assert not mode.on


async def test_a_mode_that_is_entered_after_stop_now_is_ended(
    robot: aioduco.Robot, bench: Bench
) -> None:
    mode = Mode(bench)
    async with anyio.create_task_group() as tg:
        tg.start_soon(enter, robot)
        await eventually_async(lambda: bench.received("start_realtime_mode"))
        stopping = threading.Thread(target=robot.stop_now)
        stopping.start()
        await eventually_async(lambda: not stopping.is_alive())
        mode.let.set()
    assert not mode.on


def stopped_now(robot: aioduco.Robot) -> Awaitable[None]:
    return anyio.to_thread.run_sync(robot.stop_now)


@pytest.mark.cases(3)
@pytest.mark.parametrize("stop", [aioduco.Robot.stop, aioduco.Robot.abort, stopped_now])
async def test_a_stop_ends_a_mode_that_is_on(
    robot: aioduco.Robot, bench: Bench, stop: Callable[[aioduco.Robot], Awaitable[None]]
) -> None:
    mode = Mode(bench)
    mode.let.set()
    await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_POSITION)
    await stop(robot)
    if stop is stopped_now:  # it cannot wait for that
        await eventually_async(lambda: not mode.on)
    assert not mode.on


async def test_a_mode_is_ended_although_the_stop_is_cancelled_meanwhile(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """The call that ends it has its connection reset then, and may never arrive."""
    mode = Mode(bench)
    mode.let.set()
    await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_POSITION)
    let = bench.hold("end_realtime_mode")  # this one does not end it
    stopping = asyncio.create_task(robot.stop())
    await eventually_async(lambda: bench.received("end_realtime_mode"))
    bench.answer("end_realtime_mode", mode.end)
    stopping.cancel()
    with pytest.raises(asyncio.CancelledError):
        await stopping
    let.set()
    assert not mode.on


@pytest.mark.slow
async def test_a_mode_that_waits_for_a_stop_is_ended_by_the_next_one(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """The stop that it waits for ends the modes that were on."""
    mode = Mode(bench)
    mode.let.set()
    bench.answer("teach_mode", 4)
    bench.answer("end_teach_mode", 4)
    await robot.motion.teach_mode()
    let = bench.hold("stop", bench._stop)
    async with anyio.create_task_group() as tg:
        tg.start_soon(robot.stop)
        await eventually_async(lambda: bench.received("stop"))
        tg.start_soon(robot.realtime.start_realtime_mode, RealtimeMode.JOINT_POSITION)
        await anyio.wait_all_tasks_blocked()
        let.set()
    assert mode.on
    await robot.stop()
    assert not mode.on


async def test_a_stop_behind_a_pause_counts_for_a_motion_on_its_way(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """Its permit had ended by the pause, and the stop after that was not noticed."""
    let = bench.hold("movej2", bench._answers["movej2"])
    async with anyio.create_task_group() as tg:
        tg.start_soon(under_way, bench, robot)
        await eventually_async(lambda: bench.received("movej2"))
        tg.start_soon(robot.pause)
        await eventually_async(lambda: bench.received("pause"))
        await stopped_now(robot)
        let.set()
    bench._resume(False)
    assert not bench.moving()


async def test_abort_waits_out_what_is_on_its_way(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 30.0
    let = bench.hold("movej2", bench._motion("movej2"))
    aborted = anyio.Event()

    async def move() -> None:
        with pytest.raises(TaskStopped):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)

    async def abort() -> None:
        await robot.abort()
        assert bench.tasks
        assert not bench.moving()
        aborted.set()

    async with anyio.create_task_group() as tg:
        tg.start_soon(move)
        await eventually_async(lambda: bench.received("movej2"))
        tg.start_soon(abort)
        await eventually_async(lambda: bench.received("abort"))
        polls = len(bench.received("robotmoving"))
        await eventually_async(lambda: len(bench.received("robotmoving")) > polls + 5)
        assert not aborted.is_set()
        let.set()
