"""Processes that benchmarks measure, and clients of them below the SDK."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from subprocess import PIPE, Popen
from typing import IO, TYPE_CHECKING, Any

import anyio
from _common import CORES, HERE

from aioduco._wire import codec, idl
from aioduco._wire.connection import Connection
from aioduco._wire.endpoint import Endpoint
from aioduco._wire.lane import WireLane
from aioduco._wire.rpc import RpcClient

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from aioduco import Robot

HOST = "127.0.0.1"


def processor_time(pid: int) -> float:
    """Seconds of processor time that a process has used: the clock of clock_getcpuclockid(3)."""
    return time.clock_gettime(~pid << 3 | 2)


class Program(Popen[str]):
    """A program of Python in a process of its own, which reads and writes lines.

    It ends when its standard input is closed, so it cannot outlive the benchmark.
    """

    stdin: IO[str]
    stdout: IO[str]

    def __init__(self, *arguments: str, stdout: int = PIPE, stderr: int | None = None) -> None:
        command = [sys.executable, *arguments]
        super().__init__(command, stdin=PIPE, stdout=stdout, stderr=stderr, text=True)

    def line(self) -> str:
        """The next line that it writes."""
        line = self.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.args!r} ended before it answered")
        return line

    def ask(self, line: str) -> str:
        """Write a line, and return the one that it answers by."""
        self.stdin.write(f"{line}\n")
        self.stdin.flush()
        return self.line()

    def end(self) -> str:
        """Close its standard input; the rest of what it writes until it has ended."""
        self.stdin.close()
        return self.stdout.read()


CONTROLLER = str(HERE / "controller.py")


class ServerProcess(Program):
    """A program that serves on a core of its own, if there are two, and says where as JSON.

    A controller is another machine. When the scheduler puts both on one core, a direct call
    takes a third of the time and nothing that is compared here means anything.

    Attributes:
        ports: where it speaks the wire.
        echo: where it echoes bytes, if it does.
    """

    def __init__(self, *arguments: str) -> None:
        *ours, theirs = CORES
        os.sched_setaffinity(0, {theirs})
        try:
            super().__init__(*arguments)
        finally:
            os.sched_setaffinity(0, ours or CORES)
        found = json.loads(self.line())
        self.ports: list[int] = found["ports"]
        self.echo: int = found.get("echo", 0)


@contextlib.contextmanager
def client(port: int) -> Iterator[RpcClient]:
    """A connection whose calls block."""
    with contextlib.closing(Connection(Endpoint(HOST, port))) as connection:
        connection.open()
        yield RpcClient(lambda name, args: connection.call(name, args, 60.0))


@contextlib.asynccontextmanager
async def open_lane(port: int) -> AsyncIterator[WireLane]:
    """A lane, whose calls are awaited."""
    async with contextlib.aclosing(WireLane("benchmark", HOST, port)) as lane:
        await lane.open()
        yield lane


def call_bytes(name: str, *args: Any) -> bytes:
    """The bytes of a call."""
    function = idl.functions()[name]
    return codec.message(function, 1, codec.encode(function, args))


def guard_of(robot: Robot) -> int | None:
    """The process that guards an open robot; None if there is none."""
    seat = robot._supervisor.guard
    return None if seat is None else seat.pid


async def first_stop(lane: WireLane, begin: float) -> float:
    """When a controller was first told to stop after `begin`, or stopped by itself."""
    with anyio.fail_after(30.0):
        while True:
            after = [at for at in await lane.rpc.get_system_value_list("stops") if at >= begin]
            if after:
                return min(after)
            await anyio.sleep(0.005)
