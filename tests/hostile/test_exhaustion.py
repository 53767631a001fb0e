"""A robot is stopped and left without threads, descriptors or memory to be had."""

from __future__ import annotations

import asyncio
import builtins
import contextlib
import errno
import logging
import os
import socket
import sys
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import anyio
import pytest
from api.desk import Desk
from client.bench import HOME, Bench

import aioduco
import aioduco.sync
from aioduco._process.reporting import BackgroundLogger, reporter
from aioduco._wire import codec, idl, layout
from aioduco._wire.lane import WireLane
from aioduco.api.streams.speed import Speed
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import StreamState
from aioduco.supervision import dispatcher, stop_coordinator
from aioduco.supervision.guard.messages import Watch
from aioduco.supervision.task_follower import TaskFollower
from aioduco.testing import eventually_async, no_leaks

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


# -- memory: what stopping and leaving need is made while the robot is opened ---------------------


def no_memory(*_: Any, **__: Any) -> NoReturn:
    """As Python says it when it gets no memory."""
    raise MemoryError


class NoModules:
    """Finds no module: in this program, a module that is not loaded yet gets no memory."""

    @staticmethod
    def find_spec(*_: Any) -> None:
        if of_program():
            no_memory()


def of_program() -> bool:
    """Whether the present thread is not one of the controller, which runs in the same process."""
    return not threading.current_thread().name.startswith("sim-")


def unless_served(make: Callable[..., Any]) -> Callable[..., Any]:
    """The same function, but for the controller's threads only."""

    def made(*args: Any, **options: Any) -> Any:
        return no_memory() if of_program() else make(*args, **options)

    return made


@pytest.fixture
def unmade(monkeypatch: pytest.MonkeyPatch) -> None:
    """No function of the wire has been used yet, as in a program that has just begun."""
    monkeypatch.setattr(idl.functions(), "_made", {})


@contextmanager
def no_memory_to_make_anything(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """From here on nothing is compiled, and no module is loaded; what was made works as ever."""
    with monkeypatch.context() as patch:
        patch.setattr(idl.Function, "__init__", unless_served(idl.Function.__init__))
        patch.setattr(layout, "_layout", unless_served(layout._layout))
        patch.setattr(logging, "LogRecord", unless_served(logging.LogRecord))
        patch.setattr(builtins, "exec", unless_served(exec))
        patch.setattr(builtins, "eval", unless_served(eval))
        patch.setattr(sys, "meta_path", [NoModules, *sys.meta_path])
        yield


@contextmanager
def nothing_left(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Neither threads and descriptors nor memory."""
    with exhausted(monkeypatch), no_memory_to_make_anything(monkeypatch):
        yield


async def move(robot: aioduco.Robot) -> None:
    await robot.motion.movej2(HOME, v=1.0, a=1.0).start()


async def guide(robot: aioduco.Robot) -> None:
    await robot.motion.teach_mode().start()


async def turn(robot: aioduco.Robot) -> None:
    await robot.motion.speedj([0.1] * 6, a=1.0, time=None).start()


async def jog(robot: aioduco.Robot) -> None:
    await robot.motion.move_jog(aioduco.Jog.joint(2, 1, 10)).start()


async def press(robot: aioduco.Robot) -> None:
    await robot.force.fc_start()


async def follow(robot: aioduco.Robot) -> None:
    await robot.realtime.start_realtime_mode(aioduco.RealtimeMode.JOINT_POSITION)


MOVES = pytest.mark.parametrize(
    ("begin", "ending"),
    [
        (move, "stop"),
        (guide, "end_teach_mode"),
        (turn, "stop"),
        (jog, "stop"),
        (press, "fc_stop"),
        (follow, "end_realtime_mode"),
    ],
)


@pytest.fixture
async def desk() -> AsyncIterator[Desk]:
    """A controller with motions and modes that go on."""
    async with no_leaks():
        with Desk() as desk:
            desk.motion_time = 60.0
            for name in ("fc_start", "fc_stop"):
                desk.begins(name)
            for name in ("start_realtime_mode", "end_realtime_mode"):
                desk.answer(name, 4)
            yield desk


@GUARDS
@MOVES
@pytest.mark.usefixtures("unmade")
async def test_leaving_needs_no_new_thread_descriptor_or_memory(
    desk: Desk,
    monkeypatch: pytest.MonkeyPatch,
    begin: Callable[[aioduco.Robot], Awaitable[None]],
    ending: str,
    guard: Any,
) -> None:
    robot = aioduco.connect(desk.host, desk.port, guard=guard)
    await robot.open()
    await begin(robot)
    seat = robot._supervisor.guard
    process = None if seat is None else seat.pid
    with nothing_left(monkeypatch):
        await robot.aclose()
    assert not desk.moving()
    assert desk.received(ending)
    assert process is None or not alive(process)


@GUARDS
@pytest.mark.parametrize("way", ["stop", "stop_now", "abort", "pause", "cancel", "forget"])
@pytest.mark.usefixtures("unmade")
async def test_stopping_needs_no_new_thread_descriptor_or_memory(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, way: str, guard: Any
) -> None:
    async with aioduco.connect(bench.host, bench.port, guard=guard) as robot:
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        with nothing_left(monkeypatch):
            match way:
                case "cancel":
                    with anyio.move_on_after(0.05):
                        await task
                case "forget":
                    robot._supervisor.forget()
                case "stop_now":
                    robot.stop_now()
                case _:
                    await getattr(robot, way)()
        assert bench.received(way if way in ("abort", "pause") else "stop")
        await eventually_async(lambda: not bench.moving())


@pytest.mark.parametrize(
    ("begin", "end"), [(turn, "speed_stop"), (jog, "stop_manual_move"), (guide, "end_teach_mode")]
)
@pytest.mark.usefixtures("unmade")
async def test_ending_a_held_motion_makes_nothing_that_needs_memory(
    desk: Desk,
    monkeypatch: pytest.MonkeyPatch,
    begin: Callable[[aioduco.Robot], Awaitable[None]],
    end: str,
) -> None:
    async with aioduco.connect(desk.host, desk.port) as robot:
        await begin(robot)
        with no_memory_to_make_anything(monkeypatch):
            await getattr(robot.motion, end)()
        assert not desk.moving()
        assert desk.received(end)


@pytest.mark.usefixtures("unmade")
async def test_the_end_of_a_stream_makes_nothing_that_needs_memory(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a thread here: a process of its own has a memory of its own."""
    bench.answer("speedj", 4)
    bench.answer("speed_stop", 4)
    speed = Speed(StreamEndpoint(bench.host, bench.port, stall_limit=60.0))
    options = WorkerOptions(run_in="thread", timeout=20.0)
    stream = speed.joints(a=5.0, rate=50, hold=0.1, options=options)

    async def starve() -> None:
        async with stream:
            await stream.send([0.1, 0.0, 0.0, 0.0, 0.0, 0.0])
            await eventually_async(lambda: len(bench.received("speedj")) > 0)
            with no_memory_to_make_anything(monkeypatch):
                await eventually_async(lambda: stream.state is StreamState.ENDED)
            await stream.send([0.1, 0.0, 0.0, 0.0, 0.0, 0.0])

    with pytest.raises(aioduco.StreamStarved):
        await starve()
    assert bench.received("speed_stop")
    assert bench.received("stop")


@pytest.mark.linux("the guard's process")
@pytest.mark.usefixtures("unmade")
async def test_a_guard_makes_nothing_that_needs_memory(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its part for one robot, in this process."""
    from aioduco.supervision.guard.process import Guard, GuardedRobot  # noqa: PLC0415  # Linux only

    program, _ = pair = socket.socketpair()
    guarded = GuardedRobot(Watch(1, 1, bench.host, bench.port, None, 1.0, 3.0, 2.0), Guard(program))
    await guarded.open()
    guarded.liveness.moves = True
    with no_memory_to_make_anything(monkeypatch):
        await guarded.halt(gone=True)
    assert bench.received("stop")
    await guarded.aclose()
    for end in pair:
        end.close()


@pytest.mark.usefixtures("unmade")
def test_a_program_that_waits_is_left_without_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    with Bench() as bench, contextlib.ExitStack() as ways_out:
        bench.motion_time = 60.0
        robot = aioduco.sync.connect(bench.host, bench.port)
        with robot:
            robot.motion.movej2.start(HOME, v=1.0, a=1.0)
            ways_out.enter_context(no_memory_to_make_anything(monkeypatch))
        assert not bench.moving()


def test_a_message_for_which_there_is_no_memory_is_counted(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    log = BackgroundLogger("aioduco.tests")
    log.warning("with it, those that were dropped before are counted")
    assert reporter.flush(30.0)
    caplog.clear()
    with no_memory_to_make_anything(monkeypatch):
        log.warning("the arm %s", "stands")
    log.warning("there is memory again")
    assert reporter.flush(30.0)
    said = [record.getMessage() for record in caplog.records]
    assert [text for text in said if "were dropped" in text and text.startswith("1 ")]
    assert "there is memory again" in said
    assert "the arm stands" not in said


async def test_a_stop_for_which_there_is_no_memory_is_tried_again(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        encode, failed = codec.encode, {"stop": 0, "robotmoving": 0}

        def twice_without_memory(function: idl.Function, args: tuple[Any, ...]) -> bytes:
            if failed.get(function.name, 2) < 2:
                failed[function.name] += 1
                no_memory()
            return encode(function, args)

        monkeypatch.setattr(codec, "encode", twice_without_memory)
        await robot.stop()
        assert not bench.moving()
        assert failed == {"stop": 2, "robotmoving": 2}


@pytest.mark.parametrize(
    "place",
    [
        (stop_coordinator, "may_move"),  # when the answer is judged
        (dispatcher, "Task"),  # when it becomes a task
        (TaskFollower, "follow"),
    ],
    ids=lambda place: place[1],
)
@pytest.mark.parametrize("error", [MemoryError, KeyboardInterrupt])
async def test_a_motion_is_stopped_if_it_cannot_be_followed(
    bench: Bench,
    monkeypatch: pytest.MonkeyPatch,
    place: tuple[Any, str],
    error: type[BaseException],
) -> None:
    """The controller has accepted it; there is no memory for it, or a signal comes at that line."""

    def fail(*_: Any, **__: Any) -> NoReturn:
        raise error

    async with aioduco.connect(bench.host, bench.port, heartbeat=None) as robot:
        motion = robot.motion.movej2(HOME, v=1.0, a=1.0)
        with monkeypatch.context() as patch:
            patch.setattr(*place, fail)
            with pytest.raises(error):
                await motion.start()
        assert bench.commands[:2] == ["movej2", "stop"]
        assert not bench.moving()
        assert not robot.tasks
        bench.motion_time = 0.05
        assert await motion is aioduco.Outcome.FINISHED


async def test_a_call_whose_end_cannot_be_reported_is_over_nevertheless(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its task would otherwise wait for ever: the deadline of the call has been met."""
    failures = unreported_failures()
    async with aioduco.connect(bench.host, bench.port) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        report, failed = WireLane.report, 0

        def without_memory(lane: WireLane, name: str, *args: Any) -> None:
            nonlocal failed
            if name == "stop" and not failed:
                failed += 1
                no_memory()
            report(lane, name, *args)

        monkeypatch.setattr(WireLane, "report", without_memory)
        with anyio.fail_after(20.0):
            await robot.stop()
        assert not bench.moving()
        assert failed
    assert all(isinstance(error, MemoryError) for error in failures)


async def test_a_call_is_over_although_the_next_one_gets_no_memory(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    failures = unreported_failures()
    lane = WireLane("test", bench.host, bench.port, call_timeout=0.5)
    await lane.open()
    begin, failed = codec.Exchange.begin, 0

    def without_memory(exchange: codec.Exchange, function: idl.Function, *args: Any) -> bytes:
        nonlocal failed
        if function.name == "get_last_error":
            failed += 1
            no_memory()
        return begin(exchange, function, *args)

    monkeypatch.setattr(codec.Exchange, "begin", without_memory)

    async def next_one() -> None:
        with pytest.raises(aioduco.ConnectionLost):  # at its deadline
            await lane.rpc.get_last_error()

    answer = bench.hold("get_robot_state", list(bench.states))
    with anyio.fail_after(20.0):
        async with anyio.create_task_group() as group:
            group.start_soon(lane.within(None).get_robot_state)
            await eventually_async(lambda: bool(bench.received("get_robot_state")))
            group.start_soon(next_one)
            await eventually_async(lambda: lane.statistics().waiting == 1)
            answer.set()
    await lane.aclose()
    assert failed
    assert all(isinstance(error, MemoryError) for error in failures)


def unreported_failures() -> list[BaseException | None]:
    """What callbacks of the loop raise from now on, which nothing else reports."""
    failures: list[BaseException | None] = []
    asyncio.get_running_loop().set_exception_handler(
        lambda _, context: failures.append(context.get("exception"))
    )
    return failures


def alive(process: int) -> bool:
    """Whether a process runs."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True
