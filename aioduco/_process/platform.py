"""Differences between operating systems, one function for each.

Each function checks, when it is called, whether the standard library has the name that it needs. If
the name is missing, the system lacks the feature. Linux has all of them. Windows has no `poll`, no
`MSG_DONTWAIT`, no time limits after which a socket is still usable, no descriptors that a child
inherits by number, no memory files, and signals for Ctrl-C and SIGTERM only. macOS lacks the memory
files and the details of a connection that only Linux reports.
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
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

_ioctl: Any = None
_UNSENT = 0
try:
    import fcntl
    import termios
except ImportError:
    pass  # not on Windows
else:
    _ioctl = fcntl.ioctl
    _UNSENT = termios.TIOCOUTQ

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

#: flags of `os.open`: 0 where a system has none
BINARY: Final = getattr(os, "O_BINARY", 0)
CLOSE_ON_EXEC: Final = getattr(os, "O_CLOEXEC", 0)
#: rights of a new file that may contain secrets: its owner alone reads and writes it
PRIVATE: Final = 0o600
#: error codes of a connect call whose connection is still being made
CONNECTING: Final = (errno.EINPROGRESS, getattr(errno, "WSAEWOULDBLOCK", errno.EINPROGRESS))
#: flags that keep Ctrl-C in the program's console from a child, on a system without sessions
NEW_GROUP: Final = 0x200 if sys.platform == "win32" else 0

#: command-line argument that stands for a socket that is shared, and not inherited
SHARED: Final = "shared"


def private(path: str, flags: int) -> int:
    """Opener for `open`: a file that it creates is its owner's alone."""
    return os.open(path, flags | BINARY | CLOSE_ON_EXEC, PRIVATE)


def boot_time() -> float:
    """Return the seconds since the computer started, including those for which it slept.

    `time.monotonic` stands still while a Linux computer or a Mac sleeps: a program would not notice
    that the controller of its arm has missed the heartbeat. On Windows it goes on. All processes of
    a computer read the same time.
    """
    if hasattr(time, "CLOCK_BOOTTIME"):
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    if sys.platform == "darwin":
        return time.clock_gettime(time.CLOCK_MONOTONIC)  # unlike `time.monotonic` there
    return time.monotonic()


def readiness(sock: socket.socket, *, writing: bool = False) -> Callable[[float], bool]:
    """Return a function that waits up to some seconds and returns whether a socket is ready.

    Args:
        sock: the socket.
        writing: whether to wait until it can be written to, or is connected; else until it can be
            read from.
    """
    if hasattr(select, "poll"):
        poll = select.poll()
        poll.register(sock, select.POLLOUT if writing else select.POLLIN | select.POLLHUP)
        # rounded up: a wait that ends early would be repeated at once
        return lambda seconds: bool(poll.poll(-(-seconds * 1000 // 1)))
    if writing:
        # Windows reports a failed connection only in the third list, the exceptional conditions.
        return lambda seconds: any(select.select([], [sock], [sock], seconds))
    return lambda seconds: bool(select.select([sock], [], [], seconds)[0])


def limits_sockets() -> bool:
    """Whether the system enforces time limits of a socket, and a single call can skip the wait.

    If not, Python enforces the limits: two system calls instead of one, on a socket that never
    blocks.
    """
    return hasattr(socket, "MSG_DONTWAIT")


def unacknowledged(sock: socket.socket) -> int:
    """Return how many sent bytes the other side has not acknowledged.

    0 where the system does not report it. An unanswered call is then treated as delivered: its
    answer is waited for, up to a time limit.
    """
    if _ioctl is None:
        return 0
    return int(struct.unpack("i", _ioctl(sock, _UNSENT, bytes(4)))[0])


def hands_over_by_number() -> bool:
    """Whether a child inherits open descriptors under their numbers; else sockets are shared."""
    return not hasattr(socket, "fromshare")


def has_memory_files() -> bool:
    """Whether anonymous memory can be passed to a child as a descriptor."""
    return hasattr(os, "memfd_create") and hands_over_by_number()


def has_child() -> bool:
    """Whether this process may have a child, also one that has ended and was not waited for.

    True where the system does not say.
    """
    if not hasattr(os, "P_ALL"):
        return True
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True


def has_device_files() -> bool:
    """Whether terminals and input devices are files that can be read without blocking."""
    return hasattr(os, "O_NONBLOCK")


@contextmanager
def single_keys(terminal: int) -> Iterator[None]:
    """Make a terminal deliver each key at once without echo; Ctrl-C still interrupts.

    Args:
        terminal: file descriptor of the terminal.
    """
    try:
        import termios  # noqa: PLC0415 - where there is one
        import tty  # noqa: PLC0415
    except ImportError:
        yield  # a Windows console delivers each key at once by itself
        return
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal, termios.TCSANOW)
    try:
        yield
    finally:
        with suppress(termios.error):  # the terminal was closed
            termios.tcsetattr(terminal, termios.TCSANOW, before)


def missing_guard_features() -> str:
    """Return the features that a guard's process needs and this system lacks; empty if none."""
    needed = {
        "packets between processes (SOCK_SEQPACKET)": hasattr(socket, "AF_UNIX")
        and hasattr(socket, "SOCK_SEQPACKET"),
        "sends that do not wait (MSG_DONTWAIT)": hasattr(socket, "MSG_DONTWAIT"),
        "scheduling classes (sched_setscheduler)": hasattr(os, "sched_setscheduler"),
    }
    return ", ".join(name for name, there in needed.items() if not there)


def ending_signals() -> tuple[signal.Signals, ...]:
    """Signals that ask a process to exit, other than Ctrl-C."""
    names = ("SIGTERM", "SIGHUP")
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def set_affinity(processors: Iterable[int]) -> bool:
    """Bind the calling thread to these processors. Returns whether the system allowed it."""
    return _allowed("sched_setaffinity", lambda: os.sched_setaffinity(0, processors))


def set_realtime_priority(priority: int) -> bool:
    """Give the calling thread a real-time priority, above all ordinary threads (SCHED_FIFO).

    Returns whether the system allowed it.
    """
    return _allowed(
        "sched_setscheduler",
        lambda: os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority)),
    )


def realtime_priority() -> int:
    """Return the calling thread's real-time priority; 0 if it has none."""
    if not hasattr(os, "sched_getparam"):
        return 0
    return os.sched_getparam(0).sched_priority


#: time for a process to react to the signal, before the system kills it [µs]
_KILL_GRACE: Final = 1_000_000


def boost_main_thread(longest: float, on_drop: Callable[[], object]) -> bool:
    """Let this process's main thread run before all ordinary threads, for short periods.

    If it uses a processor for `longest` without waiting, it loses the priority: it would keep
    everything else from that processor. The system measures that time, sends a signal, and kills
    the process if it does not react.

    Args:
        longest: longest time on a processor without a wait [s].
        on_drop: called in the main thread after it has lost the priority.

    Returns:
        Whether the system allowed it; also False if the thread already has another policy.
    """
    try:
        import resource  # noqa: PLC0415  # not on Windows

        watched = resource.RLIMIT_RTTIME
    except (ImportError, AttributeError):
        return False
    if os.sched_getscheduler(0) != os.SCHED_OTHER:
        return False

    def drop(*_: object) -> None:
        drop_realtime_priority()
        on_drop()

    _, most = resource.getrlimit(watched)
    soft = int(longest * 1e6)
    hard = soft + _KILL_GRACE if most == resource.RLIM_INFINITY else most
    signal.signal(signal.SIGXCPU, drop)
    try:
        resource.setrlimit(watched, (min(soft, hard), hard))
    except (OSError, ValueError):
        return False
    return set_realtime_priority(1)


def drop_realtime_priority() -> None:
    """Take the priority from the calling thread: it runs as an ordinary thread again."""
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
    """Return the resolution of the monotonic clock [s]: 16 ms on Windows before Python 3.13."""
    return time.get_clock_info("monotonic").resolution


def handed_socket(argument: str) -> socket.socket:
    """Return a socket that the parent passed to this process.

    Args:
        argument: the argument of `main` for it; each must be used once, in their order.
    """
    if argument != SHARED:
        handed = socket.socket(fileno=int(argument))
        handed.set_inheritable(False)  # children of this process must not keep it open
        return handed
    module: Any = socket
    line = sys.stdin.buffer.readline()
    shared: socket.socket = module.fromshare(binascii.a2b_base64(line))
    return shared
