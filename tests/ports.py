"""Ports for the servers of tests: none is given twice in a run, to this process or to another.

The system gives a free port to whoever asks, and soon again: then a robot that still looks for the
controller of its own test, which has gone, finds that of another test and stops it. So servers that
ask for any free port get the next of a range that belongs to this process alone, outside of the one
that the system takes from, for connections too.
"""

from __future__ import annotations

import errno
import functools
import os
import random
import socket
from typing import Any

__all__ = ["free_port", "give_each_once"]

#: below those that Linux (32768), macOS and Windows (49152) give
_FIRST, _PAST = 10_000, 32_000
#: as many as a run has, or more
_PROCESSES = 16


class Ports:
    """The ports of one process, one after the other."""

    def __init__(self, process: int) -> None:
        count = (_PAST - _FIRST) // _PROCESSES
        self._range = range(_FIRST + process % _PROCESSES * count, _PAST)[:count]
        # Another run beside this one, or just before it, begins elsewhere.
        self._next = random.SystemRandom().randrange(count)

    def bind(self, sock: socket.socket, host: str, *more: Any) -> None:
        """Bind to the next port that is free."""
        for _ in self._range:
            port = self._range[self._next % len(self._range)]
            self._next += 1
            try:
                # That of a proxy would share the port with the proxy of another run.
                with socket.socket(sock.family) as alone:
                    _bind(alone, (host, port, *more))
                _bind(sock, (host, port, *more))
            except OSError as exc:
                if exc.errno not in (errno.EADDRINUSE, errno.EACCES):
                    raise
            else:
                return
        raise OSError(errno.EADDRINUSE, "no port of this process is free")


_bind = socket.socket.bind


@functools.cache
def _ports() -> Ports:
    return Ports(int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")))


def free_port() -> int:
    """A TCP port of this computer that nothing listens on, for who is told where to listen."""
    with socket.socket() as sock:
        _ports().bind(sock, "127.0.0.1")
        port: int = sock.getsockname()[1]
        return port


def give_each_once() -> None:
    """Have all servers of this process that listen on any free port get one of its own."""

    def bind(sock: socket.socket, address: Any) -> None:
        internet = sock.family in (socket.AF_INET, socket.AF_INET6)
        if internet and sock.type == socket.SOCK_STREAM and address[1] == 0:
            _ports().bind(sock, address[0], *address[2:])
        else:
            _bind(sock, address)

    socket.socket.bind = bind  # type: ignore[method-assign, assignment]
