"""Motions as values, their tasks, and how they end."""

from __future__ import annotations

import asyncio
import gc
import math
import re
import warnings
import weakref
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path

import anyio
import anyio.lowlevel
import pytest
from client.bench import HOME, POSE, Bench, under_way
from for_each import for_each
from interpreter import python

import aioduco
from aioduco import Outcome, TaskState
from aioduco._process.reporting import reporter
from aioduco.supervision.task import Task
from aioduco.supervision.task_state import added_entries
from aioduco.testing import eventually_async


async def test_a_task_tells_its_states_and_times(robot: aioduco.Robot, bench: Bench) -> None:
    task = await robot.motion.movel(POSE, v=0.1, a=0.1).start()
    assert task.id in bench.tasks
    assert task.name == "movel"
    assert (task.done, task.outcome, robot.tasks) == (False, None, (task,))
    with pytest.raises(aioduco.TaskError, match="has not ended yet"):
        task.result()
    states = [state async for state in task]
    assert states == [TaskState.IDLE, TaskState.RUNNING, TaskState.FINISHED]
    assert await task is Outcome.FINISHED
    assert task.result() is Outcome.FINISHED
    assert not robot.tasks
    assert task.started_at is not None
    assert task.ended_at is not None
    assert task.accepted_at <= task.started_at < task.ended_at
    assert task.duration == pytest.approx(task.ended_at - task.started_at, abs=30.0)
    assert task.duration > 0.0
    assert repr(task) == f"<Task {task.id} movel FINISHED finished>"
    # Once done, it can be awaited again, and its states are all there.
    assert await task is Outcome.FINISHED
    assert [state async for state in task] == states


@pytest.mark.parametrize(
    ("end", "error", "words"),
    [
        (TaskState.ERROR, aioduco.TaskFailed, "ended with an error.*Joint 4 检测到碰撞"),
        (TaskState.ILLEGAL, aioduco.TaskIllegal, r"not allowed.*bring_up\(\).*Joint 4"),
        (TaskState.PARAMETER_MISMATCH, aioduco.TaskParameterMismatch, "parameter.*Joint 4"),
        (TaskState.INTERRUPT, aioduco.TaskInterrupted, "interrupted before its end"),
        (TaskState.STOPPED, aioduco.TaskStopped, "was stopped"),
        (TaskState(42), aioduco.TaskUnknown, "lost sight of"),
    ],
)
async def test_each_bad_end_is_a_typed_error(
    robot: aioduco.Robot, bench: Bench, end: TaskState, error: type[aioduco.TaskError], words: str
) -> None:
    bench.ends = end
    bench.errors = ["of an earlier motion"]
    task = await under_way(bench, robot)
    await eventually_async(lambda: task.state is TaskState.RUNNING)
    bench.errors.append("Joint 4 检测到碰撞")
    bench.arrive()
    with pytest.raises(error, match=words) as caught:
        await task
    assert type(caught.value) is error
    assert caught.value.name == "movej2"
    assert caught.value.task_id in bench.tasks
    assert "earlier" not in str(caught.value)


async def forgotten(bench: Bench, ask: Callable[[Task], object], record: Path | None) -> None:
    """Forget a motion that has failed, after `ask` has looked at it."""

    async def forget() -> weakref.ref[Task]:
        async with aioduco.connect(bench.host, bench.port, record=record) as robot:
            task = await under_way(bench, robot)
            bench.arrive()
            await eventually_async(lambda: task.done)
            ask(task)
            return weakref.ref(task)

    task = await forget()
    await eventually_async(lambda: gc.collect() >= 0 and task() is None)
    assert reporter.flush()


#: what the log says of a failed motion of which nothing has asked how it ended
UNASKED = r"movej2 \(task \d+\) .*; nothing has asked how it ended: wait for it, or read"


@for_each("end", [TaskState.ERROR, TaskState.ILLEGAL, TaskState.PARAMETER_MISMATCH])
@pytest.mark.parametrize("recorded", [False, True])
async def test_a_failure_that_nobody_asks_about_is_logged(
    end: TaskState,
    bench: Bench,
    recorded: bool,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    bench.ends = end
    await forgotten(bench, repr, tmp_path / "run.mcap" if recorded else None)
    assert re.search(UNASKED, caplog.text)


@for_each("name", ["state", "outcome"])
async def test_a_failure_that_was_read_is_not_logged(
    name: str, bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.ends = TaskState.ERROR
    await forgotten(bench, attrgetter(name), None)
    assert "nothing has asked" not in caplog.text


@pytest.mark.parametrize(
    ("row", "numbers"), [(math.inf, ["", "2", "4", "8"]), (-1.0, [""] * 10)], ids=["row", "apart"]
)
async def test_of_many_failures_that_nobody_asks_about_few_are_logged(
    bench: Bench,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
    row: float,
    numbers: list[str],
) -> None:
    """A loop of set-points that the controller does not carry out would fill the log."""
    monkeypatch.setattr("aioduco.supervision.task._ROW", row)
    bench.ends, bench.motion_time = TaskState.ILLEGAL, 0.0

    async def forget() -> list[weakref.ref[Task]]:
        started: list[weakref.ref[Task]] = []
        async with aioduco.connect(bench.host, bench.port) as robot:
            for _ in range(10):
                started.append(weakref.ref(await robot.motion.movej2(HOME, v=1.0, a=1.0).start()))
                await eventually_async(lambda: not robot.tasks)
        return started

    tasks = await forget()
    await eventually_async(lambda: gc.collect() >= 0 and not any(task() for task in tasks))
    assert reporter.flush()
    said = re.findall(rf"{UNASKED} its outcome(?: \(number (\d+) in a row)?", caplog.text)
    assert said == numbers


async def test_a_motion_that_the_controller_refuses(robot: aioduco.Robot, bench: Bench) -> None:
    bench.answer("movel", -1)
    with pytest.raises(aioduco.Refused, match=r"refused movel \(answer -1\)"):
        await robot.motion.movel(POSE, v=0.1, a=0.1)
    assert not robot.tasks


@pytest.mark.slow
def test_a_motion_that_is_forgotten_until_the_interpreter_ends_warns() -> None:
    program = """
import aioduco
kept = type("Kept", (), {})()
kept.itself = kept
kept.motion = aioduco.connect("127.0.0.1", 1).motion.movej2([0.0] * 6, v=1.0, a=1.0)
def keep(): return kept
keep.itself = keep
"""
    where, _, warning = python("-c", program).stderr.partition(": ")
    assert where in ("sys:1", "<sys>:0")  # from Python 3.13 on the latter
    assert warning == (
        "RuntimeWarning: the motion <movej2> was never awaited or started: the arm did not move\n"
    )


async def test_a_motion_may_be_used_again(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 0.02
    motion = robot.motion.movej2(HOME, v=1.0, a=1.0)
    await motion
    await motion
    assert len(bench.received("movej2")) == 2


async def test_a_motion_that_is_never_awaited_warns(robot: aioduco.Robot, bench: Bench) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        robot.motion.movej2(HOME, v=1.0, a=1.0)
        gc.collect()
    (warning,) = caught
    assert issubclass(warning.category, RuntimeWarning)
    assert "<movej2([0, 0, 1.5, 0, -1.5, 0], v=1, a=1)> was never" in str(warning.message)
    assert "never awaited or started: the arm did not move" in str(warning.message)
    assert bench.commands == []


async def test_a_motion_tied_to_a_block_has_ended_after_it(
    robot: aioduco.Robot, bench: Bench
) -> None:
    async with robot.motion.movej2(HOME, v=1.0, a=1.0) as task:
        assert not task.done
    assert task.outcome is Outcome.FINISHED
    assert "stop" not in bench.commands


async def test_leaving_a_block_raises_the_error_of_its_motion_also_a_handled_one(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 30.0
    motion = robot.motion.movej2(HOME, v=1.0, a=1.0)
    task = await motion.__aenter__()
    await robot.stop()
    for _ in range(2):
        with pytest.raises(aioduco.TaskStopped):
            await task
    with pytest.raises(aioduco.TaskStopped):
        await motion.__aexit__(None, None, None)


async def test_a_motion_is_tied_to_one_block_at_a_time(robot: aioduco.Robot) -> None:
    motion = robot.motion.movej2(HOME, v=1.0, a=1.0)
    async with motion:
        with pytest.raises(RuntimeError, match="tied to a block already"):
            await motion.__aenter__()


async def test_a_motion_that_is_being_tied_to_a_block_is_not_tied_to_another(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """Both tasks enter their blocks before the controller has answered."""
    bench.motion_time = 30.0
    motion = robot.motion.movej2(HOME, v=1.0, a=1.0)
    first = asyncio.ensure_future(motion.__aenter__())
    await anyio.lowlevel.checkpoint()
    with pytest.raises(RuntimeError, match="tied to a block already"):
        await motion.__aenter__()
    await first
    await motion.__aexit__(ValueError, ValueError(), None)
    assert bench.commands == ["movej2", "stop"]
    bench.motion_time = 0.05
    async with motion as task:  # after it, another block may have it
        assert await task is Outcome.FINISHED


async def test_cancel_stops_and_tells_the_outcome(robot: aioduco.Robot, bench: Bench) -> None:
    task = await under_way(bench, robot)
    assert await task.cancel() is Outcome.STOPPED
    assert not bench.moving()
    with pytest.raises(aioduco.TaskStopped):
        await task
    stops = bench.commands.count("stop")
    assert await task.cancel() is Outcome.STOPPED  # nothing is left to stop
    assert bench.commands.count("stop") == stops


async def test_pause_and_resume(robot: aioduco.Robot, bench: Bench) -> None:
    task = await under_way(bench, robot)
    states = aiter(task)
    assert [await anext(states), await anext(states)] == [TaskState.IDLE, TaskState.RUNNING]
    await task.pause()
    assert await anext(states) is TaskState.PAUSED
    assert not bench.moving()
    await task.resume()
    assert await anext(states) is TaskState.RUNNING
    bench.tasks[task.id].end = 0.0
    assert await task is Outcome.FINISHED
    assert [state async for state in states] == [TaskState.FINISHED]


async def test_a_deadline_stops_the_arm(robot: aioduco.Robot, bench: Bench) -> None:
    task = await under_way(bench, robot, deadline=0.05)
    with pytest.raises(aioduco.TaskOverdue, match="did not end by its deadline") as caught:
        await task
    assert isinstance(caught.value, TimeoutError)
    assert not bench.moving()


async def test_functions_of_the_system_end_before_they_return(
    robot: aioduco.Robot, bench: Bench
) -> None:
    await robot.system.power_off()
    assert bench.states[0] == 4
    await robot.system.power_on()
    await robot.system.enable()
    assert (await robot.state.get_robot_state()).robot is aioduco.RobotState.ENABLE
    assert bench.received("power_on")[0].args == (False,)


@for_each(
    "before, after, added",
    [
        ((), ("a",), ("a",)),
        (("a",), ("a", "b"), ("b",)),
        (("a",), ("a", "a"), ("a",)),
        (("a", "b", "c"), ("b", "c", "b"), ("b",)),  # a full list drops its oldest entry
        (("a", "b"), (), ()),
        (("a", "b"), ("c", "a"), ("c",)),  # one that is sorted otherwise
        (("a", "b"), ("c", "d"), ("c", "d")),
        (("a", "b"), ("b", "a"), ("a",)),  # the oldest entry was dropped, and came again
        (("a", "b"), ("c", "a", "a"), ("c", "a")),
        (("z",), ("a", "z"), ("a",)),
    ],
)
def test_what_was_added_to_the_error_list(
    before: tuple[str, ...], after: tuple[str, ...], added: tuple[str, ...]
) -> None:
    assert added_entries(before, after) == added


async def test_an_error_carries_what_is_new(duco_robot: aioduco.Robot) -> None:
    """Neither earlier entries of the list nor those of other calls are repeated."""
    far = [3.0, 0.0, 0.5, 3.1, 0.0, -1.5]
    messages = []
    for _ in range(3):
        with pytest.raises(aioduco.TaskError) as caught:
            await duco_robot.motion.movel(far, v=0.1, a=0.1)
        assert len(caught.value.errors) == 1
        messages.append(str(caught.value).partition("; the controller")[2])
        await duco_robot.recover()  # the list stays: this wire has nothing that clears it
    assert len(set(messages)) == 1
    assert len(await duco_robot.state.get_last_error()) >= 3


async def test_a_motion_is_sent_though_the_error_list_is_not_told(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.answer("get_last_error", 42)  # no list
    assert await robot.motion.movej2(HOME, v=1.0, a=1.0) is Outcome.FINISHED


async def test_the_error_list_is_read_at_the_end_of_a_motion_and_not_before_the_next(
    robot: aioduco.Robot, bench: Bench
) -> None:
    await robot.motion.movej2(HOME, v=1.0, a=1.0)
    await eventually_async(lambda: len(bench.received("get_last_error")) == 2)
    task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert len(bench.received("get_last_error")) == 2
    await task


async def test_a_motion_has_no_errors_of_the_one_before(robot: aioduco.Robot, bench: Bench) -> None:
    bench.errors.append("old")
    bench.ends = TaskState.ERROR
    for number in range(2):
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        bench.errors.append(f"new {number}")
        with pytest.raises(aioduco.TaskFailed):
            await task
        assert task.errors == (f"new {number}",)
