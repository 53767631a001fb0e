"""An event loop that ends cancels work before it began: nobody waits for it for ever."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, cast

from aioduco.errors import NotSent
from aioduco.supervision.concurrency import BackgroundTasks
from aioduco.supervision.unanswered import PendingCommands

if TYPE_CHECKING:
    from aioduco._wire.lane import WireLane


def cancel_all() -> None:
    """As `asyncio.run` does at its end."""
    for task in asyncio.all_tasks() - {asyncio.current_task()}:
        task.cancel()


async def test_work_that_never_began_is_over() -> None:
    began: list[str] = []
    over = asyncio.Event()

    async def work() -> None:
        began.append("work")

    background = BackgroundTasks(lambda error: None)
    background.start(work(), "work", over.set)
    cancel_all()
    await over.wait()
    assert not began
    assert not len(background)


async def test_a_command_that_was_never_sent_is_known_not_to_be() -> None:
    lane = cast("WireLane", cast("Any", None))  # it comes to no call
    commands = PendingCommands(BackgroundTasks(lambda error: None), 60.0)
    pending = commands.send(lane, "movej2", (), 2.0, lambda: None)
    cancel_all()
    assert await pending.wait()
    assert isinstance(pending.error, NotSent)
    assert pending.answered
