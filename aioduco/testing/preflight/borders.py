"""Network access of a program in a preflight: the program must not move a real arm.

Connections of this package lead to the simulator. A program may also have a client of its own, for
the arm or for anything else. The target of such a connection is not known, so it is refused, unless
it is a server of the program itself, or a server that was named.
"""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import sys
from multiprocessing import util
from typing import TYPE_CHECKING, Any, Final, NoReturn
from weakref import WeakSet

from aioduco._wire.address import parse_address

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

__all__ = ["AccessBlocked", "address_of", "block_outside_access"]

_TO: Final = ("socket.connect", "socket.sendto", "socket.sendmsg")
_STARTS: Final = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn")


class AccessBlocked(PermissionError):
    """The program tried to connect to something outside the preflight. Nothing was sent there."""


def block_outside_access(
    reachable: Collection[str],
    ports: Callable[[], Collection[int]],
    ours: Callable[[], bool],
    tell: Callable[[str], None],
) -> None:
    """Refuse connections and processes of the program, for the rest of this process.

    Args:
        reachable: addresses that the program may reach, as "host:port".
        ports: returns the ports of this computer on which the preflight's simulator listens.
        ours: returns whether the request comes from this package, and not from the program.
        tell: called with each refusal: the program may ignore the error and continue.
    """
    bound: WeakSet[socket.socket] = WeakSet()
    allowed = {address for each in reachable for address in _addresses(each)}

    def own(host: str, port: int) -> bool:
        if not _is_local(host):
            return False
        return port in ports() or any(_port(each) == port for each in list(bound))

    def look(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "socket.bind":
            bound.add(arguments[0])
        elif event in _TO and arguments[0].family in (socket.AF_INET, socket.AF_INET6):
            if arguments[1] is None:
                return  # it is already connected
            host, port = str(arguments[1][0]), int(arguments[1][1])
            if (host, port) not in allowed and not own(host, port):
                refuse(
                    f"the program opens a connection of its own to {host}:{port}, which a "
                    "preflight does not let through: it could lead to an arm. "
                    f"If it does not, allow it by --reach {host}:{port}"
                )
        elif event in _STARTS and not ours():
            started()

    def started() -> NoReturn:
        refuse("the program starts another program, which would run outside of the preflight")

    def refuse(text: str) -> NoReturn:
        tell(text)
        raise AccessBlocked(text)

    sys.addaudithook(look)

    # multiprocessing starts interpreters without an audit event.
    module: Any = util
    spawn = module.spawnv_passfds

    def spawned(path: Any, arguments: Any, descriptors: Any) -> Any:
        if any("resource_tracker import main" in str(each) for each in arguments):
            return spawn(path, arguments, descriptors)  # it only frees shared memory
        started()

    module.spawnv_passfds = spawned


def address_of(text: str) -> tuple[str, int]:
    """Host and port of "host:port".

    Raises:
        ValueError: the text is no such address.
    """
    host, port = parse_address(text)
    if port is None:
        raise ValueError(f'{text!r} is no address as "host:port"')
    return host, port


def _is_local(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _addresses(text: str) -> Iterator[tuple[str, int]]:
    """An address as given, and with the numeric addresses that connections use."""
    host, port = address_of(text)
    yield host, port
    with contextlib.suppress(OSError):
        for found in socket.getaddrinfo(host, port):
            yield str(found[4][0]), port


def _port(bound: socket.socket) -> int:
    try:
        name = bound.getsockname()
    except OSError:
        return -1  # it was closed
    return int(name[1]) if isinstance(name, tuple) else -1
