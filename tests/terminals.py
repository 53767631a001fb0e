"""Runs a program in a pseudo-terminal: its screen and its keys."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import termios
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from aioduco.testing import eventually

#: what asks a command to end: Ctrl-C, a service that is stopped, a terminal that is closed
ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Terminal:
    """A pseudo-terminal with a program in it."""

    def __init__(self, descriptor: int, program: subprocess.Popen[bytes]) -> None:
        self._descriptor = descriptor
        self.program = program
        self.seen = bytearray()
        self.closed = False

    def shows(self, text: bytes) -> bool:
        while select.select([self._descriptor], [], [], 0.0)[0]:
            try:
                self.seen.extend(os.read(self._descriptor, 65536))
            except OSError:  # the program has ended
                break
        return text in self.seen

    def until_it_shows(self, text: bytes) -> None:
        eventually(
            lambda: self.shows(text), timeout=60, what=lambda: f"{text!r} in {bytes(self.seen)!r}"
        )

    def exit_code(self) -> int | None:
        """Take what the program still shows, until it has ended."""
        eventually(lambda: self.shows(b"") and self.program.poll() is not None, timeout=60)
        return self.program.returncode

    def close(self) -> None:
        """Close the terminal's window."""
        os.close(self._descriptor)
        self.closed = True

    def press(self, keys: bytes) -> None:
        self.seen.clear()
        os.write(self._descriptor, keys)


@contextmanager
def terminal(*words: str, command: Sequence[str]) -> Iterator[Terminal]:
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 120, 0, 0))
    before = termios.tcgetattr(theirs)
    environment = {key: os.environ[key] for key in os.environ if key not in {"COLUMNS", "LINES"}}
    with subprocess.Popen(
        [*command, *words],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
        env=environment | {"TERM": "xterm-256color"},
    ) as program:
        try:
            shown = Terminal(ours, program)
            yield shown
            assert shown.closed or termios.tcgetattr(theirs) == before, "the terminal is as it was"
        finally:
            program.kill()
            if not shown.closed:
                os.close(ours)
            os.close(theirs)
