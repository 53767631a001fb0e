"""The memory behind a block, and how it gets to another process."""

from __future__ import annotations

import contextlib
import mmap
import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multiprocessing.shared_memory import SharedMemory

__all__ = ["MemoryFile", "NamedMemory"]


class MemoryFile:
    """Memory without a name (memfd). When all that have it open are gone, so is it.

    Args:
        descriptor: an open one; it is this object's from now on.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    @classmethod
    def make(cls, size: int) -> MemoryFile:
        """New memory of so many bytes."""
        descriptor = os.memfd_create("aioduco-stream", os.MFD_CLOEXEC)
        try:
            os.ftruncate(descriptor, size)
        except BaseException:
            os.close(descriptor)
            raise
        return cls(descriptor)

    @property
    def handle(self) -> int:
        """The descriptor, for a process that is handed it."""
        return self._descriptor

    def map(self) -> mmap.mmap:
        """Map all of it."""
        return mmap.mmap(self._descriptor, os.fstat(self._descriptor).st_size)

    def handed_over(self) -> None:
        """The other process has it: close the descriptor. What is mapped stays."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def close(self) -> None:
        """Let go of it."""
        self.handed_over()


class NamedMemory:
    """Shared memory of the standard library, where there are no memory files.

    The process that made it takes its name away at the end. If that process is killed, Windows
    takes it away with the last that has it open, and elsewhere Python's own resource tracker does.

    Args:
        memory: it.
        maker: whether this process made it.
    """

    def __init__(self, memory: SharedMemory, *, maker: bool) -> None:
        self._memory = memory
        self._maker = maker

    @classmethod
    def make(cls, size: int) -> NamedMemory:
        """New memory of so many bytes, and of a name that nobody can guess."""
        return cls(_shared_memory(create=True, size=size), maker=True)

    @classmethod
    def open(cls, name: str) -> NamedMemory:
        """Memory that another process made."""
        from multiprocessing import resource_tracker  # noqa: PLC0415 - used here alone

        if sys.version_info >= (3, 13):
            return cls(_shared_memory(name, track=False), maker=False)
        # Earlier ones have each process that opens it tracked, by one more process, which takes
        # the name away from the program that made it.
        tracker: Any = resource_tracker
        register = tracker.register
        tracker.register = _nothing
        try:
            return cls(_shared_memory(name), maker=False)
        finally:
            tracker.register = register

    @property
    def handle(self) -> str:
        """Its name."""
        return self._memory.name

    def map(self) -> memoryview:
        """All of it. It may be longer than what was asked for."""
        view = self._memory.buf
        assert view is not None, "it is closed"
        return memoryview(view)

    def handed_over(self) -> None:
        """The other process may not have opened it yet: the name stays."""

    def close(self) -> None:
        """Let go of it, once what was mapped is released."""
        with contextlib.suppress(BufferError):  # of a block that could not be made
            self._memory.close()
        if self._maker:
            self._memory.unlink()


def _shared_memory(*args: Any, **options: Any) -> SharedMemory:
    from multiprocessing.shared_memory import SharedMemory  # noqa: PLC0415 - used here alone

    class Memory(SharedMemory):
        """One that may be thrown away, with its process, while a view of it is still there."""

        def __del__(self) -> None:
            with contextlib.suppress(BufferError):
                super().__del__()

    return Memory(*args, **options)


def _nothing(name: str, rtype: str) -> None:
    """Track nothing."""
