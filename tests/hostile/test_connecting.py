"""Errors of the system while a robot or a stream is opened are named, and nothing is left."""

from __future__ import annotations

import errno
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

import pytest
from client.bench import HOME, Bench
from for_each import for_each

import aioduco
from aioduco._wire.connection import Connection
from aioduco._wire.endpoint import Endpoint
from aioduco.compat import DucoCobot
from aioduco.errors import ConnectError, ConnectTimeout, GuardLost, ParameterError, WorkerFailed
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.testing import eventually_async

LACKS = {
    errno.EMFILE: "no file descriptor left .EMFILE",
    errno.ENFILE: "no file descriptor left .ENFILE",
    errno.ENOBUFS: "no memory left for sockets .ENOBUFS",
    errno.EACCES: "does not permit it .EACCES",
}


def denied(number: int) -> Callable[..., Any]:
    def deny(*_: object, **__: object) -> Any:
        raise OSError(number, os.strerror(number))

    return deny


class Threads:
    """Lets so many threads of the package start, and no more."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, allowed: int) -> None:
        self.left = allowed
        start = threading.Thread.start

        def counted(thread: threading.Thread) -> None:
            if thread.name.startswith("aioduco"):
                if not self.left:
                    raise RuntimeError("can't start new thread")
                self.left -= 1
            start(thread)

        monkeypatch.setattr(threading.Thread, "start", counted)


@pytest.mark.parametrize("number", LACKS)
async def test_a_socket_that_is_denied_is_said_so(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    robot = aioduco.connect(bench.host, bench.port)
    with monkeypatch.context() as patch:
        patch.setattr("aioduco._wire.channel.DeadlineSocket", denied(number))
        with pytest.raises(ConnectError, match=LACKS[number]) as caught:
            await robot.open()
    assert not isinstance(caught.value, ConnectTimeout)
    await eventually_async(lambda: bench.connections == 0)


@pytest.mark.slow
async def test_a_heartbeat_without_a_descriptor_is_no_silent_controller(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = Connection.open

    def open_(connection: Connection, *args: Any) -> None:
        if threading.current_thread().name == "aioduco-heartbeat":
            exc = OSError(errno.EMFILE, "Too many open files")
            raise ConnectError(connection.host, connection.port, "it was denied") from exc
        made(connection, *args)

    monkeypatch.setattr(Connection, "open", open_)
    robot = aioduco.connect(bench.host, bench.port, call_timeout=2.0)
    with pytest.raises(ConnectError, match=r"no file descriptor left .EMFILE") as caught:
        await robot.open()
    assert not isinstance(caught.value, ConnectTimeout)
    await eventually_async(lambda: bench.connections == 0)


@pytest.mark.parametrize("allowed", range(2))
async def test_a_thread_that_cannot_be_had_is_said_so(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, allowed: int
) -> None:
    """The heartbeat, and the watch over the event loop."""
    robot = aioduco.connect(bench.host, bench.port)
    with monkeypatch.context() as patch:
        Threads(patch, allowed)
        with pytest.raises(ConnectError, match="can start no more threads"):
            await robot.open()
    assert robot._supervisor.state == "closed"
    await eventually_async(lambda: bench.connections == 0)
    # and with threads there is a robot
    async with aioduco.connect(bench.host, bench.port) as again:
        assert not await again.state.robotmoving()


@pytest.mark.parametrize("what", ["socketpair", "Popen", "thread"])
async def test_a_guard_that_cannot_be_started_is_said_so(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    robot = aioduco.connect(bench.host, bench.port, guard="process")
    words = LACKS[errno.EMFILE]
    with monkeypatch.context() as patch:
        if what == "socketpair":
            patch.setattr(
                "aioduco.supervision.guard.client.socket.socketpair", denied(errno.EMFILE)
            )
        elif what == "Popen":
            patch.setattr("aioduco.supervision.guard.client.subprocess.Popen", denied(errno.EMFILE))
        else:
            words = "can start no more threads"
            start = threading.Thread.start

            def start_others(thread: threading.Thread) -> None:
                if thread.name == "aioduco-guard":
                    raise RuntimeError("can't start new thread")
                start(thread)

            patch.setattr(threading.Thread, "start", start_others)
        with pytest.raises(GuardLost, match=words):
            await robot.open()
    await eventually_async(lambda: bench.connections == 0)


@pytest.mark.parametrize(
    ("run_in", "what"),
    [
        pytest.param("process", "os.memfd_create", marks=pytest.mark.linux("memory files")),
        ("process", "aioduco.streaming.session.socket.socketpair"),
        ("process", "aioduco._process.spawn.subprocess.Popen"),
        ("thread", "aioduco.streaming.session.socket.socketpair"),
        ("thread", "mmap"),
        ("thread", "thread"),
    ],
)
async def test_a_worker_that_cannot_be_started_is_said_so(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, run_in: Any, what: str
) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        stream = robot.servo.joints(v=1.0, a=5.0, options=WorkerOptions(run_in=run_in))
        words = LACKS[errno.EMFILE]
        with monkeypatch.context() as patch:
            if what == "thread":
                words = "can start no more threads"
                Threads(patch, 0)
            elif what == "mmap":
                patch.setattr("aioduco.streaming.shared.block.mmap.mmap", denied(errno.EMFILE))
            else:
                patch.setattr(what, denied(errno.EMFILE))
            with pytest.raises(WorkerFailed, match=words):
                await stream.__aenter__()
        # nothing was sent, and the robot is as it was
        assert bench.commands == []
        await robot.motion.movej2(HOME, v=1.0, a=1.0)


LIMITED = """
import asyncio, resource, socket, sys
import aioduco
from aioduco.testing import eventually_async
from aioduco.testing.leaks import Resources

async def main(host, port, spare, guard):
    async with aioduco.connect(host, port, call_timeout=1.0):
        pass  # all that is loaded is loaded
    before = Resources.now()
    held = []
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (100, limit[1]))
    try:
        while True:
            held.append(socket.socket())
    except OSError:
        for _ in range(spare):
            held.pop().close()
    try:
        async with aioduco.connect(host, port, call_timeout=1.0, guard=guard or None):
            said = "opened"
    except aioduco.DucoError as exc:
        said = f"{type(exc).__name__}: {exc}"
    for one in held:
        one.close()
    resource.setrlimit(resource.RLIMIT_NOFILE, limit)
    await eventually_async(lambda: not Resources.now().beyond(before))
    print(said, Resources.now().beyond(before))

asyncio.run(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]))
"""


@pytest.mark.slow
@pytest.mark.parametrize(("spare", "guard"), [(0, ""), (3, ""), (6, ""), (6, "process")])
def test_a_program_without_descriptors_is_told_so(bench: Bench, spare: int, guard: str) -> None:
    """The heartbeat and each lane in use take one descriptor; the guard takes more, beside them."""
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, bench.host, str(bench.port), str(spare), guard],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    # which of the two lacks one is a matter of which is faster
    said = ("GuardLost: ", "ConnectError: ") if guard else "ConnectError: "
    assert done.stdout.startswith(said), done.stdout
    assert "no file descriptor left (EMFILE)" in done.stdout
    assert done.stdout.endswith("[]\n"), done.stdout


NO_HOSTS = [
    *("127.0.0.1\0x", "127.0.0.1 ", " 127.0.0.1", "127.0.0.1\n", "127.0.0.1\t", "my robot"),
    *("robot..cell", "http://robot", "robot/", ".robot", "r" * 64, ".".join(["robot"] * 43)),
    *("", ".", "robot\x7f", "robot\ud800"),
]


@for_each("host", NO_HOSTS)
def test_what_can_be_no_host_is_refused_before_anything_is_tried(
    host: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(socket, "getaddrinfo", denied(errno.EIO))
    with pytest.raises(ParameterError, match=r"host is .*without http://, slashes, blanks"):
        aioduco.connect(host)
    with pytest.raises(ConnectError, match="the host must be"):
        Connection(Endpoint(host, 7003)).open()


def test_a_port_in_the_host_is_said_of_the_vendors_class_too() -> None:
    robot = DucoCobot("192.0.2.1:7004", 7003)
    assert robot.open() == -1
    assert "the host must be alone, with its port as an argument" in str(robot.last_error)
