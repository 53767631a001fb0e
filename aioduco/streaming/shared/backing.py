"""The memory behind a block, and how it is passed to another process."""

from __future__ import annotations

import contextlib
import mmap
import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multiprocessing.shared_memory import SharedMemory


class MemoryFile:
    """Memory without a name (memfd). It is freed when all processes that have it open have ended.

    Args:
        descriptor: an open descriptor, which this object owns from now on.

    Attributes:
        handle: the descriptor, to be passed to another process.
    """

    def __init__(self, descriptor: int) -> None:
        self.handle: int = descriptor

    @classmethod
    def make(cls, size: int) -> MemoryFile:
        """Allocate new memory of `size` bytes."""
        descriptor = os.memfd_create("aioduco-stream", os.MFD_CLOEXEC)
        try:
            os.ftruncate(descriptor, size)
        except BaseException:
            os.close(descriptor)
            raise
        return cls(descriptor)

    def map(self) -> memoryview:
        """Map all of it."""
        return memoryview(mmap.mmap(self.handle, os.fstat(self.handle).st_size))

    def close_descriptor(self) -> None:
        """Close the descriptor: the other process has its own. The mapping stays."""
        if self.handle >= 0:
            os.close(self.handle)
            self.handle = -1

    def close(self) -> None:
        """Release the memory."""
        self.close_descriptor()


class NamedMemory:
    """Shared memory of the standard library, for systems without memory files.

    The process that made it removes its name at the end. If that process is killed, Windows removes
    the name when the last process closes the memory; elsewhere Python's resource tracker does.

    Args:
        memory: the shared memory.
        maker: whether this process made it.
    """

    def __init__(self, memory: SharedMemory, *, maker: bool) -> None:
        self._memory = memory
        self._maker = maker

    @classmethod
    def make(cls, size: int) -> NamedMemory:
        """Allocate new memory of `size` bytes under a name that cannot be guessed."""
        return cls(_shared_memory(create=True, size=size), maker=True)

    @classmethod
    def open(cls, name: str) -> NamedMemory:
        """Open memory that another process made."""
        from multiprocessing import resource_tracker  # noqa: PLC0415 - used here alone

        if sys.version_info >= (3, 13):
            return cls(_shared_memory(name, track=False), maker=False)
        # Earlier versions also track memory that is only opened, in one more process; that process
        # would remove the name although the maker still uses it.
        tracker: Any = resource_tracker
        register = tracker.register
        tracker.register = _nothing
        try:
            return cls(_shared_memory(name), maker=False)
        finally:
            tracker.register = register

    @property
    def handle(self) -> str:
        """The name of the memory."""
        return self._memory.name

    def map(self) -> memoryview:
        """Map all of it. It may be longer than requested."""
        view = self._memory.buf
        assert view is not None, "it is closed"
        return memoryview(view)

    def close_descriptor(self) -> None:
        """Do nothing: the other process may not have opened it yet, so the name must stay."""

    def close(self) -> None:
        """Release the memory, after all views of it are released."""
        with contextlib.suppress(BufferError):  # a block that could not be made has left views
            self._memory.close()
        if self._maker:
            self._memory.unlink()


def _shared_memory(*args: Any, **options: Any) -> SharedMemory:
    from multiprocessing.shared_memory import SharedMemory  # noqa: PLC0415 - used here alone

    class Memory(SharedMemory):
        """Shared memory whose finalizer raises no error while a view of it still exists."""

        def __del__(self) -> None:
            with contextlib.suppress(BufferError):
                super().__del__()

    return Memory(*args, **options)


def _nothing(name: str, rtype: str) -> None:
    """Track nothing."""
