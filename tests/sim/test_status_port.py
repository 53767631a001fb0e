"""The status port: its frames by the public layout, who gets them, and who is cut off."""

from __future__ import annotations

import json
import math
import socket
import struct
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from aioduco.api.status_port import StatusPort
from aioduco.errors import ConnectError, ConnectionLost, ProtocolError
from aioduco.models import status_frame
from aioduco.models.status_frame import FRAME_SIZE, StatusFrame
from aioduco.sim import Simulator
from aioduco.sim.server.status_server import StatusServer as Pusher
from aioduco.testing import eventually

from .conftest import Connect, Program, a_program, standing_time

FACTS: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / "data" / "status-port-2001.json").read_text(encoding="utf-8")
)
FIELDS = [(offset, name, form) for offset, name, form, _ in FACTS["fields"] if form[-1] != "x"]


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(status_port=0, speed=math.inf) as sim:
        with a_program(sim) as program:
            program.bring_up()
        yield sim


@pytest.fixture
def program(sim: Simulator, connect: Connect) -> Program:
    return connect(sim)


def received(port: int | None, frames: int = 1) -> list[bytes]:
    """What a client gets that knows nothing but the length of a frame."""
    assert port is not None
    data = b""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as sock:
        while len(data) < frames * FRAME_SIZE:
            part = sock.recv(frames * FRAME_SIZE - len(data))
            assert part
            data += part
    return [data[at : at + FRAME_SIZE] for at in range(0, len(data), FRAME_SIZE)]


def public(frame: bytes) -> dict[str, tuple[Any, ...]]:
    """A frame read by the public layout, which shares no code with ours."""
    assert len(frame) == struct.calcsize(FACTS["struct"]) == FACTS["frame_bytes"]
    return {name: struct.unpack_from(f"<{form}", frame, at) for at, name, form in FIELDS}


def test_every_field_is_where_the_public_layout_has_it() -> None:
    ours = sorted((offset, form.format[1:]) for _, offset, form, _ in status_frame._LAYOUT)
    theirs = [(offset, "8B" if form == "8s" else form) for offset, _, form in FIELDS]
    assert ours == theirs
    assert [name for name, *_ in status_frame._LAYOUT] == [*StatusFrame.__dataclass_fields__]


def test_a_frame_is_read_as_it_was_written() -> None:
    frame = StatusFrame(
        joint_position=(0.5,) * 7,
        digital_in=(1, 0) * 8,
        word_register_in=(65535,) * 32,
        float_register_out=(1e300, -1e300, math.nan),
        mode=1,
        error=2**32 - 1,
    )
    read = StatusFrame.decode(frame.encode())
    assert read.joint_position == frame.joint_position
    assert (read.digital_in, read.word_register_in) == (frame.digital_in, frame.word_register_in)
    assert (read.mode, read.error, read.tool) == (1, 2**32 - 1, (0.0,) * 6)
    # What four bytes cannot hold is infinite there.
    assert read.float_register_out[:2] == (math.inf, -math.inf)
    assert math.isnan(read.float_register_out[2])
    for wrong in (b"", bytes(FRAME_SIZE - 1), bytes(FRAME_SIZE + 1)):
        with pytest.raises(ProtocolError, match="1468"):
            StatusFrame.decode(wrong)


def test_bytes_of_another_layout_are_no_frame() -> None:
    """They were read as joint angles and states."""
    for wrong in (bytes(range(255, -1, -1)) * 5 + bytes(188), b"\xff" * FRAME_SIZE):
        with pytest.raises(ProtocolError, match="another layout"):
            StatusFrame.decode(wrong)


def test_frames_tell_the_state(sim: Simulator, program: Program) -> None:
    program.write_float_reg(3, 2.5)
    program.write_word_reg(4, 65535)
    program.write_bool_reg(5, True)
    program.set_standard_digital_out(6, True, True)
    sim.signals.voltage_in[2] = 5.0
    sim.set_digital_input(7, True)
    sim.signals.tool_buttons[1] = True  # T, which comes first over the wire and last here
    assert program.to(0.3, 0.0, 1.57, 0.0, -1.57, 0.0) == 4
    status = program.getRobotStatus()
    frame = public(received(sim.status_port, 2)[1])
    assert frame["jointActualPosition"][:6] == pytest.approx(status.jointActualPosition, abs=1e-3)
    assert frame["jointExpectPosition"][:6] == pytest.approx(status.jointExpectPosition, abs=1e-5)
    assert frame["TCPActualPosition"][:3] == pytest.approx(status.cartActualPosition[:3], abs=1e-3)
    assert abs(frame["jointActualTorque"][1]) > 1.0
    assert frame["floatRegisterOutput"][2] == 2.5
    assert frame["wordRegisterOutput"][3] == 65535
    assert frame["boolRegisterOutput"][4] == 1
    assert frame["digitalIOOutput"][5] == 1
    assert frame["digitalIOInput"][6] == 1
    assert frame["analogInput"][1] == 5.0
    assert frame["toolButtonStatus"] == (0, 1)
    assert frame["globalSpeed"] == (100,)
    states = ("robotStatus", "robotProgramRunStatus", "safetyMonitorStatus", "robotOperationMode")
    assert [frame[name][0] for name in states] == program.get_robot_state()


async def test_a_program_reads_them(sim: Simulator) -> None:
    assert sim.status_port is not None
    async with StatusPort(sim.host, sim.status_port) as port:
        assert "open" in repr(port)
        frames = [await port.frame()]
        async for frame in port:
            frames.append(frame)
            if len(frames) == 3:
                break
    assert all(frame.robot == 6 and len(frame.joint_position) == 7 for frame in frames)
    with pytest.raises(ConnectionLost, match="async with"):
        await port.frame()


async def everything(port: StatusPort) -> None:
    """Read until nothing comes."""
    async for _ in port:
        pass


async def test_an_end_is_an_error_and_no_frame() -> None:
    with Simulator(status_port=0) as sim:
        assert sim.status_port is not None
        async with StatusPort(sim.host, sim.status_port) as port:
            await port.frame()
            sim.close()
            with pytest.raises(ConnectionLost, match="closed the connection"):
                await everything(port)
        with pytest.raises(ConnectError):
            await StatusPort("127.0.0.1", port.port).__aenter__()
    with pytest.raises(ValueError, match="timeout"):
        StatusPort("127.0.0.1", timeout=0.1)


def test_a_client_that_does_not_read_is_cut_off_and_delays_nobody() -> None:
    """Its frames are written without a pause, so that no time passes until its buffer is full."""
    pusher = Pusher(lambda: StatusFrame(mode=1))
    pusher.start()
    try:
        with socket.socket() as lazy:
            lazy.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            lazy.connect(("127.0.0.1", pusher.port))
            eventually(lambda: pusher.clients == 1)
            for _ in range(10_000):
                pusher._push()
                if not pusher.clients:
                    break
            assert not pusher.clients
        assert public(received(pusher.port)[0])["robotOperationMode"] == (1,)
    finally:
        pusher.close()
    pusher.close()


def test_frames_come_ten_times_a_second() -> None:
    """By the clock on the wall, whatever the simulation's speed: so many in a time, not more."""
    times: list[float] = []
    pusher = Pusher(lambda: StatusFrame(blended_speed=float(len(times))))
    assert pytest.approx(10.0) == status_frame.RATE == FACTS["rate_hz"]
    pusher.start()
    try:
        began = time.monotonic()
        received(pusher.port, 6)
        assert time.monotonic() - began > 5 * 0.9 / status_frame.RATE
    finally:
        pusher.close()


def test_a_controller_that_is_away_pushes_nothing(sim: Simulator, program: Program) -> None:
    assert sim.status_port is not None
    with socket.create_connection(("127.0.0.1", sim.status_port), timeout=10) as sock:
        assert sock.recv(1)
        with standing_time(sim):  # the answer comes before the network is gone
            program.restart(False)
        while sock.recv(1 << 16):
            pass  # ends when the controller starts again


def test_the_port_is_off_unless_asked_for() -> None:
    with Simulator() as sim:
        assert sim.status_port is None


def test_a_port_that_is_taken_is_said_and_leaves_nothing_behind(sim: Simulator) -> None:
    taken = Simulator(status_port=sim.status_port)
    with pytest.raises(OSError, match="in use"):
        taken.start()
    assert "not running" in repr(taken)
    taken.close()


@pytest.mark.slow
def test_a_simulator_in_its_own_process_says_where() -> None:
    with Simulator.spawn(status_port=0) as sim:
        assert public(received(sim.status_port)[0])["robotStatus"] == (4,)
