"""Sends that keep the interpreter's lock, and so are made before any other thread runs.

`socket.send` releases the lock for the length of the system call. That wakes the thread that waits
for it, such as a program's busy event loop, and the system may run that thread before the send: on
one core, for milliseconds. A stop must not wait for that. A send that cannot block may keep the
lock: it is made when the next thread runs.
"""

from __future__ import annotations

import ctypes
import socket
from typing import Final

__all__ = ["disconnect", "send_at_once"]

_FLAGS: Final = socket.MSG_DONTWAIT | getattr(socket, "MSG_NOSIGNAL", 0)

#: a `PyDLL` keeps the lock during its calls, where a `CDLL` releases it
_system: Final = ctypes.PyDLL(None)
_send: Final = _system.send
_send.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
_send.restype = ctypes.c_ssize_t


def send_at_once(descriptor: int, data: bytes) -> int:
    """Send what a socket takes at this moment; from any thread or signal handler.

    Args:
        descriptor: the socket's; it must not be closed meanwhile.
        data: the bytes.

    Returns:
        How many bytes the system took; negative if it took none, whatever the reason.
    """
    return int(_send(descriptor, data, len(data), _FLAGS))


_connect: Final = _system.connect
_connect.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_uint]
_connect.restype = ctypes.c_int

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
        Whether the system did it.
    """
    return bool(_connect(descriptor, _UNSPECIFIED, len(_UNSPECIFIED)) == 0)
