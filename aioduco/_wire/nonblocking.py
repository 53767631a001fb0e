"""Sends that keep the interpreter's lock, so that they happen before any other thread runs.

`socket.send` releases the lock during the system call. That wakes a thread that waits for the lock,
such as a program's busy event loop. The system may run that thread before the send: on one core,
for milliseconds. A stop must not wait for that. A send that cannot block may keep the lock: it is
complete when the next thread runs.
"""

from __future__ import annotations

import ctypes
import errno
import socket
from typing import TYPE_CHECKING, Any, Final, cast

from aioduco._process.platform import limits_sockets

if TYPE_CHECKING:
    from collections.abc import Callable


_FLAGS: Final = getattr(socket, "MSG_DONTWAIT", 0) | getattr(socket, "MSG_NOSIGNAL", 0)

#: what the functions of the system take: a descriptor, a buffer, its length, and perhaps flags
_CONNECT: Final = [ctypes.c_int, ctypes.c_char_p, ctypes.c_uint]
_TRANSFER: Final = [ctypes.c_int, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]


def _function(name: str, takes: list[Any], returns: Any) -> Callable[..., int] | None:
    """A function of the system that keeps the interpreter's lock; None where there is none."""
    if not limits_sockets():
        return None
    # a `CDLL` would release the lock
    found: Any = getattr(ctypes.PyDLL(None, use_errno=True), name)
    found.argtypes, found.restype = takes, returns
    return cast("Callable[..., int]", found)


_send: Final = _function("send", _TRANSFER, ctypes.c_ssize_t)
_receive: Final = _function("recv", _TRANSFER, ctypes.c_ssize_t)
_connect: Final = _function("connect", _CONNECT, ctypes.c_int)


def send_at_once(descriptor: int, data: bytes) -> int:
    """Send as many bytes as the system accepts at once; from any thread or signal handler.

    Args:
        descriptor: file descriptor of the socket; it must not be closed meanwhile.
        data: the bytes.

    Returns:
        The number of bytes that the system accepted; negative if it accepted none for any reason,
        or if it has no sends that do not wait.
    """
    if _send is None:
        return -1
    return _send(descriptor, data, len(data), _FLAGS)


#: buffer for the peeked byte, which is never used
_peeked: Final = ctypes.create_string_buffer(1)

#: what the system says of a socket that has nothing to read, and is not reset
_NOTHING_YET: Final = (errno.EAGAIN, errno.EWOULDBLOCK)

_PEEK: Final = getattr(socket, "MSG_DONTWAIT", 0) | socket.MSG_PEEK


def is_silent(descriptor: int) -> bool:
    """Whether a socket has nothing to read, neither the end of the stream nor a reset.

    Args:
        descriptor: file descriptor of the socket; it must not be closed meanwhile.

    Returns:
        False also where the system has no reads that do not wait: the state is unknown there.
    """
    if _receive is None:
        return False
    return _receive(descriptor, _peeked, 1, _PEEK) < 0 and ctypes.get_errno() in _NOTHING_YET


#: an address of the family AF_UNSPEC: `connect` with it resets a connection
_UNSPECIFIED: Final = bytes(16)


def disconnect(descriptor: int) -> bool:
    """Reset a TCP connection: the system discards every byte that it has not delivered.

    Closing a socket does not do that: the system continues to deliver until TCP_USER_TIMEOUT ends,
    and a forked child keeps the connection alive even if its parent closes its socket. A thread
    that waits on the socket wakes up.

    Args:
        descriptor: file descriptor of the socket; it must not be closed meanwhile.

    Returns:
        Whether the system did it. Windows cannot: there, undelivered bytes are discarded only by
        closing the socket with a linger time of zero.
    """
    if _connect is None:
        return False
    return _connect(descriptor, _UNSPECIFIED, len(_UNSPECIFIED)) == 0
