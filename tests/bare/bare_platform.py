"""Runs the package without what Windows lacks, on Linux: `pytest --bare-platform`.

What is taken away is taken from the package only, at its imports: it sees `os`, `socket`, `select`,
`selectors`, `signal` and `subprocess` without it. The standard library, which on Windows has other
code in these places, and the tests go on as they are. What Windows has instead is put in:
`socket.share` and `socket.fromshare`, and an event loop of `select.select` without handlers for
signals.

Children get it too: those of the package by a line before their own, others by `sitecustomize.py`.
"""

from __future__ import annotations

import builtins
import contextlib
import os
import select
import selectors
import signal
import socket
import struct
import subprocess
import sys
import threading
import types
from pathlib import Path
from typing import Any

#: variable in the environment of children: the folder of this file
VARIABLE = "AIODUCO_TESTS_BARE"

MODULES = frozenset(
    ("_posixsubprocess", "fcntl", "grp", "pty", "pwd", "resource", "syslog", "termios", "tty")
)
ATTRIBUTES: dict[str, frozenset[str]] = {
    "os": frozenset(
        name
        for name in dir(os)
        if name.startswith(("sched_", "SCHED_", "MFD_", "posix_", "pidfd_", "EFD_", "P_", "memfd_"))
    )
    | {
        *("fork", "forkpty", "register_at_fork", "pread", "pwrite", "eventfd", "pipe2", "setsid"),
        *("getpgid", "killpg", "setpgid", "getuid", "geteuid", "getgid", "O_CLOEXEC", "O_NONBLOCK"),
        *("sendfile", "openpty", "mkfifo", "set_blocking", "get_blocking", "WNOHANG", "splice"),
    },
    "select": frozenset(("poll", "epoll", "kqueue", "devpoll")),
    "selectors": frozenset(("PollSelector", "EpollSelector", "KqueueSelector", "DevpollSelector")),
    "signal": frozenset(
        name
        for name in dir(signal)
        if name.startswith("SIG")
        and name.isupper()
        and not name.startswith("SIG_")
        and name not in ("SIGABRT", "SIGFPE", "SIGILL", "SIGINT", "SIGSEGV", "SIGTERM")
    )
    | {"pthread_kill", "pthread_sigmask", "setitimer", "alarm", "sigwait", "siginterrupt"},
    "socket": frozenset(
        ("MSG_DONTWAIT", "MSG_NOSIGNAL", "AF_UNIX", "SOCK_SEQPACKET", "SO_REUSEPORT")
    )
    | {"TCP_USER_TIMEOUT", "TCP_QUICKACK", "SOCK_NONBLOCK", "SOCK_CLOEXEC", "send_fds", "recv_fds"},
}


class Bare(types.ModuleType):
    """A module of the standard library as the package sees it."""

    def __init__(self, module: types.ModuleType, more: dict[str, Any]) -> None:
        super().__init__(module.__name__)
        self.__dict__.update(more)
        self.__dict__["_module"] = module
        self.__dict__["_without"] = ATTRIBUTES.get(module.__name__, frozenset())
        #: what was replaced, as a test does, by name
        self.__dict__["_replaced"] = {}

    def __getattr__(self, name: str) -> Any:
        if name in self._without:
            raise AttributeError(f"this platform has no {self.__name__}.{name}")
        return getattr(self._module, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if hasattr(self._module, name):
            self._replaced.setdefault(name, getattr(self._module, name))
        setattr(self._module, name, value)

    def __delattr__(self, name: str) -> None:
        # What is replaced for a while is not in this module's own table, and so "deleted" at last.
        if name in self._replaced:
            setattr(self._module, name, self._replaced.pop(name))
        else:
            delattr(self._module, name)

    def __dir__(self) -> list[str]:
        return [name for name in dir(self._module) if name not in self._without]


class Popen(subprocess.Popen[bytes]):
    """As that of Windows: no descriptor is inherited but the standard three."""

    def __init__(self, *args: Any, **options: Any) -> None:
        if options.get("pass_fds"):
            raise ValueError("pass_fds not supported on Windows.")
        environment = {**(options.get("env") or os.environ), **_environment()}
        super().__init__(*args, **{**options, "env": environment})


def _environment() -> dict[str, str]:
    here = str(Path(__file__).parent)
    return {VARIABLE: here}


# Sharing a socket: the real one is kept for the other process, which fetches it over a socket of
# the Unix family by a name of the abstract space.


def share(self: socket.socket, process: int) -> bytes:
    """As `socket.socket.share` of Windows."""
    name = b"\0aioduco-share-" + os.urandom(16)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(name)
    listener.listen(1)
    kept = self.dup()
    threading.Thread(target=_give, args=(listener, kept, process), daemon=True).start()
    return name + struct.pack("ii", self.family, self.type)


def _give(listener: socket.socket, kept: socket.socket, process: int) -> None:
    # What nobody fetches is closed with the process that it was for.
    with listener, kept, contextlib.suppress(OSError):
        end = os.pidfd_open(process)
        try:
            ready, _, _ = select.select([listener.fileno(), end], [], [])
            if listener.fileno() in ready:
                taker, _ = listener.accept()
                with taker:
                    socket.send_fds(taker, [b"x"], [kept.fileno()])
        finally:
            os.close(end)


def fromshare(data: bytes) -> socket.socket:
    """As `socket.fromshare` of Windows."""
    name, (family, kind) = data[:-8], struct.unpack("ii", data[-8:])
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as giver:
        giver.connect(name)
        _, descriptors, _, _ = socket.recv_fds(giver, 1, 1)
    return socket.socket(family, kind, 0, descriptors[0])


MORE: dict[str, dict[str, Any]] = {
    "os": {},
    "select": {},
    "selectors": {"DefaultSelector": selectors.SelectSelector},
    "signal": {},
    "socket": {"fromshare": fromshare},
    "subprocess": {"Popen": Popen, "CREATE_NEW_PROCESS_GROUP": 0},
}

_import = builtins.__import__
_bare: dict[str, Bare] = {}


def _bare_import(
    name: str,
    globals: Any = None,  # noqa: A002 - as the interpreter calls it
    locals: Any = None,  # noqa: A002
    fromlist: Any = (),
    level: int = 0,
) -> Any:
    importer = (globals or {}).get("__name__", "") or ""
    ours = level == 0 and (importer == "aioduco" or importer.startswith("aioduco."))
    if ours and name in MODULES:
        raise ModuleNotFoundError(f"No module named {name!r}: this platform has none", name=name)
    found = _import(name, globals, locals, fromlist, level)
    if name == "asyncio" or name.startswith("asyncio."):
        _limit_loops()
    if "aioduco._process.spawn" in sys.modules:
        _prepare_children(sys.modules["aioduco._process.spawn"])
    if not ours or name not in MORE:
        return found
    if name not in _bare:
        _bare[name] = Bare(found, MORE[name])
    return _bare[name]


def _prepare_children(spawn: Any) -> None:
    begin = getattr(spawn, "_BEGIN", None)
    if begin is None or VARIABLE in begin:
        return
    spawn._BEGIN = f"""
import os, sys
sys.path.insert(0, os.environ["{VARIABLE}"])
import bare_platform
sys.path.pop(0)
bare_platform.install()
{begin}"""


_limited = False


def _limit_loops() -> None:
    """Have asyncio's event loops wait by `select.select`, and take no handlers for signals."""
    global _limited  # noqa: PLW0603 - once
    events: Any = sys.modules.get("asyncio.unix_events")
    loops: Any = sys.modules.get("asyncio.selector_events")
    if _limited or not hasattr(events, "_UnixSelectorEventLoop"):
        return
    _limited = True
    begin = loops.BaseSelectorEventLoop.__init__

    def limited(self: Any, selector: Any = None) -> None:
        begin(self, selector or selectors.SelectSelector())

    def none(self: Any, *_: Any) -> None:
        raise NotImplementedError  # as Windows' loop answers: it takes no handlers for signals

    loops.BaseSelectorEventLoop.__init__ = limited
    events._UnixSelectorEventLoop.add_signal_handler = none


def install() -> None:
    """Take it all away, in this process and in those that it starts."""
    if builtins.__import__ is _bare_import:
        return
    if "aioduco._process.platform" in sys.modules:
        raise RuntimeError("the package has seen all of the platform already")
    socket.socket.share = share  # type: ignore[attr-defined]  # Windows alone has it
    os.environ.update(_environment())
    builtins.__import__ = _bare_import
    if "asyncio" in sys.modules:
        _limit_loops()
