"""What lies between a task and a thread, piece by piece."""

from __future__ import annotations

import asyncio
import contextvars
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import pytest

from aioduco._wire import codec, handoff, idl
from aioduco._wire.connection_factory import ConnectionFactory
from aioduco._wire.handoff import AwaitedCall, BlockingCall, Deadlines, OwnerLoop
from aioduco._wire.worker import AbandonOutcome, Worker
from aioduco.errors import ConnectionLost
from aioduco.testing import eventually, eventually_async, no_leaks

from .servers import PATIENCE, ScriptedServer

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

STOP = idl.functions()["stop"]
ARGUMENTS = codec.encode(STOP, (True,))


def nothing(*_: object) -> None:
    """Nobody is told."""


# Answers


async def test_a_task_goes_on_in_the_turn_of_the_loop_in_which_its_call_is_settled() -> None:
    call = awaited(OwnerLoop(), None)
    name = contextvars.ContextVar("name", default="another's")
    told: list[object] = []

    async def wait() -> None:
        name.set("its own")
        told.append(await call)
        told.append(name.get())
        told.append(asyncio.current_task() is task)

    task = asyncio.create_task(wait())
    await asyncio.sleep(0)
    call.value = 7

    def settle() -> None:
        call.settle()
        told.append("settled")

    asyncio.get_running_loop().call_soon(settle)
    await task
    assert told == [7, "its own", True, "settled"]


async def test_a_call_that_is_settled_before_its_task_waits_has_its_value() -> None:
    call = awaited(OwnerLoop(), None)
    call.value = 7
    call.settle()
    call.settle()
    assert await call == 7


@pytest.mark.parametrize("then", ["settled", "cancelled"])
async def test_a_task_goes_on_once_if_its_call_is_cancelled_and_settled(then: str) -> None:
    """In one turn of the loop, in either order."""
    call = awaited(OwnerLoop(), None)
    came: list[str] = []

    async def wait() -> None:
        try:
            await call
        except asyncio.CancelledError:
            came.append("cancelled")
            raise
        came.append("answered")
        await asyncio.sleep(0)

    task = asyncio.create_task(wait())
    await asyncio.sleep(0)
    turns: list[Callable[[], object]] = [call.settle, task.cancel]
    for turn in turns if then == "cancelled" else reversed(turns):
        asyncio.get_running_loop().call_soon(turn)
    with pytest.raises(asyncio.CancelledError):
        await task
    assert came == (["answered"] if then == "cancelled" else ["cancelled"])


@pytest.mark.parametrize("then", ["settled", "cancelled"])
async def test_an_interrupt_in_the_middle_of_settling_leaves_no_task_behind(then: str) -> None:
    """After whichever line it comes: settled once more or cancelled, the task goes on, and once."""
    loop = asyncio.get_running_loop()
    lines, interrupted = 0, True
    while interrupted:
        lines += 1
        call = awaited(OwnerLoop(), None)
        call.value = 7
        came: list[object] = []

        async def wait(call: AwaitedCall = call, came: list[object] = came) -> None:
            came.append(await call)

        task = asyncio.create_task(wait())
        await asyncio.sleep(0)
        interrupted = await _interrupted(loop, call, after=lines)
        loop.call_soon(call.settle if then == "settled" else task.cancel)
        ended, _ = await asyncio.wait([task], timeout=PATIENCE)
        assert ended == {task}, f"it waits for ever after line {lines}"
        assert came == [7] or (then == "cancelled" and task.cancelled() and came == [])
    assert lines > 8


def test_an_interrupt_as_a_task_begins_to_wait_leaves_none_behind() -> None:
    """At whichever line of the package: the loop has the task go on when it is cancelled."""
    lines, interrupted = 0, True
    while interrupted:
        lines += 1
        with asyncio.Runner() as runner:
            loop = runner.get_loop()
            tracer = _Tracer(lines)
            waiting = loop.create_task(_wait_for_a_call(tracer))
            try:
                loop.run_until_complete(asyncio.sleep(0))
            except KeyboardInterrupt:
                interrupted = True
            else:
                interrupted = False
            finally:
                sys.settrace(None)
            waiting.cancel()
            ended, _ = loop.run_until_complete(asyncio.wait([waiting], timeout=PATIENCE))
            assert ended == {waiting}, f"it waits for ever after line {lines}"
            if not waiting.cancelled():
                assert isinstance(waiting.exception(), KeyboardInterrupt)
    assert lines > 1


async def _wait_for_a_call(tracer: _Tracer) -> None:
    call = awaited(OwnerLoop(), None)
    sys.settrace(tracer.trace)
    await call


class _Tracer:
    """Interrupts at one of the lines that are run of how a call gets to its thread and back."""

    def __init__(self, line: int) -> None:
        self._left = line

    def trace(self, frame: FrameType, event: str, _: object) -> Any:
        if frame.f_code.co_filename != handoff.__file__:
            return None
        if event == "line":
            self._left -= 1
            if not self._left:
                sys.settrace(None)
                raise KeyboardInterrupt
        return self.trace


async def _interrupted(loop: asyncio.AbstractEventLoop, call: AwaitedCall, after: int) -> bool:
    """Settle a call in a callback of the loop; whether it was interrupted at that line."""
    left, told = after, loop.create_future()

    def trace(frame: FrameType, event: str, _: object) -> Any:
        nonlocal left
        if frame.f_code.co_filename != handoff.__file__:
            return None
        if event == "line":
            left -= 1
            if not left:
                sys.settrace(None)
                raise _Interrupt
        return trace

    def settle() -> None:
        sys.settrace(trace)
        try:
            call.settle()
        except _Interrupt:
            told.set_result(True)
        else:
            told.set_result(False)
        finally:
            sys.settrace(None)

    loop.call_soon(settle)
    return bool(await told)


class _Interrupt(BaseException):
    """What a handler of a signal raises, wherever the main thread is."""


# Deadlines


def awaited(owner_loop: OwnerLoop, deadline: float | None) -> AwaitedCall:
    return AwaitedCall(owner_loop, STOP, ARGUMENTS, deadline, nothing)


async def test_a_call_expires_at_its_deadline_and_once_more_after_the_grace(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(handoff, "GRACE", 0.02)
    seen: list[tuple[AwaitedCall, bool, float]] = []
    deadlines = Deadlines(lambda call, again: seen.append((call, again, time.monotonic())))
    owner_loop = OwnerLoop()
    begin = time.monotonic()
    never = awaited(owner_loop, None)
    later = awaited(owner_loop, begin + 0.06)
    sooner = awaited(owner_loop, begin + 0.03)
    for call in (never, later, sooner):
        deadlines.add(call)
    await eventually_async(lambda: len(seen) == 4)
    # nobody discards them: they are looked at no more, and not in every turn of the loop
    for _ in range(10):
        await asyncio.sleep(0)
    assert sorted((call.due, again) for call, again, _ in seen) == sorted(
        (call.deadline + 0.02, again)
        for call in (sooner, later)
        for again in (False, True)
        if call.deadline is not None
    )
    assert [call for call, again, _ in seen if again] == [sooner, later]
    assert all(at >= (call.deadline or 0.0) for call, _, at in seen)
    assert deadlines.calls == {never}
    deadlines.stop()
    assert deadlines.calls == set()


async def test_a_call_that_is_over_does_not_expire() -> None:
    seen: list[AwaitedCall] = []
    deadlines = Deadlines(lambda call, _: seen.append(call))
    owner_loop = OwnerLoop()
    over = awaited(owner_loop, time.monotonic() + 0.01)
    other = awaited(owner_loop, time.monotonic() + 0.03)
    deadlines.add(over)
    deadlines.add(other)
    deadlines.discard(over)
    await eventually_async(lambda: other in seen)
    assert over not in seen
    deadlines.stop()


def test_deadlines_go_on_with_another_loop() -> None:
    """The timer of a loop that was closed rings no more."""
    seen: list[AwaitedCall] = []
    deadlines = Deadlines(lambda call, _: seen.append(call))
    owner_loop = OwnerLoop()

    async def first() -> None:
        deadlines.add(awaited(owner_loop, time.monotonic() + 0.01))

    async def second() -> None:
        call = awaited(owner_loop, time.monotonic() + 0.05)
        deadlines.add(call)
        await eventually_async(lambda: call in seen)

    asyncio.run(first())
    asyncio.run(second())


# Workers


@pytest.fixture
def worker() -> Iterator[tuple[Worker, ScriptedServer]]:
    with no_leaks(), ScriptedServer() as server:
        made = ConnectionFactory("test", server.host, server.port, PATIENCE, None).worker()
        yield made, server
        made.dismiss()
        assert made.join(PATIENCE)


def blocking(deadline: float | None = None) -> BlockingCall:
    return BlockingCall(STOP, ARGUMENTS, deadline, nothing)


def test_a_worker_is_claimed_by_one(worker: tuple[Worker, ScriptedServer]) -> None:
    made, _ = worker
    call, other = blocking(), blocking()
    assert made.claim(call)
    assert made.claim(call)
    assert not made.claim(other)
    made.submit(call)
    assert call.wait(PATIENCE)
    assert call.outcome() == 0
    # free as soon as the caller knows
    assert made.claim(other)
    made.recover(other)
    assert made.claim(call)
    made.recover(call)
    assert "idle" in repr(made)


def test_a_call_that_was_interrupted_on_its_way_is_finished_or_undone(
    worker: tuple[Worker, ScriptedServer],
) -> None:
    made, server = worker
    claimed, begun, whole = blocking(), blocking(), blocking()
    # as an interrupt between two steps of `submit` leaves it
    assert made.claim(claimed)
    made.recover(claimed)
    assert made.claim(begun)
    made.start()
    begun.worker, made._current = made, begun
    made.recover(begun)
    assert begun.wait(PATIENCE)
    assert begun.outcome() == 0
    assert made.claim(whole)
    made.submit(whole)
    made.recover(whole)
    made.recover(whole)
    assert whole.wait(PATIENCE)
    assert whole.outcome() == 0
    last = blocking()
    assert made.claim(last)
    made.submit(last)
    assert last.wait(PATIENCE)
    assert server.names == ["stop"] * 3


def test_a_call_that_meets_the_end_of_its_worker_is_told(
    worker: tuple[Worker, ScriptedServer],
) -> None:
    """Claimed by a signal handler just before the lane closes, handed over just after."""
    made, server = worker
    first, call = blocking(), blocking()
    assert made.claim(first)
    made.submit(first)
    assert first.wait(PATIENCE)
    assert made.claim(call)
    said = threading.Event()
    made.dismiss(said.set)
    eventually(lambda: made.connection is None)
    made.submit(call)
    assert call.wait(PATIENCE)
    with pytest.raises(ConnectionLost, match="stop was not sent, since its lane was closed"):
        call.outcome()
    assert said.wait(PATIENCE)
    assert made.join(PATIENCE)
    assert not made.claim(blocking())
    assert server.names == ["stop"]


def test_everybody_who_waits_for_the_end_of_a_worker_is_told(
    worker: tuple[Worker, ScriptedServer],
) -> None:
    made, _ = worker
    call = blocking()
    assert made.claim(call)
    made.submit(call)
    assert call.wait(PATIENCE)
    # some before it is gone, some after
    for _ in range(20):
        told = threading.Event()
        made.dismiss(told.set)
        assert told.wait(PATIENCE)
    assert made.join(PATIENCE)
    after = threading.Event()
    made.dismiss(after.set)
    assert after.is_set()


def test_a_worker_that_never_began_ends_at_once(worker: tuple[Worker, ScriptedServer]) -> None:
    made, server = worker
    said = threading.Event()
    made.dismiss(said.set)
    assert said.is_set()
    assert not made.alive
    assert not made.claim(blocking())
    assert server.connections == 0


def test_abandoning_a_call_that_is_over_leaves_the_next_one_alone(
    worker: tuple[Worker, ScriptedServer],
) -> None:
    made, server = worker
    call = blocking()
    assert made.claim(call)
    made.submit(call)
    assert call.wait(PATIENCE)
    assert made.abandon(call, "too late") is AbandonOutcome.OVER
    assert made.abandon(None, "nothing is under way") is AbandonOutcome.OVER
    again = blocking()
    assert made.claim(again)
    made.submit(again)
    assert again.wait(PATIENCE)
    assert again.outcome() == 0
    assert server.connections == 1
