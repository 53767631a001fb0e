"""A jog whose time the program ends, and the motion that comes after it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

import aioduco
from aioduco import HeldMotion, Jog, Outcome, Task, TaskState
from aioduco.api.motion import Motion
from aioduco.errors import StopUnconfirmed
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

#: name of the background task that ends a motion when its time is over
END = "aioduco end of a motion"


@pytest.mark.slow
async def test_a_motion_that_follows_a_jog_is_not_taken_for_it(
    duco_robot: aioduco.Robot, duco_simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The end of the jog looks whether the arm stands, and finds that the next motion moves it."""
    coordinator = duco_robot._supervisor.stop_coordinator
    stands = coordinator.standstill
    looked = asyncio.Event()
    jog = await duco_robot.motion.move_jog(Jog.joint(1, 1, vel=10)).start()

    async def moved_by_the_next(*_: object) -> None:
        await stands()
        if (task := asyncio.current_task()) is not None and task.get_name() == END:
            await jog.wait()
            looked.set()
            raise StopUnconfirmed("the arm still moves after 5 s")

    monkeypatch.setattr(coordinator, "standstill", moved_by_the_next)
    assert await jog is Outcome.FINISHED
    await looked.wait()
    there = duco_simulator.joints.array + 0.1
    assert await duco_robot.motion.movej2(there, v=1.0, a=1.0) is Outcome.FINISHED
    assert duco_robot.statistics().stops == 0


async def test_a_jog_that_its_end_does_not_stop_is_stopped(
    duco_robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def moves(*_: object) -> None:
        raise StopUnconfirmed("the arm still moves after 5 s")

    jog = await duco_robot.motion.move_jog(Jog.joint(1, 1, vel=10)).start()
    monkeypatch.setattr(duco_robot._supervisor.stop_coordinator, "standstill", moves)
    with pytest.raises(aioduco.TaskError):
        await jog
    await eventually_async(lambda: duco_robot.statistics().stops > 0)


@pytest.mark.parametrize(
    "make",
    [
        lambda motion: motion.move_jog(Jog.joint(1, 1, vel=10), time=30.0),
        lambda motion: motion.speedl([0, 0, -0.02, 0, 0, 0], a=1.0, time=30.0),
        lambda motion: motion.teach_mode(),
    ],
    ids=["move_jog", "speedl", "teach_mode"],
)
async def test_one_that_is_paused_when_its_block_is_left_is_stopped(
    duco_robot: aioduco.Robot, make: Callable[[Motion], HeldMotion]
) -> None:
    """Without an error the program's next motion would move the arm that somebody has paused."""

    async def block() -> None:
        async with make(duco_robot.motion) as task:
            assert await duco_robot.pause()
            # the pause is known, and not only asked for
            await eventually_async(lambda: task.state in {TaskState.PAUSED, TaskState.FINISHED})

    with pytest.raises(aioduco.TaskStopped, match="paused"):
        await block()
    assert not await duco_robot.resume()


@pytest.mark.parametrize("resumed", [False, True])
async def test_a_jog_that_is_paused_when_its_time_is_over_is_stopped(
    duco_robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch, *, resumed: bool
) -> None:
    jog = await duco_robot.motion.move_jog(Jog.joint(1, 1, vel=1), time=30.0).start()
    assert await duco_robot.pause()
    await eventually_async(lambda: jog.state is TaskState.PAUSED)
    if resumed:
        await duco_robot.resume()
    monkeypatch.setattr(Task, "time_over", True)
    assert await jog.wait() is (Outcome.FINISHED if resumed else Outcome.STOPPED)
