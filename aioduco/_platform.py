"""What differs between operating systems, each in one function.

A function asks for what it needs when it is called, by the name that the standard library gives it:
where the name is missing, so is the means. On Linux all of it is there. Windows has no `poll`, no
`MSG_DONTWAIT`, no limits on a socket that leave it usable, no descriptors that a child inherits by
number, no memory files, and signals for Ctrl-C and SIGTERM only. macOS lacks the memory files and
what Linux alone tells of a connection.
"""

from __future__ import annotations

import binascii
import errno
import os
import select
import signal
import socket
import struct
import sys
import time
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

__all__ = [
    "BINARY",
    "CLOSE_ON_EXEC",
    "CONNECTING",
    "NEW_GROUP",
    "SHARED",
    "clock_step",
    "ending_signals",
    "guard_lacks",
    "handed_socket",
    "hands_over_by_number",
    "has_device_files",
    "has_memory_files",
    "limits_sockets",
    "processors",
    "readiness",
    "set_affinity",
    "set_first",
    "unacknowledged",
]

#: flags of `os.open`: 0 where a system has none
BINARY: Final = getattr(os, "O_BINARY", 0)
CLOSE_ON_EXEC: Final = getattr(os, "O_CLOEXEC", 0)
#: what a connection that is being made answers to its start
CONNECTING: Final = (errno.EINPROGRESS, getattr(errno, "WSAEWOULDBLOCK", errno.EINPROGRESS))
#: flags for a child that Ctrl-C in the program's console is not for, where a session does not do it
NEW_GROUP: Final = 0x200 if sys.platform == "win32" else 0

#: argument for a socket that is shared, and not inherited
SHARED: Final = "shared"


def readiness(sock: socket.socket, *, writing: bool = False) -> Callable[[float], bool]:
    """A function that waits for a socket at most so many seconds, and says whether it is ready.

    Args:
        sock: the socket.
        writing: to be written to, or connected; else to be read from.
    """
    if hasattr(select, "poll"):
        poll = select.poll()
        poll.register(sock, select.POLLOUT if writing else select.POLLIN | select.POLLHUP)
        # rounded up: a wait that ends early would be made again at once
        return lambda seconds: bool(poll.poll(-(-seconds * 1000 // 1)))
    if writing:
        # Windows tells of a connection that failed among the exceptions only.
        return lambda seconds: any(select.select([], [sock], [sock], seconds))
    return lambda seconds: bool(select.select([sock], [], [], seconds)[0])


def limits_sockets() -> bool:
    """Whether a socket blocks up to a limit that the system keeps, and can be asked not to.

    If not, Python keeps the time: two system calls instead of one, on a socket that never blocks.
    """
    return hasattr(socket, "MSG_DONTWAIT")


def unacknowledged(sock: socket.socket) -> int:
    """How many bytes the system holds that the other side has not acknowledged.

    0 where the system does not tell. What was not answered is then treated as delivered: it is
    waited for, and outlasted.
    """
    try:
        import fcntl  # noqa: PLC0415 - where there is one
        import termios  # noqa: PLC0415

        return int(struct.unpack("i", fcntl.ioctl(sock, termios.TIOCOUTQ, bytes(4)))[0])
    except ImportError:
        return 0


def hands_over_by_number() -> bool:
    """Whether a child gets open descriptors under their numbers; else sockets are shared."""
    return not hasattr(socket, "fromshare")


def has_memory_files() -> bool:
    """Whether memory without a name can be handed to a child as a descriptor."""
    return hasattr(os, "memfd_create") and hands_over_by_number()


def has_device_files() -> bool:
    """Whether terminals and input devices are files that are read without waiting."""
    return hasattr(os, "O_NONBLOCK")


def guard_lacks() -> str:
    """What a guard's process needs and this system lacks; empty if it has all of it."""
    needed = {
        "packets between processes (SOCK_SEQPACKET)": hasattr(socket, "AF_UNIX")
        and hasattr(socket, "SOCK_SEQPACKET"),
        "sends that do not wait (MSG_DONTWAIT)": hasattr(socket, "MSG_DONTWAIT"),
        "scheduling classes (sched_setscheduler)": hasattr(os, "sched_setscheduler"),
    }
    return ", ".join(name for name, there in needed.items() if not there)


def ending_signals() -> tuple[signal.Signals, ...]:
    """Signals that ask a process to end, Ctrl-C aside."""
    names = ("SIGTERM", "SIGHUP")
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def set_affinity(processors: Iterable[int]) -> bool:
    """Keep the calling thread on these processors. Returns whether the system did it."""
    return _allowed("sched_setaffinity", lambda: os.sched_setaffinity(0, processors))


def set_first(priority: int) -> bool:
    """Have the calling thread run before all others (SCHED_FIFO).

    Returns whether the system did it.
    """
    return _allowed(
        "sched_setscheduler",
        lambda: os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority)),
    )


def goes_first() -> int:
    """The calling thread's priority for real time; 0: none."""
    if not hasattr(os, "sched_getparam"):
        return 0
    return os.sched_getparam(0).sched_priority


#: time for its signal to be heeded, before the system ends the process [µs]
_HEEDED: Final = 1_000_000


def go_first_by_moments(longest: float, given_back: Callable[[], object]) -> bool:
    """Have this process's main thread run before all that have no priority, for moments at a time.

    Once it has used a processor for longer without a wait, it is one like all others again: what
    does not wait would keep everything else from that processor. The system watches that, and ends
    the process if it goes on without heeding it.

    Args:
        longest: how long [s].
        given_back: called in the main thread when that came to pass.

    Returns:
        Whether the system did it; False as well where the thread has a policy of its own already.
    """
    try:
        import resource  # noqa: PLC0415  # not on Windows

        watched = resource.RLIMIT_RTTIME
    except (ImportError, AttributeError):
        return False
    if os.sched_getscheduler(0) != os.SCHED_OTHER:
        return False

    def give_back(*_: object) -> None:
        go_with_all()
        given_back()

    _, most = resource.getrlimit(watched)
    soft = int(longest * 1e6)
    hard = soft + _HEEDED if most == resource.RLIM_INFINITY else most
    signal.signal(signal.SIGXCPU, give_back)
    try:
        resource.setrlimit(watched, (min(soft, hard), hard))
    except (OSError, ValueError):
        return False
    return set_first(1)


def go_with_all() -> None:
    """Have the calling thread run as all others do that have no priority."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _allowed(name: str, request: Callable[[], Any]) -> bool:
    if not hasattr(os, name):
        return False
    try:
        request()
    except OSError:
        return False
    return True


def clock_step() -> float:
    """The steps in which the monotonic clock goes on [s]: 16 ms on Windows before Python 3.13."""
    return time.get_clock_info("monotonic").resolution


def handed_socket(argument: str) -> socket.socket:
    """The socket that this process was given.

    Args:
        argument: what its `main` got for it; each is taken once, in their order.
    """
    if argument != SHARED:
        handed = socket.socket(fileno=int(argument))
        handed.set_inheritable(False)  # what this process starts is not to hold it open
        return handed
    module: Any = socket
    line = sys.stdin.buffer.readline()
    shared: socket.socket = module.fromshare(binascii.a2b_base64(line))
    return shared
