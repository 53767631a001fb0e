"""A TCP socket with a deadline for every operation."""

from __future__ import annotations

import errno
import math
import os
import socket
import struct
import threading
import time
from typing import TYPE_CHECKING, Final

from aioduco._process.platform import CONNECTING, limits_sockets, readiness, unacknowledged
from aioduco._wire.failures import DeadlinePassed
from aioduco._wire.forks import fork_hooks
from aioduco._wire.nonblocking import disconnect, is_silent, send_at_once

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.endpoint import Address

#: If the peer disappears without a FIN, the connection ends after about eight seconds, both when
#: it is idle (probes from the fifth second on) and when sent bytes are not acknowledged.
_KEEP_ALIVE: Final = (("TCP_KEEPIDLE", 5), ("TCP_KEEPINTVL", 1), ("TCP_KEEPCNT", 3))
_USER_TIMEOUT_MS: Final = 8000

#: Closing discards bytes that were not delivered. Otherwise the system would deliver them after the
#: process was killed.
_DISCARD: Final = struct.pack("ii", 1, 0)
_DELIVER: Final = struct.pack("ii", 0, 0)

#: seconds by which the system's limit on a read or write may exceed the remaining time
_SLACK: Final = 0.02

#: seconds after which a wait of the main thread is interrupted to run signal handlers. A signal
#: that arrives just before a wait begins does not end the wait. Its handler, which may stop the
#: arm, would otherwise run only when the controller answers.
WAKE_EVERY: Final = 0.2
#: the same for a caller that is told of each wait
WAITING_EVERY: Final = 0.1

_CHUNK: Final = 16384


class DeadlineSocket:
    """A socket with absolute deadlines for the thread that uses it, or one of an event loop.

    Deadlines are times of `time.monotonic()`; None is no limit. The system's limits on a socket
    (SO_RCVTIMEO, SO_SNDTIMEO) enforce them, not Python's: a read is then one blocking system call
    that releases the interpreter's lock once instead of twice. A limit is set again only if the
    remaining time differs from it. Where the system has no such limits, Python's time-outs enforce
    the deadlines. On an event loop the socket never blocks, and the loop keeps the time.

    One thread at a time; `shutdown`, `undelivered` and `silent` may be used from any thread.

    Guarantees: after `shutdown`, `discard`, or the end of the process, the system delivers no more
    of the sent bytes. Only `close` ends the connection in the ordinary way.

    Args:
        to: the address to connect to, as `socket.getaddrinfo` returns it.
        waiting: called every tenth of a second while a read of a thread waits.
    """

    __slots__ = ("__weakref__", "_limit", "_readable", "_shut", "_to", "_waiting", "socket")

    def __init__(self, to: Address, waiting: Callable[[], object] | None = None) -> None:
        self._to = to[-1]
        self._waiting = waiting
        #: the socket itself, for the event loop
        self.socket: socket.socket = socket.socket(*to[:3])
        self._readable = readiness(self.socket)
        #: the system's limit in seconds; without one, as on a new socket, infinite
        self._limit = math.inf
        self._shut = False
        fork_hooks.add(self)

    def connect(self, deadline: float) -> None:
        """Connect.

        Args:
            deadline: time by which the connection must be made.

        Raises:
            TimeoutError: the deadline has passed.
            OSError: the system's error.
            EOFError: the socket was shut down.
        """
        self.prepare()
        error = self.socket.connect_ex(self._to)
        # A shutdown before the line above had no effect on the socket, but has set `_shut`. A later
        # one ends the wait.
        if self._shut:
            raise EOFError
        if error in CONNECTING:
            error = self._wait_connected(deadline)
        if error:
            raise OSError(error, os.strerror(error))
        self.connected(blocking=True)

    def prepare(self) -> None:
        """Set the options that a connection has from its first packet on; it does not block."""
        sock = self.socket
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _DISCARD)
        for name, value in _KEEP_ALIVE:
            if hasattr(socket, name):
                sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        sock.setblocking(False)

    def connected(self, *, blocking: bool) -> None:
        """Set the options of a connection that was made.

        Args:
            blocking: whether a thread will wait for its bytes; else an event loop does.
        """
        sock = self.socket
        # Without it, the system repeats bytes that are not acknowledged for some fifteen minutes.
        # Set after the handshake, since it would limit that too.
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _USER_TIMEOUT_MS)
        # from here on the system enforces a thread's deadlines, if it can
        sock.setblocking(blocking)

    @property
    def has_peer(self) -> bool:
        """Whether the other side has taken the connection."""
        try:
            self.socket.getpeername()
        except OSError:
            return False
        return True

    def _wait_connected(self, deadline: float) -> int:
        # one that was made while this thread did not run is taken, also after the deadline
        left = max(deadline - time.monotonic(), 0.0)
        if not readiness(self.socket, writing=True)(left):
            return errno.ETIMEDOUT
        return self.socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)

    def unasked(self) -> bytes:
        """Return bytes that have arrived, without removing them from the system's buffer.

        Raises:
            EOFError: the other side closed the connection.
        """
        if self.silent or not self._readable(0):
            return b""
        found = self.socket.recv(64, socket.MSG_PEEK)
        if not found:
            raise EOFError
        return found

    @property
    def silent(self) -> bool:
        """Whether there is nothing to read, not even the end of the stream; from any thread."""
        if limits_sockets():
            return is_silent(self.socket.fileno())
        return not self._readable(0)

    def send(self, data: bytes | memoryview, deadline: float | None) -> int:
        """Pass bytes to the system.

        Returns:
            The number of bytes that the system accepted, at least one.

        Raises:
            DeadlinePassed: the system accepted none before the deadline.
        """
        while True:
            self._limit_to(deadline)
            # A wait would release the interpreter's lock first, and a busy event loop could hold it
            # for milliseconds before the bytes are sent.
            if isinstance(data, bytes) and limits_sockets():
                sent = send_at_once(self.socket.fileno(), data)
                if sent > 0:
                    return sent
            try:
                return self.socket.send(data)
            except BlockingIOError:
                # the system's limit, which may end a little before or after the deadline
                continue
            except TimeoutError as exc:
                if _is_end(exc):
                    raise

    def send_at_once(self, data: bytes) -> int:
        """Send without waiting, like `nonblocking.send_at_once`; only on an event loop.

        Returns:
            The number of bytes that the system accepted; negative if it accepted none.
        """
        if limits_sockets():
            return send_at_once(self.socket.fileno(), data)
        try:
            return self.socket.send(data)
        except OSError:
            return -1

    def receive_at_once(self) -> bytes:
        """Return the bytes that have arrived; on an event loop without waiting.

        Raises:
            BlockingIOError: none have arrived.
            EOFError: the other side closed the connection.
        """
        data = self.socket.recv(_CHUNK)
        if not data:
            raise EOFError
        return data

    def answers_within(self, seconds: float) -> bool:
        """Wait until there is something to read, at most some seconds; return whether there is."""
        return self._readable(seconds)

    def receive(self, deadline: float | None) -> bytes:
        """Wait for the next bytes, at least one.

        Raises:
            DeadlinePassed: none arrived before the deadline.
            EOFError: the other side closed the connection.
        """
        while True:
            self._limit_to(deadline)
            try:
                return self.receive_at_once()
            except (BlockingIOError, TimeoutError) as exc:
                if isinstance(exc, TimeoutError) and _is_end(exc):
                    raise
                if self._waiting is not None:
                    self._waiting()

    @property
    def undelivered(self) -> int:
        """Number of sent bytes that the other side has not acknowledged."""
        return unacknowledged(self.socket)

    def shutdown(self) -> None:
        """End all current reads and writes, from any thread; discard undelivered bytes."""
        self._shut = True
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            # not connected yet, or already broken: no thread waits
            return
        # Some kernels refuse this while a thread waits on the socket. That thread then disconnects.
        disconnect(self.socket.fileno())

    def discard(self) -> None:
        """Close the socket and discard undelivered bytes; while no other thread uses it."""
        disconnect(self.socket.fileno())
        self.socket.close()

    def forked(self) -> None:
        """In a forked child: close its copy; a reset of it would be its parent's too."""
        self.socket.close()

    def close(self) -> None:
        """End an idle connection in the ordinary way; never while another thread uses it."""
        if self.socket.fileno() < 0:
            # at its exit the interpreter may close the socket before the object that owns it
            return
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _DELIVER)
        self.socket.close()

    def _limit_to(self, deadline: float | None) -> None:
        left = math.inf if deadline is None else deadline - time.monotonic()
        if left <= 0:
            raise DeadlinePassed
        if self._waiting is not None:
            left = min(left, WAITING_EVERY)
        elif threading.current_thread() is threading.main_thread():
            left = min(left, WAKE_EVERY)
        slack = min(_SLACK, left / 8)
        if left <= self._limit <= left + slack:
            return
        # a little longer, so that it also fits the next call with the same time limit
        self._limit = left + slack / 2
        limited = self._limit < math.inf
        if not limits_sockets():
            self.socket.settimeout(self._limit if limited else None)
            return
        microseconds = math.ceil(self._limit * 1e6) if limited else 0
        packed = struct.pack("@ll", *divmod(microseconds, 1_000_000))
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, packed)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, packed)


def _is_end(error: TimeoutError) -> bool:
    """Whether the system or a signal handler ended a wait by this; else it is Python's limit."""
    return limits_sockets() or error.args != ("timed out",)
