"""The network of the cable tests does what it says, and leaves nothing behind."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from aioduco.testing import eventually

from .cable.network import CONTROLLER, KINDS, Network, network, why_not

_SERVER = f"""
import socket, sys
listener = socket.create_server(({CONTROLLER!r}, 0))
print(listener.getsockname()[1], flush=True)
kept = [listener.accept()]
sys.stdin.read()
"""

#: connects once, then tries each time that it reads a line; a new connection, and the first one
_CLIENT = f"""
import socket, sys
address = ({CONTROLLER!r}, int(sys.argv[1]))
first = socket.create_connection(address, 60)
first.settimeout(1.0)
print("connected", flush=True)
for limit in sys.stdin:
    try:
        socket.create_connection(address, float(limit))
        second = "connected"
    except OSError as exc:
        second = type(exc).__name__
    try:
        first.send(b"x")
        first.recv(1)
        known = "closed"
    except OSError as exc:
        known = type(exc).__name__
    print(second, known, flush=True)
"""


@pytest.fixture
def cable() -> Iterator[Network]:
    if reason := why_not():
        pytest.skip(f"no network namespaces here: {reason}")
    with network() as made:
        yield made


def _inside(namespace: str, *command: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        ["ip", "netns", "exec", namespace, *command],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _line(process: subprocess.Popen[str], given: str | None = None) -> str:
    assert process.stdin is not None
    assert process.stdout is not None
    if given is not None:
        process.stdin.write(f"{given}\n")
        process.stdin.flush()
    return process.stdout.readline().strip()


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_an_outage_ends_what_it_says_it_ends_and_no_more(cable: Network, kind: str) -> None:
    with (
        _inside(cable.controller, sys.executable, "-c", _SERVER) as server,
        _inside(cable.program, sys.executable, "-c", _CLIENT, _line(server)) as client,
    ):
        assert _line(client) == "connected"
        cable.interrupt(kind)
        second, known = _line(client, "1").split()
        if kind == "reset":
            assert (second, known) == ("ConnectionRefusedError", "ConnectionResetError")
        else:
            # nobody is told
            assert second in ("TimeoutError", "OSError")
            assert known == "TimeoutError"
        cable.restore(kind)
        second, _ = _line(client, "60").split()
        assert second == "connected"
        client.kill()
        server.kill()


def test_a_network_leaves_no_process_and_no_namespace(cable: Network) -> None:
    with network() as made:
        process = _inside(made.program, "sleep", "1000")
        eventually(lambda: process.pid in made.pids())
    assert process.wait() == -9
    names = subprocess.run(["ip", "netns", "list"], capture_output=True, text=True, check=True)
    assert made.program not in names.stdout
    assert made.controller not in names.stdout
    assert cable.program in names.stdout
    for stream in (process.stdin, process.stdout):
        assert stream is not None
        stream.close()
