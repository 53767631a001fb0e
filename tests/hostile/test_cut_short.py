"""An event loop that ends cancels work before it began: nobody waits for it for ever."""

from __future__ import annotations

import asyncio

from aioduco.supervision.concurrency import BackgroundTasks


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
