"""What a program under preflight may reach: its own servers and the named ones."""

from __future__ import annotations

import logging
import math
import os
import signal
import socket
import socketserver
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from itertools import product
from pathlib import Path

import psutil
import pytest
from cli_runner import CliRunner
from for_each import for_each

from aioduco.cli.app import app
from aioduco.sim import Simulator, runtime
from aioduco.testing import eventually
from aioduco.testing.preflight.borders import _answers
from aioduco.testing.preflight.program_clock import ProgramClock

from .trying import tried

#: begins each program: it uses a robot, at an address where an arm could be
BEGIN = """
import asyncio, concurrent.futures, multiprocessing, os, socket, socketserver, subprocess, sys
import threading
import aioduco, aioduco.sync
ARM = ("192.0.2.1", 7003)
with aioduco.sync.connect(*ARM) as robot:
    robot.state.get_tcp_pose()
"""
#: each way out, and whether the line is known: a thread of a pool does not tell who asked it
WAYS_OUT = {
    "socket.create_connection(ARM, timeout=30)": True,
    "socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b'', ARM)": True,
    "asyncio.run(asyncio.wait_for(asyncio.open_connection(*ARM), 30))": True,
    "socket.create_connection(('127.0.0.1', 9), timeout=30)": True,
    "subprocess.run([sys.executable, '-c', ''])": True,
    "os.system('true')": True,
    "os.execv('/bin/true', ['true'])": True,
    "multiprocessing.get_context('spawn').Process(target=print).start()": True,
    "concurrent.futures.ThreadPoolExecutor().submit(subprocess.run, 'true').result()": False,
}
OWN_SERVERS = """
class Echo(socketserver.StreamRequestHandler):
    def handle(self):
        self.wfile.write(self.rfile.readline())

def heard(address):
    with socket.create_connection(address, timeout=30) as client:
        client.sendall(b"word\\n")
        return client.makefile("rb").readline()

with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Echo) as server:
    threading.Thread(target=server.serve_forever, daemon=True).start()
    assert heard(server.server_address) == heard(("localhost", server.server_address[1]))
    server.shutdown()

async def main():
    async def echo(reader, writer):
        writer.write(await reader.readline())
        writer.close()

    server = await asyncio.start_server(echo, "127.0.0.1", 0)
    async with server:
        reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
        writer.write(b"word\\n")
        assert await reader.readline() == b"word\\n"
        writer.close()

asyncio.run(main())
"""
OWN_STATUS_PORT = """
from aioduco.api.status_port import StatusPort
from aioduco.sim import Simulator
async def main():
    with Simulator(status_port=0) as simulator:
        async with StatusPort(simulator.host, simulator.status_port, timeout=30.0) as frames:
            await anext(frames)
asyncio.run(main())
"""
OWN_PROCESSES = """
from aioduco.planning import Planner, Scene
async def main():
    async with aioduco.connect(*ARM, guard="process") as robot:
        await robot.bring_up()
        here = await robot.state.get_actual_joints_position()
        async with Planner(Scene()) as planner:
            Scene().picture(here, width=20, height=20)
            plan = await planner.plan(here, aioduco.Joints.of([q + 0.1 for q in here]))
        await robot.motion.execute(plan)
        # No controller answers as soon as that; here, a computer that is too busy is not found.
        hasty = aioduco.WorkerOptions(timeout=1e-6)
        async with robot.servo.joints(v=1.0, a=5.0, rate=100, options=hasty) as stream:
            await stream.send(await robot.state.get_actual_joints_position())
asyncio.run(main())
"""
#: two arms at once, each by an address, or by a simulator
TWO_ARMS = {
    "two addresses": """
async def main():
    async with aioduco.connect("192.0.2.1"), aioduco.connect("192.0.2.1"):
        async with aioduco.connect("192.0.2.2"):  # SECOND
            pass
""",
    "two simulators": """
from aioduco.sim import Simulator
async def main():
    with Simulator() as one, Simulator() as two:  # SECOND
        async with aioduco.connect(one.host, one.port), aioduco.connect(two.host, two.port):
            pass
""",
    "one after the other": """
from aioduco.sim import Simulator
async def main():
    for _ in range(2):
        with Simulator() as one:
            async with aioduco.connect(one.host, one.port):
                pass
""",
}


class Answer(socketserver.StreamRequestHandler):
    def handle(self) -> None:
        self.wfile.write(b"reached")


@pytest.fixture
def there() -> Iterator[int]:
    """The port of a server on this computer that is none of the program's."""
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Answer) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.server_address[1]
        server.shutdown()
        thread.join()


@pytest.mark.slow
def test_each_way_out_is_refused_and_found_even_if_the_program_goes_on(tmp_path: Path) -> None:
    text = BEGIN
    for way in WAYS_OUT:
        text += f"try:\n    {way}\n    sys.exit({way!r})\nexcept PermissionError: pass\n"
    report = tried(tmp_path, text)
    lines = text.splitlines()
    found = [(finding.kind, finding.line) for finding in report.findings]
    assert report.status == 0, report.findings
    assert found == [
        ("not reached", lines.index(f"    {way}") + 1 if known else 0)
        for way, known in WAYS_OUT.items()
    ]
    assert "--reach 192.0.2.1:7003" in report.findings[0].text


@pytest.mark.slow
def test_what_is_refused_and_not_caught_is_one_finding(tmp_path: Path) -> None:
    report = tried(tmp_path, BEGIN + "socket.create_connection(ARM)\n")
    assert [finding.kind for finding in report.findings] == ["not reached"]
    assert report.status == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "body",
    [OWN_SERVERS, OWN_STATUS_PORT, OWN_PROCESSES],
    ids=["servers", "status port", "processes"],
)
def test_what_is_its_own_or_of_this_package_works(tmp_path: Path, body: str) -> None:
    # The program's time races while it waits for a server, which has the time of the wall.
    report = tried(tmp_path, BEGIN + body, patience=1e6)
    assert report.ok, report.findings
    assert report.status == 0


@pytest.mark.slow
def test_what_is_named_is_reached_and_a_bad_name_is_refused(tmp_path: Path, there: int) -> None:
    program, told = tmp_path / "program.py", tmp_path / "told"
    program.write_text(
        f"{BEGIN}for host in ('localhost', '127.0.0.1'):\n"
        f"    with socket.create_connection((host, {there}), timeout=30) as client:\n"
        f"        open({str(told)!r}, 'ab').write(client.recv(99))\n"
    )

    def run(*reach: str) -> tuple[int, str]:
        done = CliRunner().invoke(app, ["preflight", "--quiet", *reach, str(program)])
        return done.exit_code, " ".join(done.output.split())

    status, said = run("--reach", f"localhost:{there}")
    assert (status, told.read_bytes()) == (0, b"reachedreached"), said
    status, said = run()
    assert status == 1
    assert f"--reach 127.0.0.1:{there}" in said
    for bad in (f":{there}", str(there), "host:0", "host:70000", "host:port"):
        status, said = run("--reach", bad)
        assert status == 2
        assert repr(bad) in said
        assert "no program was run" in said


@pytest.mark.slow
def test_a_tried_program_ends_with_a_preflight_that_is_killed(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text("import threading\nprint('here', flush=True)\nthreading.Event().wait()\n")
    command = [sys.executable, "-m", "aioduco.cli", "preflight", str(program)]
    own = os.environ | {"TMPDIR": str(tmp_path)}  # what it leaves
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=own) as running:
        assert running.stdout is not None
        assert running.stdout.readline() == b"here\n"
        (child,) = psutil.Process(running.pid).children()
        os.kill(running.pid, signal.SIGKILL)
    gone, _ = psutil.wait_procs([child], timeout=60)
    assert gone == [child]


def bound(kind: int, host: str, port: int = 0, *, listens: bool = False) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    server = socket.socket(family, kind)
    server.bind((host, port))
    if listens:
        server.listen()
    return server


@for_each("asked, host", product(["127.0.0.1", "localhost"], ["127.0.0.1", "0.0.0.0"]))
def test_a_server_that_listens_is_the_program_s_own(host: str, asked: str) -> None:
    with (
        bound(socket.SOCK_STREAM, host, listens=True) as server,
        socket.socket(socket.AF_INET, socket.SOCK_STREAM) as client,
        bound(socket.SOCK_DGRAM, host) as datagrams,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        assert _answers(server, client, asked, server.getsockname()[1])
        assert _answers(datagrams, sender, asked, datagrams.getsockname()[1])
        assert not _answers(server, client, asked, server.getsockname()[1] ^ 1)
        assert not _answers(server, client, "192.0.2.1", server.getsockname()[1])
        assert not _answers(server, client, "arm.example", server.getsockname()[1])


def test_the_number_of_a_port_alone_leads_nowhere() -> None:
    """A tunnel to an arm may have the number: by another protocol, address or socket."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_STREAM) as client,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
        bound(socket.SOCK_STREAM, "127.0.0.1", listens=True) as tunnel,
    ):
        port = tunnel.getsockname()[1]
        with bound(socket.SOCK_DGRAM, "127.0.0.1", port) as datagrams:
            assert not _answers(datagrams, client, "127.0.0.1", port), "of another protocol"
        assert not _answers(tunnel, sender, "127.0.0.1", port), "of another protocol"
        assert not _answers(tunnel, client, "127.0.0.2", port), "of another address"
    with bound(socket.SOCK_STREAM, "127.0.0.1") as silent:
        port = silent.getsockname()[1]
        assert not _answers(silent, client, "127.0.0.1", port), "it does not listen"
    assert not _answers(silent, client, "127.0.0.1", port), "it is closed"
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as shared:
        shared.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        shared.bind(("127.0.0.1", 0))
        shared.listen()
        assert not _answers(shared, client, "127.0.0.1", shared.getsockname()[1]), "of others too"


@pytest.mark.slow
@pytest.mark.linux("audit hooks see all connections")
def test_a_datagram_socket_opens_no_stream_to_the_same_number(tmp_path: Path) -> None:
    hits: list[object] = []

    class Tunnel(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            hits.append(self.client_address)

    with socketserver.TCPServer(("127.0.0.1", 0), Tunnel) as tunnel:
        thread = threading.Thread(target=tunnel.serve_forever, daemon=True)
        thread.start()
        port = tunnel.server_address[1]
        report = tried(
            tmp_path,
            BEGIN + f"with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as here:\n"
            f"    here.bind(('127.0.0.1', {port}))\n"
            f"    socket.create_connection(('127.0.0.1', {port}), timeout=30)\n",
        )
        tunnel.shutdown()
        thread.join()
    assert not report.ok
    assert hits == []


def _given_up(log: pytest.LogCaptureFixture, times: int) -> bool:
    return log.text.count("and goes on") == times


def test_a_program_that_is_held_up_for_long_finds_its_time_where_it_was(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Where all threads stop for seconds, the simulator may go on before any of them."""
    caplog.set_level(logging.WARNING)
    monkeypatch.setattr(runtime, "_HOLD", 0.01)
    clock = ProgramClock()  # not started: its thread comes too late
    with Simulator() as simulator:
        clock.attach(simulator)
        simulator.speed = 1e5
        at = math.nan
        for number in range(1, 6):
            simulator.clock.hold(-math.inf)
            eventually(partial(_given_up, caplog, number), 30.0)
            if number == 1:
                at = clock.passed
        assert clock.passed == at
        clock.detach()


def test_time_stands_while_a_loop_with_a_timer_due_does_not_get_to_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a busy machine the arm would be far beyond the end of its motion at the next poll."""
    looks: list[float] = []
    look = ProgramClock._look

    def counted(self: ProgramClock) -> None:
        looks.append(self.passed)
        look(self)

    monkeypatch.setattr(ProgramClock, "_look", counted)
    clock = ProgramClock()
    with Simulator() as simulator:
        clock.start()
        clock.attach(simulator)
        try:
            with clock.waiting(-1.0):  # it was due a second ago
                begin, number = simulator.time, len(looks)
                eventually(lambda: len(looks) > number + 5)
                assert simulator.time < begin + 0.01  # a cycle may be under way
            with clock.waiting(60.0):
                eventually(lambda: simulator.time > begin + 1.0)
        finally:
            clock.close()


@pytest.mark.slow
@pytest.mark.parametrize("body", TWO_ARMS.values(), ids=TWO_ARMS)
def test_a_second_arm_is_found_since_both_would_be_the_same(tmp_path: Path, body: str) -> None:
    text = f"import asyncio, aioduco\n{body}asyncio.run(main())\n"
    report = tried(tmp_path, text)
    second = [number for number, line in enumerate(text.splitlines(), 1) if "SECOND" in line]
    assert [(each.kind, each.line) for each in report.findings] == [
        ("not reached", number) for number in second
    ], report.findings
    assert all("a preflight has one arm" in each.text for each in report.findings)


def test_a_thread_that_works_beside_the_program_does_not_hold_its_time_for_ever() -> None:
    clock, over = ProgramClock(), threading.Event()

    def last() -> None:
        clock.add_actor(0.0)
        over.wait(60.0)

    lasting = threading.Thread(target=last)
    with Simulator() as simulator:
        clock.start()
        clock.attach(simulator)
        lasting.start()
        try:
            with clock.waiting(60.0):
                begin = simulator.time
                eventually(lambda: simulator.time > begin + 60.0)
            over.set()
            lasting.join()
        finally:
            clock.close()
