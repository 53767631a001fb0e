"""An envelope that is set while something waits to be checked against the one before."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any

import anyio
import pytest
from client.bench import FLANGE, HOME, Bench

import aioduco
from aioduco.envelope import Envelope, Zone
from aioduco.testing import eventually_async

WIDE = Envelope("gcr5_910", Zone.plane((0, 0, -5.0), (0, 0, 1)))
OTHER = Envelope("gcr5_910", Zone.plane((0, 0, -4.0), (0, 0, 1)))


async def move(robot: aioduco.Robot) -> None:
    await robot.motion.movej2(HOME, v=1.0, a=1.0).start()


async def stream(robot: aioduco.Robot) -> None:
    keeper = robot._supervisor.envelope
    assert await keeper.of_stream("servoj", "", "", speeds=False) is not None


async def points(robot: aioduco.Robot) -> None:
    await robot._supervisor.envelope.admit("trackEnqueue", [HOME], moves=True)


@pytest.mark.cases(6)
@pytest.mark.parametrize("other", [None, OTHER], ids=["none", "another"])
@pytest.mark.parametrize("ask", [move, stream, points])
async def test_what_is_checked_meanwhile_is_not_forgotten(
    robot: aioduco.Robot,
    bench: Bench,
    ask: Callable[[aioduco.Robot], Coroutine[Any, Any, None]],
    other: Envelope | None,
) -> None:
    """It is checked by the old one to the end, and the new one watches the arm."""
    bench.answer("get_wobj", [0.0] * 6)
    bench.answer("get_tcp_offset", [0.0] * 6)
    let = bench.hold("get_flange_pose", FLANGE)
    robot.envelope = WIDE
    async with anyio.create_task_group() as tg:
        tg.start_soon(ask, robot)
        await eventually_async(lambda: bench.received("get_flange_pose"))
        robot.envelope = other
        let.set()
    if other is not None:
        assert robot._supervisor.envelope._watch.unchecked
