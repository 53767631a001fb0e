"""A child process of this package, with a socket for requests and replies."""

from __future__ import annotations

import contextlib
import os
import pickle
import socket
import struct
import subprocess
from typing import TYPE_CHECKING, Any

from aioduco._process.platform import handed_socket
from aioduco._process.spawn import Process
from aioduco.errors import WrongProcess

if TYPE_CHECKING:
    from collections.abc import Sequence

_HEAD = struct.Struct("<Q")
#: time for a process to exit after its channel was closed [s]
_END = 5.0


class ValueChannel:
    """A socket for Python values between a parent and its child process, which trust each other.

    A child that was forked from the parent has a copy of the socket: it must not use it, or it
    would get the parent's answers, and closing its copy changes nothing for the parent.

    Args:
        link: the socket; the channel closes it.
    """

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._owner = os.getpid()

    @property
    def inherited(self) -> bool:
        """Whether this is a forked child, whose parent has the channel."""
        return os.getpid() != self._owner

    def require_own(self) -> None:
        """Check that this process may use the channel.

        Raises:
            WrongProcess: this is a forked child; nothing was sent.
        """
        if self.inherited:
            raise WrongProcess(
                f"process {os.getpid()} was forked from {self._owner}, which this belongs to: make "
                "another one in this process. Nothing was sent"
            )

    @classmethod
    def of(cls, arguments: Sequence[str]) -> ValueChannel:
        """Return the channel to the program, in a process whose `main` got these arguments."""
        return cls(handed_socket(arguments[0]))

    def fileno(self) -> int:
        """File descriptor of the socket, for a selector that waits for a value or the end."""
        return self._link.fileno()

    def copy(self) -> socket.socket:
        """Return a duplicate of the socket, for bytes in another format."""
        return self._link.dup()

    def send(self, value: object) -> None:
        """Send a value.

        Raises:
            OSError: the other side has closed.
            WrongProcess: this is a forked child; nothing was sent.
        """
        self.require_own()
        data = pickle.dumps(value)
        self._link.sendall(_HEAD.pack(len(data)))
        self._link.sendall(data)

    def receive(self, timeout: float | None = None) -> Any:
        """Wait for a value.

        Args:
            timeout: seconds within which the value must begin to arrive; None for no limit.

        Raises:
            EOFError: the other side has closed.
            TimeoutError: nothing came in time.
            OSError: the other side exited before it had read everything.
            WrongProcess: this is a forked child.
        """
        self.require_own()
        self._link.settimeout(timeout)
        head = self._read(_HEAD.size)
        self._link.settimeout(None)
        return pickle.loads(self._read(*_HEAD.unpack(head)))

    def close(self) -> None:
        """Close the socket: `receive` ends on both sides, in other threads too."""
        # A call to receive in another thread keeps a socket open that was closed only.
        if not self.inherited:
            with contextlib.suppress(OSError):  # the other side has closed
                self._link.shutdown(socket.SHUT_RDWR)
        self._link.close()

    def _read(self, size: int) -> bytearray:
        data = bytearray(size)
        rest = memoryview(data)
        while rest:
            count = self._link.recv_into(rest)
            if not count:
                raise EOFError("the other side has closed")
            rest = rest[count:]
        return data


class LinkedProcess(Process):
    """A process with a channel. It must exit when the channel closes, and so with the program.

    Args:
        module: module whose `main` it runs; `main` opens the channel by `ValueChannel.of`.
        patience: seconds for it to exit after its channel was closed; then it is killed.
        options: further options of `Process`.

    Raises:
        Unstartable: there is no interpreter to start.
        OSError: the system does not allow it.
    """

    def __init__(self, module: str, *, patience: float = _END, **options: Any) -> None:
        self._patience = patience
        ours, theirs = socket.socketpair()
        try:
            super().__init__(module, [theirs], **options)
        except BaseException:
            ours.close()
            raise
        finally:
            theirs.close()
        self.channel = ValueChannel(ours)

    def ask(self, request: object) -> Any:
        """Send a request, and wait for the answer.

        Raises:
            EOFError, OSError: the process has exited.
        """
        self.channel.send(request)
        return self.channel.receive()

    def close(self) -> None:
        """Close the channel, and wait for the exit of the process. `stderr_tail` stays readable.

        In a forked child this closes the child's copy alone: the process goes on for the parent.
        """
        self.channel.close()
        if self.channel.inherited:
            return
        try:
            self.popen.wait(self._patience)
        except subprocess.TimeoutExpired:
            self.popen.kill()
            self.popen.wait()
        super().close()

    def end(self) -> str:
        """Close it. Returns the last line of its standard error; empty if it wrote nothing."""
        self.close()
        return self.stderr_tail.rpartition("\n")[2]
