"""A tap passes on exactly the bytes of client and controller."""

from __future__ import annotations

import io
import json
import os
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from client.bench import HOME, Bench

import aioduco
import aioduco.sync
from aioduco.cli import tap as tap_command
from aioduco.errors import ConnectError
from aioduco.recording import read
from aioduco.recording.tap import Tap, TapNote, TappedCall
from aioduco.testing import eventually, no_leaks

PATIENCE = 60.0


class Told:
    """Everything that a tap tells, by a thread of its own."""

    def __init__(self, tap: Tap) -> None:
        self.items: list[TappedCall | TapNote] = []
        self._thread = threading.Thread(target=self._read, args=(tap,), name="told")
        self._thread.start()

    def _read(self, tap: Tap) -> None:
        self.items.extend(tap)

    def notes(self) -> list[str]:
        return [item.text for item in list(self.items) if isinstance(item, TapNote)]

    def calls(self) -> list[TappedCall]:
        return [item for item in list(self.items) if isinstance(item, TappedCall)]

    def join(self) -> None:
        self._thread.join()


@contextmanager
def told(tap: Tap) -> Iterator[Told]:
    with tap:
        found = Told(tap)
        try:
            yield found
        finally:
            tap.end()
            found.join()


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    """Where the tap looks for a controller."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(PATIENCE)
        yield listener


@contextmanager
def joined(tap: Tap, listener: socket.socket) -> Iterator[tuple[socket.socket, socket.socket]]:
    """A client's socket and the controller's."""
    with ExitStack() as stack:
        there: list[socket.socket] = []
        while listener not in there:  # a client that comes while others are cut is cut with them
            address = tap.host, tap.port
            client = stack.enter_context(socket.create_connection(address, timeout=PATIENCE))
            there, _, _ = select.select([client, listener], [], [], PATIENCE)
            assert there
        controller, _ = listener.accept()
        stack.enter_context(controller)
        controller.settimeout(PATIENCE)
        yield client, controller


def taken(sock: socket.socket, size: int) -> bytes:
    data = bytearray()
    while len(data) < size and (chunk := sock.recv(65536)):
        data += chunk
    return bytes(data)


async def test_a_robot_behind_it_is_told_of(bench: Bench) -> None:
    with told(tap := Tap(bench.host, bench.port)) as found:
        async with aioduco.connect(tap.host, tap.port) as robot:
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
    (move,) = [call for call in found.calls() if call.function == "movej2"]
    assert move.arguments["joints_list"] == list(HOME)
    assert move.answer >= 1000
    assert not move.error


def test_bytes_pass_both_ways_whatever_they_are(listener: socket.socket) -> None:
    with no_leaks(), told(tap := Tap("127.0.0.1", listener.getsockname()[1])) as found:
        with joined(tap, listener) as (client, controller):
            there, back = os.urandom(3_000_000), os.urandom(2_000_000)
            for sender, receiver, data in ((client, controller, there), (controller, client, back)):
                thread = threading.Thread(target=sender.sendall, args=(data,))
                thread.start()
                assert taken(receiver, len(data)) == data
                thread.join()
            client.shutdown(socket.SHUT_WR)
            assert controller.recv(1) == b""
            controller.sendall(b"still here")
            assert taken(client, 10) == b"still here"
            controller.shutdown(socket.SHUT_WR)
            assert client.recv(1) == b""
        eventually(lambda: "closed by the client" in found.notes(), PATIENCE)
    assert sum("is no message" in note for note in found.notes()) == 2


def test_what_a_client_reads_late_is_told_of_all_the_same(listener: socket.socket) -> None:
    """A copy was left out, and nothing said so, while the client's socket took no more."""
    name, text = b"function_of_later", b"x" * 60_000
    call = struct.pack(f">Ii{len(name)}sib", 0x80010001, len(name), name, 1, 0)
    answer = struct.pack(f">Ii{len(name)}sibhi", 0x80010002, len(name), name, 1, 11, 0, len(text))
    answer += text + b"\0"
    count = 200
    answers = answer * count  # more than the sockets on the way usually take
    tap = Tap("127.0.0.1", listener.getsockname()[1])
    with told(tap) as found, joined(tap, listener) as (client, controller):
        client.sendall(call * count)
        assert taken(controller, len(call) * count) == call * count
        sent = 0
        controller.setblocking(False)
        # until nothing more passes; the system may have room for all
        while sent < len(answers) and select.select([], [controller], [], 0.5)[1]:
            sent += controller.send(answers[sent : sent + 4096])
        controller.setblocking(True)
        thread = threading.Thread(target=controller.sendall, args=(answers[sent:],))
        thread.start()
        assert taken(client, len(answers)) == answers
        thread.join()
    assert (len(found.calls()), found.notes()[1:-1]) == (count, [])


@pytest.mark.slow
def test_who_does_not_read_what_it_tells_holds_up_nothing(listener: socket.socket) -> None:
    with Tap("127.0.0.1", listener.getsockname()[1]) as tap, joined(tap, listener) as pair:
        client, controller = pair
        data = os.urandom(1_000_000)
        for _ in range(80):  # more than it keeps
            thread = threading.Thread(target=client.sendall, args=(data,))
            thread.start()
            assert taken(controller, len(data)) == data
            thread.join()
        client.close()
        assert controller.recv(1) == b""
        controller.close()
        texts = []
        for item in tap:
            texts.append(str(item))
            if "closed" in texts[-1]:
                break
        assert any("passed unseen" in text for text in texts)


@pytest.mark.slow
@pytest.mark.parametrize("who", ["client", "controller"])
def test_a_reset_of_one_side_is_one_of_the_other(listener: socket.socket, who: str) -> None:
    with told(tap := Tap("127.0.0.1", listener.getsockname()[1])) as found:
        with joined(tap, listener) as pair:
            gone, left = pair if who == "client" else pair[::-1]
            gone.sendall(b"x")
            assert left.recv(1) == b"x"
            gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            gone.close()
            with pytest.raises(ConnectionResetError):
                left.recv(1)
        eventually(lambda: f"closed by the {who}" in found.notes(), PATIENCE)


@pytest.mark.slow
def test_a_controller_that_is_not_there(listener: socket.socket) -> None:
    port = listener.getsockname()[1]
    listener.close()
    with told(tap := Tap("127.0.0.1", port)) as found:
        with (
            pytest.raises(ConnectionResetError),
            socket.create_connection((tap.host, tap.port), timeout=PATIENCE) as client,
        ):
            client.recv(1)
        eventually(lambda: any("was not reached" in note for note in found.notes()), PATIENCE)


@pytest.mark.slow
def test_its_end_ends_what_is_connected_and_tells_what_passed(listener: socket.socket) -> None:
    with told(tap := Tap("127.0.0.1", listener.getsockname()[1])) as found:
        stack = ExitStack()
        client, controller = stack.enter_context(joined(tap, listener))
        client.sendall(b"no message")
        assert controller.recv(64) == b"no message"
    assert "is no message" in found.notes()[-2]
    assert found.notes()[-1] == "closed by the tap"
    with stack:
        for sock in (client, controller):
            with pytest.raises(ConnectionResetError):
                sock.recv(1)


@pytest.mark.slow
@pytest.mark.linux("freezes a process")
def test_a_relay_that_stood_still_delivers_nothing_of_before(listener: socket.socket) -> None:
    with Tap("127.0.0.1", listener.getsockname()[1]) as tap, joined(tap, listener) as pair:
        client, controller = pair
        assert tap._linked is not None
        tap._linked.popen.send_signal(signal.SIGSTOP)
        client.sendall(b"late")
        with socket.create_connection((tap.host, tap.port), timeout=PATIENCE) as another:
            another.sendall(b"late")
            time.sleep(2.1)
            tap._linked.popen.send_signal(signal.SIGCONT)
            for sock in (client, controller, another):
                with pytest.raises(ConnectionResetError):
                    sock.recv(1)
        with joined(tap, listener) as (client, controller):
            client.sendall(b"new")
            assert taken(controller, 3) == b"new"


def test_a_relay_that_is_killed_ends_what_is_told(listener: socket.socket) -> None:
    with told(tap := Tap("127.0.0.1", listener.getsockname()[1])) as found:
        assert tap._linked is not None
        tap._linked.popen.send_signal(signal.SIGKILL)
        found.join()


@pytest.mark.cases(1)
@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0"])
def test_a_tap_that_would_connect_to_itself_is_refused(host: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with (
        pytest.raises(ConnectError, match="listens there itself"),
        Tap("localhost", port, listen=(host, port)),
    ):
        pass


def test_it_is_used_in_a_block() -> None:
    with pytest.raises(RuntimeError, match="with"):
        next(iter(Tap("127.0.0.1")))


@pytest.mark.slow
def test_a_tap_that_is_open_starts_no_second_relay(listener: socket.socket) -> None:
    with no_leaks(), Tap(*listener.getsockname()) as tap:
        with pytest.raises(RuntimeError, match="open already"):
            tap.__enter__()
        assert tap.port


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".jsonl", ".mcap"])
def test_the_command_shows_and_records_each_call(bench: Bench, tmp_path: Path, suffix: str) -> None:
    file = wanted = tmp_path / f"calls{suffix}"
    if suffix == ".mcap":
        wanted.touch()
        file = tmp_path / "calls-1.mcap"
    command = [sys.executable, "-m", "aioduco.cli", "tap", bench.host, "--port", str(bench.port)]
    with ExitStack() as stack:
        program = stack.enter_context(
            subprocess.Popen(
                [*command, "--listen", "127.0.0.1:0", "--only", "power_on", "-o", str(wanted)],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        )
        stack.callback(program.kill)
        assert program.stdout is not None
        assert program.stderr is not None
        said = program.stdout.readline()
        between = re.match(r"between 127\.0\.0\.1:(\d+) and ", said)
        assert between, said + program.stderr.read()
        with aioduco.sync.connect("127.0.0.1", int(between[1])) as robot:
            robot.system.power_on()
            states = robot.state.get_robot_state()
        lines = []
        while "power_on" not in (line := program.stdout.readline()):
            lines.append(line)
        lines.append(line)
        program.send_signal(signal.SIGINT)
        lines += program.stdout.readlines()
        assert program.wait(PATIENCE) == 0, program.stderr.read()
        assert (f"recording to {file}\n" in program.stderr.read()) is (suffix == ".mcap")
    assert sum("power_on(block=False) -> " in line for line in lines) == 1
    assert not any("get_robot_state" in line for line in lines)
    if suffix == ".mcap":
        data = [message.data for message in read(file).messages("/commands")]
    else:
        data = [json.loads(line) for line in file.read_text("utf-8").splitlines()]
    answers = {each["function"]: each.get("answer", each.get("result")) for each in data}
    found = (states.robot, states.program, states.safety, states.mode)
    assert answers["get_robot_state"] == [int(each) for each in found]
    assert isinstance(answers["power_on"], int)


@pytest.mark.linux("a file that is full")
def test_a_full_disk_ends_the_file_alone(capsys: pytest.CaptureFixture[str]) -> None:
    with tap_command._file(Path("/dev/full"), "127.0.0.1", 7003, str) as write:
        for _ in range(3):
            write("a call")  # type: ignore[arg-type]
    said = capsys.readouterr().err
    assert said == "/dev/full ended early: No space left on device; the tap goes on\n"


def test_a_line_of_which_the_disk_takes_a_part_at_first_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next line followed the part."""

    class Nearly(io.FileIO):
        def write(self, data: Any) -> int:
            return super().write(data[: 100 if self.tell() else 3])

    path = tmp_path / "calls.jsonl"
    monkeypatch.setattr(tap_command, "open", lambda *_, **__: Nearly(path, "ab"), raising=False)
    with tap_command._file(path, "127.0.0.1", 7003, str) as write:
        for _ in range(2):
            write("a call")  # type: ignore[arg-type]
    assert path.read_text() == "a call\na call\n"


@pytest.mark.parametrize("step", [-7200.0, 3600.0])
def test_a_clock_that_is_set_does_not_part_the_calls(
    step: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, wall = tmp_path / "calls.jsonl", time.time
    with tap_command._file(file, "127.0.0.1", 7003, tap_command._line_maker()) as write:
        write(TappedCall(0, "stop", {}, 1, "", 1.0, 0.001))
        monkeypatch.setattr(time, "time", lambda: wall() + step)
        write(TappedCall(0, "stop", {}, 2, "", 1.5, 0.001))
    first, second = (json.loads(each)["at"] for each in file.read_text("utf-8").splitlines())
    assert second - first == pytest.approx(0.5, abs=1e-3)


@pytest.mark.slow
@pytest.mark.linux("limits of another process")
@pytest.mark.parametrize("spare", [0, 1, 2, 3])
def test_without_descriptors_the_connections_that_are_open_go_on(spare: int) -> None:
    import resource  # noqa: PLC0415 - not on Windows

    with Bench() as bench, Tap(bench.host, bench.port) as tap, ExitStack() as clients:

        def client() -> socket.socket:
            return clients.enter_context(socket.create_connection((tap.host, tap.port), PATIENCE))

        told = Told(tap)
        first = aioduco.sync.connect(tap.host, tap.port, heartbeat=None)
        clients.enter_context(first)
        assert tap._linked is not None
        process = tap._linked.popen.pid
        open_files = [each.name for each in Path(f"/proc/{process}/fd").iterdir()]
        used = max(int(each) for each in open_files) + 1
        limit = resource.prlimit(process, resource.RLIMIT_NOFILE)
        resource.prlimit(process, resource.RLIMIT_NOFILE, (used + spare, limit[1]))
        more = [client() for _ in range(10)]
        for _ in range(3):
            assert first.state.get_actual_joints_position()
        assert tap._linked.popen.poll() is None
        resource.prlimit(process, resource.RLIMIT_NOFILE, limit)
        for each in more:
            each.close()
        with aioduco.sync.connect(tap.host, tap.port, heartbeat=None) as second:
            assert second.state.get_actual_joints_position(), "clients are accepted again"
        first.close()
        tap.end()
        told.join()
