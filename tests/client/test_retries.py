"""Reads are repeated after a lost connection; commands are never sent again."""

from __future__ import annotations

import random
from itertools import islice

import anyio
import pytest
from hypothesis import given
from hypothesis import strategies as st

import aioduco
from aioduco.supervision.retry import FIRST, LONGEST, pauses
from aioduco.testing import Cut, FaultProxy, Place
from client.bench import Bench


@given(seed=st.integers(), count=st.integers(1, 20))
def test_pauses_grow_and_are_scattered(seed: int, count: int) -> None:
    limit = FIRST
    for pause in islice(pauses(random.Random(seed)), count):
        assert limit / 2 <= pause <= limit
        limit = min(2 * limit, LONGEST)


async def test_a_read_waits_for_the_connection(proxy: FaultProxy) -> None:
    async with aioduco.connect(proxy.host, proxy.port, call_timeout=5.0) as robot:
        proxy.refuse()
        proxy.cut()
        async with anyio.create_task_group() as tasks:
            answers: list[bool] = []

            async def ask() -> None:
                answers.append(await robot.state.robotmoving())

            tasks.start_soon(ask)
            with anyio.fail_after(5.0):
                while robot._supervisor.calls.statistics().failed < 3:
                    await anyio.lowlevel.checkpoint()
            assert answers == []
            proxy.accept()
        assert answers == [False]


@pytest.mark.slow
async def test_but_not_beyond_its_deadline(proxy: FaultProxy) -> None:
    async with aioduco.connect(proxy.host, proxy.port, call_timeout=1.0) as robot:
        proxy.refuse()
        proxy.cut()
        # Without a deadline it would be tried for ever: nothing accepts it before the end.
        with (
            anyio.fail_after(20),
            pytest.raises((aioduco.ConnectError, aioduco.ConnectionLost)),
        ):
            await robot.state.robotmoving()
        assert robot._supervisor.calls.statistics().failed > 1
        proxy.accept()


async def test_of_a_robot_that_is_not_open_it_fails_at_once(bench: Bench) -> None:
    robot = aioduco.connect(bench.host, bench.port, call_timeout=600.0)
    with anyio.fail_after(20):
        with pytest.raises(aioduco.ConnectionLost, match="is not open yet"):
            await robot.state.robotmoving()
        async with robot:
            pass
        with pytest.raises(aioduco.ConnectionLost, match="is closed"):
            await robot.state.robotmoving()


@pytest.mark.parametrize("place", [Place.AFTER_REQUEST, Place.BEFORE_REPLY, Place.IN_REPLY])
async def test_a_command_is_sent_once(bench: Bench, proxy: FaultProxy, place: Place) -> None:
    bench.answer("set_standard_digital_out", 4)
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        proxy.on("set_standard_digital_out", Cut(place))
        with pytest.raises(aioduco.OutcomeUnknown, match="was sent"):
            await robot.io.set_standard_digital_out(3, True)
    assert len(bench.received("set_standard_digital_out")) <= 1
