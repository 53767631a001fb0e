"""A TCP socket whose every operation ends at a deadline."""

from __future__ import annotations

import errno
import fcntl
import math
import os
import select
import socket
import struct
import termios
import time
from typing import Any, Final

from aioduco._wire.nonblocking import disconnect, send_at_once

#: A peer that vanished without a FIN is given up after about eight seconds, whether the
#: connection idles (probes from the fifth second on) or bytes are on their way.
_KEEP_ALIVE: Final = (("TCP_KEEPIDLE", 5), ("TCP_KEEPINTVL", 1), ("TCP_KEEPCNT", 3))
_USER_TIMEOUT_MS: Final = 8000

#: Closing discards what was not delivered, so that a process that is killed leaves nothing behind
#: that its system would deliver later.
_DISCARD: Final = struct.pack("ii", 1, 0)
_DELIVER: Final = struct.pack("ii", 0, 0)

#: seconds by which the system's own limit on a read or write may be longer than what is left
_SLACK: Final = 0.02

_CHUNK: Final = 16384


class DeadlinePassed(Exception):
    """The time for an operation is over."""


class Ended(Exception):
    """The other side closed the connection."""


class DeadlineSocket:
    """A blocking socket with absolute deadlines.

    Deadlines are times of `time.monotonic()`; None is no limit. They are kept by the system's
    limits on a socket (SO_RCVTIMEO, SO_SNDTIMEO), not by Python's: a read is then one blocking
    system call that releases the interpreter's lock once instead of twice. A limit is set
    anew only if what is left differs from it.

    One thread at a time; `shutdown` and `undelivered` may be used from any.

    Guarantees: after `shutdown`, `discard`, or the end of the process, the system delivers nothing
    more of what was sent. Only `close` is an ordinary end.
    """

    __slots__ = ("_limit", "_poll", "_shut", "_socket")

    def __init__(self, family: int, type_: int, protocol: int) -> None:
        self._socket = socket.socket(family, type_, protocol)
        self._poll = select.poll()
        self._poll.register(self._socket, select.POLLIN)
        #: the system's limit in seconds; None: none, as on a new socket
        self._limit: float | None = None
        self._shut = False

    def connect(self, address: Any, deadline: float) -> None:
        """Connect; raises what the system says, TimeoutError at the deadline, Ended if shut down.

        Args:
            address: as `socket.getaddrinfo` gives it.
            deadline: when it must have happened.
        """
        sock = self._socket
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _DISCARD)
        for name, value in _KEEP_ALIVE:
            if hasattr(socket, name):
                sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        sock.setblocking(False)
        error = sock.connect_ex(address)
        # A shutdown that came before the line above was of no effect on the socket, but is seen
        # here; one that comes later ends the wait.
        if self._shut:
            raise Ended
        if error == errno.EINPROGRESS:
            error = self._wait_connected(deadline)
        if error:
            raise OSError(error, os.strerror(error))
        # Without it, bytes that are not acknowledged are repeated for some fifteen minutes. Not
        # before: it would limit the handshake too.
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _USER_TIMEOUT_MS)
        # from here on the system keeps the time
        sock.setblocking(True)

    def _wait_connected(self, deadline: float) -> int:
        poll = select.poll()
        poll.register(self._socket, select.POLLOUT)
        left = deadline - time.monotonic()
        if left <= 0 or not poll.poll(math.ceil(left * 1000)):
            return errno.ETIMEDOUT
        return self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)

    def waiting_bytes(self) -> bytes:
        """Bytes that came and have not been read; they stay where they are.

        Raises:
            Ended: the other side closed the connection.
        """
        if not self._poll.poll(0):
            return b""
        found = self._socket.recv(64, socket.MSG_PEEK)
        if not found:
            raise Ended
        return found

    def send(self, data: bytes | memoryview, deadline: float | None) -> int:
        """Hand bytes to the system; how many it took, at least one.

        Raises:
            DeadlinePassed: it took none until then.
        """
        while True:
            self._limit_to(deadline)
            try:
                return self._socket.send(data)
            except BlockingIOError:
                # the system's limit, which may be a little before or after the deadline
                continue

    def send_at_once(self, data: bytes) -> int:
        """As `nonblocking.send_at_once`: how many bytes the system took, negative for none."""
        return send_at_once(self._socket.fileno(), data)

    def receive(self, deadline: float | None) -> bytes:
        """The next bytes, at least one.

        Raises:
            DeadlinePassed: none came until then.
            Ended: the other side closed the connection.
        """
        while True:
            self._limit_to(deadline)
            try:
                data = self._socket.recv(_CHUNK)
            except BlockingIOError:
                continue
            if not data:
                raise Ended
            return data

    @property
    def undelivered(self) -> int:
        """How many bytes the system still holds that the other side has not acknowledged."""
        found = fcntl.ioctl(self._socket, termios.TIOCOUTQ, bytes(4))
        return int(struct.unpack("i", found)[0])

    def shutdown(self) -> None:
        """End reads and writes that are under way, on any thread; discard what is undelivered."""
        self._shut = True
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            # not connected yet, or broken already: there is nothing to wake
            return
        # Some kernels refuse it while a thread waits on the socket; that thread then does it.
        disconnect(self._socket.fileno())

    def discard(self) -> None:
        """Give the socket back and forget what is undelivered; while no other thread uses it."""
        disconnect(self._socket.fileno())
        self._socket.close()

    def close_copy(self) -> None:
        """Close a forked child's copy of the socket, and nothing else: the parent uses it on."""
        self._socket.close()

    def close(self) -> None:
        """End an idle connection in the ordinary way; never while another thread uses it."""
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _DELIVER)
        self._socket.close()

    def _limit_to(self, deadline: float | None) -> None:
        limit: float | None = None
        if deadline is not None:
            left = deadline - time.monotonic()
            if left <= 0:
                raise DeadlinePassed
            slack = min(_SLACK, left / 8)
            if self._limit is not None and left <= self._limit <= left + slack:
                return
            # a little longer, so that it also fits the next call with the same time
            limit = left + slack / 2
        elif self._limit is None:
            return
        microseconds = 0 if limit is None else math.ceil(limit * 1e6)
        packed = struct.pack("@ll", *divmod(microseconds, 1_000_000))
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, packed)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, packed)
        self._limit = limit
