"""Cancelling a motion, at each of its awaits and in each way: the arm must stand afterwards."""

from __future__ import annotations

import asyncio
import functools
import math
import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import anyio
import pytest
from client.bench import HOME, Bench, under_way
from moments import cancelled_once

import aioduco
from aioduco import Outcome
from aioduco.supervision.concurrency import run_to_completion
from aioduco.testing import DropReply, FaultProxy, eventually, eventually_async
from aioduco.testing.cancel import cancel_at

HOWS: list[Literal["scope", "task"]] = ["scope", "task"]


@pytest.mark.parametrize("how", HOWS)
@pytest.mark.parametrize("again", [0, 3])
async def test_at_every_await_of_a_motion(
    robot: aioduco.Robot, bench: Bench, how: Literal["scope", "task"], again: int
) -> None:
    """The first cancellation, and those that follow it, find a standing arm when they are done."""
    bench.motion_time = 30.0

    async def program() -> None:
        await robot.motion.movej2(HOME, v=1.0, a=1.0)

    def looked_on(before: int) -> bool:
        return looks() > before + 5

    def looks() -> int:
        return len(bench.received("get_noneblock_taskstate"))

    for at in range(1, 30):
        looked = looks()
        # A motion lasts: the program waits at its last await until it is cancelled there, while
        # the motion is looked at again and again.
        async with cancelled_once(functools.partial(looked_on, looked)) as waited:
            run = await cancel_at(program, at, how=how, again=again)
            assert run.struck
            assert run.ended == "cancelled"
        assert not bench.moving()
        await eventually_async(lambda: not robot.tasks)
        if waited.cancelled_caught:
            break
    else:
        pytest.fail("the program has more awaits than were tried")
    # The last one was under way: it was looked at. Of those before it any may not have been sent.
    assert at > 1


@pytest.mark.parametrize("how", HOWS)
async def test_a_motion_on_its_way_is_awaited_and_stopped(
    robot: aioduco.Robot, bench: Bench, how: str
) -> None:
    """The stop must not overtake the motion: its answer is waited for first."""
    bench.motion_time = 30.0
    gate = bench.hold("movej2", bench._answers["movej2"])
    motion = robot.motion.movej2(HOME, v=1.0, a=1.0)
    if how == "scope":
        async with anyio.create_task_group() as tg:
            tg.start_soon(motion.start)
            await eventually_async(lambda: bench.received("movej2"))
            tg.cancel_scope.cancel()
            gate.set()
    else:
        task = asyncio.ensure_future(motion.start())
        await eventually_async(lambda: bench.received("movej2"))
        task.cancel()
        await asyncio.wait([task], timeout=0.05)
        assert not task.done()
        gate.set()
        with pytest.raises(asyncio.CancelledError):
            await task
    assert bench.commands == ["movej2", "stop"]
    assert not bench.moving()


async def test_a_start_that_waits_its_turn_is_not_sent(robot: aioduco.Robot, bench: Bench) -> None:
    gate = bench.hold("movej2", bench._answers["movej2"])
    async with anyio.create_task_group() as tg:
        tg.start_soon(robot.motion.movej2(HOME, v=1.0, a=1.0).start)
        await eventually_async(lambda: bench.received("movej2"))
        with anyio.move_on_after(0.05) as scope:  # in time or not, it is not sent
            await robot.motion.movej2([0.1] * 6, v=1.0, a=1.0)
        assert scope.cancelled_caught
        gate.set()
    assert len(bench.received("movej2")) == 1
    assert "stop" not in bench.commands


@pytest.mark.parametrize("timeout", [asyncio.timeout, anyio.fail_after])
async def test_timeouts_of_either_library_stop_the_arm(
    robot: aioduco.Robot, bench: Bench, timeout: object
) -> None:
    bench.motion_time = 30.0
    motion = robot.motion.movej2(HOME, v=1.0, a=1.0)

    async def asyncios() -> None:
        async with asyncio.timeout(None) as limit:
            expiring.append(lambda: limit.reschedule(asyncio.get_running_loop().time()))
            await motion

    async def anyios() -> None:
        with anyio.fail_after(math.inf) as limit:
            expiring.append(lambda: setattr(limit, "deadline", anyio.current_time()))
            await motion

    async def expire() -> None:
        await eventually_async(bench.moving)
        expiring[0]()

    expiring: list[Callable[[], None]] = []
    async with anyio.create_task_group() as tg:
        tg.start_soon(expire)
        with pytest.raises(TimeoutError):
            await (asyncios() if timeout is asyncio.timeout else anyios())
    assert bench.commands == ["movej2", "stop"]
    assert not bench.moving()


async def test_looking_on_can_be_cancelled_without_effect(
    robot: aioduco.Robot, bench: Bench
) -> None:
    task = await under_way(bench, robot)
    with anyio.move_on_after(0.02) as scope:
        await task.wait()
    assert scope.cancelled_caught
    with anyio.move_on_after(0.02) as scope:
        async for _ in task:
            pass
    assert scope.cancelled_caught
    bench.arrive()
    assert await task is Outcome.FINISHED
    assert "stop" not in bench.commands


async def test_on_cancel_pause_leaves_the_task_paused(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port, on_cancel="pause") as robot:
        task = await under_way(bench, robot)
        with anyio.move_on_after(0.05):
            await task
        assert bench.commands == ["movej2", "pause"]
        assert not bench.moving()
        await task.resume()
        bench.arrive()
        assert await task is Outcome.FINISHED


async def test_on_cancel_pause_stops_if_the_pause_is_refused(bench: Bench) -> None:
    bench.motion_time = 30.0
    bench.answer("pause", -1)
    async with aioduco.connect(bench.host, bench.port, on_cancel="pause") as robot:
        async with cancelled_once(bench.moving):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert not bench.moving()
    # If it was cancelled before its answer came, the arm is stopped at once, and once more then.
    assert bench.commands[0] == "movej2"
    assert bench.commands[1:] == ["pause", "stop"] or set(bench.commands[1:]) == {"stop"}


async def test_on_cancel_detach_lets_the_arm_move_on(robot: aioduco.Robot, bench: Bench) -> None:
    task = await under_way(bench, robot, on_cancel="detach")
    with anyio.move_on_after(0.05):
        await task
    assert bench.moving()
    bench.arrive()
    assert await task is Outcome.FINISHED
    assert bench.commands == ["movej2"]


async def test_an_answer_that_is_lost_stops_the_arm(bench: Bench, proxy: FaultProxy) -> None:
    bench.motion_time = 30.0
    async with aioduco.connect(
        proxy.host, proxy.port, call_timeout=1.0, unanswered_timeout=0.1
    ) as robot:
        proxy.on("movej2", DropReply())
        with pytest.raises(aioduco.OutcomeUnknown, match="movej2 was sent"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert set(bench.commands) == {"movej2", "stop"}
        assert not bench.moving()


@pytest.mark.slow
async def test_a_motion_that_is_served_after_the_stop_is_stopped_too(bench: Bench) -> None:
    """Its answer was lost, the stop came first, and then the controller began to move."""
    bench.motion_time = 30.0
    start = bench._answers["movej2"]
    async with aioduco.connect(bench.host, bench.port, call_timeout=1.0) as robot:
        gate = bench.hold("movej2", start)
        stop = bench._answers["stop"]

        def stopped(block: bool) -> int:
            gate.set()  # the motion is served only now
            answer: int = stop(block)
            return answer

        bench.answer("stop", stopped)
        with pytest.raises(aioduco.OutcomeUnknown):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert len(bench.tasks) >= 2
        assert not bench.moving()


INTERRUPTED = """
    import asyncio, sys
    import aioduco

    async def main():
        async with aioduco.connect({host!r}, {port}, loop_stall_limit=15.0) as robot:
            motion = robot.motion.movej2([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0)
            task = await motion.start()
            print("moving", flush=True)
            await task

    asyncio.run(main())
"""


@pytest.mark.slow
@pytest.mark.parametrize("interrupts", [1, 2, 3])
def test_ctrl_c_however_often_leaves_a_standing_arm(
    bench: Bench, tmp_path: Path, interrupts: int
) -> None:
    bench.motion_time, bench.braking_time = 30.0, 1.0
    script = tmp_path / "program.py"
    script.write_text(textwrap.dedent(INTERRUPTED.format(host=bench.host, port=bench.port)))
    program = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )

    def asked() -> int:
        return len(bench.received("robotmoving"))

    def further(before: int) -> bool:
        return asked() > before or program.poll() is not None

    try:
        assert program.stdout is not None
        assert program.stdout.readline() == "moving\n"
        program.send_signal(signal.SIGINT)
        eventually(lambda: bench.received("stop") or program.poll() is not None)
        assert bench.received("stop"), program.communicate()
        for _ in range(interrupts - 1):
            # The arm is braking, and the program waits to see it stand.
            eventually(functools.partial(further, asked()))
            program.send_signal(signal.SIGINT)
        _, errors = program.communicate(timeout=100)
    finally:
        program.kill()
        program.communicate()
    assert "KeyboardInterrupt" in errors
    assert "never awaited" not in errors
    if interrupts < 3:
        # It was seen to stand before the program ended.
        assert not bench.moving()
        assert bench.received("robotmoving")[-1].at >= bench._stopped_at + bench.braking_time
    # The third breaks the event loop itself; the stop was accepted long before.
    eventually(lambda: not bench.moving())


# -- what a signal's handler raises --------------------------------------------------------------


@pytest.mark.parametrize("step", ["send_stop", "rest"])
@pytest.mark.parametrize("way", ["stop", "cancel", "leave"])
async def test_no_error_of_a_signals_handler_breaks_off_a_stop(
    robot: aioduco.Robot, bench: Bench, monkeypatch: pytest.MonkeyPatch, way: str, step: str
) -> None:
    """A handler may raise in any line of the program, as one of SIGALRM that ends a wait does."""
    coordinator = robot._supervisor.stop_coordinator
    carry_out, raised = getattr(coordinator, step), [TimeoutError("the time is over")]

    async def interrupted(*args: object) -> None:
        if raised:
            raise raised.pop()
        await carry_out(*args)

    task = await under_way(bench, robot)
    awaiting = asyncio.ensure_future(_awaited(task))
    await anyio.wait_all_tasks_blocked()
    monkeypatch.setattr(coordinator, step, interrupted)
    if way == "cancel":
        awaiting.cancel()
    else:
        with pytest.raises(TimeoutError, match="the time is over"):
            await (robot.stop() if way == "stop" else robot.aclose())
    with pytest.raises((aioduco.TaskStopped, asyncio.CancelledError)):
        await awaiting
    assert not bench.moving()
    assert not raised


async def _awaited(task: aioduco.Task) -> None:
    await task


async def test_a_signal_handler_that_raises_twice_cuts_no_step_short() -> None:
    """Its errors come from different places of the step, and a step's own from one."""
    left = [1, 0]

    def handler() -> None:
        raise TimeoutError

    async def step() -> str:
        if len(left) == 2:
            left.pop()
            handler()
        if len(left) == 1:
            left.pop()
            handler()
        return "stands"

    result, cancelled = await run_to_completion(step)
    assert (result, type(cancelled)) == ("stands", TimeoutError)


async def test_an_error_of_a_step_itself_is_raised() -> None:
    async def fails() -> None:
        raise ValueError("a defect")

    with pytest.raises(ValueError, match="a defect"):
        await run_to_completion(fails)
