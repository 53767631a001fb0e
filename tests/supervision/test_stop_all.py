"""Several arms are stopped at once, before anything else runs, each whatever the others do."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import AsyncExitStack, ExitStack
from typing import Any

import anyio
import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco.supervision.settings import GuardKind
from aioduco.testing import eventually

Fleet = list[Bench]


@pytest.fixture
def fleet() -> Iterator[Fleet]:
    with ExitStack() as stack:
        benches = [stack.enter_context(Bench()) for _ in range(3)]
        for bench in benches:
            bench.motion_time = 600.0
        yield benches


async def open_all(
    stack: AsyncExitStack, fleet: Fleet, guard: GuardKind | None = None
) -> list[aioduco.Robot]:
    robots = [
        aioduco.connect(bench.host, bench.port, stop_timeout=0.5, guard=guard) for bench in fleet
    ]
    for robot in robots:
        await stack.enter_async_context(robot)
    return robots


async def move_all(robots: list[aioduco.Robot]) -> list[aioduco.Task]:
    return [await robot.motion.movej2(HOME, v=1.0, a=1.0).start() for robot in robots]


@pytest.mark.cases(1)
@pytest.mark.parametrize("guard", [None, "process"])
async def test_all_are_told_before_anything_else_runs(
    fleet: Fleet, guard: GuardKind | None
) -> None:
    def busy() -> None:
        """Hold the loop up until all stops have come."""
        eventually(lambda: all(bench.received("stop") for bench in fleet))
        came.extend(len(bench.received("stop")) for bench in fleet)

    came: list[int] = []
    async with AsyncExitStack() as stack:
        robots = await open_all(stack, fleet, guard)
        tasks = await move_all(robots)
        asyncio.get_running_loop().call_soon(busy)
        await aioduco.stop_all(robots)
        assert came == [1, 1, 1]
        assert not any(bench.moving() for bench in fleet)
        assert [await task.wait() for task in tasks] == [aioduco.Outcome.STOPPED] * 3
        assert [len(bench.received("stop")) for bench in fleet] == [1, 1, 1]


async def test_who_fails_is_named_and_the_others_stand(fleet: Fleet) -> None:
    async with AsyncExitStack() as stack:
        robots = await open_all(stack, fleet)
        await move_all(robots[:2])
        fleet[0].answer("stop", -1)
        await robots[2].aclose()
        with pytest.raises(aioduco.StopsUnconfirmed, match="of 2 of 3 arms") as caught:
            await aioduco.stop_all(robots)
        first, second, third = caught.value.errors
        assert isinstance(first, aioduco.StopUnconfirmed)
        assert second is None
        assert isinstance(third, aioduco.RobotStateError)
        assert f"{fleet[0].host}:{fleet[0].port}: " in str(caught.value)
        assert f"{fleet[2].host}:{fleet[2].port}: " in str(caught.value)
        assert fleet[0].moving()
        assert not fleet[1].moving()
        fleet[0].answer("stop", fleet[0]._stop)


async def test_a_cancellation_leaves_no_stop_behind(fleet: Fleet) -> None:
    async with AsyncExitStack() as stack:
        robots = await open_all(stack, fleet)
        await move_all(robots)
        with anyio.CancelScope() as scope:
            scope.cancel()
            await aioduco.stop_all(robots)
        assert scope.cancelled_caught
        assert not any(bench.moving() for bench in fleet)


async def test_a_stop_that_nobody_awaited_is_no_later_one(fleet: Fleet) -> None:
    """What was begun long ago says nothing of a motion that began since."""
    async with aioduco.connect(fleet[0].host, fleet[0].port) as robot:
        channel = robot._supervisor.stop_channel
        at, by = channel.begin(5.0)
        channel._begun = at - 1.0, by
        eventually(lambda: fleet[0].received("stop"))
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        await channel.stop(5.0)
        assert fleet[0].commands == ["stop", "movej2", "stop"]


async def test_a_robot_in_place_of_a_list_is_stopped(fleet: Fleet) -> None:
    async with AsyncExitStack() as stack:
        (robot,) = await open_all(stack, fleet[:1])
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        await aioduco.stop_all(robot)  # type: ignore[arg-type]  # that is the test
        assert not fleet[0].moving()
        assert await task.wait() is aioduco.Outcome.STOPPED
    with pytest.raises(aioduco.ParameterError, match="robots is None"):
        await aioduco.stop_all(None)  # type: ignore[arg-type]  # that is the test


async def test_nobody_to_stop() -> None:
    await aioduco.stop_all([])


async def test_what_is_no_robot_keeps_no_other_from_its_stop(fleet: Fleet) -> None:
    """Such as the arm of a cell that has only one, or a robot of blocking programs."""
    async with AsyncExitStack() as stack:
        robots = await open_all(stack, fleet)
        await move_all(robots)
        missing: Any = None
        with pytest.raises(
            aioduco.StopsUnconfirmed, match=r"robots\[1\]: None is no robot"
        ) as caught:
            await aioduco.stop_all([robots[0], missing, *robots[1:]])
        assert [error is None for error in caught.value.errors] == [True, False, True, True]
        assert not any(bench.moving() for bench in fleet)
