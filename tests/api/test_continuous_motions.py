"""Continuous motions end by their end function, after their time, or by a stop.

Every test runs against two controllers: one whose task lasts as long as the motion, and one that
has finished the task as soon as the motion has begun. The manual allows both.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import anyio
import pytest
from client.bench import BenchTask
from moments import cancelled_once

import aioduco
from aioduco import HeldMotion, Jog, Outcome, ProgramState, Task
from aioduco.supervision import task_follower, task_state
from aioduco.testing import eventually_async
from api.desk import Desk

DOWN = [0.0, 0.0, -0.02, 0.0, 0.0, 0.0]
TURN = [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
UP = Jog.joint(2, 1, 10)

#: each motion that moves on, by its ending
MAKE: dict[str, Callable[[aioduco.Robot, float | None], Any]] = {
    "speedj": lambda robot, t: robot.motion.speedj(TURN, a=1.0, time=t),
    "speedl": lambda robot, t: robot.motion.speedl(DOWN, a=1.0, time=t),
    "move_jog": lambda robot, t: robot.motion.move_jog(UP, time=t),
    "move_jog_eaxis": lambda robot, t: robot.external_axes.move_jog_eaxis("rail", 1, 5, time=t),
}
ENDING = {"speedj": "speed_stop", "speedl": "speed_stop", "move_jog": "stop_manual_move"}


@pytest.fixture(params=[False, True], ids=["task lasts", "task ends early"], autouse=True)
def early(desk: Desk, request: pytest.FixtureRequest) -> bool:
    desk.early = request.param
    return desk.early


@pytest.fixture(params=list(MAKE))
def name(request: pytest.FixtureRequest) -> str:
    value: str = request.param
    return value


@pytest.mark.cases(2)
async def test_it_is_over_when_the_arm_stands_after_its_time(
    robot: aioduco.Robot, desk: Desk, name: str
) -> None:
    begin = time.monotonic()
    assert await MAKE[name](robot, 0.3) is Outcome.FINISHED
    assert time.monotonic() - begin >= 0.3
    assert not desk.moving()
    if name != "move_jog_eaxis":
        assert "stop" not in desk.commands


async def test_leaving_its_block_ends_it_by_its_own_function(
    robot: aioduco.Robot, desk: Desk, name: str
) -> None:
    async with MAKE[name](robot, None) as task:
        await eventually_async(desk.moving)
        assert not task.done
    assert not desk.moving()
    assert task.outcome in {Outcome.FINISHED, Outcome.STOPPED}
    ending = ENDING.get(name, "stop")
    assert desk.commands == [name, ending]
    await robot.aclose()
    assert desk.commands == [name, ending]  # nothing is left to stop


async def test_it_can_be_ended_from_elsewhere(robot: aioduco.Robot, desk: Desk) -> None:
    task = await robot.motion.speedl(DOWN, a=1.0, time=None).start()
    await eventually_async(desk.moving)
    await robot.motion.speed_stop()
    assert not desk.moving()
    assert await task is Outcome.FINISHED
    assert await task.end() is Outcome.FINISHED
    jog = await robot.motion.move_jog(UP, time=None).start()
    await robot.motion.stop_manual_move()
    assert await jog is Outcome.FINISHED
    assert desk.commands == ["speedl", "speed_stop", "move_jog", "stop_manual_move"]


async def test_an_error_in_its_block_stops_the_arm(
    robot: aioduco.Robot, desk: Desk, name: str
) -> None:
    tasks: list[Task] = []

    async def block() -> None:
        async with MAKE[name](robot, None) as task:
            tasks.append(task)
            _ = 1 / 0

    with pytest.raises(ZeroDivisionError):
        await block()
    assert not desk.moving()
    assert tasks[0].outcome is Outcome.STOPPED
    assert "stop" in desk.commands


async def test_cancelling_its_await_stops_the_arm(
    robot: aioduco.Robot, desk: Desk, name: str
) -> None:
    task = await MAKE[name](robot, None).start()
    with anyio.move_on_after(0.05) as scope:
        await task
    assert scope.cancelled_caught
    assert not desk.moving()
    assert task.outcome is Outcome.STOPPED


async def test_cancelling_its_end_stops_the_arm(robot: aioduco.Robot, desk: Desk) -> None:
    task = await robot.motion.speedl(DOWN, a=1.0, time=None).start()
    desk.hold("speed_stop")
    async with cancelled_once(lambda: desk.received("speed_stop")) as scope:
        await task.end()
    assert scope.cancelled_caught
    assert not desk.moving()
    assert "stop" in desk.commands


async def test_leaving_the_robot_stops_it(desk: Desk, name: str) -> None:
    async with aioduco.connect(desk.host, desk.port) as robot:
        task = await MAKE[name](robot, None).start()
        await eventually_async(desk.moving)
    assert not desk.moving()
    assert "stop" in desk.commands
    assert task.outcome is Outcome.STOPPED


async def test_a_stop_ends_it_as_stopped(robot: aioduco.Robot, desk: Desk, name: str) -> None:
    task = await MAKE[name](robot, None).start()
    await robot.stop()
    assert not desk.moving()
    with pytest.raises(aioduco.TaskStopped):
        await task
    with pytest.raises(aioduco.TaskStopped):
        await task.end()


async def test_an_arm_that_stands_before_its_time_ended_as_the_controller_says(
    robot: aioduco.Robot, desk: Desk, early: bool
) -> None:
    task = await robot.motion.speedl(DOWN, a=1.0, time=30.0).start()
    await eventually_async(desk.moving)
    desk.halted()  # it met an obstacle, say
    # No time of ours makes anything else of it: the controller's may go faster.
    assert await task is Outcome.FINISHED


async def test_one_that_somebody_has_paused_has_not_ended(
    robot: aioduco.Robot, desk: Desk, early: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It goes on when anybody resumes, and leaving the robot would stop nothing."""
    if not early:
        return  # the state of its task says it
    monkeypatch.setattr(task_follower, "STOOD", 0.0)
    desk.states[1] = ProgramState.PAUSED
    desk.answer("robotmoving", False)
    task = await robot.motion.speedl(DOWN, a=1.0, time=30.0).start()
    await eventually_async(lambda: task.done or len(desk.received("get_robot_state")) > 5)
    assert not task.done
    desk.states[1] = ProgramState.STOPPED
    assert await task is Outcome.FINISHED


async def test_an_ending_that_is_refused_becomes_a_stop(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("speed_stop", -1)
    tasks: list[Task] = []

    async def block() -> None:
        async with robot.motion.speedl(DOWN, a=1.0, time=None) as task:
            tasks.append(task)
            await eventually_async(desk.moving)

    with pytest.raises(aioduco.Refused, match="speed_stop"):
        await block()
    assert not desk.moving()
    assert tasks[0].outcome in {Outcome.STOPPED, Outcome.FINISHED}
    assert desk.commands[-1] == "stop"


async def test_an_ending_without_effect_becomes_a_stop(desk: Desk) -> None:
    desk.deaf = True
    async with aioduco.connect(desk.host, desk.port, standstill_timeout=0.2) as robot:
        task = await robot.motion.speedl(DOWN, a=1.0, time=None).start()
        await robot.motion.speed_stop()
        assert not desk.moving()
        assert desk.commands[-1] == "stop"
        assert await task.wait() in {Outcome.STOPPED, Outcome.FINISHED}


async def test_an_ending_without_effect_on_what_is_paused_becomes_a_stop(
    robot: aioduco.Robot, desk: Desk, early: bool
) -> None:
    """It would go on when anybody resumes, after its block was left."""
    desk.motion_time, desk.deaf = 30.0, True
    desk.moves("speedl")
    if early:
        begun = desk._answers["speedl"]

        def start(*args: Any) -> int:
            begun(*args)
            return desk._add(BenchTask("speedl", 0.0, 0.0, motion=False))

        desk.answer("speedl", start)

    async def block() -> None:
        async with robot.motion.speedl(DOWN, a=1.0, time=None):
            await eventually_async(desk.moving)
            await robot.pause()

    with pytest.raises(aioduco.TaskStopped):
        await block()
    desk._resume(False)
    assert not desk.moving()


async def test_nothing_to_end_stops_nothing(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("speed_stop", -1)
    with pytest.raises(aioduco.Refused):
        await robot.motion.speed_stop()
    assert desk.commands == ["speed_stop"]


async def test_a_controller_that_forgets_the_time_is_stopped(
    robot: aioduco.Robot, desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(task_state, "_BRAKING", 0.1)
    desk.forgets_time = True
    with pytest.raises(aioduco.TaskOverdue, match="the arm was stopped"):
        await robot.motion.speedl(DOWN, a=1.0, time=0.05)
    assert not desk.moving()


async def test_velocities_have_an_end_unless_none_is_asked_for(
    robot: aioduco.Robot, desk: Desk
) -> None:
    for motion in (robot.motion.speedj(TURN, a=1.0), robot.motion.speedl(DOWN, a=1.0)):
        motion.mark_used()
        assert motion.command.args[2] == 1000
        assert motion.command.continuous is not None
        assert motion.command.continuous.limit == 3.0
    jog = robot.motion.move_jog(UP)
    jog.mark_used()
    assert jog.command.continuous is not None
    assert jog.command.continuous.time == 1.0
    endless = robot.motion.speedl(DOWN, a=1.0, time=None)
    endless.mark_used()
    assert endless.command.args[2] == -1
    assert endless.command.continuous is not None
    assert endless.command.continuous.limit is None


async def test_a_second_velocity_takes_over_from_the_first(
    robot: aioduco.Robot, desk: Desk
) -> None:
    first = await robot.motion.speedl(DOWN, a=1.0, time=30.0).start()
    await eventually_async(desk.moving)
    async with robot.motion.speedl(TURN, a=1.0, time=30.0) as second:
        assert await first is Outcome.BLENDED
        assert desk.moving()
        assert not second.done
    assert not desk.moving()


async def test_a_step_ends_by_itself(robot: aioduco.Robot, desk: Desk) -> None:
    desk.moves("move_jog")
    desk.motion_time = 0.02
    jog = robot.motion.move_jog(Jog.joint(1, -1, 10, step=0.01), time=None)
    assert jog.command.continuous is None
    assert await jog is Outcome.FINISHED
    async with jog:
        pass
    assert desk.commands == ["move_jog", "move_jog"]


async def test_what_goes_on_is_stopped_where_others_are_paused(desk: Desk) -> None:
    async with aioduco.connect(desk.host, desk.port, on_cancel="pause") as robot:
        async with cancelled_once(desk.moving):
            await robot.motion.speedl(DOWN, a=1.0, time=None)
        assert not desk.moving()
        assert "stop" in desk.commands
        assert "pause" not in desk.commands


def guiding(robot: aioduco.Robot) -> HeldMotion:
    return robot.motion.teach_mode()


@pytest.mark.cases(1)
async def test_hand_guiding_lasts_until_its_block_is_left(robot: aioduco.Robot, desk: Desk) -> None:
    async with guiding(robot) as task:
        with anyio.move_on_after(2 * task_state.STOOD) as scope:
            await task.wait()  # nobody pushes the arm, so it stands
        assert scope.cancelled_caught
        assert not task.done
    assert not desk.going_on
    assert task.outcome is Outcome.FINISHED
    assert desk.commands == ["teach_mode", "end_teach_mode"]


@pytest.mark.parametrize("way", ["error", "stop", "leave", "cancel"])
async def test_hand_guiding_never_stays_on(desk: Desk, way: str) -> None:
    """A stop may leave it on, as here: it is ended by its own function besides."""
    async with aioduco.connect(desk.host, desk.port) as robot:
        task = await guiding(robot).start()
        match way:
            case "error":
                with pytest.raises(ZeroDivisionError):
                    async with guiding(robot):
                        _ = 1 / 0
            case "stop":
                await robot.stop()
            case "cancel":
                with anyio.move_on_after(0.02):
                    await task
            case _:
                pass
        still: bool = desk.going_on
        assert still is (way == "leave")
    assert not desk.going_on
    assert desk.commands.index("stop") < desk.commands.index("end_teach_mode")


async def test_hand_guiding_is_ended_once_the_stop_was_accepted(
    robot: aioduco.Robot, desk: Desk
) -> None:
    """Now and then a keep-alive ended it before."""
    await guiding(robot).start()
    let = desk.hold("stop", desk._answers["stop"])
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(robot.stop)
        await eventually_async(lambda: desk.received("stop"))
        robot._supervisor.dispatcher.look()
        for _ in range(3):
            await robot.state.get_tcp_pose()
        assert desk.received("end_teach_mode") == ()
        let.set()
    assert not desk.going_on


async def test_that_hand_guiding_was_not_ended_is_said_in_words(
    desk: Desk, caplog: pytest.LogCaptureFixture
) -> None:
    desk.answer("end_teach_mode", -1)
    async with aioduco.connect(desk.host, desk.port) as robot:
        await guiding(robot).start()
        await robot.stop()
        await eventually_async(lambda: "end_teach_mode after a stop failed" in caplog.text)
    assert "Refused(" not in caplog.text


async def test_hand_guiding_that_is_refused_leaves_nothing_to_end(
    robot: aioduco.Robot, desk: Desk
) -> None:
    desk.answer("teach_mode", -1)
    with pytest.raises(aioduco.Refused):
        await guiding(robot)
    await robot.aclose()
    assert desk.commands == ["teach_mode"]


async def test_hand_guiding_is_entered_and_left_by_two_calls(
    robot: aioduco.Robot, desk: Desk
) -> None:
    assert await guiding(robot) is Outcome.FINISHED
    entered: bool = desk.going_on
    assert entered
    (task,) = robot.tasks
    await robot.motion.end_teach_mode()
    assert not desk.going_on
    assert task.outcome is Outcome.FINISHED
    await robot.aclose()
    assert desk.commands == ["teach_mode", "end_teach_mode"]


async def test_hand_guiding_for_a_time_is_ended_by_the_program(
    robot: aioduco.Robot, desk: Desk
) -> None:
    assert await robot.motion.teach_mode(time=0.05) is Outcome.FINISHED
    assert not desk.going_on
    assert desk.commands == ["teach_mode", "end_teach_mode"]


async def test_hand_guiding_for_a_time_lasts_until_its_end_is_answered(
    robot: aioduco.Robot, desk: Desk
) -> None:
    """Also if the controller says before that its task is over, and the arm stands."""
    desk.early = True
    answer = desk.hold("end_teach_mode", desk._ending("end_teach_mode"))
    task = await robot.motion.teach_mode(time=0.05).start()
    await eventually_async(lambda: bool(desk.received("end_teach_mode")))
    with anyio.move_on_after(0.2) as scope:
        await task.wait()
    assert scope.cancelled_caught
    answer.set()
    assert await task is Outcome.FINISHED
