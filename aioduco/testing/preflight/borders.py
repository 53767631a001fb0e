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

from aioduco.models.address import parse_address
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator


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

    def own(sock: socket.socket, host: str, port: int) -> bool:
        if sock.type == socket.SOCK_STREAM and _is_home(sock, host) and port in ports():
            return True
        return any(_answers(each, sock, host, port) for each in list(bound))

    def look(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "socket.bind":
            bound.add(arguments[0])
        elif event in _TO and arguments[0].family in (socket.AF_INET, socket.AF_INET6):
            if arguments[1] is None:
                return  # it is already connected
            host, port = str(arguments[1][0]), int(arguments[1][1])
            if (host, port) not in allowed and not own(arguments[0], host, port):
                where = host_port(host, port)
                refuse(
                    f"the program opens a connection of its own to {where}, which a preflight does "
                    "not let through: it could lead to an arm. If it does not, allow it by --reach "
                    f"{where}"
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


#: the address on which the preflight's simulators listen
_HOME: Final = "127.0.0.1"


def _is_home(sock: socket.socket, host: str) -> bool:
    return sock.family == socket.AF_INET and host in (_HOME, "localhost")


def _addresses(text: str) -> Iterator[tuple[str, int]]:
    """An address as given, and with the numeric addresses that connections use."""
    host, port = address_of(text)
    yield host, port
    with contextlib.suppress(OSError):
        for found in socket.getaddrinfo(host, port):
            yield str(found[4][0]), port


def _answers(server: socket.socket, sock: socket.socket, host: str, port: int) -> bool:
    """Whether a socket of the program is what answers at an address of this computer.

    A number alone says nothing: the same port of another protocol, another address or another
    socket may be a tunnel to an arm. So it must be of the same kind, listen (a datagram's need
    not), have this address or all addresses, and share it with no other socket.
    """
    try:
        found = ipaddress.ip_address(_numeric(sock, host))
        name = server.getsockname()
        return (
            found.is_loopback
            and int(name[1]) == port
            and _is_alone(server, sock.type)
            and _has(server, str(name[0]), sock, found)
        )
    except (OSError, ValueError, TypeError, IndexError):
        return False  # it was closed, or is no socket of an address and a port


def _is_alone(server: socket.socket, kind: int) -> bool:
    """Whether it is of this kind, takes connections, and shares its address with no other."""
    if server.type != kind or _option(server, "SO_REUSEPORT"):
        return False
    if kind == socket.SOCK_STREAM:
        return bool(_option(server, "SO_ACCEPTCONN"))
    return not _option(server, "SO_REUSEADDR")


def _has(server: socket.socket, name: str, sock: socket.socket, found: Any) -> bool:
    """Whether it has the address `found`, or all addresses."""
    if server.family == sock.family:
        at = ipaddress.ip_address(name.partition("%")[0])
        return bool(at == found) or at.is_unspecified
    both = server.family == socket.AF_INET6 and name == "::"
    return both and not server.getsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY)


def _numeric(sock: socket.socket, host: str) -> str:
    """The address that a connection to this name would use."""
    if host == "localhost":
        return "::1" if sock.family == socket.AF_INET6 else _HOME
    return host.partition("%")[0]


def _option(sock: socket.socket, name: str) -> int:
    number = getattr(socket, name, None)
    if number is None:  # a system without it
        return int(name == "SO_ACCEPTCONN")
    return sock.getsockopt(socket.SOL_SOCKET, number)
