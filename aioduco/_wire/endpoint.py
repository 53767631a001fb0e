"""The controller's end of connections: a host, and which of its addresses is tried for how long.

A name is resolved off the event loop, with a deadline. It may have several addresses, of which one
leads nowhere: a second network, or an old entry.
"""

from __future__ import annotations

import errno
import os
import socket
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from aioduco._process import trial
from aioduco._process.wakeup import Wakeup
from aioduco._wire.failures import resource_error
from aioduco.errors import ConnectError, ParameterError
from aioduco.models.address import host_alone
from aioduco.models.trace import ConnectionEnded, ConnectionOpened, Trace, emit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator


#: an address of a host: family, kind, protocol, name, and what `connect` takes, as
#: `socket.getaddrinfo` returns them
Address: TypeAlias = tuple[Any, ...]

#: seconds after which the resolution of a name counts as hanging
_HANGS_AFTER: Final = 1.0
_LAST_PORT: Final = 65535


class Lookup:
    """The resolution of a name, on a thread of its own: nothing can interrupt it.

    Neither side waits for a lock, so that a signal handler may begin one and wait for it.

    Raises:
        RuntimeError: the system has no more threads.
    """

    def __init__(self, host: str, port: int) -> None:
        self._host = host
        self._port = port
        self._begun = time.monotonic()
        self._found: list[Address] = []
        self._error: OSError | UnicodeError | None = None
        self._waiting: deque[Callable[[], object]] = deque()
        #: whether the system has answered
        self.over: bool = False
        # a daemon: a program whose name server hangs must still be able to end
        threading.Thread(target=self._run, name="aioduco-resolve", daemon=True).start()

    @property
    def hangs(self) -> bool:
        """Whether the system has not answered for long."""
        return not self.over and time.monotonic() > self._begun + _HANGS_AFTER

    def when_over(self, callback: Callable[[], object]) -> None:
        """Call the callback once it is over: on its thread, or at once on this one."""
        self._waiting.append(callback)
        if self.over:
            self._tell()

    def wait(self, deadline: float) -> None:
        """Block until it is over, or until the deadline [s of `time.monotonic`]."""
        answered = Wakeup()
        self.when_over(answered.set)
        answered.wait(deadline - time.monotonic())

    def addresses(self) -> list[Address]:
        """Return the addresses.

        Raises:
            OSError: the system knows none, or has not answered yet (`TimeoutError`).
            UnicodeError: the text can be no name.
        """
        if not self.over:
            raise TimeoutError(errno.ETIMEDOUT, "the resolution of its name hangs")
        if self._error is not None:
            raise self._error
        return self._found

    def _run(self) -> None:
        try:
            self._found = _resolve(self._host, self._port)
        except (OSError, UnicodeError) as exc:
            self._error = exc
        self.over = True
        self._tell()

    def _tell(self) -> None:
        while self._waiting:
            try:
                callback = self._waiting.popleft()
            except IndexError:
                return  # the other side was faster
            callback()


@dataclass(slots=True)
class Route:
    """The way to one host; connections that share it begin with the address that connected last.

    Attributes:
        address: the address that connected last, in the form of `socket.getaddrinfo`; None before.
    """

    address: Any = None

    def tries(self, found: Iterable[Address], deadline: float) -> Iterator[tuple[Address, float]]:
        """Yield each address, and the time until which to try it [s of `time.monotonic`].

        The time that is left is shared equally by the addresses that are left: one that does not
        answer leaves time for the others. No address is yielded after the deadline.

        Args:
            found: the addresses.
            deadline: time by which one must have connected.
        """
        order = sorted(dict.fromkeys(found), key=lambda each: each[-1] != self.address)
        for left, each in zip(range(len(order), 0, -1), order, strict=True):
            now = time.monotonic()
            if now >= deadline:
                return
            yield each, now + (deadline - now) / left


class Endpoint:
    """The controller's end of connections.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        connect_timeout: seconds within which a connection must be made.
        purpose: the purpose of the connections, for names of threads and for a trace.
        route: which address to try first; share it with other connections to the host.
        trace: hook that gets an event for each connection.
        functions: whether the functions of the wire are called there: a preflight leads these
            connections to its simulator.

    Attributes:
        opened: number of connections that were made.
        known: addresses of the last resolution that led to a connection. They serve calls that
            cannot wait for another one.
    """

    def __init__(
        self,
        host: str,
        port: int,
        connect_timeout: float = 3.0,
        purpose: str = "",
        route: Route | None = None,
        trace: Trace | None = None,
        *,
        functions: bool = True,
    ) -> None:
        if functions and trial.current is not None:
            host, port, connect_timeout = trial.current.endpoint(host, port, connect_timeout)
        self._trace = trace
        self.host = host
        self.port = port
        self.connect_timeout = connect_timeout
        self.purpose = purpose
        self.route: Route = Route() if route is None else route
        self.opened: int = 0
        self.known: list[Address] = []
        self._lookup: Lookup | None = None

    @property
    def hanging(self) -> bool:
        """Whether the resolution of the name hangs in the operating system."""
        return self._lookup is not None and self._lookup.hangs

    def lookup(self) -> list[Address] | Lookup:
        """Return the addresses if the host is an address, else the resolution of its name.

        All calls share the resolution that is under way, so no more than one thread hangs. A name
        is resolved for each connection: a replaced controller may have another address.

        Raises:
            ConnectError: the host is no name and no address, the port is none, or the system has no
                more threads.
        """
        try:
            host_alone(self.host)
        except ParameterError as error:
            said = f"the host must be {error.expected}"
            raise ConnectError(str(self.host), self.port, said) from None
        # the system takes another number for an unknown host, or for another port
        if not (str(self.port).isdecimal() and 0 < int(self.port) <= _LAST_PORT):
            said = f"the port must be a whole number from 1 to {_LAST_PORT}"
            raise ConnectError(self.host, self.port, said)
        try:
            return _resolve(self.host, self.port, socket.AI_NUMERICHOST)
        except (OSError, UnicodeError):
            pass  # it is a name
        lookup = self._lookup
        if lookup is None or lookup.over:
            try:
                lookup = self._lookup = Lookup(self.host, self.port)
            except RuntimeError as exc:
                raise self.refused(exc) from exc
        return lookup

    def resolve(self, deadline: float) -> list[Address]:
        """Return the addresses; block until they are known, or until the deadline.

        Args:
            deadline: time of `time.monotonic()` by which the name must be resolved.

        Raises:
            ConnectError: the host is no name and no address, or the system has no more threads.
            OSError: the system knows none, or has not answered in time (`TimeoutError`).
            UnicodeError: the text can be no name.
        """
        found = self.lookup()
        if isinstance(found, Lookup):
            found.wait(deadline)
            return found.addresses()
        return found

    def refused(self, error: BaseException) -> ConnectError:
        """Make the error for a connection that could not be made; the caller raises it."""
        known = resource_error(error)
        if known:
            return ConnectError(self.host, self.port, known)
        if isinstance(error, socket.gaierror | UnicodeError):
            return ConnectError(self.host, self.port, f"unknown host ({error})")
        if isinstance(error, TimeoutError):
            said = "no answer in time; check the address, the cable and the firewall"
            return ConnectError(self.host, self.port, said)
        number = error.errno if isinstance(error, OSError) else None
        said = os.strerror(number) if number else str(error)
        if isinstance(error, ConnectionRefusedError):
            said += "; nothing listens there: start the controller, or `aioduco sim`"
        return ConnectError(self.host, self.port, said)

    def made(self, begin: float, addresses: list[Address]) -> None:
        """Record a connection that was made since `begin` [s]; from any thread."""
        self.opened += 1
        self.known = addresses
        if self._trace is not None:
            now, peer = time.monotonic(), (self.host, self.port)
            emit(self._trace, ConnectionOpened(now, self.purpose, peer, now - begin))

    def ended(self, reason: str) -> None:
        """Record that a connection is no longer used, for this reason; from any thread."""
        if self._trace is not None:
            peer = self.host, self.port
            emit(self._trace, ConnectionEnded(time.monotonic(), self.purpose, peer, reason))


def _resolve(host: str, port: int, flags: int = 0) -> list[Address]:
    return [*socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=flags)]
