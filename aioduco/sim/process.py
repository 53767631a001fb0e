"""A simulator in a process of its own, which ends with the process that started it."""

from __future__ import annotations

import json
import selectors
import subprocess
import sys
import tempfile
import time
from typing import TYPE_CHECKING, Any

import anyio
import anyio.to_thread

from aioduco.controller_clock import ScaledClock

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

#: until the process has said where it listens, and until it has ended after being asked to [s]
_START, _END = 60.0, 20.0


class SimulatorProcess:
    """`python -m aioduco.sim` with its standard input held open.

    The process ends when its standard input closes. The system closes it when this process ends, a
    kill included.

    Args:
        options: arguments of `Simulator`.

    Attributes:
        host: address that the simulator listens on.
        port: its TCP port.
        status_port: that of status frames; None if there is none.
        process: the process, for tests that kill it.
    """

    process: subprocess.Popen[bytes]

    def __init__(self, options: dict[str, Any]) -> None:
        self._options = options
        # A file, not a pipe: a pipe that is not read fills up and stops the process.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
        self.host: str = ""
        self.port: int = 0
        self.status_port: int | None = None

    @property
    def pid(self) -> int:
        """Id of the process."""
        return self.process.pid

    @property
    def clock(self) -> ScaledClock:
        """Its time for `aioduco.connect(clock=...)`, told from its speed; it cannot be held.

        Raises:
            ValueError: It goes as fast as possible: how fast that is, nobody here knows.
        """
        return ScaledClock(float(self._options.get("speed", 1.0)))

    def start(self) -> Self:
        """Start the process and wait until it listens.

        Raises:
            RuntimeError: It ended, or was silent, instead.
        """
        command = [sys.executable, "-m", "aioduco.sim", json.dumps(self._options)]
        # In a session of its own: a Ctrl-C on the terminal is for the program that started it,
        # which still needs the controller to see its arm stand.
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            start_new_session=True,
        )
        try:
            ready = json.loads(self._first_line())
        except BaseException:
            self.close()
            raise
        self.host, self.port = ready["host"], ready["port"]
        self.status_port = ready["status_port"]
        return self

    def close(self) -> None:
        """End the process; returns when it has ended."""
        process = self.process
        assert process.stdin is not None
        process.stdin.close()
        try:
            process.wait(_END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        assert process.stdout is not None
        process.stdout.close()
        self._errors.close()

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    async def __aenter__(self) -> Self:
        return await anyio.to_thread.run_sync(self.start)

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(self.close)

    def _first_line(self) -> bytes:
        stdout = self.process.stdout
        assert stdout is not None
        deadline = time.monotonic() + _START
        with selectors.DefaultSelector() as selector:
            selector.register(stdout, selectors.EVENT_READ)
            # The line is written at once, so once there is something, there is all of it.
            if not selector.select(deadline - time.monotonic()):
                raise RuntimeError(f"the simulator's process said nothing for {_START} s")
        line = stdout.readline()
        if not line:
            status = self.process.wait()
            self._errors.seek(0)
            raise RuntimeError(
                f"the simulator's process ended with status {status} before it listened: "
                f"{self._errors.read().decode(errors='replace').strip()}"
            )
        return line
