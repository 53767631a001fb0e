"""An event loop that ends cancels work before it began: nobody waits for it for ever."""

from __future__ import annotations

import asyncio

import pytest

from aioduco._process.reporting import reporter
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


@pytest.mark.parametrize(
    ("error", "said"), [(ValueError("a defect"), ["work failed"]), (KeyboardInterrupt(), [])]
)
def test_an_interrupt_in_the_midst_of_work_is_no_failure_of_it(
    error: BaseException, said: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    """A signal's handler raises where the loop happens to be: the command says so by itself."""
    assert reporter.flush()
    caplog.clear()  # of what earlier tests have logged
    ended: list[BaseException] = []

    async def work() -> None:
        raise error

    async def program() -> None:
        background = BackgroundTasks(ended.append)
        background.start(work(), "work")
        await background.ended()

    try:
        asyncio.run(program())
    except KeyboardInterrupt:
        assert not said
    assert ended == [error]
    assert reporter.flush()
    assert [record.getMessage() for record in caplog.records] == said
