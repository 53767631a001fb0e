"""The task follower notices ends, follows many tasks, and lets every await end."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable

import anyio
import pytest
from client.bench import HOME, POSE, Bench, under_way
from for_each import for_each

import aioduco
from aioduco import Outcome, TaskState
from aioduco.supervision import task_follower as poller
from aioduco.supervision.task_follower import FAST, STEADY, interval
from aioduco.testing import Cut, FaultProxy, Place, eventually_async


@pytest.mark.parametrize(
    ("motion", "expected"),
    [
        (lambda robot: robot.motion.movej2([0.0] * 6, v=3.0, a=300.0), 0.51),
        (lambda robot: robot.motion.movel(POSE, v=0.2, a=1.0), None),
    ],
    ids=["expected", "not expected"],
)
async def test_the_end_is_noticed_soon(
    robot: aioduco.Robot,
    bench: Bench,
    monkeypatch: pytest.MonkeyPatch,
    motion: Callable[[aioduco.Robot], aioduco.MotionCommand],
    expected: float | None,
) -> None:
    """By the next poll, which is due soon: the times of polls are tested in `test_poll_times`."""
    bench.motion_time = 600.0
    known: list[float | None] = []

    def noted(age: float, remaining: float | None = None) -> float:
        known.append(remaining)
        return interval(age, remaining)

    monkeypatch.setattr(poller, "interval", noted)
    monkeypatch.setattr(poller, "ASK_LIMIT", 60.0)  # each poll has its answer, however late
    task = await motion(robot).start()
    await eventually_async(lambda: len(known) >= 3)
    bench.arrive()
    await task
    end = bench.tasks[task.id].ended_at
    assert end is not None
    asked = [
        call.at for call in bench.received("get_noneblock_taskstate") if call.args == (task.id,)
    ]
    # the first question after the end, or the one that was on its way
    assert sum(at > end for at in asked) <= 2
    assert {remaining is None for remaining in known} == {expected is None}
    if task.expected_end is not None:
        assert task.expected_end - task.since == pytest.approx(expected)


async def test_a_motion_with_an_expected_end_is_asked_about_less_often(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 0.6
    # 1.5 rad at 3 rad/s and almost at once at that speed: 0.51 s expected.
    await robot.motion.movej2([0.0] * 6, v=3.0, a=300.0)
    (begin,) = (call.at for call in bench.received("movej2"))
    asked = [call.at - begin for call in bench.received("get_noneblock_taskstate")]
    # On its way, well before its end; a busy machine asks even less often.
    middle = [at for at in asked if 0.15 < at < 0.3]
    assert len(middle) < 0.15 / (1.5 * STEADY)
    assert len(bench.received("get_actual_joints_position")) == 1


@pytest.mark.slow
async def test_many_tasks_are_asked_about_in_turn(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 600.0  # the first goes on until all wait behind it
    tasks = [await robot.motion.movel(POSE, v=0.2, a=1.0, r=0.01).start()]
    bench.motion_time = 0.05
    tasks += [await robot.motion.movel(POSE, v=0.2, a=1.0, r=0.01).start() for _ in range(9)]
    bench.arrive()
    assert [await task for task in tasks] == [Outcome.BLENDED] * 9 + [Outcome.FINISHED]
    asked = [call.args[0] for call in bench.received("get_noneblock_taskstate")]
    counts = [asked.count(task.id) for task in tasks]
    assert all(counts)

    # Nobody is left out while the others are asked, too.
    bench.motion_time = 600.0
    living = [await robot.motion.movel(POSE, v=0.2, a=1.0, r=0.01).start() for _ in range(3)]

    def asked_again() -> bool:
        calls = bench.received("get_noneblock_taskstate")
        counts = Counter(call.args[0] for call in calls)
        return all(counts[task.id] >= 3 for task in living)

    await eventually_async(asked_again)
    await robot.stop()


async def test_a_stop_does_not_wait_for_the_next_poll(
    robot: aioduco.Robot, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = await under_way(bench, robot)
    monkeypatch.setattr(poller, "interval", lambda *_: 600.0)
    polls = robot.statistics().polls
    await eventually_async(lambda: robot.statistics().polls > polls)
    await robot.stop()
    assert task.outcome is Outcome.STOPPED


async def test_a_task_far_from_its_end_is_asked_for_with_the_samples(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 600.0

    def asked() -> int:
        return len(bench.received("get_noneblock_taskstate")) - robot.statistics().polls

    with robot.feed.subscribe() as samples:
        task = await robot.motion.movej2([0.0] * 6, v=0.003, a=1.0).start()  # 500 s expected
        await eventually_async(lambda: asked() > 3)
        assert task.state is TaskState.RUNNING
        # no sample comes: it is polled
        held = bench.hold("getRobotStatus", bench._status)
        polls = robot.statistics().polls
        await eventually_async(lambda: robot.statistics().polls > polls + 3)
        held.set()
        await anext(samples)
        await eventually_async(lambda: asked() > 6)
        bench.arrive()
        assert await task is Outcome.FINISHED
        # nor is one that has ended
        before = asked()
        for _ in range(3):
            await anext(samples)
        assert asked() <= before + 1


async def test_nothing_is_asked_when_no_task_lives(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 0.02
    await robot.motion.movej2(HOME, v=1.0, a=1.0)
    polls = robot.statistics().polls
    with anyio.move_on_after(20 * FAST):
        await anyio.sleep_forever()
    assert robot.statistics().polls == polls


async def test_a_short_loss_of_the_connection_is_survived(bench: Bench, proxy: FaultProxy) -> None:
    bench.motion_time = 0.4
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        proxy.on("get_noneblock_taskstate", Cut(Place.IN_REPLY), times=3)
        assert await task is Outcome.FINISHED
        assert "stop" not in bench.commands


async def test_a_task_that_is_lost_sight_of_ends_unknown_and_the_arm_is_stopped(
    bench: Bench, proxy: FaultProxy, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(poller, "LOST_AFTER", 0.2)
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        task = await under_way(bench, robot)
        await eventually_async(bench.moving)
        proxy.on("get_noneblock_taskstate", Cut(Place.BEFORE_REQUEST), times=None)
        with pytest.raises(aioduco.TaskUnknown, match="lost sight of") as caught:
            await task
        assert isinstance(caught.value, aioduco.ConnectionLost)
        assert task.outcome is Outcome.UNKNOWN
        await eventually_async(lambda: not bench.moving())
        assert "stop" in bench.commands


@pytest.mark.slow
@pytest.mark.parametrize("how", ["is gone", "stops answering"])
async def test_a_controller_that_fails_leaves_no_await_behind(
    bench: Bench, proxy: FaultProxy, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    monkeypatch.setattr(poller, "LOST_AFTER", 0.3)
    robot = aioduco.connect(proxy.host, proxy.port, stop_timeout=0.3, call_timeout=1.0)
    await robot.open()
    task = await under_way(bench, robot)
    if how == "is gone":
        proxy.refuse()
        proxy.cut()
    else:
        proxy.freeze()
    with anyio.fail_after(20), pytest.raises(aioduco.TaskUnknown):
        await task
    error = aioduco.ConnectError if how == "is gone" else aioduco.CallTimeout
    with anyio.fail_after(20), pytest.raises(error):
        await robot.state.robotmoving()
    # On the way out it is said that nobody knows whether the arm stands.
    with anyio.fail_after(20), pytest.raises(aioduco.StopUnconfirmed):
        await robot.aclose()


def restart(bench: Bench) -> None:
    """The controller forgets its tasks, and gives their numbers again."""
    with bench._lock:
        bench.tasks.clear()
        bench._ids = itertools.count(1000)


@for_each("stopped", [False, True])
async def test_motions_that_a_restarted_controller_has_forgotten_end(
    robot: aioduco.Robot, bench: Bench, stopped: bool
) -> None:
    for _ in range(10):  # the stops below get numbers, too
        await robot.pause()
        await robot.resume()
    tasks = [await under_way(bench, robot) for _ in range(2)]
    await eventually_async(lambda: tasks[0].state is TaskState.RUNNING)
    restart(bench)
    if stopped:  # else the loss of the first one stops the arm
        await robot.stop()
    for task in tasks:
        assert await task.wait() is Outcome.UNKNOWN


async def test_a_number_that_is_given_again_is_not_that_of_the_motion_before(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.answer("get_noneblock_taskstate", lambda _: TaskState.IDLE)
    forgotten = await under_way(bench, robot)
    restart(bench)
    bench.answer("get_noneblock_taskstate", bench.task_state)
    task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert task.id == forgotten.id
    assert await forgotten.wait() is Outcome.UNKNOWN
    bench.arrive()
    assert await task is Outcome.FINISHED


async def test_a_motion_that_was_forgotten_before_a_stop_does_not_stop_the_next_one(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.answer("get_noneblock_taskstate", lambda _: TaskState.IDLE)
    forgotten = await under_way(bench, robot)
    await robot.stop()
    bench.answer("get_noneblock_taskstate", lambda n: TaskState.RUNNING if n > forgotten.id else 0)
    task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert await forgotten.wait() is Outcome.UNKNOWN
    assert not task.done
    assert bench.commands == ["movej2", "stop", "movej2"]


async def test_closing_ends_every_task(bench: Bench) -> None:
    outcomes: list[Outcome] = []

    async with anyio.create_task_group() as tg:
        robot = aioduco.connect(bench.host, bench.port)
        await robot.open()
        for _ in range(3):
            task = await under_way(bench, robot)

            async def look_on(task: aioduco.Task = task) -> None:
                outcomes.append(await task.wait())

            tg.start_soon(look_on)
        await robot.aclose()
    assert len(outcomes) == 3
    assert set(outcomes) <= {Outcome.STOPPED, Outcome.UNKNOWN}
    assert not bench.moving()
