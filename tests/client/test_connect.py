"""Connecting: the errors for everything that may be at the other end."""

from __future__ import annotations

import contextlib
import socket
import socketserver
import threading
from collections.abc import Iterator

import anyio
import pytest
from wire.servers import black_hole

import aioduco
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco.testing import RecordingServer, eventually_async
from client.bench import HOME, Bench


@contextlib.contextmanager
def listening(greeting: bytes = b"", answer: bytes = b"", close: bool = False) -> Iterator[int]:
    """A server that is no controller: it greets, answers all alike, or closes."""

    class Handler(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            if greeting:
                self.request.sendall(greeting)
            while not close and self.request.recv(4096):
                if answer:
                    self.request.sendall(answer)

    class Server(socketserver.ThreadingTCPServer):
        daemon_threads = True
        block_on_close = False
        allow_reuse_address = True
        request_queue_size = 64  # a robot connects several times at once

    with Server(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server.server_address[1]
        finally:
            server.shutdown()
            thread.join()


async def refused(port: int, host: str = "127.0.0.1") -> aioduco.ConnectError:
    robot = aioduco.connect(host, port, call_timeout=0.4, connect_timeout=0.4)
    with anyio.fail_after(30), pytest.raises(aioduco.ConnectError) as caught:
        await robot.open()
    assert isinstance(caught.value, ConnectionError)
    assert (caught.value.host, caught.value.port) == (host, port)
    assert "closed" in repr(robot)
    left = [t for t in threading.enumerate() if t.name.startswith("aioduco")]
    await eventually_async(lambda: not any(thread.is_alive() for thread in left))
    return caught.value


@pytest.mark.slow
async def test_an_address_that_leads_nowhere_is_tried_once(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All connections of a robot begin with the address that connected before."""
    with black_hole() as dead:
        kind = (socket.AF_INET, socket.SOCK_STREAM, 6, "")
        addresses = [(*kind, dead), (*kind, (bench.host, bench.port))]
        monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: addresses)
        tried: list[object] = []
        prepare = DeadlineSocket.prepare

        def noted(stream: DeadlineSocket) -> None:
            tried.append(stream)
            prepare(stream)

        monkeypatch.setattr(DeadlineSocket, "prepare", noted)
        async with aioduco.connect("arm.example", 7003, connect_timeout=2.0) as robot:
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
            opened = sum(lane.opened for lane in robot.statistics().lanes.values())
        assert opened > 6
        assert len(tried) == opened + 2  # the dead one, and that of the heartbeat


async def test_a_port_on_which_nobody_listens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    error = await refused(port)
    assert "refused" in str(error)


async def test_a_server_that_answers_nothing() -> None:
    with listening() as port:
        error = await refused(port)
    assert isinstance(error, aioduco.ConnectTimeout)
    assert isinstance(error, TimeoutError)
    assert "did not answer within 0.4 s; is the controller still starting" in str(error)


async def test_a_listener_that_never_accepts() -> None:
    with socket.create_server(("127.0.0.1", 0), backlog=64) as silent:
        error = await refused(silent.getsockname()[1])
    assert isinstance(error, aioduco.ConnectTimeout)


@pytest.mark.parametrize(
    ("greeting", "answer"),
    [
        (b"", b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n"),
        (b"SSH-2.0-OpenSSH_9.6\r\n", b""),
        (b"", bytes(range(256))),
    ],
    ids=["http", "ssh", "binary"],
)
async def test_a_server_that_is_no_controller(greeting: bytes, answer: bytes) -> None:
    with listening(greeting, answer) as port:
        error = await refused(port)
    assert isinstance(error, aioduco.NotAController)
    assert "the controller's port is 7003" in str(error)
    assert error.__cause__ is not None


async def test_a_controller_that_is_starting_closes_connections() -> None:
    with listening(close=True) as port:
        error = await refused(port)
    assert isinstance(error, aioduco.NotAController)
    assert "or one that is still starting" in str(error)


async def test_a_thrift_server_of_something_else() -> None:
    with RecordingServer() as server:
        error = await refused(server.port)
    assert isinstance(error, aioduco.NotAController)
    assert "does not know the controller's functions" in str(error)


async def test_a_controller_whose_heartbeat_hangs(bench: Bench) -> None:
    bench.hold("rpc_heartbeat", None)
    error = await refused(bench.port)
    assert isinstance(error, aioduco.ConnectTimeout)


async def test_what_is_opened_and_what_is_sent(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        assert bench.connections == 8
        assert {call.method for call in bench.received()} <= {
            "get_robot_state",
            "get_robot_version",
            "rpc_heartbeat",
        }
        figures = robot.statistics()
        assert set(figures.lanes) == {
            *("stop", "control", "poll", "motion", "feed", "call", "blocking")
        }
        assert figures.lanes["stop"].calls == 0
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
        figures = robot.statistics()
        assert (figures.tasks, figures.live_tasks, figures.stops) == (1, 0, 0)
        assert figures.polls > 0
        assert figures.heartbeat is not None
        assert figures.heartbeat.beats > 0
    await eventually_async(lambda: bench.connections == 0)


async def test_the_trace_hook_sees_calls_and_connections(bench: Bench) -> None:
    seen: list[object] = []
    async with aioduco.connect(bench.host, bench.port, trace=seen.append) as robot:
        await robot.state.robotmoving()
    kinds = {type(event).__name__ for event in seen}
    assert {"ConnectionOpened", "CallFinished"} <= kinds
