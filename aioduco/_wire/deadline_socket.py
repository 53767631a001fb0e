"""A TCP socket whose every operation ends at a deadline."""

from __future__ import annotations

import errno
import math
import os
import socket
import struct
import threading
import time
from typing import Any, Final

from aioduco._platform import CONNECTING, limits_sockets, readiness, unacknowledged
from aioduco._wire.nonblocking import disconnect, is_silent, send_at_once

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

#: seconds between two moments at which the main thread can take a signal. One that comes just
#: before a wait begins does not end the wait: its handler, which may be to stop the arm, would run
#: only when the controller answers.
WAKE_EVERY: Final = 0.2

_CHUNK: Final = 16384

#: seconds of a wait without a deadline, where Python keeps the time: it is begun anew then
_LONG: Final = 3600.0


class DeadlinePassed(Exception):
    """The time for an operation is over."""


class Ended(Exception):
    """The other side closed the connection."""


class DeadlineSocket:
    """A blocking socket with absolute deadlines.

    Deadlines are times of `time.monotonic()`; None is no limit. They are kept by the system's
    limits on a socket (SO_RCVTIMEO, SO_SNDTIMEO), not by Python's: a read is then one blocking
    system call that releases the interpreter's lock once instead of twice. A limit is set
    anew only if what is left differs from it. Where the system has no such limits, the socket
    never blocks, and Python's limits keep the time.

    One thread at a time; `shutdown` and `undelivered` may be used from any.

    Guarantees: after `shutdown`, `discard`, or the end of the process, the system delivers nothing
    more of what was sent. Only `close` is an ordinary end.
    """

    __slots__ = ("_ahead", "_limit", "_readable", "_shut", "_socket")

    def __init__(self, family: int, type_: int, protocol: int) -> None:
        self._socket = socket.socket(family, type_, protocol)
        self._readable = readiness(self._socket)
        #: where Python keeps the time: the same socket, for sends that do not wait
        self._ahead: socket.socket | None = None
        if not limits_sockets():
            self._ahead = socket.socket(family, type_, protocol, self._socket.fileno())
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
        if error in CONNECTING:
            error = self._wait_connected(deadline)
        if error:
            raise OSError(error, os.strerror(error))
        # Without it, bytes that are not acknowledged are repeated for some fifteen minutes. Not
        # before: it would limit the handshake too.
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _USER_TIMEOUT_MS)
        if self._ahead is None:
            # from here on the system keeps the time
            sock.setblocking(True)
        else:
            self._ahead.setblocking(False)
            sock.settimeout(_LONG)

    def _wait_connected(self, deadline: float) -> int:
        left = deadline - time.monotonic()
        if left <= 0 or not readiness(self._socket, writing=True)(left):
            return errno.ETIMEDOUT
        return self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)

    def waiting_bytes(self) -> bytes:
        """Bytes that came and have not been read; they stay where they are.

        Raises:
            Ended: the other side closed the connection.
        """
        if not self._readable(0):
            return b""
        found = self._socket.recv(64, socket.MSG_PEEK)
        if not found:
            raise Ended
        return found

    @property
    def silent(self) -> bool:
        """Whether nothing came that has not been read, not even the end; from any thread."""
        if self._ahead is None:
            return is_silent(self._socket.fileno())
        try:
            self._ahead.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return True
        except OSError:
            return False
        return False

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
            except TimeoutError as exc:
                if exc.errno is not None:
                    raise  # the system gave the connection up; Python's own limit has no number

    def send_at_once(self, data: bytes) -> int:
        """As `nonblocking.send_at_once`: how many bytes the system took, negative for none."""
        if self._ahead is None:
            return send_at_once(self._socket.fileno(), data)
        try:
            return self._ahead.send(data)
        except OSError:
            return -1

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
            except TimeoutError as exc:
                if exc.errno is not None:
                    raise
                continue
            if not data:
                raise Ended
            return data

    @property
    def undelivered(self) -> int:
        """How many bytes the system still holds that the other side has not acknowledged."""
        return unacknowledged(self._socket)

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
        self.close_copy()

    def close_copy(self) -> None:
        """Close a forked child's copy of the socket, and nothing else: the parent uses it on."""
        if self._ahead is not None:
            self._ahead.detach()
        self._socket.close()

    def close(self) -> None:
        """End an idle connection in the ordinary way; never while another thread uses it."""
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _DELIVER)
        self.close_copy()

    def _limit_to(self, deadline: float | None) -> None:
        limit: float | None = None
        wakes = threading.current_thread() is threading.main_thread()
        if deadline is not None or wakes:
            left = WAKE_EVERY if deadline is None else deadline - time.monotonic()
            if left <= 0:
                raise DeadlinePassed
            if wakes:
                left = min(left, WAKE_EVERY)
            slack = min(_SLACK, left / 8)
            if self._limit is not None and left <= self._limit <= left + slack:
                return
            # a little longer, so that it also fits the next call with the same time
            limit = left + slack / 2
        elif self._limit is None:
            return
        if self._ahead is not None:
            # Never without a limit: that would make both blocking.
            self._socket.settimeout(_LONG if limit is None else limit)
            self._limit = limit
            return
        microseconds = 0 if limit is None else math.ceil(limit * 1e6)
        packed = struct.pack("@ll", *divmod(microseconds, 1_000_000))
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, packed)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, packed)
        self._limit = limit
