"""Sending in one breath: without giving the interpreter's lock away.

`socket.send` gives the lock away for the length of the system call. That wakes the thread that
waits for it, a program's busy event loop for instance, and the system may let that thread run
before the send has been made: on one core, for milliseconds. A stop must not wait for that. A
send that cannot block may keep the lock, and has then been made when the next thread runs.
"""

from __future__ import annotations

import ctypes
import socket
from typing import Final

__all__ = ["send_at_once"]

_FLAGS: Final = socket.MSG_DONTWAIT | getattr(socket, "MSG_NOSIGNAL", 0)

#: a `PyDLL` keeps the lock during its calls, where a `CDLL` gives it away
_send: Final = ctypes.PyDLL(None).send
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
