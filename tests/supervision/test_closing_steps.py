"""Leaving `async with robot`: after anything inside, the arm stands and nothing is left."""

from __future__ import annotations

import asyncio
import gc
import threading
from typing import Any

import anyio
import pytest
from client.bench import HOME, Bench, under_way
from moments import cancelled_once

import aioduco
from aioduco import Outcome, TaskState
from aioduco.errors import ParameterError, RobotStateError
from aioduco.supervision.gate import Gate
from aioduco.supervision.supervisor import Supervisor
from aioduco.testing import FaultProxy, eventually_async


def threads() -> set[str]:
    return {t.name for t in threading.enumerate() if t.name.startswith("aioduco")}


async def moving(bench: Bench, **options: Any) -> aioduco.Robot:
    """An open robot with a motion under way."""
    robot = aioduco.connect(bench.host, bench.port, **options)
    await robot.open()
    await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    return robot


async def left_standing(bench: Bench) -> None:
    assert not bench.moving()
    await eventually_async(lambda: bench.connections == 0)
    await eventually_async(lambda: not threads(), what=lambda: str(threads()))


async def test_a_motion_that_runs_is_stopped(bench: Bench) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.1
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert bench.commands == ["movej2", "stop"]
    # It was seen to stand, and the heartbeat went on until then.
    assert bench.received("robotmoving")[-1].at >= bench._stopped_at + bench.braking_time
    await left_standing(bench)


async def test_how_a_motion_ended_is_known_that_would_be_polled_much_later(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        task = await under_way(bench, robot)
        follower = robot._supervisor.stop_coordinator.follower
        await eventually_async(lambda: task.state is TaskState.RUNNING)
        follower._due[task] += 60.0
        follower._alarm.ring()
    assert task.outcome is Outcome.STOPPED


async def test_a_program_that_moved_nothing_stops_nothing(bench: Bench) -> None:
    """Somebody else's arm is moving; this program only looks on."""
    bench.motion_time = 30.0
    bench._answers["movej2"](HOME, 1.0, 1.0, 0.0, False, None, False)
    async with aioduco.connect(bench.host, bench.port) as robot:
        assert await robot.state.robotmoving()
    assert bench.commands == []
    assert bench.moving()


async def test_a_motion_that_has_ended_is_not_stopped(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert bench.commands == ["movej2"]
    await left_standing(bench)


async def test_a_detached_motion_is_stopped_when_leaving(bench: Bench) -> None:
    bench.motion_time = 30.0
    async with aioduco.connect(bench.host, bench.port, on_cancel="detach") as robot:
        async with cancelled_once(bench.moving):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert bench.moving()
    await left_standing(bench)


async def test_an_exception_inside(bench: Bench) -> None:

    async def program() -> None:
        async with aioduco.connect(bench.host, bench.port) as robot:
            await under_way(bench, robot)
            _ = 1 / 0

    with pytest.raises(ZeroDivisionError):
        await program()
    await left_standing(bench)


@pytest.mark.parametrize("name", ["stop", "pause", "abort"])
async def test_a_stop_of_another_task_is_confirmed_before_the_connections_close(
    bench: Bench, name: str
) -> None:
    """Somebody else's arm is moving, so that leaving has nothing to stop."""
    bench.motion_time, bench.braking_time = 30.0, 0.3
    bench._answers["movej2"](HOME, 1.0, 1.0, 0.0, False, None, False)
    async with (
        anyio.create_task_group() as tasks,
        aioduco.connect(bench.host, bench.port, stop_timeout=0.5) as robot,
    ):
        tasks.start_soon(getattr(robot, name))  # it raises nothing
        await eventually_async(lambda: bool(bench.received(name)))
    await left_standing(bench)


async def test_a_start_on_its_way_while_leaving_is_waited_for(bench: Bench) -> None:
    gate = bench.hold("movej2", bench._answers["movej2"])
    robot = aioduco.connect(bench.host, bench.port)
    await robot.open()
    async with anyio.create_task_group() as tg:
        tg.start_soon(under_way, bench, robot)
        await eventually_async(lambda: bench.received("movej2"))
        tg.start_soon(robot.aclose)
        await eventually_async(lambda: "closed" in repr(robot))
        with pytest.raises(aioduco.RobotStateError, match="being closed"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        gate.set()
    assert len(bench.received("movej2")) == 1
    await left_standing(bench)


@pytest.mark.slow
async def test_a_controller_that_hangs_does_not_hold_the_way_out_for_ever(
    bench: Bench, proxy: FaultProxy
) -> None:
    robot = aioduco.connect(
        proxy.host, proxy.port, call_timeout=1.0, stop_timeout=0.5, standstill_timeout=0.5
    )
    await robot.open()
    await under_way(bench, robot)
    proxy.freeze()
    with anyio.fail_after(20), pytest.raises(aioduco.StopUnconfirmed):
        await robot.aclose()
    # All but that of the messages, which ends when it has nothing to do.
    assert threads() <= {"aioduco-reports"}


async def test_closing_twice_and_opening_twice(bench: Bench) -> None:
    robot = aioduco.connect(bench.host, bench.port)
    await robot.aclose()  # not open yet: nothing to do
    async with robot:
        with pytest.raises(RobotStateError, match="opened once"):
            await robot.open()
        assert repr(robot) == f"<Robot {bench.host}:{bench.port} open, 0 live tasks>"
    await robot.aclose()
    with pytest.raises(RobotStateError, match="opened once"):
        await robot.open()
    assert repr(robot.motion) == f"<Motion of {bench.host}:{bench.port}, closed>"


async def test_opened_in_one_task_and_closed_in_another(bench: Bench) -> None:
    """As a fixture's set-up and tear-down do, or two cells of a notebook."""
    bench.motion_time = 30.0
    robot = aioduco.connect(bench.host, bench.port)
    await asyncio.ensure_future(robot.open())
    await asyncio.ensure_future(robot.motion.movej2(HOME, v=1.0, a=1.0).start())
    await asyncio.ensure_future(robot.aclose())
    await left_standing(bench)


# -- steps one by one -----------------------------------------------------------------------------


def test_steps_are_times_or_none() -> None:
    steps = aioduco.ClosingSteps(stop=2.0, modes=None)
    assert (steps.stop, steps.standstill, steps.modes) == (2.0, 5.0, None)
    for step in ("answers", "stop", "standstill", "modes"):
        with pytest.raises(ParameterError, match=f"closing_steps.{step} is 0"):
            aioduco.ClosingSteps(**{step: 0})
    with pytest.raises(ParameterError, match="closing_steps"):
        aioduco.connect("robot", closing_steps=5.0)  # type: ignore[arg-type]  # the wrong type is the point


async def test_each_step_is_logged(bench: Bench, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("DEBUG", "aioduco.supervision")
    steps = aioduco.ClosingSteps(modes=None)
    async with aioduco.connect(bench.host, bench.port, closing_steps=steps) as robot:
        robot._supervisor.stop_coordinator.modes.force_control = True
        await under_way(bench, robot)
    said = [record.getMessage().removeprefix("leaving the robot: ") for record in caplog.records]
    assert [line.split(" took ")[0] for line in said] == [
        "answers",
        "stop",
        "standstill",
        "modes is left out",
        "close",
    ]
    assert "fc_stop" not in bench.commands


async def test_without_the_stop_a_motion_may_come_to_its_end(bench: Bench) -> None:
    seen: list[bool] = []

    def arriving() -> bool:
        seen.append(bench.moving())
        bench.arrive()
        return seen[-1]

    steps = aioduco.ClosingSteps(stop=None)
    async with aioduco.connect(bench.host, bench.port, closing_steps=steps) as robot:
        await under_way(bench, robot)
        assert bench.moving()
        bench.answer("robotmoving", arriving)
    assert bench.commands == ["movej2"]
    assert seen[:2] == [True, False]
    await left_standing(bench)


async def test_without_the_stop_a_motion_that_goes_on_is_told(bench: Bench) -> None:
    bench.motion_time = 30.0
    steps = aioduco.ClosingSteps(stop=None, standstill=0.1)
    robot = await moving(bench, closing_steps=steps)
    with pytest.raises(aioduco.StopUnconfirmed, match="still moves"):
        await robot.aclose()
    assert bench.commands == ["movej2"]
    await eventually_async(lambda: bench.connections == 0)
    await eventually_async(lambda: not threads(), what=lambda: str(threads()))


async def test_without_standstill_nobody_waits_for_it(bench: Bench) -> None:
    bench.motion_time, bench.braking_time = 30.0, 30.0
    steps = aioduco.ClosingSteps(standstill=None)
    async with aioduco.connect(bench.host, bench.port, closing_steps=steps) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert bench.commands == ["movej2", "stop"]
    assert bench.moving()


async def test_a_rung_that_fails_is_followed_by_the_others(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    """The stop is refused; that the arm stands is seen all the same, and everything closes."""
    bench.motion_time = 0.3
    bench.answer("stop", -1)
    robot = await moving(bench, stop_timeout=0.1)
    with pytest.raises(aioduco.StopUnconfirmed, match=r"no stop was accepted within 0\.1 s"):
        await robot.aclose()
    await left_standing(bench)
    assert any("stop failed after" in record.getMessage() for record in caplog.records)


async def test_force_control_is_ended_once_the_arm_stands(bench: Bench) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.1
    bench.answer("fc_start", 4)
    standing: list[bool] = []

    def fc_stop() -> int:
        standing.append(not bench.moving())
        return 4

    bench.answer("fc_stop", fc_stop)
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.force.fc_start()
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        await robot.stop()  # of a program that goes on: force control is its own to end
        assert "fc_stop" not in bench.commands
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert standing == [True]
    assert bench.commands[-2:] == ["stop", "fc_stop"]
    await left_standing(bench)


async def test_force_control_is_left_on_while_the_arm_moves(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    """The manual forbids to end it then; somebody else may be moving the arm."""
    bench.motion_time = 30.0
    bench.answer("fc_start", 4)
    bench.answer("fc_stop", 4)
    steps = aioduco.ClosingSteps(modes=0.1)
    async with aioduco.connect(bench.host, bench.port, closing_steps=steps) as robot:
        await robot.force.fc_start()
        bench._answers["movej2"](HOME, 1.0, 1.0, 0.0, False, None, False)
    assert "fc_stop" not in bench.commands
    assert any("fc_stop was not sent" in record.getMessage() for record in caplog.records)


async def test_force_control_that_was_ended_is_not_ended_again(bench: Bench) -> None:
    bench.answer("fc_start", 4)
    bench.answer("fc_stop", 4)
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.force.fc_start()
        await robot.force.fc_stop()
    assert bench.commands == ["fc_start", "fc_stop"]
    bench.answer("fc_start", 7)
    async with aioduco.connect(bench.host, bench.port) as robot:
        with pytest.raises(aioduco.TaskIllegal):
            await robot.force.fc_start()
    assert bench.commands == ["fc_start", "fc_stop", "fc_start"]


async def test_force_control_whose_start_was_answered_by_no_end_is_ended(bench: Bench) -> None:
    bench.answer("fc_start", TaskState.RUNNING)
    bench.answer("fc_stop", 4)
    async with aioduco.connect(bench.host, bench.port) as robot:
        with pytest.raises(aioduco.Refused):
            await robot.force.fc_start()
    assert bench.commands == ["fc_start", "fc_stop"]


@pytest.mark.filterwarnings("ignore::ResourceWarning")
async def test_a_robot_that_is_forgotten_warns(bench: Bench) -> None:
    robot = aioduco.connect(bench.host, bench.port)
    await robot.open()
    supervisor = robot._supervisor
    with pytest.warns(ResourceWarning, match="unclosed <Robot"):
        robot.__del__()
    await supervisor.aclose()
    del robot
    gc.collect()


@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("moves", [False, True])
async def test_what_is_kept_of_a_dropped_robot_moves_the_arm_no_more(
    bench: Bench, moves: bool
) -> None:
    """Nothing would stop the arm at the program's end: the robot's stop has been sent."""
    bench.motion_time = 30.0
    robot = aioduco.connect(bench.host, bench.port, heartbeat=None)
    await robot.open()
    supervisor, motion = robot._supervisor, robot.motion
    if moves:
        await motion.movej2(HOME, v=1.0, a=1.0).start()
    del robot
    gc.collect()
    await eventually_async(lambda: not bench.moving())
    before = list(bench.commands)
    with pytest.raises(aioduco.RobotStateError, match="dropped without being closed: keep what"):
        await motion.movej2(HOME, v=1.0, a=1.0)
    assert "movej2" not in bench.commands[len(before) :]
    # its connections end, and with them its threads
    await eventually_async(lambda: supervisor.state == "closed" and not bench.connections)


async def test_a_robot_that_is_being_closed_is_closed_when_the_next_aclose_returns(
    bench: Bench,
) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.2
    robot = await moving(bench)
    first = asyncio.ensure_future(robot.aclose())
    await eventually_async(lambda: bool(bench.received("stop")))
    await robot.aclose()
    await left_standing(bench)
    await first
    await robot.aclose()  # of a robot that is closed: it returns at once


async def test_an_aclose_that_waits_is_not_cut_short(bench: Bench) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.2
    robot = await moving(bench)
    first, second = (asyncio.ensure_future(robot.aclose()) for _ in range(2))
    await eventually_async(lambda: bool(bench.received("stop")))
    second.cancel()
    with pytest.raises(asyncio.CancelledError):
        await second
    await left_standing(bench)
    await first


async def test_an_arm_that_does_not_stop_is_told_to_each_task_that_closes_its_robot(
    bench: Bench,
) -> None:
    bench.motion_time = 30.0
    robot = await moving(bench, stop_timeout=0.3, standstill_timeout=0.3)
    bench.answer("stop", -1)
    told = await asyncio.gather(robot.aclose(), robot.aclose(), return_exceptions=True)
    assert [type(error) for error in told] == [aioduco.StopUnconfirmed] * 2


@pytest.mark.parametrize("place", [(Gate, "close"), (Supervisor, "_closing_steps")])
async def test_a_closing_that_was_cut_short_is_carried_out_by_the_next_one(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, place: tuple[type, str]
) -> None:
    """There was no memory for a moment; or a signal's handler raised at that line."""
    real = getattr(*place)
    failures = [MemoryError()]

    def fail_once(*args: object) -> object:
        if failures:
            raise failures.pop()
        return real(*args)

    monkeypatch.setattr(*place, fail_once)

    async def program() -> None:
        async with aioduco.connect(bench.host, bench.port) as robot:
            await under_way(bench, robot)
            await robot.aclose()

    with pytest.raises(MemoryError):
        await program()
    await left_standing(bench)
