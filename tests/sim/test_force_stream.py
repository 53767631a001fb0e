"""The force stream: samples on request, of both lengths, until a silence."""

from __future__ import annotations

import contextlib
import math
import socket
import struct
import threading
from collections.abc import Iterator

import pytest

import aioduco
from aioduco.api import force_stream
from aioduco.api.force_stream import ForceStream
from aioduco.compat import DucoCobot
from aioduco.errors import ConnectionLost, ProtocolError
from aioduco.models.force_sample import FORCE_REQUEST, ForceSample
from aioduco.models.pose import Pose
from aioduco.models.status_frame import FRAME_SIZE, StatusFrame
from aioduco.sim import Simulator
from aioduco.sim.server.force_server import ForceServer
from aioduco.testing import eventually

SAMPLE = ForceSample((1.0, -2.0, 3.5, 0.25, 0.5, -0.125), Pose(0.5, 0.25, 0.125, 1.0, 0.5, -1.0))


@contextlib.contextmanager
def client(port: int) -> Iterator[socket.socket]:
    """A socket that knows nothing of this package."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.connect(("127.0.0.1", port))
        opened.settimeout(10.0)
        yield opened


def test_who_asks_gets_forces_and_poses() -> None:
    with Simulator(force_port=0, speed=math.inf) as sim:
        assert sim.force_port
        with client(sim.force_port) as opened:
            opened.send(b"start_force_stream")
            first, second = opened.recv(4096), opened.recv(4096)
        assert len(first) == len(second) == 48
        robot = DucoCobot(sim.host, sim.port)
        robot.open()
        assert struct.unpack("<12f", second)[6:] == pytest.approx(robot.get_tcp_pose(), abs=1e-5)
        robot.close()


def test_without_a_sensor_nothing_is_sent_and_the_status_tells_no_force() -> None:
    with Simulator(force_port=0, status_port=0, speed=math.inf) as sim:
        sim.cabinet.force_sensor = False
        sim.push((0.0, 0.0, -20.0, 0.0, 0.0, 0.0))
        assert sim.force_port
        assert sim.status_port
        with client(sim.force_port) as opened:
            opened.send(FORCE_REQUEST)
            with socket.create_connection((sim.host, sim.status_port), 10.0) as pushed:
                data = b""
                while len(data) < 4 * FRAME_SIZE:  # 0.3 s, in which thirty samples would come
                    data += pushed.recv(FRAME_SIZE)
            assert StatusFrame.decode(data[:FRAME_SIZE]).tcp_force == (0.0,) * 6
            opened.setblocking(False)
            with pytest.raises(BlockingIOError):
                opened.recv(4096)


async def test_our_client_takes_what_the_simulator_sends() -> None:
    async with Simulator(force_port=0, speed=math.inf) as sim:
        flange = sim.arm.fkine(sim.joints)
        sim.push((0.0, 0.0, -20.0, 0.0, 0.0, 0.0))
        async with ForceStream(sim.host, sim.force_port or 0) as stream:
            async for sample in stream:
                if sample.force[2] < -15.0:
                    break
        assert sample.tcp is not None
        assert sample.tcp.z == pytest.approx(flange[2, 3], abs=1e-2)


@pytest.fixture
def server() -> Iterator[ForceServer]:
    server = ForceServer(lambda: SAMPLE)
    server.start()
    yield server
    server.close()


def test_a_controller_that_starts_anew_forgets_who_asked(server: ForceServer) -> None:
    with client(server.port) as opened:
        opened.send(FORCE_REQUEST)
        assert ForceSample.decode(opened.recv(4096)) == SAMPLE
        server.refuse(True)
        eventually(lambda: not server._clients)
        opened.send(FORCE_REQUEST)
        server.refuse(False)
    with contextlib.ExitStack() as stack:
        for _ in range(10):
            stack.enter_context(client(server.port)).send(FORCE_REQUEST)
        eventually(lambda: len(server._clients) == 8)


def test_other_words_start_nothing(server: ForceServer) -> None:
    with client(server.port) as opened:
        for word in (b"start", b"", b"start_force_stream_now"):
            opened.send(word)
        opened.send(FORCE_REQUEST)
        opened.recv(4096)
        assert list(server._clients) == [opened.getsockname()]


class Silent:
    """A controller that answers the second request alone, with datagrams of its own length."""

    def __init__(self, answer: bytes) -> None:
        self.asked = 0
        self._answer = answer
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self.port: int = self._socket.getsockname()[1]
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            data, sender = self._socket.recvfrom(256)
            if data != FORCE_REQUEST:
                return
            self.asked += 1
            if self.asked == 2:
                self._socket.sendto(self._answer, sender)

    def close(self) -> None:
        with client(self.port) as opened:
            opened.send(b"end")
        self._thread.join()
        self._socket.close()


async def test_it_asks_again_and_takes_forces_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(force_stream, "ASK_AGAIN", 0.01)
    with contextlib.closing(Silent(struct.pack("<6f", *SAMPLE.force))) as controller:
        async with ForceStream("127.0.0.1", controller.port, timeout=30.0) as stream:
            assert await stream.sample() == ForceSample(SAMPLE.force)
            assert controller.asked == 2


async def test_a_length_that_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(force_stream, "ASK_AGAIN", 0.01)
    with contextlib.closing(Silent(bytes(20))) as controller:
        async with ForceStream("127.0.0.1", controller.port, timeout=30.0) as stream:
            with pytest.raises(ProtocolError, match="20 bytes"):
                await stream.sample()


def test_a_pose_that_is_none_is_no_wrong_argument_of_the_program() -> None:
    with pytest.raises(ProtocolError, match="a pose that is not finite"):
        ForceSample.decode(struct.pack("<12f", *[0.0] * 6, math.nan, *[0.0] * 5))


async def test_nobody_is_there() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        async with ForceStream("127.0.0.1", taken.getsockname()[1]) as stream:
            stream.timeout = 0.05  # of the sample alone
            with pytest.raises(ConnectionLost, match="no sample within"):
                await stream.sample()
    with pytest.raises(ConnectionLost, match="open it"):
        await stream.sample()


def test_the_port_is_off_unless_asked_for() -> None:
    with Simulator(speed=math.inf) as sim:
        assert sim.force_port is None
    with pytest.raises(aioduco.ParameterError):
        ForceStream("")
