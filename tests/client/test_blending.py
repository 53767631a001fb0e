"""Blended motions: several in a row, of which the blended ones count as success."""

from __future__ import annotations

import math
import threading

import anyio
import pytest
from moments import cancelled_once

import aioduco
from aioduco import Outcome, TaskState
from aioduco.testing import eventually_async
from client.bench import HOME, POSE, Bench, BenchTask


def motions(robot: aioduco.Robot, radii: list[float]) -> list[aioduco.MotionCommand]:
    return [robot.motion.movel(POSE, v=0.2, a=0.2, r=r) for r in radii]


def three_legs(robot: aioduco.Robot) -> list[aioduco.MotionCommand]:
    """Of which the last ones may not be sent."""
    legs = motions(robot, [0.02, 0.02, 0.0])
    for leg in legs:
        leg.mark_used()
    return legs


async def test_run_sends_ahead_and_blends(robot: aioduco.Robot, bench: Bench) -> None:
    bench.lead("movel", 3)
    outcomes = await robot.motion.run(*motions(robot, [0.02, 0.02, 0.0]))
    assert outcomes == (Outcome.BLENDED, Outcome.BLENDED, Outcome.FINISHED)
    first, second, third = bench.tasks.values()
    # Each was there before the one before it ended: otherwise the arm would have stopped.
    assert first.state is second.state is TaskState.INTERRUPT
    assert third.state is TaskState.FINISHED
    assert bench.commands == ["movel"] * 3


async def test_run_keeps_the_controllers_queue_short(robot: aioduco.Robot, bench: Bench) -> None:
    live = bench.lead("movel", 10)
    outcomes = await robot.motion.run(*motions(robot, [0.01] * 9 + [0.0]), ahead=2)
    assert outcomes == (Outcome.BLENDED,) * 9 + (Outcome.FINISHED,)
    assert max(live) == 2


async def test_starting_one_after_another_blends_too(robot: aioduco.Robot, bench: Bench) -> None:
    bench.lead("movel", 2)
    tasks = [await motion.start() for motion in motions(robot, [0.02, 0.0])]
    assert [await task for task in tasks] == [Outcome.BLENDED, Outcome.FINISHED]


async def test_a_radius_without_a_successor_just_finishes(
    robot: aioduco.Robot, bench: Bench
) -> None:
    assert await robot.motion.run(*motions(robot, [0.02])) == (Outcome.FINISHED,)


async def test_an_interruption_without_a_successor_is_an_error(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.ends = TaskState.INTERRUPT
    (motion,) = motions(robot, [0.02])
    with pytest.raises(aioduco.TaskInterrupted):
        await motion


async def test_the_successors_acceptance_is_waited_for(robot: aioduco.Robot, bench: Bench) -> None:
    """The controller has blended already, but the answer to the second start is on its way."""
    bench.motion_time = 100.0
    first, second = motions(robot, [0.02, 0.0])
    task = await first.start()
    start = bench._answers["movel"]
    gate = bench.hold("movel")

    def held(*args: object) -> int:
        answer: int = start(*args)  # accepted, but not answered yet
        bench.arrive()
        gate.wait(10)
        return answer

    bench.answer("movel", held)
    async with anyio.create_task_group() as tg:
        tg.start_soon(second.start)
        await eventually_async(lambda: task.state is TaskState.INTERRUPT)
        assert task.outcome is None
        gate.set()
    assert await task is Outcome.BLENDED
    bench.arrive()


async def test_one_that_fails_stops_those_after_it(robot: aioduco.Robot, bench: Bench) -> None:
    bench.lead("movel", 3)
    bench.ends = TaskState.ERROR
    with pytest.raises(aioduco.TaskFailed):
        await robot.motion.run(*motions(robot, [0.02, 0.02, 0.0]), ahead=2)
    assert not bench.moving()
    assert len(bench.received("movel")) == 2
    assert "stop" in bench.commands
    assert not robot.tasks


async def test_one_that_is_refused_stops_those_before_it(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 30.0
    bench.answer("movej2", -1)
    refused = robot.motion.movej2(HOME, v=1.0, a=1.0)
    with pytest.raises(aioduco.Refused):
        await robot.motion.run(*motions(robot, [0.02]), refused)
    assert not bench.moving()
    assert not robot.tasks


async def test_cancelling_a_run_stops_the_arm(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 30.0
    async with cancelled_once(bench.moving) as scope:
        await robot.motion.run(*motions(robot, [0.02, 0.02, 0.0]))
    assert scope.cancelled_caught
    assert not bench.moving()
    assert not robot.tasks


async def test_a_stop_ends_a_run(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 30.0
    async with anyio.create_task_group() as tg:

        async def run() -> None:
            with pytest.raises(aioduco.TaskStopped):
                await robot.motion.run(*motions(robot, [0.02, 0.0]))

        tg.start_soon(run)
        await eventually_async(lambda: len(robot.tasks) == 2)
        await robot.stop()
    assert bench.commands.count("movel") == 2
    assert not bench.moving()


async def test_a_stop_by_somebody_else_holds_for_what_was_sent_meanwhile(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """The controller carries out what comes after a stop as soon as the arm stands."""
    bench.motion_time = 30.0
    stopped, behind = [await motion.start() for motion in motions(robot, [0.02, 0.0])]
    bench.tasks[stopped.id].state = TaskState.STOPPED
    for task in stopped, behind:
        with pytest.raises(aioduco.TaskStopped):
            await task
    assert "stop" in bench.commands
    assert not bench.moving()


async def test_a_stop_by_somebody_else_is_not_repeated_if_nothing_was_sent_since(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 30.0
    tasks = [await motion.start() for motion in motions(robot, [0.02, 0.0])]
    bench._stop(block=False)
    for task in tasks:
        with pytest.raises(aioduco.TaskStopped):
            await task
    assert "stop" not in bench.commands


async def test_what_is_no_motion_is_refused(robot: aioduco.Robot, bench: Bench) -> None:
    with pytest.raises(aioduco.ParameterError, match=r"motions\[0\].*must be a motion"):
        await robot.motion.run("home")  # type: ignore[arg-type]  # the wrong type is the point
    with pytest.raises(aioduco.ParameterError, match="ahead is 0"):
        await robot.motion.run(ahead=0)
    assert await robot.motion.run() == ()
    assert bench.commands == []


# -- a path: motions that a program sends one by one ---------------------------------------------


@pytest.mark.slow
async def test_a_path_goes_on_while_the_arm_moves_and_blends(
    robot: aioduco.Robot, bench: Bench
) -> None:
    live = bench.lead("movel", 3)
    moving: list[bool] = []
    async with robot.motion.path() as path:
        for motion in motions(robot, [0.02, 0.02, 0.0]):
            await path.add(motion)
            moving.append(bench.moving())
    assert not bench.moving()
    assert path.outcomes == (Outcome.BLENDED, Outcome.BLENDED, Outcome.FINISHED)
    assert path.tasks == ()
    assert moving == [True] * 3
    assert max(live) == 2  # the running one and the next, as the controller reads ahead at first


async def test_alone_a_motion_with_a_radius_has_no_successor(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """What an awaited motion returns is its end at the target, whatever its radius."""
    bench.motion_time = 0.1
    for motion in motions(robot, [0.02, 0.02]):
        assert await motion is Outcome.FINISHED
        assert not bench.moving()


@pytest.mark.parametrize("noticed", [True, False])
async def test_a_path_sends_nothing_after_a_failure(
    robot: aioduco.Robot, bench: Bench, noticed: bool
) -> None:
    bench.lead("movel", 1 if noticed else 3)
    bench.ends = TaskState.ERROR

    async def along() -> None:
        first, second, third = motions(robot, [0.02, 0.02, 0.0])
        second.mark_used()
        async with robot.motion.path() as path:
            task = await path.add(first)
            if noticed:
                await task.wait()
            else:
                await path.add(second)
            await path.add(third)

    with pytest.raises(aioduco.TaskFailed):
        await along()
    assert len(bench.received("movel")) == (1 if noticed else 2)
    assert not bench.moving()
    assert not robot.tasks


async def test_a_stop_ends_a_path_and_holds_for_what_would_follow(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 30.0

    async def along(before: list[aioduco.MotionCommand]) -> None:
        (behind,) = motions(robot, [0.0])
        async with robot.motion.path(ahead=5) as path:
            for motion in before:
                await path.add(motion)
            await robot.stop()
            await path.add(behind)

    with pytest.raises(aioduco.TaskStopped):
        await along(motions(robot, [0.02]))
    assert len(bench.received("movel")) == 1
    assert not bench.moving()
    # A stop before the first motion holds for it, too: the block began before.
    with pytest.raises(aioduco.RobotStateError, match="was stopped on this path"):
        await along([])
    assert len(bench.received("movel")) == 1


async def test_an_abort_by_somebody_else_is_not_taken_for_blending(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 30.0
    legs = three_legs(robot)

    async def along() -> None:
        async with robot.motion.path() as path:
            first, _ = [await path.add(leg) for leg in legs[:2]]
            told, sent = threading.Event(), threading.Event()

            def state(task: int) -> int:
                if task == first.id:
                    told.set()
                elif not told.is_set():
                    return int(TaskState.IDLE)
                else:
                    sent.wait(0.3)  # there is time to send the third
                return int(TaskState.INTERRUPT)

            def third(*_: object) -> int:
                sent.set()
                return 2000

            bench.answer("movel", third)
            bench.answer("get_noneblock_taskstate", state)
            await path.add(legs[2])

    with pytest.raises(aioduco.TaskInterrupted):
        await along()
    assert len(bench.received("movel")) == 2


@pytest.mark.parametrize("abort", [True, False])
async def test_a_path_goes_on_when_the_task_of_another_program_has_ended(
    robot: aioduco.Robot, bench: Bench, abort: bool
) -> None:
    """That of an abort ends with the motions, when the arm stands; another one before them."""
    bench.motion_time = 30.0
    legs = three_legs(robot)
    sent: list[int] = []

    async def end_their_task(theirs: int, second: int) -> None:
        state = "get_noneblock_taskstate"
        await eventually_async(
            lambda: any(call.args == (theirs,) for call in bench.received(state))
        )
        sent.append(len(bench.received("movel")))
        with bench._lock:
            bench.tasks[theirs].state = TaskState.FINISHED
            if abort:
                bench.tasks[second].state = TaskState.INTERRUPT

    async def along() -> None:
        async with anyio.create_task_group() as tg, robot.motion.path() as path:
            _, second = [await path.add(leg) for leg in legs[:2]]
            bench.arrive()  # the first one blends into the second
            theirs = bench._add(BenchTask("theirs", 0.0, math.inf, motion=False))
            tg.start_soon(end_their_task, theirs, second.id)
            await path.add(legs[2])
            bench.arrive()
            bench.arrive()

    if abort:
        with pytest.raises(ExceptionGroup) as raised:
            await along()
        assert isinstance(raised.value.exceptions[0], aioduco.TaskInterrupted)
    else:
        await along()
    assert [*sent, len(bench.received("movel"))] == [2, 2 if abort else 3]


async def test_a_motion_that_is_sent_meanwhile_may_have_replaced_the_last_one(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """Set-points come in such fast succession."""
    bench.motion_time = 30.0
    first, second, third = motions(robot, [0.02, 0.02, 0.0])
    tasks = [await first.start(), await second.start()]
    asked, sent = threading.Event(), threading.Event()

    def state(task: int) -> int:
        if task == tasks[1].id and asked.is_set():
            sent.wait(10.0)
        elif task == tasks[1].id or task == 2000:
            return int(TaskState.RUNNING)
        asked.set()
        return int(TaskState.INTERRUPT)

    def start(*_: object) -> int:
        sent.set()
        return 2000

    bench.answer("movel", start)
    bench.answer("get_noneblock_taskstate", state)
    await eventually_async(asked.is_set)
    await third.start()
    assert [await task for task in tasks] == [Outcome.BLENDED] * 2


async def test_a_block_that_raises_stops_the_arm(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 30.0

    async def along() -> None:
        async with robot.motion.path() as path:
            await path.add(motions(robot, [0.02])[0])
            assert bench.moving()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        await along()
    assert not bench.moving()
    assert not robot.tasks


async def test_a_block_that_is_cancelled_stops_the_arm(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 30.0
    legs = three_legs(robot)
    async with cancelled_once(bench.moving) as scope, robot.motion.path() as path:
        for leg in legs:
            await path.add(leg)
    assert scope.cancelled_caught
    assert not bench.moving()
    assert not robot.tasks


async def test_a_path_takes_motions_within_its_block(robot: aioduco.Robot, bench: Bench) -> None:
    (motion,) = motions(robot, [0.02])
    path = robot.motion.path()
    with pytest.raises(aioduco.RobotStateError, match="within its block"):
        await path.add(motion)
    async with path:
        with pytest.raises(aioduco.ParameterError, match="must be a motion"):
            await path.add("home")  # type: ignore[arg-type]  # the wrong type is the point
        with pytest.raises(RuntimeError, match="make another one"):
            await path.__aenter__()
    with pytest.raises(aioduco.RobotStateError, match="within its block"):
        await path.add(motion)
    with pytest.raises(aioduco.ParameterError, match="ahead is 0"):
        robot.motion.path(ahead=0)
    assert bench.commands == []
    assert path.outcomes == ()


async def test_a_block_that_is_left_while_another_task_waits_to_add(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """After it no motion is sent, and the arm stands."""
    bench.motion_time = 100.0
    errors: list[BaseException] = []
    first, second, third = three_legs(robot)
    path = robot.motion.path(ahead=2)

    async def go_on() -> None:
        with pytest.raises(aioduco.RobotStateError, match="was left meanwhile") as told:
            await path.add(third)
        errors.append(told.value)

    async def arrive() -> None:
        await eventually_async(lambda: path._closed)
        for _ in (first, second):
            bench.arrive()

    async with anyio.create_task_group() as tg:
        async with path:
            for leg in (first, second):
                await path.add(leg)
            tg.start_soon(go_on)
            await eventually_async(path._adding.locked)
            with pytest.raises(aioduco.RobotStateError, match="another task is adding"):
                await path.add(motions(robot, [0.0])[0])
            tg.start_soon(arrive)
        assert errors
        assert not bench.moving()
    assert bench.commands == ["movel"] * 2
    assert len(path.outcomes) == 2


@pytest.mark.parametrize("broken", [False, True])
async def test_a_block_that_is_left_while_another_task_sends(
    robot: aioduco.Robot, bench: Bench, broken: bool
) -> None:
    """It waits for the motion; or the motion is stopped once it is known."""
    bench.motion_time = 30.0 if broken else 0.1
    start, gate = bench._answers["movel"], threading.Event()
    reached = threading.Event()

    def held(*args: object) -> int:
        answer: int = start(*args)
        reached.set()
        gate.wait(10)
        return answer

    bench.answer("movel", held)
    path = robot.motion.path()
    told: list[str] = []

    async def add() -> None:
        try:
            await path.add(motions(robot, [0.0])[0])
        except aioduco.RobotStateError as error:
            told.append(str(error))

    async def along() -> None:
        async with path:
            tg.start_soon(add)
            await eventually_async(reached.is_set)
            if broken:
                raise ZeroDivisionError
            threading.Timer(0.05, gate.set).start()

    async with anyio.create_task_group() as tg:
        if broken:
            with pytest.raises(ZeroDivisionError):
                await along()
            gate.set()
        else:
            await along()
            assert path.outcomes == (Outcome.FINISHED,)
            assert path.tasks == ()
    assert not bench.moving()
    assert not robot.tasks
    assert ["was stopped" in text for text in told] == [True] * broken


async def test_a_motion_of_another_robot_is_no_part_of_a_path(
    robot: aioduco.Robot, bench: Bench
) -> None:
    async with aioduco.connect(robot.host, robot.port, lag_limit=None) as other:
        theirs = other.motion.movej2(HOME, v=1.0, a=1.0)
        with pytest.raises(aioduco.ParameterError, match=r"motions\[1\] .*a motion of this robot"):
            await robot.motion.run(*motions(robot, [0.0]), theirs)
        async with robot.motion.path() as path:
            with pytest.raises(aioduco.ParameterError, match="a motion of this robot"):
                await path.add(theirs)
    assert bench.commands == []
