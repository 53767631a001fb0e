"""A relay, and the calls that passed through it."""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import time
from typing import TYPE_CHECKING, Any, Self

from aioduco._process.copying import Uncopied
from aioduco._process.linked_process import LinkedProcess
from aioduco._process.spawn import Unstartable
from aioduco._wire.endpoint import Endpoint
from aioduco.errors import ConnectError, ParameterError
from aioduco.models.address import HOST_RULE, host_alone, is_host
from aioduco.models.host_port import host_port
from aioduco.models.ranges import LISTEN_PORT, PORT
from aioduco.recording.tap.conversation import Conversation, TapNote, TappedCall
from aioduco.recording.tap.relay import HEAD, CopyKind

if TYPE_CHECKING:
    from collections.abc import Iterator


#: time-out for the relay to report its address [s]
_START = 60.0
#: time-out for the controller's name to be resolved [s]
_RESOLVE = 5.0
_CHUNK = 256 * 1024


class Tap(Uncopied):
    """Relays between clients and a controller, and reports each call.

        with Tap("192.168.1.10", listen=("127.0.0.1", 7003)) as tap:
            for item in tap:              # clients connect to tap.host, tap.port
                print(item)

    It works with any client and any controller: a process of its own forwards the bytes as they
    come, and the tap decodes a copy of them. A call is delayed by some tenths of a millisecond. The
    tap sends nothing of its own, no heartbeat either. If it ends, the connections through it end,
    as if the cable had been cut, and the controller reacts as when a client's heartbeat stops.

    Args:
        host: address of the controller.
        port: its TCP port.
        listen: address and port for clients; port 0 takes a free one. An address other than
            loopback lets every computer of that network drive the arm.

    Raises:
        ParameterError: an address or a port is none.

    Attributes:
        host: address that it listens on.
        port: its TCP port.
    """

    def __init__(
        self, host: str, port: int = 7003, *, listen: tuple[str, int] = ("127.0.0.1", 0)
    ) -> None:
        host = host_alone(host)
        if not isinstance(listen, (tuple, list)) or len(listen) != 2 or not is_host(listen[0]):
            raise ParameterError("listen", listen, f"a pair: {HOST_RULE}, and a port")
        self._controller = (host, PORT("port", port))
        self._listen = (listen[0], LISTEN_PORT("listen[1]", listen[1]))
        self._linked: LinkedProcess | None = None
        self._link: socket.socket | None = None
        self._conversation = Conversation()
        self.host: str = ""
        self.port: int = 0

    def __enter__(self) -> Self:
        """Start the relay.

        Raises:
            OSError: the address cannot be listened on, for instance if the port is in use.
            ConnectError: that address is the controller's own, or the controller's name is unknown
                or not resolved within 5 s.
            RuntimeError: no process can be started, or it is open already.
        """
        if self._linked is not None:
            raise RuntimeError("the tap is open already: make another one")
        addresses = self._addresses()
        try:
            linked = LinkedProcess("aioduco.recording.tap.relay")
        except Unstartable as error:
            raise RuntimeError(f"the relay was not started: {error}") from error
        try:
            linked.channel.send((addresses, self._listen))
            ready = linked.channel.receive(_START)
        except (EOFError, TimeoutError, OSError) as error:
            linked.close()
            raise RuntimeError(f"the relay did not start: {linked.stderr_tail}") from error
        except BaseException:
            linked.close()
            raise
        if isinstance(ready, str):
            linked.close()
            raise OSError(f"the tap cannot listen on {host_port(*self._listen)}: {ready}")
        if _leads_to(addresses, ready):
            linked.close()
            where = host_port(*ready)
            raise ConnectError(
                *self._controller, f"the tap listens there itself, on {where}: listen elsewhere"
            )
        self._link = linked.channel.copy()
        self._link.setblocking(True)
        self._linked = linked
        self.host, self.port = ready
        return self

    def _addresses(self) -> list[tuple[int, Any]]:
        """The controller's addresses, each with its family."""
        endpoint = Endpoint(*self._controller, _RESOLVE)
        try:
            found = endpoint.resolve(time.monotonic() + _RESOLVE)
        except ConnectError:
            raise
        except (OSError, UnicodeError) as error:
            raise endpoint.refused(error) from error
        return [(int(family), name) for family, *_, name in found]

    def __exit__(self, *_: object) -> None:
        link, self._link = self._link, None
        if link is not None:
            link.close()
        linked, self._linked = self._linked, None
        if linked is not None:
            linked.close()

    def end(self) -> None:
        """End all connections through it; earlier calls are still reported. From any thread."""
        link = self._link
        if link is not None:
            with contextlib.suppress(OSError):
                link.shutdown(socket.SHUT_WR)

    def __iter__(self) -> Iterator[TappedCall | TapNote]:
        """Iterate over the calls and events as they occur, until `end`."""
        link = self._link
        if link is None:
            raise RuntimeError("the tap is not open: use it in a `with` block")
        data = bytearray()
        while chunk := link.recv(_CHUNK):
            data += chunk
            done = 0
            while len(data) - done >= HEAD.size:
                at, connection, kind, size = HEAD.unpack_from(data, done)
                begin = done + HEAD.size
                if len(data) < begin + size:
                    break
                done = begin + size
                copied = bytes(data[begin:done])
                yield from self._conversation.feed(at, connection, CopyKind(kind), copied)
            del data[:done]


def _leads_to(addresses: list[tuple[int, Any]], listener: tuple[str, int]) -> bool:
    """Whether one of the addresses is that of a listener on this computer."""
    host, port = ipaddress.ip_address(listener[0]), listener[1]
    return any(
        name[1] == port
        and (
            (found := ipaddress.ip_address(name[0])) == host
            or (host.is_unspecified and found.is_loopback)
        )
        for _, name in addresses
    )
