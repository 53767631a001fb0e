"""Hanging name servers, addresses that lead nowhere and silent servers end within deadlines.

The ways to a controller: the robot in both forms, the vendor's class, the command, the ports that
send by themselves, and the tap.
"""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import anyio
import numpy as np
import pytest
from client.bench import Bench
from for_each import for_each
from typer.testing import CliRunner
from wire.names import NAME, Names
from wire.servers import PATIENCE, black_hole

import aioduco
import aioduco.sync
from aioduco._wire.endpoint import Address, Route
from aioduco.api.force_stream import ForceStream
from aioduco.api.status_port import StatusPort
from aioduco.cli.app import app
from aioduco.compat import DucoCobot
from aioduco.errors import ConnectError, ConnectionLost, ParameterError, RobotStateError
from aioduco.integrations.panel import Panel
from aioduco.models.status_frame import FRAME_SIZE
from aioduco.recording.tap import Tap
from aioduco.sim import Simulator
from aioduco.testing import FaultProxy, no_leaks

#: shorter than what the silent side keeps silent, and not waited for where a test passes
SHORT = 0.3


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is answered has time for it on a busy machine."""
    monkeypatch.setattr(f"{__name__}.SHORT", PATIENCE)


@pytest.fixture
def hurried(patient: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of several addresses has a moment, in place of its share of that time."""
    tries = Route.tries

    def first_is_hurried(
        route: Route, found: Iterable[Address], deadline: float
    ) -> Iterator[tuple[Address, float]]:
        for number, (address, until) in enumerate(tries(route, found, deadline)):
            first = number == 0 and route.address is None
            yield address, time.monotonic() + 0.3 if first else until

    monkeypatch.setattr(Route, "tries", first_is_hurried)


def by_robot(host: str, port: int) -> None:
    async def look() -> None:
        async with aioduco.connect(host, port, connect_timeout=SHORT, call_timeout=SHORT):
            pass

    anyio.run(look)


def by_sync(host: str, port: int) -> None:
    with aioduco.sync.connect(host, port, connect_timeout=SHORT, call_timeout=SHORT):
        pass


def by_compat(host: str, port: int) -> None:
    robot = DucoCobot(host, port)
    if robot.open():
        raise ConnectError(host, port, str(robot.last_error))
    robot.close()


def by_command(host: str, port: int) -> None:
    done = CliRunner().invoke(app, ["status", f"{host}:{port}"])
    if done.exit_code:
        raise ConnectError(host, port, done.output)


def by_status_port(host: str, port: int) -> None:
    async def look() -> None:
        async with StatusPort(host, port, timeout=SHORT):
            pass

    anyio.run(look)


def by_force_stream(host: str, port: int) -> None:
    async def look() -> None:
        async with ForceStream(host, port, timeout=SHORT):
            pass

    anyio.run(look)


def by_tap(host: str, port: int) -> None:
    with Tap(host, port):
        pass


WAYS = [by_robot, by_sync, by_compat, by_command, by_status_port, by_force_stream, by_tap]


@pytest.mark.parametrize("way", WAYS)
def test_a_name_that_hangs_ends_in_time_and_holds_up_no_end(
    names: Names, monkeypatch: pytest.MonkeyPatch, way: Callable[[str, int], None]
) -> None:
    monkeypatch.setattr("aioduco.recording.tap.tap._RESOLVE", SHORT)
    names.answers.clear()
    with pytest.raises(ConnectError, match="no answer in time"):
        way(NAME, 7003)
    # a thread that a program, or its event loop, waits for as it ends would hang with the name
    assert names.threads
    assert all(each.name == "aioduco-resolve" and each.daemon for each in names.threads)


@pytest.mark.usefixtures("patient")
@pytest.mark.parametrize("way", WAYS)
def test_a_name_that_nobody_knows(names: Names, way: Callable[[str, int], None]) -> None:
    with pytest.raises(ConnectError, match="unknown host"):
        way(NAME, 7003)


@pytest.mark.slow
@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("way", WAYS[:4])
def test_a_first_address_that_does_not_answer(
    names: Names, way: Callable[[str, int], None]
) -> None:
    with Bench() as bench, black_hole() as nobody:
        names.addresses = [nobody, (bench.host, bench.port)]
        way(NAME, 7003)


@contextmanager
def silent() -> Iterator[socket.socket]:
    """A server that takes connections, and neither reads nor writes."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        yield listener


@pytest.mark.usefixtures("hurried")
async def test_a_status_port_whose_first_address_does_not_answer(names: Names) -> None:
    with silent() as server, black_hole() as nobody:
        names.addresses = [nobody, server.getsockname()]
        async with StatusPort(NAME, timeout=SHORT) as port:
            taken, _ = server.accept()
            taken.sendall(bytes(FRAME_SIZE))
            with suppress(aioduco.errors.ProtocolError):
                await port.frame()
            taken.close()


@pytest.mark.slow
@pytest.mark.parametrize("first", ["silent", "closed"])
def test_a_tap_whose_first_address_leads_nowhere(
    names: Names, monkeypatch: pytest.MonkeyPatch, first: str
) -> None:
    """Connections after it begin with the address that answered."""
    with silent() as server, black_hole() as nobody, socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        server.settimeout(PATIENCE)
        away = nobody if first == "silent" else closed.getsockname()
        names.addresses = [away, server.getsockname()]
        with Tap(NAME) as tap:
            for _ in range(2):
                with socket.create_connection((tap.host, tap.port), timeout=PATIENCE) as client:
                    client.sendall(b"abc")
                    taken, _ = server.accept()
                    with taken:
                        taken.settimeout(PATIENCE)
                        assert taken.recv(3) == b"abc"


@pytest.mark.parametrize("way", [by_robot, by_sync])
def test_a_server_that_takes_connections_and_never_reads(way: Callable[[str, int], None]) -> None:
    with no_leaks(), silent() as server, pytest.raises((ConnectError, ConnectionLost)):
        way(*server.getsockname())


async def test_a_status_port_that_sends_nothing() -> None:
    with silent() as server:
        async with StatusPort(*server.getsockname(), timeout=PATIENCE) as port:
            port.timeout = SHORT
            with pytest.raises(ConnectionLost, match="no frame within"):
                await port.frame()


#: by name, what takes the port of a controller, or one to listen on
PORT_TAKERS: dict[str, Callable[[Any], object]] = {
    "robot": lambda port: aioduco.connect("192.0.2.1", port),
    "status port": lambda port: StatusPort("192.0.2.1", port),
    "force stream": lambda port: ForceStream("192.0.2.1", port),
    "tap": lambda port: Tap("192.0.2.1", port),
    "proxy": lambda port: FaultProxy("192.0.2.1", port),
    "panel": lambda port: Panel("192.0.2.1", port),
    "tap, its own": lambda port: Tap("192.0.2.1", listen=("127.0.0.1", port)),
    "panel, its own": lambda port: Panel("192.0.2.1", listen=port),
}


@for_each("name", PORT_TAKERS)
def test_what_is_no_port_is_refused_where_it_is_given(name: str) -> None:
    take = PORT_TAKERS[name]
    for port in ("7003", "x", -1, 70000, True, None, 7003.0, math.nan):
        with pytest.raises(ParameterError):
            take(port)
    take(np.int64(7003))


@for_each("listen", ["x", 5, None, ("127.0.0.1",), ("", 0), (5, 0)])
def test_a_tap_listens_on_no_address_that_is_none(listen: Any) -> None:
    with pytest.raises(ParameterError, match="listen"):
        Tap("192.0.2.1", listen=listen)


@pytest.mark.slow
async def test_what_is_open_is_not_opened_again() -> None:
    """The first connection, process or proxy was left behind, and lived on."""
    with (
        no_leaks(),
        Simulator.spawn(speed=math.inf, status_port=0) as sim,
        FaultProxy(sim.host, sim.port) as proxy,
    ):
        with pytest.raises(RuntimeError, match="running already"):
            sim.start()
        with pytest.raises(RuntimeError, match="running already"):
            proxy.__enter__()
        async with StatusPort(sim.host, sim.status_port or 0, timeout=PATIENCE) as status:
            with pytest.raises(RobotStateError, match="once at a time"):
                await status.__aenter__()
            await status.frame()
