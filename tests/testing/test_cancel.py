"""A program is cancelled at each of its awaits, and nowhere else."""

from __future__ import annotations

import asyncio

import anyio
import anyio.lowlevel
import pytest
from for_each import for_each

from aioduco.testing.cancel import Cancelled, How, cancel_at, cancel_at_every_await

HOWS: list[How] = ["scope", "task"]


@for_each("how", HOWS)
async def test_every_await_is_struck_once(how: How) -> None:
    reached: list[str] = []
    runs: list[Cancelled] = []

    async def program() -> None:
        reached.append("|")
        for step in "abc":
            await anyio.sleep(0.001)
            reached.append(step)
        await asyncio.sleep(0)
        reached.append("d")

    async def check(run: Cancelled) -> None:
        runs.append(run)

    assert await cancel_at_every_await(program, check, how=how) == 4
    assert "".join(reached) == "||a|ab|abc|abcd"
    assert [(run.at, run.ended) for run in runs] == [
        *((at, "cancelled") for at in (1, 2, 3, 4)),
        (5, "returned"),
    ]
    assert not runs[-1].struck


async def test_a_shield_keeps_a_scope_away_but_not_a_task() -> None:
    async def program() -> str:
        with anyio.CancelScope(shield=True):
            await anyio.sleep(0.001)
        return "through"

    run = await cancel_at(program, 1, how="scope")
    assert (run.ended, run.struck) == ("returned", True)
    run = await cancel_at(program, 1, how="task")
    assert run.ended == "cancelled"


@for_each("how", HOWS)
async def test_what_the_program_raises_is_kept(how: How) -> None:
    async def program() -> None:
        try:
            await anyio.sleep_forever()
        finally:
            raise KeyError("arm")

    run = await cancel_at(program, 1, how=how)
    assert run.ended == "raised"
    assert isinstance(run.error, KeyError)


async def test_strikes_again_at_the_awaits_that_follow() -> None:
    async def insisting() -> int:
        cancelled = 0
        while cancelled < 3:
            try:
                await anyio.sleep(0.001)
            except asyncio.CancelledError:
                cancelled += 1
        return cancelled

    run = await cancel_at(insisting, 1, how="task", again=2)
    assert (run.strikes, run.awaits, run.ended) == (3, 3, "returned")


async def test_a_cancellation_from_outside_is_not_swallowed() -> None:
    async def program() -> None:
        scope.cancel()
        await anyio.sleep_forever()

    for how in HOWS:
        with anyio.CancelScope() as scope:
            await cancel_at(program, 100, how=how)
            pytest.fail("the cancellation was swallowed")
        assert scope.cancelled_caught


@for_each("how", HOWS)
async def test_what_was_awaited_is_cancelled_too(how: How) -> None:
    """A future that the program awaited must be seen as cancelled by whoever would resolve it."""
    future: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    async def program() -> None:
        await future

    await cancel_at(program, 1, how=how)
    assert future.cancelled()


async def test_begins_and_steps_where_it_is_told() -> None:
    struck: list[int] = []

    async def program() -> None:
        for _ in range(10):
            await anyio.lowlevel.checkpoint()

    async def check(run: Cancelled) -> None:
        struck.append(run.at)

    whole = (await cancel_at(program, 1000)).awaits
    await cancel_at_every_await(program, check, first=2, step=3)
    assert struck == list(range(2, whole + 3, 3))[: len(struck)]
    assert struck[-1] > whole >= struck[-2]
