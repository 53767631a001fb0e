"""Finds what a piece of code left open: threads, sockets and other files, child processes."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from aioduco._process.copying import Uncopied
from aioduco._process.platform import has_child
from aioduco.models.ranges import WAIT
from aioduco.testing.waiting import eventually, eventually_async


@dataclass(frozen=True, slots=True)
class Resources:
    """The resources of this process at one moment.

    Attributes:
        threads: names of the threads, by their ids.
        files: target of each open file descriptor, by its number; a socket is
            "socket:[inode]".
        children: command lines of the child processes, by their ids; a child that has ended and
            was not waited for is "(not waited for)".
    """

    threads: dict[int, str]
    files: dict[int, str]
    children: dict[int, str]

    @classmethod
    def now(cls) -> Resources:
        """List the present resources of this process. Needs Linux."""
        threads = {t.native_id or 0: t.name for t in threading.enumerate()}
        return cls(threads, _files(), _children(os.getpid()))

    def beyond(self, before: Resources) -> list[str]:
        """List what was not there before, one line each; empty if nothing is new.

        A descriptor or an id that has been reused counts as new, although its number is old.
        """
        left = [
            f"{kind} {number}: {name}"
            for kind, here, there in (
                ("thread", self.threads, before.threads),
                ("file", self.files, before.files),
                ("child process", self.children, before.children),
            )
            for number, name in here.items()
            if there.get(number) != name
        ]
        return sorted(left)


class no_leaks(Uncopied):  # noqa: N801 - used like a function, as contextlib.suppress is
    """Assert that everything that the block opens is closed when it ends, or soon after.

        with no_leaks():
            with Simulator() as simulator:
                ...

    Threads, sockets, other files and child processes are counted. Works as `async with` too,
    where waiting does not block the loop. An error that leaves the block is passed on as it is.
    """

    def __init__(self, timeout: float = 5.0) -> None:
        """Make the context.

        Args:
            timeout: seconds within which everything must be closed after the block.
        """
        self._timeout = WAIT("timeout", timeout)
        self._before = Resources({}, {}, {})

    def __enter__(self) -> Self:
        self._before = Resources.now()
        return self

    def __exit__(self, _kind: object, exc: BaseException | None, _trace: object) -> None:
        """Wait until everything is closed.

        Raises:
            AssertionError: something is left; the message lists it.
        """
        if exc is None:
            eventually(self._gone, self._timeout, what=self._left)

    async def __aenter__(self) -> Self:
        return self.__enter__()

    async def __aexit__(self, _kind: object, exc: BaseException | None, _trace: object) -> None:
        """Wait until everything is closed.

        Raises:
            AssertionError: something is left; the message lists it.
        """
        if exc is None:
            await eventually_async(self._gone, self._timeout, what=self._left)

    def _gone(self) -> bool:
        return not Resources.now().beyond(self._before)

    def _left(self) -> str:
        return "\n  ".join(["nothing left", *Resources.now().beyond(self._before)])


def _files() -> dict[int, str]:
    files = {}
    for entry in Path("/proc/self/fd").iterdir():
        try:
            files[int(entry.name)] = str(entry.readlink())
        except FileNotFoundError:
            continue  # the descriptor of this very listing
    return files


def _children(parent: int) -> dict[int, str]:
    children: dict[int, str] = {}
    if not has_child():
        return children  # so that not all processes of the system need be read
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            # the name in brackets may contain anything; plain fields follow it
            state, ppid = (entry / "stat").read_text().rpartition(")")[2].split()[:2]
            if int(ppid) != parent:
                continue
            command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except (FileNotFoundError, ProcessLookupError):
            continue  # it has ended meanwhile
        children[int(entry.name)] = "(not waited for)" if state == "Z" else command.strip()
    return children
