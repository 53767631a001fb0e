"""The block of memory between a program and its worker.

It is a memory file without a name (memfd), passed to the worker's process as an open descriptor:
the system frees the block when both processes have ended, however they ended. Where there are no
such files it is the standard library's shared memory, under a name that cannot be guessed. A worker
in a thread uses the same layout in anonymous memory.

Each word has one writer: the program writes `ControlWord`, the worker writes `StatusWord`, the
histograms and the report. Words are 64 bits wide and aligned, so that a reader never sees half a
word.
"""

from __future__ import annotations

import itertools
import mmap
import struct

from aioduco._process.platform import has_memory_files
from aioduco.streaming.shared.backing import MemoryFile, NamedMemory
from aioduco.streaming.shared.config import WorkerConfig
from aioduco.streaming.shared.histogram import Histogram
from aioduco.streaming.shared.ring import Ring
from aioduco.streaming.shared.words import StatusWord

_MAGIC = 0x61696F6475636F31
_HEADER = struct.Struct("<QQ")
_TEXT = 1024

#: the worker's measurements; times in nanoseconds, depth in points
HISTOGRAMS = ("lateness", "interval", "round_trip", "work", "age", "depth")


_WORDS = 32
_REPORT = 4  # slots: the reader always finds a slot that is not being written


def _sizes(config: WorkerConfig, length: int) -> list[int]:
    """Bytes of the parts: configuration, control, status, text, report, ring, each histogram.

    Args:
        config: the configuration.
        length: its bytes.
    """
    head = -(-(_HEADER.size + length) // 8) * 8  # the words behind it are aligned
    rings = Ring.size(_REPORT), Ring.size(config.feeding.capacity, config.extra)
    counts = [8 * Histogram.WORDS] * len(HISTOGRAMS)
    return [head, 8 * _WORDS, 8 * _WORDS, _TEXT, *rings, *counts]


class Block:
    """The block, as the program or the worker uses it.

    Args:
        memory: the mapped memory.
        text: the worker's configuration, packed, for the side that makes the block.
        backing: the memory's owner, which can pass it to another process; None within one process.

    Attributes:
        control: words of `ControlWord`.
        status: words of `StatusWord`.
        ring: the program's set-points.
        report: the newest of the set-points that the worker sent.
        histograms: one for each name of `HISTOGRAMS`.
    """

    def __init__(
        self,
        memory: memoryview,
        text: bytes = b"",
        backing: MemoryFile | NamedMemory | None = None,
    ) -> None:
        self._memory = memory
        self._backing = backing
        if text:
            _HEADER.pack_into(memory, 0, _MAGIC, len(text))
            memory[_HEADER.size : _HEADER.size + len(text)] = text
        magic, length = _HEADER.unpack_from(memory)
        if magic != _MAGIC:
            raise ValueError("this is no block of a worker, or one of another version")
        self.config: WorkerConfig = WorkerConfig.unpack(
            bytes(memory[_HEADER.size : _HEADER.size + length])
        )
        head, *sizes = _sizes(self.config, length)
        ends = itertools.accumulate(sizes, initial=head)
        parts = [memory[begin:end] for begin, end in itertools.pairwise(ends)]
        control, status, self._text, report, ring, *histograms = parts
        self.control: memoryview[int] = control.cast("Q")
        self.status: memoryview[int] = status.cast("Q")
        self.report: Ring = Ring(report, _REPORT)
        self.ring: Ring = Ring(ring, self.config.feeding.capacity, self.config.extra)
        self.histograms: dict[str, Histogram] = {
            name: Histogram(words.cast("Q"))
            for name, words in zip(HISTOGRAMS, histograms, strict=True)
        }

    @classmethod
    def make(cls, config: WorkerConfig, *, shared: bool) -> Block:
        """Make a block.

        Args:
            config: the worker's configuration.
            shared: whether another process opens it, by its `handle`.
        """
        text = config.pack()
        size = sum(_sizes(config, len(text)))
        if not shared:
            return cls(memoryview(mmap.mmap(-1, size)), text)
        backing = MemoryFile.make(size) if has_memory_files() else NamedMemory.make(size)
        try:
            return cls(backing.map(), text, backing)
        except BaseException:
            backing.close()
            raise

    @classmethod
    def open(cls, handle: int | str) -> Block:
        """Open a block that another process made, by its `handle`; closes a descriptor."""
        backing = MemoryFile(handle) if isinstance(handle, int) else NamedMemory.open(handle)
        try:
            return cls(backing.map(), backing=backing)
        finally:
            backing.close_descriptor()

    @property
    def handle(self) -> int | str:
        """The handle by which another process opens it: an inherited descriptor, or a name."""
        assert self._backing is not None, "this block is of one process alone"
        return self._backing.handle

    @property
    def text(self) -> str:
        """Why the stream ended, in words."""
        return bytes(self._text[: self.status[StatusWord.TEXT]]).decode("utf-8", "replace")

    @text.setter
    def text(self, text: str) -> None:
        encoded = text.encode()[:_TEXT]
        self._text[: len(encoded)] = encoded
        self.status[StatusWord.TEXT] = len(encoded)

    def close_descriptor(self) -> None:
        """Close the program's descriptor, after the worker's process has its own."""
        if self._backing is not None:
            self._backing.close_descriptor()

    def close(self) -> None:
        """Release the memory and its system resources.

        The memory is freed with its last view: another thread may have one for a moment, as that
        which tells the line that blocks the event loop has the variables of that line.
        """
        self.close_descriptor()
        for histogram in self.histograms.values():
            histogram.close()
        self.ring.close()
        self.report.close()
        for view in (self.control, self.status, self._text, self._memory):
            view.release()
        if self._backing is not None:
            self._backing.close()
