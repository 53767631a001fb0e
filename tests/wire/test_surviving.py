"""A call goes on to its end, whether or not a task waits for it."""

from __future__ import annotations

import anyio
import pytest

from aioduco.errors import NotSent, OutcomeUnknown
from aioduco.testing import eventually_async

from .lanes import Gate, opened
from .servers import PATIENCE, silent


async def test_a_call_whose_wait_is_cancelled_goes_on() -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        call = lane.prepare("get_noneblock_taskstate", (7,), PATIENCE)
        lane.send(call)
        with anyio.CancelScope() as scope:
            scope.cancel()
            await call.wait()
        assert scope.cancelled_caught
        assert call.ended_at is None
        gate.open()
        assert await call.wait(PATIENCE)
        assert (call.value, call.error, call.answered) == (7, None, True)
        assert server.connections == 1
        assert lane.statistics().abandoned == 0


async def test_a_wait_with_a_limit_leaves_the_call_alone() -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        call = lane.prepare("get_noneblock_taskstate", (7,), PATIENCE)
        lane.send(call)
        assert not await call.wait(0.0)
        gate.open()
        assert await call.answer() == 7
        assert server.connections == 1


async def test_an_answer_that_is_not_awaited_any_more_abandons_its_call() -> None:
    async with opened(silent) as (lane, server):
        call = lane.prepare("pause", (True,), PATIENCE)
        lane.send(call)
        await eventually_async(lambda: len(server.calls) == 1)
        with anyio.CancelScope() as scope:
            scope.cancel()
            await call.answer()
        assert isinstance(call.error, OutcomeUnknown)
        assert lane.statistics().abandoned == 1


async def test_an_abandoned_command_may_have_been_carried_out() -> None:
    async with opened(silent) as (lane, server):
        call = lane.prepare("pause", (True,), PATIENCE)
        lane.send(call)
        await eventually_async(lambda: len(server.calls) == 1)
        call.abandon("no answer came in time", late=True)
        assert await call.wait(0.0)
        assert call.handed_over
        assert not call.answered
        with pytest.raises(OutcomeUnknown, match="no answer came in time"):
            await call.answer()


async def test_a_call_that_is_abandoned_while_it_waits_is_certainly_not_sent() -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        first, second = (lane.prepare("pause", (True,), PATIENCE) for _ in range(2))
        lane.send(first)
        lane.send(second)
        assert lane.statistics().waiting == 1
        second.abandon("no connection was free", late=True)
        assert lane.statistics().waiting == 0
        assert not second.handed_over
        assert second.answered
        gate.open()
        await first.answer()
        with pytest.raises(NotSent, match="no connection was free"):
            await second.answer()
        assert server.names == ["pause"]
        assert (lane.statistics().abandoned, lane.statistics().failed) == (0, 0)
