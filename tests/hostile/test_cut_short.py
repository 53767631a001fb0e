"""Work that is cancelled before it begins, or while it fails, leaves nobody waiting."""

from __future__ import annotations

import asyncio
import gc
import threading
from contextlib import suppress

import pytest

from aioduco._process.reporting import reporter
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import GuardLost, WrongProcess
from aioduco.supervision import concurrency
from aioduco.supervision.concurrency import BackgroundTasks, DaemonThread


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


async def test_a_cancellation_that_meets_the_error_of_a_thread_is_not_lost() -> None:
    begun, go = asyncio.Event(), threading.Event()
    ring = loop_callback(begun.set)

    def fail() -> None:
        ring()
        go.wait()
        raise GuardLost("no process could be started")

    thread = DaemonThread("work")
    waiting = asyncio.get_running_loop().create_task(thread.run(fail))
    await begun.wait()
    waiting.cancel()
    go.set()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    thread.end()


async def test_a_forked_child_does_not_wait_for_a_thread_of_its_parent() -> None:
    """As one that is forked while a robot is opened, and whose event loop runs on."""
    begun, go = asyncio.Event(), threading.Event()
    ring = loop_callback(begun.set)
    thread = DaemonThread("work")
    waiting = asyncio.get_running_loop().create_task(thread.run(lambda: (ring(), go.wait())))
    await begun.wait()
    thread.forked()
    with pytest.raises(WrongProcess):
        await asyncio.wait_for(waiting, 10.0)
    with pytest.raises(WrongProcess):
        await asyncio.wait_for(thread.run(go.wait), 10.0)
    go.set()
    thread.end()


async def test_work_that_goes_on_after_a_cancellation_is_cancelled_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As work that takes it for the error that came with it."""
    monkeypatch.setattr(concurrency, "_CANCEL_AGAIN", 0.01)
    begun = asyncio.Event()

    async def work() -> None:
        begun.set()
        with suppress(asyncio.CancelledError):
            await asyncio.Event().wait()
        await asyncio.Event().wait()

    background = BackgroundTasks(lambda error: None)
    background.start(work(), "work")
    await begun.wait()
    await background.aclose()
    assert not len(background)


def test_work_whose_turn_an_interrupt_took_is_not_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It never ends, and a robot that waited for it would need one Ctrl-C more to be left."""
    monkeypatch.setattr(concurrency, "_CANCEL_AGAIN", 0.01)

    async def program() -> None:
        begun = asyncio.Event()

        async def work() -> None:
            begun.set()
            await asyncio.Event().wait()

        background = BackgroundTasks(lambda error: None)
        background.start(work(), "work")
        await begun.wait()
        with monkeypatch.context() as interrupting:
            interrupting.setattr(loop, "call_soon", interrupt)
            with pytest.raises(KeyboardInterrupt):
                await background.aclose()
        await background.aclose()
        assert not len(background)

    def interrupt(*args: object, **context: object) -> None:
        raise KeyboardInterrupt

    # no runner, which would wait for the task
    loop = asyncio.new_event_loop()
    loop.run_until_complete(asyncio.wait_for(program(), 10.0))
    loop.close()
    gc.collect()  # asyncio tells that the task never ended: now, and not in another test


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
