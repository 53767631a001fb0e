"""The vendor's class: lost connections, threads, interrupts, and stops beside them."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from thrift import Thrift
from thrift.transport.TTransport import TTransportException

from aioduco import compat
from aioduco._wire.connection import Connection
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco.compat import DucoCobot
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    OutcomeUnknown,
    TaskStopped,
)
from aioduco.testing import Cut, FaultProxy, HalfOpen, Place, RecordingServer, eventually

JOINTS = [0.1, 0.2, 1.5, 0.0, -1.5, 0.3]


def test_a_lost_connection_raises_what_the_vendors_class_raises(server: RecordingServer) -> None:
    robot = DucoCobot(server.host, server.port)
    assert robot.close() == 0
    with pytest.raises(TTransportException) as never_opened:
        robot.stop(True)
    assert never_opened.value.type == TTransportException.NOT_OPEN
    assert robot.open() == robot.open() == 0
    server.__exit__(None, None, None)
    for call in (
        robot.get_tcp_pose,
        robot.robotmoving,
        lambda: robot.movej2(JOINTS, 1, 1, 0, True),
    ):
        with pytest.raises(Thrift.TException) as lost:
            call()
        assert isinstance(lost.value, ConnectionLost)
        assert lost.value is robot.last_error
        assert lost.value.args[0] == lost.value.__dict__["message"] == str(lost.value)
    assert robot.open() == -1  # nobody is there
    assert isinstance(robot.last_error, ConnectError)
    assert str(server.port) in str(robot.last_error)
    with pytest.raises(ConnectionError), robot:
        pass
    assert robot.close() == 0


@pytest.mark.slow
def test_a_lost_answer_is_told_in_last_error(server: RecordingServer) -> None:
    gate = threading.Event()
    server.answer("movej2", lambda *_: gate.wait(30.0) and 4)
    with DucoCobot(server.host, server.port, timeout=1.0) as robot:
        with pytest.raises(OutcomeUnknown, match="movej2"):
            robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
        assert "movej2" in str(robot.last_error)
        gate.set()
        server.answer("stop", 4)
        server.answer("robotmoving", True)
        assert robot.stop(True) == 4  # on a new connection
        with pytest.raises(ConnectionLost):
            robot.robotmoving()  # the object's own is over, until it is opened again
        assert robot.open() == 0
        assert robot.robotmoving() is True
        assert robot.last_error is None


def in_thread(call: Any, name: str = "second") -> tuple[threading.Thread, list[Any]]:
    """A call in a thread of its own, and what it gave, once the thread has ended."""
    ended: list[Any] = []

    def run() -> None:
        try:
            ended.append(call())
        except (ConnectionLost, TaskStopped) as exc:
            ended.append(exc)

    thread = threading.Thread(target=run, name=name)
    thread.start()
    return thread, ended


class Blocking:
    """A motion on a recording server that goes on until `gate` is set."""

    def __init__(self, server: RecordingServer) -> None:
        self.gate, self.begun = threading.Event(), threading.Event()
        server.answer("movej2", self._move)
        server.answer("robotmoving", True)
        server.answer("stop", 4)

    def _move(self, *_: Any) -> int:
        self.begun.set()
        assert self.gate.wait(30.0)
        return 4

    def start(self, robot: DucoCobot) -> tuple[threading.Thread, list[Any]]:
        started = in_thread(lambda: robot.movej2(JOINTS, 1.0, 1.0, 0.0, True), "mover")
        assert self.begun.wait(30.0)
        return started


def test_threads_take_turns_and_a_stop_does_not_wait(
    server: RecordingServer, robot: DucoCobot, caplog: pytest.LogCaptureFixture
) -> None:
    motion = Blocking(server)
    mover, moved = motion.start(robot)
    asker, answers = in_thread(robot.robotmoving)
    assert robot.open() == 0
    assert robot.stop(True) == 4  # the same object
    with DucoCobot(server.host, server.port) as second:
        assert second.stop(True) == 4
        assert second.robotmoving() is True
    assert [call.method for call in server.received()] == ["movej2", "stop", "stop", "robotmoving"]
    assert asker.is_alive()
    motion.gate.set()
    mover.join()
    asker.join()
    assert (moved, answers) == ([4], [True])
    eventually(lambda: "is used in thread" in caplog.text)
    assert caplog.text.count("is used in thread") == 1


@pytest.mark.parametrize(
    ("other", "stop"),
    [("", "stop"), ("127.0.0.1", "stop"), ("localhost", "stop"), ("127.0.0.1", "abort")],
)
def test_a_motion_that_waits_when_the_arm_is_stopped_is_not_sent(
    server: RecordingServer,
    robot: DucoCobot,
    monkeypatch: pytest.MonkeyPatch,
    other: str,
    stop: str,
) -> None:
    """By another object, too, as manual 1.3.3 asks for; what comes after the stop is sent."""
    motion = Blocking(server)
    server.answer("servoj", 1000)
    server.answer("set_standard_digital_out", 4)
    server.answer("abort", 4)
    waiting, acquire = threading.Semaphore(0), robot._acquire
    mover, _ = motion.start(robot)

    def wait() -> None:
        waiting.release()
        acquire()

    monkeypatch.setattr(robot, "_acquire", wait)
    next_one, moved = in_thread(lambda: robot.servoj(JOINTS, 1.0, 1.0))
    output, is_set = in_thread(lambda: robot.set_standard_digital_out(1, False, True))
    for _ in range(2):
        assert waiting.acquire(timeout=30.0)
    with DucoCobot(other or server.host, server.port) as second:
        assert getattr(second if other else robot, stop)(True) == 4
    motion.gate.set()
    for thread in (mover, next_one, output):
        thread.join()
    assert isinstance(moved[0], TaskStopped)
    assert "servoj was not sent" in str(moved[0])
    assert is_set == [4]
    assert not server.received("servoj")
    assert robot.servoj(JOINTS, 1.0, 1.0) == 1000


def test_a_stop_until_the_last_moment_keeps_a_motion_back(
    server: RecordingServer, robot: DucoCobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.answer("stop", 4)
    hand_over = Connection.hand_over

    def late(connection: Connection) -> None:
        hand_over(connection)
        if connection is robot._connection:
            assert second.stop(True) == 4

    with DucoCobot(server.host, server.port) as second:
        monkeypatch.setattr(Connection, "hand_over", late)
        with pytest.raises(TaskStopped):
            robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
    assert [call.method for call in server.received()] == ["stop"]


@contextmanager
def handled(motion: Blocking, handler: Any) -> Iterator[None]:
    """A signal comes in this thread once the motion has begun."""
    waiting = threading.get_ident()

    def kill() -> None:
        assert motion.begun.wait(30.0)
        signal.pthread_kill(waiting, signal.SIGUSR1)

    former = signal.signal(signal.SIGUSR1, handler)
    killer = threading.Thread(target=kill)
    killer.start()
    try:
        yield
    finally:
        signal.signal(signal.SIGUSR1, former)
        motion.gate.set()
        killer.join()


def test_a_call_in_the_middle_of_another_by_a_signal_handler(
    server: RecordingServer, robot: DucoCobot
) -> None:
    motion = Blocking(server)
    answers = []

    def handler(*_: Any) -> None:
        answers.append((robot.stop(True), robot.robotmoving()))
        motion.gate.set()

    with handled(motion, handler):
        assert robot.movej2(JOINTS, 1.0, 1.0, 0.0, True) == 4
    assert answers == [(4, True)]


def test_a_stop_keeps_the_motion_of_a_signal_handler_back(
    server: RecordingServer, robot: DucoCobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = Blocking(server)
    kept = []

    def connected(connection: Connection, *_: Any) -> None:
        opens(connection)
        assert second.stop(True) == 4

    def handler(*_: Any) -> None:
        monkeypatch.setattr(Connection, "open", connected)
        with pytest.raises(TaskStopped) as raised:
            robot.servoj(JOINTS, 1.0, 1.0)
        kept.append(raised.value)
        motion.gate.set()

    opens = Connection.open
    with DucoCobot(server.host, server.port) as second, handled(motion, handler):
        robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
    assert len(kept) == 1
    assert not server.received("servoj")


@pytest.mark.parametrize(
    "error", [KeyboardInterrupt(), TimeoutError("it takes too long"), LookupError()], ids=repr
)
def test_after_an_interrupted_call_the_next_ones_are_sent(
    server: RecordingServer, robot: DucoCobot, error: BaseException
) -> None:
    """By Ctrl-C, or by what the handler of another signal raises, such as an alarm's."""

    def handler(*_: Any) -> None:
        raise error

    motion = Blocking(server)
    server.answer("disable", 4)
    with handled(motion, handler):
        with pytest.raises(type(error)) as raised:
            robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
        assert raised.value is error
        assert robot.stop(True) == robot.disable(True) == 4
        assert robot.robotmoving() is True


def test_what_an_alarm_raises_while_it_connects_leaves_open_as_it_is(
    server: RecordingServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It came out as -1, and a program that tries again until it is connected did so for ever."""

    def alarm(*_: Any) -> None:
        raise error

    error = TimeoutError("no controller for a minute")
    monkeypatch.setattr(DeadlineSocket, "connect", alarm)
    with pytest.raises(TimeoutError) as raised:
        DucoCobot(server.host, server.port).open()
    assert raised.value is error


@pytest.mark.parametrize("call", ["robotmoving", "stop"])
def test_an_interrupt_at_its_begin_leaves_no_call_of_another_thread_waiting(
    server: RecordingServer, robot: DucoCobot, call: str
) -> None:
    lock = robot._lock

    class Interrupted:
        """The interrupt comes when the lock is held already."""

        def acquire(self, *args: Any, **given: Any) -> bool:
            assert lock.acquire(*args, **given)
            robot._lock = lock
            raise KeyboardInterrupt

        def __getattr__(self, name: str) -> Any:
            return getattr(lock, name)

    robot._lock = Interrupted()  # type: ignore[assignment]  # for one call
    with pytest.raises(KeyboardInterrupt):
        getattr(robot, call)(*[True] * (call == "stop"))

    def free() -> bool:
        taken = lock.acquire(blocking=False)
        if taken:
            lock.release()
        return taken

    other, found = in_thread(free)
    other.join()
    assert found == [True]


def test_a_stop_is_sent_although_the_connection_is_lost(server: RecordingServer) -> None:
    server.answer("stop", 4)
    server.answer("robotmoving", True)
    with (
        FaultProxy(server.host, server.port) as proxy,
        DucoCobot(proxy.host, proxy.port) as robot,
    ):
        proxy.on("robotmoving", Cut(Place.BEFORE_REPLY))
        with pytest.raises(ConnectionLost):
            robot.robotmoving()
        with pytest.raises(ConnectionLost, match=r"the connection broke.*; call open\(\) first"):
            robot.robotmoving()
        assert robot.stop(True) == 4
        assert robot.open() == 0
        proxy.on("stop", Cut(Place.BEFORE_REPLY))
        assert robot.stop(True) == 4  # the first answer is lost
    assert len(server.received("stop")) == 3


def test_a_stop_is_sent_although_the_connection_could_not_be_made_again(
    server: RecordingServer,
) -> None:
    """It was refused as one that was never opened, while the arm moved on."""
    server.answer("stop", 4)
    with (
        FaultProxy(server.host, server.port) as proxy,
        DucoCobot(proxy.host, proxy.port) as robot,
    ):
        proxy.on("robotmoving", Cut(Place.BEFORE_REPLY))
        with pytest.raises(ConnectionLost):
            robot.robotmoving()
        there, robot.port = robot.port, 1
        assert robot.open() == -1  # nobody is there for a moment
        robot.port = there
        assert robot.stop(True) == 4


def test_a_stop_is_sent_again_if_the_connection_is_silent(
    server: RecordingServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It waited for ever, although a new connection would have reached the controller."""
    monkeypatch.setattr(compat, "_STOP_LIMIT", 0.05)
    server.answer("stop", 4)
    server.answer("robotmoving", True)
    with (
        FaultProxy(server.host, server.port) as proxy,
        DucoCobot(proxy.host, proxy.port) as robot,
    ):
        proxy.on("stop", HalfOpen())
        assert robot.stop(True) == 4
        assert robot.robotmoving() is True


def test_closing_ends_what_another_thread_waits_for(
    server: RecordingServer, robot: DucoCobot
) -> None:
    motion = Blocking(server)
    mover, moved = motion.start(robot)
    assert robot.close() == 0
    mover.join()
    assert isinstance(moved[0], OutcomeUnknown)
    assert robot.open() == 0
    assert robot.stop(True) == 4
    motion.gate.set()


def test_a_call_that_waits_when_its_connection_is_closed_is_not_sent_on_the_next(
    server: RecordingServer, robot: DucoCobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = Blocking(server)
    waits, opened, acquire = threading.Event(), threading.Event(), robot._acquire
    mover, _ = motion.start(robot)

    def wait() -> None:
        if threading.current_thread().name == "waiter":
            waits.set()
            assert opened.wait(30.0)
        acquire()

    monkeypatch.setattr(robot, "_acquire", wait)
    waiter, answers = in_thread(lambda: robot.movej2(JOINTS, 1.0, 1.0, 0.0, True), "waiter")
    assert waits.wait(30.0)
    motion.gate.set()
    assert robot.close() == 0
    assert robot.open() == 0
    opened.set()
    waiter.join()
    mover.join()
    assert isinstance(answers[0], ConnectionLost)
    assert len(server.received("movej2")) == 1


def test_one_left_open_warns(server: RecordingServer) -> None:
    robot = DucoCobot(server.host, server.port)
    robot.open()
    with pytest.warns(ResourceWarning, match="unclosed <DucoCobot"):
        robot.__del__()
