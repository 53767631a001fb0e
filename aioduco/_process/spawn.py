"""Starting the processes of this package: the guard, workers of streams, planners, simulators.

Guarantees:
- A process imports each package from the place where the program found it. It imports nothing from
  the current folder, from PYTHONPATH, or from a folder that has only the program's own modules. So
  a stray file with the name of a package never runs in a process that can stop or move an arm. Only
  a process that tries out a user's program uses PYTHONPATH, as the program would.
- Only a Python interpreter is started. A frozen program is started only after it has called
  `aioduco.freeze_support`: it then runs the process instead of itself.
- If a program is started in place of such a process by mistake, it opens no robot.
- A process inherits no standard stream of the program: a reader of the program's output does not
  have to wait for other processes. The end of a process's standard error is kept for the program.
  Only a process that tries out a user's program may write to the output of the program.
"""

from __future__ import annotations

import base64
import contextlib
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from aioduco._process.platform import NEW_GROUP, SHARED, hands_over_by_number, has_memory_files

if TYPE_CHECKING:
    import socket
    from collections.abc import Iterable, Sequence

#: first argument of a frozen program that must run one of the processes
MARK: Final = "--aioduco-process"
#: environment variable of each process: its module
_VARIABLE: Final = "AIODUCO_PROCESS"
#: packages that the processes import besides the standard library; glfw uses cffi if it is there
_PACKAGES: Final = (
    "_cffi_backend",
    "aioduco",
    "anyio",
    "cffi",
    "idna",
    "ijson",
    "numpy",
    "ply",
    "pycparser",
    "ruckig",
    "six",
    "sniffio",
    "thriftpy2",
    "typing_extensions",
)
#: those that a process imports besides, if it imports MuJoCo, which imports glfw
MUJOCO_PACKAGES: Final = ("OpenGL", "glfw", "mujoco")
#: number of bytes that are read from the end of a process's standard error
_TAIL_BYTES: Final = 4000

#: start code of a process. Its interpreter is isolated (`-I`): its path has only the standard
#: library and the installed packages. One that runs a user's program has `-P` instead.
_BEGIN: Final = """
import importlib, json, os, sys
from importlib.machinery import PathFinder

class Places:
    places = json.loads(sys.argv.pop(1))

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        if name in cls.places:
            return PathFinder.find_spec(name, [cls.places[name]], target)

sys.meta_path.insert(0, Places)
# This is the process, and no program in its place: what it starts may open robots.
del os.environ[sys.argv.pop(1)]
sys.exit(importlib.import_module(sys.argv.pop(1)).main(sys.argv[1:]))
"""


class Unstartable(Exception):
    """No process can be started from this program. The text says why, and what to do."""


class _Children:
    """Whether a frozen program has called `freeze_support`, and so runs its child processes."""

    def __init__(self) -> None:
        self.freeze_support_called = False


#: one per process: the program calls `freeze_support` once, before anything else
children: Final = _Children()


def is_frozen() -> bool:
    """Whether this program is one file or folder that contains its interpreter."""
    return bool(getattr(sys, "frozen", False))


def started_in_place_of() -> str:
    """Return the module of the process in whose place this program runs by mistake; empty if none.

    This happens if `sys.executable` is the program itself, and `sys.frozen` is not set.
    """
    return "" if children.freeze_support_called else os.environ.get(_VARIABLE, "")


class Process:
    """A process of this package.

    Args:
        module: module whose `main` it runs.
        sockets: sockets for the process, which it opens by `handed_socket` from its first
            arguments, in order.
        memory: its shared memory, passed as the next argument: an open descriptor, or a name.
        packages: packages that it imports besides `_PACKAGES`.
        runs_program: whether it runs a program of the user, which finds its modules by PYTHONPATH
            and in the user's own packages, too.
        output: whether it writes to the output of this program; else its standard output is
            discarded, and its standard error is kept as `stderr_tail`.

    Raises:
        Unstartable: there is no interpreter to start.
        OSError: the system does not allow it.
    """

    def __init__(
        self,
        module: str,
        sockets: Sequence[socket.socket],
        *,
        memory: int | str | None = None,
        packages: Sequence[str] = (),
        runs_program: bool = False,
        output: bool = False,
    ) -> None:
        begin = _command(module, (*_PACKAGES, *packages), "-P" if runs_program else "-I")
        by_number = hands_over_by_number()
        handed = [str(each.fileno()) if by_number else SHARED for each in sockets]
        if memory is not None:
            handed.append(str(memory))
        kept = [each.fileno() for each in sockets]
        if isinstance(memory, int):
            kept.append(memory)
        self._tail = ""
        self._stderr: _StderrCapture | None = _StderrCapture()
        try:
            self.popen: subprocess.Popen[bytes] = subprocess.Popen(
                [*begin, *handed],
                pass_fds=kept if by_number else (),
                stdin=subprocess.DEVNULL if by_number else subprocess.PIPE,
                stdout=None if output else subprocess.DEVNULL,
                stderr=None if output else self._stderr.descriptor,
                # Ctrl-C and the end of a terminal must reach only the program.
                start_new_session=True,
                creationflags=NEW_GROUP,
                env=_environment(module, runs_program=runs_program),
            )
        except BaseException:
            Process.close(self)
            raise
        if not by_number:
            self._share(sockets)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.popen.pid}>"

    def __del__(self) -> None:
        if getattr(self, "_stderr", None) is not None:
            Process.close(self)  # not that of a subclass, which may wait

    @property
    def stderr_tail(self) -> str:
        """The end of its standard error, mostly the reason of a failure; empty if none."""
        if self._stderr is not None:
            self._tail = self._stderr.read().decode(errors="replace").strip()
        return self._tail

    def close(self) -> None:
        """Close its standard error, once it has exited; `stderr_tail` stays readable."""
        _ = self.stderr_tail
        stderr, self._stderr = self._stderr, None
        if stderr is not None:
            stderr.close()

    def _share(self, sockets: Sequence[socket.socket]) -> None:
        """Pass sockets on a system whose children inherit none: as lines on standard input."""
        given: Any = sockets  # they have `share` wherever `socket` has `fromshare`
        assert self.popen.stdin is not None
        with contextlib.suppress(OSError), self.popen.stdin as lines:  # it may have exited
            for each in given:
                lines.write(base64.b64encode(each.share(self.popen.pid)) + b"\n")


class _StderrCapture:
    """The standard error of a process.

    It is kept in memory if the system allows that, so that it cannot fill the disk. Else it is kept
    in a temporary file, which is read through another descriptor: a shared descriptor has only one
    position.
    """

    def __init__(self) -> None:
        self._owner = os.getpid()
        self._file: Path | None = None
        if has_memory_files():
            self.descriptor = os.memfd_create("aioduco-process")
        else:
            import tempfile  # noqa: PLC0415 - only needed here

            self.descriptor, name = tempfile.mkstemp(prefix="aioduco-")
            self._file = Path(name)

    def read(self) -> bytes:
        """Return the end of the output."""
        if self._file is None:
            size = os.fstat(self.descriptor).st_size
            return os.pread(self.descriptor, _TAIL_BYTES, max(0, size - _TAIL_BYTES))
        return self._file.read_bytes()[-_TAIL_BYTES:]

    def close(self) -> None:
        """Close it, and delete its content; in a forked child, only its copy."""
        os.close(self.descriptor)
        if self._file is not None and self._owner == os.getpid():
            # Windows does not delete it while the process that writes it runs
            with contextlib.suppress(OSError):
                self._file.unlink()


def _environment(module: str, *, runs_program: bool) -> dict[str, str]:
    environment = {**os.environ, _VARIABLE: module}
    if runs_program:
        return environment
    # NumPy's algebra starts one thread per processor. 6 x 6 matrices do not need them, and to start
    # and end them takes longer than to import NumPy.
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    # MuJoCo would load its drawing library, which starts interpreters in the current folder, to
    # look for the newest of its libraries there, too. Pictures are drawn by a process that loads
    # its own.
    environment.setdefault("MUJOCO_GL", "disable")
    return environment


def _command(module: str, packages: Sequence[str], isolation: str) -> list[str]:
    """Return the command that runs a module, without the module's arguments."""
    if started_in_place_of():
        raise Unstartable(f"this program was itself started instead of {started_in_place_of()}")
    if not sys.executable:
        raise Unstartable("the interpreter of this program does not know its own file")
    if not is_frozen():
        places = json.dumps(_places(packages))
        return [sys.executable, isolation, "-c", _BEGIN, places, _VARIABLE, module]
    if not children.freeze_support_called:
        raise Unstartable(
            "this is a frozen program, and its executable would be started as the program once "
            "more. Call aioduco.freeze_support() as the first thing that the program does"
        )
    return [sys.executable, MARK, module]


def _places(packages: Iterable[str] = _PACKAGES) -> dict[str, str]:
    """Return, by package, the folder or archive from which the program imports it."""
    places = {}
    for name in packages:
        found = getattr(sys.modules.get(name), "__spec__", None) or importlib.util.find_spec(name)
        if found is None:
            continue
        where = next(iter(found.submodule_search_locations or ()), None) or found.origin
        if where is not None:
            places[name] = str(Path(where).absolute().parent)
    return places
