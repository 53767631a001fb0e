"""The process between clients and a controller: it forwards the bytes, and copies them to the tap.

Guarantees:
- Bytes are forwarded as they arrive, whatever they are, and before their copy.
- If the program reads the copies slowly, or not at all, no byte is delayed: when `KEPT` bytes of
  copies wait, further copies are left out, and this is reported.
- Without descriptors a client waits or is refused; the connections that are open go on.
- A connection ends on each side as it ended on the other. When the process ends, all connections
  end.
- A process that stood still, since it was frozen or its computer slept, delivers nothing of what
  came before: an arm would begin to move when nobody expects it any more. All connections end.

The process loads little, and does nothing else, so it delays a call only by two process switches.
"""

from __future__ import annotations

import contextlib
import errno
import os
import selectors
import socket
import struct
import time
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Final

from aioduco._process.linked_process import ValueChannel
from aioduco._process.platform import CONNECTING, boot_time
from aioduco._process.scheduling import shorten_slice
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    from collections.abc import Sequence

    #: family of an address, and what `connect` takes
    _Address = tuple[int, Any]


#: head of a copy: time of `time.monotonic` [s], number of the connection, kind, number of bytes
HEAD: Final = struct.Struct("<dIBI")
#: maximum bytes of copies that wait
KEPT: Final = 64 * 1024 * 1024
#: seconds for which copies are collected, so that their reader wakes up less often than bytes pass
_GATHER: Final = 0.01
#: time slice of a processor [ns]: it is short, so that this process, which wakes up for one call,
#: runs before a process that decodes a hundred calls
_SLICE: Final = 100_000
#: maximum bytes that wait for one side; while more wait, the other side is not read
_AHEAD: Final = 1024 * 1024
_CHUNK: Final = 64 * 1024
#: seconds within which the program must take the remaining copies at the end
_DRAIN_TIMEOUT: Final = 5.0
#: `SO_LINGER` for a reset: unsent bytes are discarded, and the other side gets an error
_RESET: Final = struct.pack("ii", 1, 0)

#: seconds after which the controller's next address is tried, if it has one
_TRY: Final = 1.0

#: seconds between two looks whether this process runs, and after which it stood still
_LOOK: Final = 0.5
_AWAY: Final = 2.0

#: seconds in which no client is accepted after descriptors or memory ran out
_REST: Final = 0.1
_NO_DESCRIPTOR: Final = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)

_READ, _WRITE = selectors.EVENT_READ, selectors.EVENT_WRITE


class CopyKind(IntEnum):
    """Kind of a copy, which determines its data."""

    #: a client has connected; data: its address
    OPENED = 0
    #: data: bytes from the client to the controller
    REQUEST = 1
    #: data: bytes from the controller to the client
    ANSWER = 2
    #: the connection has ended; data: the side that ended it
    CLOSED = 3
    #: the controller could not be reached; data: the reason
    REFUSED = 4
    #: copies were left out; data: their number of bytes
    MISSED = 5


class _Copies:
    """Copies that wait to be sent to the program, which may be slow.

    Args:
        link: socket to the program.
        selector: selector that waits until more can be sent.
    """

    def __init__(self, link: socket.socket, selector: selectors.BaseSelector) -> None:
        self._link = link
        self._selector = selector
        self._waiting = bytearray()
        self._missed: dict[int, int] = {}
        self._full = False
        self._due = 0.0

    def left(self) -> float | None:
        """Return the seconds until they are sent; None if there are none, or none can be sent."""
        if not self._waiting or self._full:
            return None
        return max(0.0, self._due - time.monotonic())

    def put(self, at: float, number: int, kind: CopyKind, data: bytes = b"") -> None:
        """Add a copy; `send` sends it."""
        if len(self._waiting) + len(data) > KEPT and kind in (CopyKind.REQUEST, CopyKind.ANSWER):
            self._missed[number] = self._missed.get(number, 0) + len(data)
            return
        missed = self._missed.pop(number, 0)
        if missed:
            self.put(at, number, CopyKind.MISSED, str(missed).encode())
        if not self._waiting:
            self._due = time.monotonic() + _GATHER
        self._waiting += HEAD.pack(at, number, kind, len(data)) + data

    def send(self) -> None:
        """Send the bytes that can be sent now.

        Raises:
            OSError: the program has exited.
        """
        try:
            sent = self._link.send(self._waiting)
        except BlockingIOError:
            sent = 0
        del self._waiting[:sent]
        if bool(self._waiting) is not self._full:
            self._full = not self._full
            self._selector.modify(self._link, _READ | _WRITE * self._full)

    def finish(self) -> None:
        """Send all waiting copies.

        Raises:
            OSError: the program did not take them in time, or has exited.
        """
        self._link.settimeout(_DRAIN_TIMEOUT)
        self._link.sendall(self._waiting)


class _Side:
    """One of the two sockets of a connection.

    Args:
        sock: the socket.
        kind: kind of the copies of its bytes.
    """

    def __init__(self, sock: socket.socket, kind: CopyKind) -> None:
        sock.setblocking(False)
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.sock = sock
        self.kind = kind
        self.connected = kind is CopyKind.REQUEST
        #: bytes that wait to be sent to it
        self.waiting = bytearray()
        #: whether it has closed its direction
        self.ended = False
        #: whether the close of the other side's direction was passed on to it
        self.end_forwarded = False


class _Link:
    """One connection: a client's socket and one to the controller.

    Args:
        relay: the relay.
        number: number of the connection, from 0.
        client: socket of the client.
        server: socket for the first address.
        addresses: addresses of the controller, in the order in which they are tried.
    """

    def __init__(
        self,
        relay: _Relay,
        number: int,
        client: socket.socket,
        server: socket.socket,
        addresses: Sequence[_Address],
    ) -> None:
        self._relay = relay
        self.number = number
        self.client = _Side(client, CopyKind.REQUEST)
        self.server = _Side(server, CopyKind.ANSWER)
        self._address, *self._others = addresses
        self._first = ""

    def dial(self) -> None:
        """Connect to the controller's address."""
        code = self.server.sock.connect_ex(self._address[1])
        if code not in (0, *CONNECTING):
            self._cut(self.server, OSError(code, os.strerror(code)))
            return
        self._relay.tries(self, again=bool(self._others))
        self._watch()

    def dial_next(self) -> None:
        """Give up the address that does not answer, and connect to the next one."""
        self._relay.forget(self.server.sock)
        self.server.sock.close()
        self._address, *self._others = self._others
        try:
            sock = socket.socket(self._address[0], socket.SOCK_STREAM)
        except OSError as error:
            self._others.clear()
            self._cut(self.server, error)
            return
        self.server = _Side(sock, CopyKind.ANSWER)
        self.dial()

    def other(self, side: _Side) -> _Side:
        """Return the opposite side."""
        return self.server if side is self.client else self.client

    def ready(self, side: _Side, mask: int) -> None:
        """Write to and read from a side, as far as it is ready."""
        try:
            if mask & _WRITE:
                if not side.connected:
                    self._connected(side)
                self._flush(side)
            if mask & _READ:
                self._pass_on(side)
        except BlockingIOError:
            pass
        except OSError as error:
            self._cut(side, error)
            return
        if self.client.end_forwarded and self.server.end_forwarded:
            self._over()
        else:
            self._watch()

    def close(self, *, reset: bool) -> None:
        """Close both sockets."""
        for side in (self.client, self.server):
            self._relay.forget(side.sock)
            if reset:
                with contextlib.suppress(OSError):
                    side.sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
            side.sock.close()

    def _connected(self, side: _Side) -> None:
        error = side.sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if error:
            raise OSError(error, os.strerror(error))
        side.connected = True
        self._relay.reached(self, self._address)

    def _pass_on(self, side: _Side) -> None:
        """Read from a side, and write to the other one; then make a copy."""
        data = side.sock.recv(_CHUNK)
        at = time.monotonic()
        other = self.other(side)
        if data:
            other.waiting += data
            self._flush(other)
            self._relay.copies.put(at, self.number, side.kind, data)
        else:
            side.ended = True
            self._first = self._first or _name(side)
            self._flush(other)

    def _flush(self, side: _Side) -> None:
        if side.waiting and side.connected:
            with contextlib.suppress(BlockingIOError):  # it takes no more: the caller goes on
                del side.waiting[: side.sock.send(side.waiting)]
        if (
            not side.waiting
            and side.connected
            and self.other(side).ended
            and not side.end_forwarded
        ):
            side.end_forwarded = True
            side.sock.shutdown(socket.SHUT_WR)

    def _watch(self) -> None:
        for side in (self.client, self.server):
            other = self.other(side)
            reads = not side.ended and side.connected and other.connected
            reads = reads and len(other.waiting) < _AHEAD
            writes = not side.connected or bool(side.waiting)
            self._relay.watch(side.sock, _READ * reads | _WRITE * writes, (self, side))

    def _cut(self, side: _Side, error: OSError) -> None:
        """Reset the connection after an error of one side, unless another address is left."""
        if not self.server.connected and self._others:
            self.dial_next()
            return
        if not self.server.connected:
            self._relay.end(self, CopyKind.REFUSED, str(error).encode())
        else:
            self._relay.end(self, CopyKind.CLOSED, (self._first or _name(side)).encode())
        self.close(reset=True)

    def _over(self) -> None:
        self._relay.end(self, CopyKind.CLOSED, self._first.encode())
        self.close(reset=False)


def _name(side: _Side) -> str:
    return "client" if side.kind is CopyKind.REQUEST else "controller"


class _Relay:
    """All connections, on one thread.

    Args:
        listener: socket to which clients connect.
        addresses: addresses of the controller; the one that connected last is tried first.
        link: socket to the program; the relay ends when the program closes it.
    """

    def __init__(
        self,
        listener: socket.socket,
        addresses: Sequence[_Address],
        link: socket.socket,
    ) -> None:
        self.selector = selectors.DefaultSelector()
        self._listener = listener
        self._addresses = list(addresses)
        self._program = link
        self._number = 0
        self._links: set[_Link] = set()
        #: connections that try their next address, and when
        self._trying: dict[_Link, float] = {}
        self._watched: dict[socket.socket, int] = {}
        self._rests_until: float | None = None
        listener.setblocking(False)
        link.setblocking(False)
        self.selector.register(listener, _READ)
        self.copies = _Copies(link, self.selector)
        self.selector.register(link, _READ)

    def run(self) -> None:
        """Forward bytes until the program closes its socket."""
        now = boot_time()
        while True:
            ready = self.selector.select(self._timeout())
            before, now = now, boot_time()
            if now - before > _AWAY:
                self._cut_all()
                continue
            for key, mask in ready:
                if key.fileobj is self._program:
                    if mask & _READ and not self._program.recv(1):
                        return
                    self.copies.send()
                elif key.fileobj is self._listener:
                    self._accept()
                else:
                    link, side = key.data
                    # An earlier event of this batch may have ended the connection.
                    if link in self._links:
                        link.ready(side, mask)
            if self.copies.left() == 0.0:
                self.copies.send()
            self._resume()
            if self._trying:
                self._try_others()

    def _rest(self) -> None:
        """Accept no client for a moment: there are no descriptors. Those that are here go on."""
        self.selector.unregister(self._listener)
        self._rests_until = time.monotonic() + _REST

    def _timeout(self) -> float:
        """Seconds until something is to be done that no socket tells."""
        left = [_LOOK] if (copies := self.copies.left()) is None else [_LOOK, copies]
        if self._rests_until is not None:
            left.append(max(0.0, self._rests_until - time.monotonic()))
        if self._trying:
            left.append(max(0.0, min(self._trying.values()) - time.monotonic()))
        return min(left)

    def tries(self, link: _Link, *, again: bool) -> None:
        """Note that a link connects, and whether it tries another address if that takes long."""
        self._trying.pop(link, None)
        if again:
            self._trying[link] = time.monotonic() + _TRY

    def reached(self, link: _Link, address: _Address) -> None:
        """Note that a link has connected to an address: others try it first."""
        self._trying.pop(link, None)
        self._addresses.sort(key=lambda each: each != address)

    def _try_others(self) -> None:
        """Let links whose address does not answer try their next one."""
        now = time.monotonic()
        for link in [each for each, due in self._trying.items() if due <= now]:
            link.dial_next()

    def _resume(self) -> None:
        """Accept clients again after a rest."""
        if self._rests_until is not None and time.monotonic() >= self._rests_until:
            self._rests_until = None
            self.selector.register(self._listener, _READ)

    def close(self) -> None:
        """End all connections, and send the remaining copies."""
        self._end_links()
        self.copies.finish()

    def _end_links(self) -> None:
        for link in tuple(self._links):
            self.end(link, CopyKind.CLOSED, b"tap")
            link.close(reset=True)

    def _cut_all(self) -> None:
        """End all connections, also those that clients opened while this process stood still."""
        self._end_links()
        with contextlib.suppress(OSError):  # there is none any more
            while True:
                client, _ = self._listener.accept()
                client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
                client.close()

    def watch(self, sock: socket.socket, events: int, data: tuple[_Link, _Side]) -> None:
        """Set the events of a socket for which to wait."""
        if self._watched.get(sock) == events:
            return
        if self._watched.get(sock):
            self.selector.unregister(sock)
        if events:
            self.selector.register(sock, events, data)
        self._watched[sock] = events

    def forget(self, sock: socket.socket) -> None:
        """Wait for no events of a socket any more."""
        if self._watched.pop(sock, 0):
            self.selector.unregister(sock)

    def end(self, link: _Link, kind: CopyKind, why: bytes) -> None:
        """Note and report that a connection has ended."""
        self._links.discard(link)
        self._trying.pop(link, None)
        self.copies.put(time.monotonic(), link.number, kind, why)

    def _accept(self) -> None:
        try:
            client, address = self._listener.accept()
        except OSError as error:
            if error.errno in _NO_DESCRIPTOR:
                self._rest()
            return  # else the client disconnected before it was accepted
        try:
            server = socket.socket(self._addresses[0][0], socket.SOCK_STREAM)
        except OSError:  # no descriptor for its other side
            client.close()
            self._rest()
            return
        number, self._number = self._number, self._number + 1
        where = host_port(*address[:2]).encode()
        self.copies.put(time.monotonic(), number, CopyKind.OPENED, where)
        link = _Link(self, number, client, server, self._addresses)
        self._links.add(link)
        link.dial()


def main(arguments: Sequence[str]) -> int:
    """Relay between clients and a controller until the program closes its socket.

    The program first sends the controller's addresses, and the address to listen on. The relay
    answers with the address that it listens on, or with the text of an error.

    Args:
        arguments: arguments of the process: the descriptor of the socket to the program.

    Returns:
        Exit status of the process.
    """
    channel = ValueChannel.of(arguments)
    addresses, listen = channel.receive()
    try:
        own = socket.AF_INET6 if ":" in listen[0] else socket.AF_INET
        listener = socket.create_server(listen, family=own, backlog=128)
    except OSError as error:
        channel.send(error.strerror or str(error))
        return 1
    channel.send(listener.getsockname()[:2])
    shorten_slice(_SLICE)
    link = channel.copy()
    relay = _Relay(listener, addresses, link)
    try:
        try:
            relay.run()
        finally:
            relay.close()
    except OSError:
        return 1  # the program has exited
    return 0
