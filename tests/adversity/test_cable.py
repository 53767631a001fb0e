"""The connection breaks while the arm moves, for a moment or for good."""

from __future__ import annotations

import itertools
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AsyncExitStack, asynccontextmanager

import anyio
import pytest

import aioduco
from aioduco.errors import (
    DucoError,
    HeartbeatLost,
    StopUnconfirmed,
    TaskError,
    TaskStopped,
    TaskUnknown,
)
from aioduco.models.enums import Outcome
from aioduco.sim import Simulator
from aioduco.supervision import task_follower
from aioduco.supervision.settings import GuardKind
from aioduco.testing import Ending, FaultProxy, eventually_async

from .arm import idle, see_it_stand, unrest
from .guards import BOTH
from .program import LEFT, RIGHT

pytestmark = pytest.mark.usefixtures("guards")

#: s
HEARTBEAT = 1.0
#: s after which a task is lost, once no answer can come: patience would be in vain
LOST = 2.0


@pytest.fixture
def proxy(sim: Simulator) -> Iterator[FaultProxy]:
    with FaultProxy(sim.host, sim.port) as proxy:
        yield proxy


def connect(
    proxy: FaultProxy, guard: GuardKind | None, heartbeat: float = HEARTBEAT
) -> aioduco.Robot:
    return aioduco.connect(
        proxy.host,
        proxy.port,
        call_timeout=1.0,
        unanswered_timeout=1.0,
        connect_timeout=3.0,
        heartbeat=heartbeat,
        stop_timeout=0.5,
        standstill_timeout=0.5,
        guard=guard,
    )


@asynccontextmanager
async def moving(
    sim: Simulator, proxy: FaultProxy, guard: GuardKind | None
) -> AsyncIterator[tuple[aioduco.Robot, aioduco.Task]]:
    """A robot whose arm moves slowly; opened again if a busy machine answers its beats too late."""
    for attempt in itertools.count(1):
        async with AsyncExitStack() as stack:
            try:
                robot = await stack.enter_async_context(connect(proxy, guard))
                await robot.bring_up()
                task = await robot.motion.movej2(LEFT, v=0.05, a=4.0).start()
                await eventually_async(lambda: sim.moving)
            except DucoError:
                if attempt == 20:
                    raise
                await stack.aclose()
                continue
            yield robot, task
            return


async def move_again(robot: aioduco.Robot) -> None:
    """The program goes on; tried again if a busy machine gives the next beats too late as well."""
    for attempt in itertools.count(1):
        try:
            await robot.rearm_heartbeat(timeout=60.0)
            await robot.bring_up()
            assert await robot.motion.movej2(RIGHT, v=2.0, a=8.0) is Outcome.FINISHED
        except (HeartbeatLost, TaskError):
            if attempt == 20:
                raise
        else:
            return


def freeze(proxy: FaultProxy) -> None:
    """Nothing passes, and nobody is told."""
    proxy.freeze()


def cut(proxy: FaultProxy) -> None:
    """The connections end, and there are no new ones."""
    proxy.refuse()
    proxy.cut(Ending.RESET)


@pytest.mark.slow
@pytest.mark.parametrize(("pull", "guard"), [(freeze, None), (cut, "process")])
async def test_for_good(
    sim: Simulator,
    proxy: FaultProxy,
    pull: Callable[[FaultProxy], None],
    guard: GuardKind | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def program() -> None:
        async with moving(sim, proxy, guard) as (robot, task):
            pull(proxy)
            monkeypatch.setattr(task_follower, "LOST_AFTER", LOST)
            # what the heartbeat is for
            await eventually_async(lambda: idle(sim) and not sim.moving, what=lambda: unrest(sim))
            with pytest.raises(TaskError):
                await task
            with pytest.raises(HeartbeatLost):
                await robot.motion.movej2(RIGHT, v=0.2, a=4.0)
            with pytest.raises(StopUnconfirmed):
                await robot.stop()

    with pytest.raises(StopUnconfirmed):
        await program()
    proxy.clear()
    await see_it_stand(sim, "the cable was plugged in again")
    assert {call.request.body for call in proxy.calls("movej2")} == {
        proxy.calls("movej2")[0].request.body
    }


@pytest.mark.slow
@pytest.mark.parametrize(("pull", "guard"), [(freeze, "process"), (cut, None)])
async def test_for_a_moment(
    sim: Simulator, proxy: FaultProxy, pull: Callable[[FaultProxy], None], guard: GuardKind | None
) -> None:
    """Shorter than the heartbeat time: the arm goes on, and the program with it."""
    async with connect(proxy, guard, heartbeat=10.0) as robot:
        await robot.bring_up()
        task = await robot.motion.movej2(LEFT, v=0.2, a=4.0).start()
        await eventually_async(lambda: sim.moving)
        pull(proxy)
        await anyio.sleep_until(anyio.current_time() + 0.05)
        proxy.clear()
        assert await task is Outcome.FINISHED
        await robot.motion.movej2(RIGHT, v=2.0, a=8.0)
    await see_it_stand(sim, "the program")


@pytest.mark.slow
@pytest.mark.parametrize("pull", [freeze, cut])
@BOTH
async def test_for_longer_than_the_heartbeat(
    sim: Simulator, proxy: FaultProxy, pull: Callable[[FaultProxy], None], guard: GuardKind | None
) -> None:
    """The controller has stopped the arm; the program learns so, and may go on."""
    async with moving(sim, proxy, guard) as (robot, task):
        pull(proxy)
        await eventually_async(lambda: idle(sim) and not sim.moving, what=lambda: unrest(sim))
        proxy.clear()
        with pytest.raises(TaskStopped):
            await task
        await move_again(robot)
    await see_it_stand(sim, "the program")


@pytest.mark.slow
@BOTH
async def test_the_error_comes_as_soon_as_the_controller_has_stopped_the_arm(
    sim: Simulator, proxy: FaultProxy, guard: GuardKind | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not only when no stop was accepted in its time; what is sent next waits for the stop.

    It is so where no beat can be given: one that is not answered may reach the controller.
    """
    async with aioduco.connect(
        proxy.host, proxy.port, heartbeat=HEARTBEAT, stop_timeout=100.0, guard=guard
    ) as robot:
        await robot.bring_up()
        task = await robot.motion.movej2(LEFT, v=0.2, a=4.0).start()
        await eventually_async(lambda: sim.moving)
        cut(proxy)
        monkeypatch.setattr(task_follower, "LOST_AFTER", LOST)
        try:
            with pytest.raises(TaskUnknown) as caught:
                await task
            # On a machine that is late, so is the simulated controller.
            await eventually_async(lambda: idle(sim) and not sim.moving, 30.0)
        finally:
            proxy.clear()
        assert isinstance(caught.value.__cause__, HeartbeatLost)
        await move_again(robot)
