"""With no thread and no descriptor to be had, a robot is stopped and left as ever."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NoReturn

import anyio
import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco.testing import eventually_async, no_leaks

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

GUARDS = pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])


@pytest.fixture
async def bench() -> AsyncIterator[Bench]:
    async with no_leaks():
        with Bench() as bench:
            bench.motion_time = 60.0
            yield bench


def no_thread(*_: Any, **__: Any) -> NoReturn:
    """As the system says it of a process with all the threads that it may have."""
    raise RuntimeError("can't start new thread")


_start = threading.Thread.start


def only_served(thread: threading.Thread) -> None:
    """No thread but those of the controller, which needs one for each connection."""
    if thread.name.startswith("aioduco-"):
        no_thread()
    _start(thread)


def no_descriptor(*_: Any, **__: Any) -> NoReturn:
    """As the system says it of a process with all the files that it may have."""
    raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))


@contextmanager
def exhausted(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """From here on there are no more threads, sockets and other descriptors to be had.

    For this program, and not for the controller, which runs in the same process: its connections
    are there.
    """
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", no_thread)
        patch.setattr(socket, "socket", no_descriptor)
        patch.setattr(os, "pidfd_open", no_descriptor)
        patch.setattr(os, "pipe", no_descriptor)
        yield


@GUARDS
async def test_leaving_needs_no_new_thread_and_no_new_descriptor(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, guard: Any
) -> None:
    robot = aioduco.connect(bench.host, bench.port, guard=guard)
    await robot.open()
    await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    seat = robot._supervisor.guard
    process = None if seat is None else seat.pid
    with exhausted(monkeypatch):
        await robot.aclose()
    assert not bench.moving()
    assert bench.commands == ["movej2", "stop"]
    assert process is None or not alive(process)


@GUARDS
async def test_a_stop_needs_no_new_thread_and_no_new_descriptor(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, guard: Any
) -> None:
    async with aioduco.connect(bench.host, bench.port, guard=guard) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        with exhausted(monkeypatch):
            await robot.stop()
        assert not bench.moving()
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        with exhausted(monkeypatch):
            robot.stop_now()
        await eventually_async(lambda: not bench.moving())


async def test_a_cancelled_motion_is_stopped_without_a_new_thread(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        with exhausted(monkeypatch):
            with anyio.move_on_after(0.05):
                await task
            assert not bench.moving()


async def test_leaving_that_is_cancelled_again_and_again_needs_no_new_thread(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cancelled question loses its connection; the thread that had it goes on with the next."""
    robot = aioduco.connect(bench.host, bench.port)
    await robot.open()
    await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    answers = bench.hold("robotmoving", bench.moving)
    asked = len(bench.received("robotmoving"))
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", only_served)
        leaving = asyncio.ensure_future(robot.aclose())
        for number in range(1, 4):
            await eventually_async(
                lambda: len(bench.received("robotmoving")) >= asked + number  # noqa: B023
            )
            leaving.cancel()
        answers.set()
        with pytest.raises(asyncio.CancelledError):
            await leaving
    assert not bench.moving()


def alive(process: int) -> bool:
    """Whether a process runs."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True
