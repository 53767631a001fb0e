"""A process of a run, inside one of its namespaces."""

from __future__ import annotations

import math
import os
import signal
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
from anyio.abc import ByteReceiveStream, Process
from anyio.streams.text import TextReceiveStream

from .lines import Line, parse

#: the folder of the tests: processes import their modules from it
_TESTS = Path(__file__).parents[2]
_PATH = os.pathsep.join(filter(None, [str(_TESTS), os.environ.get("PYTHONPATH")]))


class Child:
    """A process, and what it has said.

    Attributes:
        lines: what it has said so far.
        errors: what it wrote to its standard error.
        ended: when it ended [s]; infinite while it runs.
        status: its exit status, once it has ended.
    """

    def __init__(self, name: str, process: Process) -> None:
        self.name = name
        self._process = process
        self.lines: list[Line] = []
        self.errors = ""
        self.ended = math.inf
        self.status: int | None = None
        self._news = anyio.Event()

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    async def write(self, text: str) -> None:
        """Write a line to its standard input."""
        stdin = self._process.stdin
        assert stdin is not None
        await stdin.send(f"{text}\n".encode())

    async def says(self, what: str, timeout: float, after: int = 0) -> Line:
        """Wait until it has said something."""
        with anyio.move_on_after(timeout):
            while True:
                news = self._news
                for line in self.lines[after:]:
                    if line.what == what:
                        return line
                if self.status is not None:
                    raise RuntimeError(f"{self.name} ended before it said {what}: {self.errors}")
                await news.wait()
        raise TimeoutError(f"{self.name} did not say {what} within {timeout:g} s: {self.errors}")

    async def ends(self, timeout: float) -> bool:
        """Wait for its end, `timeout` seconds at the most; whether it has ended."""
        with anyio.move_on_after(timeout):
            while self.status is None:
                await self._news.wait()
        return self.status is not None

    async def _read_lines(self, stream: ByteReceiveStream) -> None:
        rest = ""
        async for text in TextReceiveStream(stream):
            *whole, rest = (rest + text).split("\n")
            self.lines += map(parse, whole)
            self._tell()

    async def _read_errors(self, stream: ByteReceiveStream) -> None:
        async for text in TextReceiveStream(stream, errors="replace"):
            self.errors += text

    async def _wait(self) -> None:
        await self._process.wait()
        self.ended = time.monotonic()
        self.status = self._process.returncode
        self._tell()

    def _tell(self) -> None:
        self._news.set()
        self._news = anyio.Event()


@asynccontextmanager
async def child(namespace: str, module: str, *options: str) -> AsyncIterator[Child]:
    """Run a module of this folder inside a namespace; it is killed at the end."""
    command = ["ip", "netns", "exec", namespace, sys.executable, "-m", f"hostile.cable.{module}"]
    process = await anyio.open_process(
        [*command, *options],
        env={**os.environ, "PYTHONPATH": _PATH},
        # a Ctrl-C at the terminal is for the tests
        start_new_session=True,
    )
    made = Child(module, process)
    assert process.stdout is not None
    assert process.stderr is not None
    try:
        async with anyio.create_task_group() as readers:
            readers.start_soon(made._read_lines, process.stdout)
            readers.start_soon(made._read_errors, process.stderr)
            readers.start_soon(made._wait)
            try:
                yield made
            finally:
                readers.cancel_scope.cancel()
    finally:
        if process.returncode is None:
            process.send_signal(signal.SIGKILL)
        with anyio.CancelScope(shield=True):
            await process.aclose()
