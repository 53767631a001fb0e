"""A set-point is sent only while the stream's permit is valid; then the arm is only stopped."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import anyio
import pytest
from for_each import for_each
from patient import patient_queue

from aioduco._process.platform import boot_time
from aioduco.api.streams.realtime import CYCLE, RealtimeStreams
from aioduco.api.streams.servo import Servo
from aioduco.api.streams.speed import Speed
from aioduco.api.streams.track import TrackStreams
from aioduco.errors import StreamClosed, StreamError, StreamStarved, StreamStopped, WorkerFailed
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import ControlWord, Reason, StreamState
from aioduco.streaming.stream import Stream
from aioduco.streaming.worker.driver import Driver
from aioduco.streaming.worker.encoding import Batch, Point
from aioduco.streaming.worker.permit import StreamPermit
from aioduco.supervision.gate import Gate, Permit, PermitEnding
from aioduco.testing import eventually, eventually_async, no_leaks

from .conftest import HERE, PROCESS, THREAD, Controller, Cycles, answer_all, workers

# -- the rules ---------------------------------------------------------------------------------

SECOND = 1_000_000_000
STALL, AWAY = 1.0, 0.25
#: the computer has slept for that long before
SLEPT = 500 * SECOND


class Clocks:
    """The two clocks, the words of a program that is alive, and a permit that looks at them."""

    def __init__(self) -> None:
        self.now = 100 * SECOND
        self.slept = SLEPT
        self.control = [0] * 8
        self.lives()
        self.permit = StreamPermit(self.control, STALL, AWAY, lambda: (self.now, self.boot))

    @property
    def boot(self) -> int:
        return self.now + self.slept

    def lives(self) -> None:
        self.control[ControlWord.ALIVE] = self.boot
        self.control[ControlWord.LEASE] = self.boot + SECOND

    def look(self, passed: float, due: int = 0) -> Reason:
        self.now += round(passed * SECOND)
        return self.permit.look(due)


def test_it_stays_valid_while_all_send_keep_alives() -> None:
    clocks = Clocks()
    for _ in range(100):
        clocks.lives()
        assert clocks.look(0.2) is Reason.NONE


def test_a_sleep_until_a_tick_is_due_does_not_count() -> None:
    clocks = Clocks()
    due = clocks.now + 3 * SECOND
    clocks.now += 3 * SECOND
    clocks.lives()
    assert clocks.look(0.2, due) is Reason.NONE


def test_a_late_tick_ends_it() -> None:
    clocks = Clocks()
    due = clocks.now + SECOND
    clocks.now += SECOND
    clocks.lives()
    assert clocks.look(0.26, due) is Reason.AWAY
    assert clocks.permit.text == "it did not run for 0.26 s"


def test_a_gap_between_two_looks_ends_it() -> None:
    """A freeze between computing a set-point and sending it."""
    clocks = Clocks()
    assert clocks.look(0.26) is Reason.AWAY


def test_a_sleep_of_the_computer_ends_it_though_the_monotonic_clock_stood() -> None:
    clocks = Clocks()
    due = clocks.now + SECOND // 100
    clocks.slept += 5 * SECOND
    clocks.lives()
    assert clocks.look(0.01, due) is Reason.AWAY
    assert clocks.permit.text == "it did not run for 5.00 s"


def test_looks_while_it_waits_for_an_answer_keep_it() -> None:
    clocks = Clocks()
    assert not any(clocks.look(0.1) for _ in range(8))


def test_the_time_of_the_set_up_does_not_count() -> None:
    clocks = Clocks()
    clocks.now += SECOND // 2
    clocks.permit.begin()
    assert clocks.look(0.1) is Reason.NONE


def test_without_a_keep_alive_it_ends() -> None:
    clocks = Clocks()
    clocks.control[ControlWord.LEASE] += 10 * SECOND
    assert not any(clocks.look(0.1) for _ in range(10))
    assert clocks.look(0.1) is Reason.HUNG


def test_without_a_heartbeat_it_ends() -> None:
    clocks = Clocks()
    for _ in range(9):
        clocks.control[ControlWord.ALIVE] = clocks.boot
        assert clocks.look(0.1) is Reason.NONE
    assert clocks.look(0.1) is Reason.LAPSED


@for_each(
    "commands, reason",
    [
        ({ControlWord.CLOSE: 1, ControlWord.ABORT: 1}, Reason.NONE),
        ({ControlWord.HALT: 1}, Reason.STOPPED),
        ({ControlWord.WITHDRAW: Reason.LAPSED}, Reason.LAPSED),
        ({ControlWord.HALT: 1, ControlWord.WITHDRAW: Reason.HUNG}, Reason.HUNG),
    ],
)
def test_the_program_ends_it(commands: dict[int, int], reason: Reason) -> None:
    clocks = Clocks()
    for command, value in commands.items():
        clocks.control[command] = value
    assert clocks.look(0.001) is reason


def test_the_first_reason_stays() -> None:
    clocks = Clocks()
    assert clocks.look(0.3) is Reason.AWAY
    clocks.lives()
    clocks.control[ControlWord.HALT] = 1
    assert clocks.look(0.001) is Reason.AWAY


# -- the worker --------------------------------------------------------------------------------

Open = Callable[["StreamEndpoint", WorkerOptions], "Stream"]

#: how each kind is opened, its call, and what ends it at the controller
KINDS: dict[str, tuple[Open, str, list[str]]] = {
    "servo": (
        lambda endpoint, options: Servo(endpoint).joints(v=1.0, a=0.5, options=options),
        "servoj",
        ["stop"],
    ),
    "speed": (
        lambda endpoint, options: Speed(endpoint).joints(a=0.5, hold=10.0, options=options),
        "speedj",
        ["speed_stop", "stop"],
    ),
    "realtime": (
        lambda endpoint, options: RealtimeStreams(endpoint).stream(
            "joint_position", v=1.0, a=0.5, options=options
        ),
        "realtime_data_enqueue",
        ["end_realtime_mode", "stop", "clear_realtime_data_queue"],
    ),
    "track": (
        lambda endpoint, options: TrackStreams(endpoint).stream(
            "joints", speed=0.5, acc=1.0, low=10, high=20, period=0.005, options=options
        ),
        "trackEnqueue",
        ["trackClearQueue", "stop"],
    ),
}
kinds = pytest.mark.parametrize("kind", KINDS)


@pytest.fixture
def arm(controller: Controller) -> Iterator[Controller]:
    """A controller that takes all kinds of set-points."""
    queue = Cycles(CYCLE)
    track = {"trackClearQueue": 4, "trackEnqueue": 4, "getQueueSize": 5, "trackJointMotion": 1234}
    answer_all(controller.server, {**queue.answers, **track})
    with no_leaks():
        yield controller


async def feed(stream: Stream, kind: str) -> None:
    """Send until the stream has ended: faster and faster, so that it cannot end by itself."""
    number = 0
    while True:
        way = 0.2 if kind == "speed" else min(1.0, 1e-7 * number**2)
        await stream.send([way, *HERE[1:]] if kind == "speed" else [HERE[0] + way, *HERE[1:]])
        number += 1


async def ended(
    arm: Controller, kind: str, options: WorkerOptions, end: Callable[[Stream], object]
) -> StreamError:
    """End the permit of a stream in full course, and check what the controller gets then."""
    opened, call, ending = KINDS[kind]
    with patient_queue():  # the program here may be held up for longer than a stream waits
        stream = opened(arm.endpoint, options)
    begun = {"servo": 20, "speed": 5, "realtime": 5, "track": 1}[kind]

    async def program() -> None:
        async with stream, anyio.create_task_group() as tasks:
            tasks.start_soon(feed, stream, kind)
            await eventually_async(
                lambda: (
                    len(arm.server.received(call)) > begun
                    and stream.state in (StreamState.FOLLOWING, StreamState.HOLDING)
                )
            )
            end(stream)
            await stream.ended()

    with pytest.raises(BaseExceptionGroup) as caught:
        await program()
    assert arm.names()[-len(ending) :] == ending
    error: BaseException = caught.value
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    assert isinstance(error, StreamError)
    return error


@pytest.mark.cases(2)
@kinds
@workers
async def test_a_withdrawn_permit_ends_the_mode_and_stops_and_nothing_more(
    arm: Controller, kind: str, options: WorkerOptions
) -> None:
    def withdraw(stream: Stream) -> None:
        stream._session.withdraw(PermitEnding.LAPSED)

    error = await ended(arm, kind, options, withdraw)
    assert isinstance(error, StreamStarved)
    assert "heartbeat was lost" in str(error)
    assert "open a new stream" in str(error).lower()


@kinds
async def test_a_lease_that_is_over_ends_it(arm: Controller, kind: str) -> None:
    """Without the program: its heartbeat's thread may be the one that is late."""
    endings: list[StreamError] = []
    gate = Gate(5.0, 1000.0, boot_time())
    gate.beaten(boot_time() + 3600.0)
    arm.gate = gate

    def lapse(stream: Stream) -> None:
        # the loop's keep-alives renew the lease again and again, so the gate has to lose it
        gate.lapse()
        stream._session.renew(gate.lease)

    endings.append(await ended(arm, kind, THREAD, lapse))
    assert isinstance(endings[0], StreamStarved)
    assert "heartbeat was lost" in str(endings[0])


@pytest.mark.slow
@kinds
async def test_a_worker_that_was_away_sends_no_set_point_any_more(
    arm: Controller, kind: str
) -> None:
    options = replace(PROCESS, away_limit=1.0)

    def freeze(stream: Stream) -> None:
        assert stream.pid is not None
        os.kill(stream.pid, signal.SIGSTOP)
        begin = boot_time()
        eventually(lambda: boot_time() > begin + 1.1)
        os.kill(stream.pid, signal.SIGCONT)

    error = await ended(arm, kind, options, freeze)
    assert isinstance(error, WorkerFailed)
    assert "did not run for longer than its away_limit" in str(error)
    assert "(it did not run for" in str(error)


@pytest.mark.parametrize(
    ("kind", "place", "name"),
    [
        # The next tick is chosen after it, and is not late.
        pytest.param("servo", Driver, "_follows", marks=pytest.mark.slow),
        # A set-point is computed, and not sent yet.
        ("servo", Point, "send"),
        ("realtime", Batch, "send"),
    ],
)
async def test_a_freeze_before_or_after_a_set_point_is_sent_ends_it(
    arm: Controller, kind: str, place: type, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    frozen: list[int] = []
    armed, thawed = threading.Event(), threading.Event()
    original = getattr(place, name)
    _, call, _ = KINDS[kind]

    def freeze(self: Any, *args: Any) -> Any:
        if not frozen and armed.is_set():
            frozen.append(len(arm.server.received(call)))
            begin = boot_time()
            eventually(lambda: boot_time() > begin + 1.1)
            thawed.set()
        return original(self, *args)

    def freeze_once(_: Stream) -> None:
        armed.set()
        thawed.wait(30.0)

    monkeypatch.setattr(place, name, freeze)
    error = await ended(arm, kind, replace(THREAD, away_limit=1.0), freeze_once)
    assert isinstance(error, WorkerFailed)
    assert [len(arm.server.received(call))] == frozen


@pytest.mark.parametrize(
    ("ending", "error", "text"),
    [
        (PermitEnding.STOPPED, StreamStopped, "the robot was stopped"),
        (PermitEnding.LEFT, StreamStopped, "the robot was stopped"),
        (PermitEnding.HUNG, StreamStarved, "event loop did not run"),
        (PermitEnding.LAPSED, StreamStarved, "heartbeat was lost"),
    ],
)
async def test_a_permit_that_ends_before_the_worker_exists_is_never_used(
    arm: Controller, ending: PermitEnding, error: type[StreamError], text: str
) -> None:
    gate = Gate(None, 1000.0, boot_time())

    async def admit(name: str) -> Permit:
        permit = gate.ask(name, boot_time())
        gate.end(ending)
        return permit

    endpoint = replace(arm.endpoint, admit=admit, gate=gate)
    stream = Servo(endpoint).joints(v=1.0, a=5.0, options=THREAD)
    with pytest.raises(error, match=text):
        async with stream:
            raise AssertionError("entered")
    assert not arm.server.received()


async def test_a_permit_that_ends_while_the_arm_is_braked_stops_it(arm: Controller) -> None:
    """It braked by set-points, of which none may follow; the stop does the rest."""
    stream = Servo(arm.endpoint).joints(v=1.0, a=0.01, options=THREAD)
    sent: list[int] = []

    def answer(*_: Any) -> int:
        if not sent and stream.state is StreamState.DECELERATING:
            stream._session.withdraw(PermitEnding.HUNG)
            sent.append(len(arm.points()))
        return 1001

    async def program() -> None:
        async with stream:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(feed, stream, "servo")
                await eventually_async(lambda: len(arm.points()) > 200)
                tasks.cancel_scope.cancel()
            arm.server.answer("servoj", answer)
            stream._session._command(ControlWord.ABORT)
            await stream.ended()

    with pytest.raises(StreamClosed, match="by its program"):
        await program()
    assert arm.names()[-1] == "stop"
    assert [len(arm.points())] == sent


# -- a block that is released while a task still sends -----------------------------------------


async def test_a_send_that_waits_while_another_task_leaves_raises_a_stream_error(
    arm: Controller,
) -> None:
    answering = threading.Event()
    stream = Servo(arm.endpoint).joints(v=1.0, a=5.0, ahead=2, options=THREAD)
    found: list[type[BaseException]] = []

    async def sends() -> None:
        try:
            await feed(stream, "servo")
        except Exception as exc:
            found.append(type(exc))

    await stream.__aenter__()
    await stream.send(HERE)

    def held(*_: Any) -> int:
        answering.wait(30.0)
        return 1001

    arm.server.answer("servoj", held)
    await stream.send(HERE)
    async with anyio.create_task_group() as tasks:
        # The task that leaves waits first, so it is woken first, and releases the block.
        tasks.start_soon(stream.__aexit__, ZeroDivisionError, ZeroDivisionError(), None)
        for _ in range(10):
            await anyio.lowlevel.checkpoint()
        for _ in range(3):
            tasks.start_soon(sends)
        for _ in range(10):
            await anyio.lowlevel.checkpoint()
        answering.set()
    assert found == [StreamClosed] * 3
