"""What a program that is tried may reach: nothing by which it could move a real arm.

Connections of this package lead to the simulator. A program may also have a client of its own, for
the arm or for anything else; where such a connection leads is not known, so it is refused, unless
it leads to a server of the program's own, or to one that was named.
"""

from __future__ import annotations

import contextlib
import socket
import sys
from typing import TYPE_CHECKING, Any, Final, NoReturn
from weakref import WeakSet

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

__all__ = ["NotReached", "guard_borders"]

_TO: Final = ("socket.connect", "socket.sendto", "socket.sendmsg")
_LOCAL: Final = ("localhost", "127.", "::1")


class NotReached(PermissionError):
    """The program tried to reach something outside of the preflight. Nothing was sent there."""


def guard_borders(
    reachable: Collection[str],
    ports: Callable[[], Collection[int]],
    ours: Callable[[], bool],
    tell: Callable[[str], None],
) -> None:
    """Refuse connections and processes of the program, for the rest of this process.

    Args:
        reachable: addresses that the program may reach, as "host:port".
        ports: gives the ports of this computer that the simulator of the preflight listens on.
        ours: tells whether this package asks, and not the program.
        tell: is told what was refused: the program may go on as if nothing had been.
    """
    bound: WeakSet[socket.socket] = WeakSet()
    allowed = {address for each in reachable for address in _addresses(each)}

    def own(host: str, port: int) -> bool:
        if not host.startswith(_LOCAL):
            return False
        return port in ports() or any(_port(each) == port for each in list(bound))

    def look(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "socket.bind":
            bound.add(arguments[0])
        elif event in _TO and arguments[0].family in (socket.AF_INET, socket.AF_INET6):
            if arguments[1] is None:
                return  # it is connected already
            host, port = str(arguments[1][0]), int(arguments[1][1])
            if (host, port) not in allowed and not own(host, port):
                refuse(
                    f"the program opens a connection of its own to {host}:{port}, which a "
                    "preflight does not let through: it could lead to an arm. If not, allow it by "
                    f"--reach {host}:{port}"
                )
        elif event in ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn") and not ours():
            refuse("the program starts another program, which would run outside of the preflight")

    def refuse(text: str) -> NoReturn:
        tell(text)
        raise NotReached(text)

    sys.addaudithook(look)


def _addresses(text: str) -> Iterator[tuple[str, int]]:
    """An address as it is named, and as connections name it."""
    host, _, port = text.rpartition(":")
    yield host, int(port)
    with contextlib.suppress(OSError):
        for found in socket.getaddrinfo(host, int(port), type=socket.SOCK_STREAM):
            yield str(found[4][0]), int(port)


def _port(bound: socket.socket) -> int:
    try:
        name = bound.getsockname()
    except OSError:
        return -1  # it was closed
    return int(name[1]) if isinstance(name, tuple) else -1
