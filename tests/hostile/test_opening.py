"""Opening a robot on a slow controller."""

from __future__ import annotations

import asyncio
import threading
import time

import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco import HeartbeatState
from aioduco.supervision.settings import GuardKind
from aioduco.testing import eventually_async

#: s without a keep-alive after which an event loop counts as hung
STALL = 0.3


async def did_hang(robot: aioduco.Robot) -> None:
    """Check that the event loop did hang, as on a machine that stood still.

    It is on time if a keep-alive, of which ten fit into the limit, comes before the limit.
    """
    await eventually_async(lambda: robot.statistics().longest_stall > STALL * 0.8)


@pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])
async def test_a_first_beat_that_takes_longer_than_the_stall_limit_is_no_hung_loop(
    bench: Bench, guard: GuardKind | None
) -> None:
    never = threading.Event()

    def slowly(milliseconds: int) -> None:
        never.wait(0.6)  # the controller's time for an answer

    bench.answer("rpc_heartbeat", slowly)
    async with aioduco.connect(
        bench.host,
        bench.port,
        guard=guard,
        heartbeat=60.0,
        call_timeout=20.0,
        loop_stall_limit=STALL,
    ) as robot:
        assert robot.heartbeat is not None
        if robot.heartbeat.state is not HeartbeatState.BEATING or robot.heartbeat.stalls:
            await did_hang(robot)
        assert not bench.received("stop")
        try:
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        except (aioduco.HeartbeatLost, aioduco.TaskStopped):
            await did_hang(robot)


@pytest.mark.slow
@pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])
async def test_an_event_loop_that_hangs_meanwhile_is_no_controller_that_is_silent(
    bench: Bench, guard: GuardKind | None
) -> None:
    never, loop = threading.Event(), asyncio.get_running_loop()

    def hold_up_the_first(milliseconds: int) -> None:
        if len(bench.received("rpc_heartbeat")) == 1:
            loop.call_soon_threadsafe(time.sleep, 1.0)
            never.wait(0.6)

    bench.answer("rpc_heartbeat", hold_up_the_first)
    async with aioduco.connect(
        bench.host,
        bench.port,
        guard=guard,
        heartbeat=60.0,
        call_timeout=20.0,
        loop_stall_limit=STALL,
    ) as robot:
        assert not bench.received("stop")
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert len(bench.received("movej2")) == 1
