"""Sends that keep the interpreter's lock, and so are made before any other thread runs.

`socket.send` releases the lock for the length of the system call. That wakes the thread that waits
for it, such as a program's busy event loop, and the system may run that thread before the send: on
one core, for milliseconds. A stop must not wait for that. A send that cannot block may keep the
lock: it is made when the next thread runs.
"""

from __future__ import annotations

import ctypes
import socket
from typing import TYPE_CHECKING, Final

from aioduco._platform import limits_sockets

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["disconnect", "is_silent", "send_at_once"]

_FLAGS: Final = getattr(socket, "MSG_DONTWAIT", 0) | getattr(socket, "MSG_NOSIGNAL", 0)

_send: Callable[[int, bytes, int, int], int] | None = None
_receive: Callable[[int, ctypes.Array[ctypes.c_char], int, int], int] | None = None
_connect: Callable[[int, bytes, int], int] | None = None
if limits_sockets():
    #: a `PyDLL` keeps the lock during its calls, where a `CDLL` releases it
    _system: Final = ctypes.PyDLL(None)
    _system.send.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    _system.send.restype = ctypes.c_ssize_t
    _system.recv.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    _system.recv.restype = ctypes.c_ssize_t
    _system.connect.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_uint]
    _system.connect.restype = ctypes.c_int
    _send, _receive, _connect = _system.send, _system.recv, _system.connect


def send_at_once(descriptor: int, data: bytes) -> int:
    """Send what a socket takes at this moment; from any thread or signal handler.

    Args:
        descriptor: the socket's; it must not be closed meanwhile.
        data: the bytes.

    Returns:
        How many bytes the system took; negative if it took none, whatever the reason, and where
        the system has no sends that do not wait.
    """
    if _send is None:
        return -1
    return int(_send(descriptor, data, len(data), _FLAGS))


#: where the byte comes that nobody reads
_peeked: Final = ctypes.create_string_buffer(1)

_PEEK: Final = getattr(socket, "MSG_DONTWAIT", 0) | socket.MSG_PEEK


def is_silent(descriptor: int) -> bool:
    """Whether nothing came on a socket that has not been read, not even its end.

    Args:
        descriptor: the socket's; it must not be closed meanwhile.

    Returns:
        False where the system has no reads that do not wait: it is not known.
    """
    if _receive is None:
        return False
    return bool(_receive(descriptor, _peeked, 1, _PEEK) < 0)


#: the address of the family AF_UNSPEC: connecting to it dissolves a connection
_UNSPECIFIED: Final = bytes(16)


def disconnect(descriptor: int) -> bool:
    """Dissolve a TCP connection: the system forgets every byte that it has not delivered.

    Closing a socket does not do that: the system goes on delivering for as long as
    TCP_USER_TIMEOUT lets it, and a child that was forked keeps the connection alive however its
    parent closes it. Wakes a thread that waits on the socket.

    Args:
        descriptor: the socket's; it must not be closed meanwhile.

    Returns:
        Whether the system did it. Windows does not: there only closing the socket, with nothing
        left to linger for, discards what was not delivered.
    """
    if _connect is None:
        return False
    return bool(_connect(descriptor, _UNSPECIFIED, len(_UNSPECIFIED)) == 0)
