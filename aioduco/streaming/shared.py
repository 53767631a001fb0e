"""The block of memory between a program and its lane.

It is a memory file without a name (memfd), handed to the lane's process as an open descriptor:
when both processes are gone, however they went, so is the block. A lane in a thread uses the
same layout in anonymous memory.

Each word has one writer: the program writes `Command` and `Control`, the lane writes `Status`, the
histograms and `Report`. Words are 64 bits wide and aligned, so that a reader never sees half a
word.
"""

from __future__ import annotations

import mmap
import os
import struct
from enum import IntEnum, IntFlag

from aioduco.streaming.config import LaneConfig
from aioduco.streaming.ring import Ring
from aioduco.streaming.statistics import Histogram

__all__ = ["HISTOGRAMS", "Block", "Command", "Control", "Status", "Unmet"]

_MAGIC = 0x61696F6475636F31
_HEADER = struct.Struct("<QQ")
_CONFIG = 8192
_TEXT = 1024

#: what the lane measures; times in nanoseconds, depth in points
HISTOGRAMS = ("lateness", "interval", "round_trip", "work", "age", "depth")


class Command(IntEnum):
    """What the program wants of the lane; a higher one overrides a lower one.

    Each is a word of `Control`, set once and never taken back: so two threads that want
    different things at the same moment cannot undo each other.
    """

    #: follow what was sent to its end, then end
    CLOSE = 0
    #: come to rest at once, then end
    ABORT = 1
    #: send nothing more, at once: the robot was stopped
    HALT = 2


class Control(IntEnum):
    """Words that the program writes, after those of `Command`."""

    #: wake the program when no more than this many set-points are in the ring; 0: do not
    WAKE_BELOW = 3
    #: monotonic time at which the program's event loop last ran, and the heartbeat beat [ns]
    ALIVE = 4


class Status(IntEnum):
    """Words that the lane writes."""

    #: the lane is connected and runs
    READY = 0
    STATE = 1
    REASON = 2
    TICKS = 3
    SENT = 4
    MISSED = 5
    STARVED = 6
    LIMITED = 7
    OVERWRITTEN = 8
    #: points in the controller's queue when last looked at
    DEPTH = 9
    #: times at which the controller's queue was found empty
    DRAINED = 10
    #: number of the last set-point taken
    TAKEN = 11
    #: monotonic time of the last tick [ns]
    BEAT = 12
    #: length of the text that says why the stream ended
    TEXT = 13
    #: size of the lane's process at its largest [kB]
    MEMORY = 14
    #: what was asked of the system and not allowed: flags of `Unmet`
    UNMET = 15


class Unmet(IntFlag):
    """What a lane asked of the system and did not get."""

    TIMER_SLACK = 1
    CPUS = 2
    PRIORITY = 4
    SLICE = 8


_WORDS = 32
_REPORT = 4  # slots: the reader always finds one that is not being written


class Block:
    """The block, from either side.

    Args:
        memory: the mapped memory.
        config: the lane's configuration, for the side that makes the block.

    Attributes:
        control: words of `Command` and `Control`.
        status: words of `Status`.
        ring: the program's set-points.
        report: the set-points that the lane sent, the newest only.
        histograms: one for each name of `HISTOGRAMS`.
    """

    def __init__(
        self, memory: mmap.mmap, config: LaneConfig | None = None, descriptor: int = -1
    ) -> None:
        self._memory = memory
        self._view = memoryview(memory)
        self.descriptor: int = descriptor
        if config is not None:
            text = config.pack()
            if len(text) > _CONFIG:
                raise ValueError(f"the configuration of a lane has {len(text)} bytes")
            _HEADER.pack_into(memory, 0, _MAGIC, len(text))
            memory[_HEADER.size : _HEADER.size + len(text)] = text
        magic, length = _HEADER.unpack_from(memory)
        if magic != _MAGIC:
            raise ValueError("this is no block of a lane, or one of another version")
        self.config: LaneConfig = LaneConfig.unpack(memory[_HEADER.size : _HEADER.size + length])
        capacity, extra = self.config.feeding.capacity, self.config.sent.extra
        at = _HEADER.size + _CONFIG
        self.control: memoryview[int] = self._view[at : at + 8 * _WORDS].cast("Q")
        at += 8 * _WORDS
        self.status: memoryview[int] = self._view[at : at + 8 * _WORDS].cast("Q")
        at += 8 * _WORDS
        self._text = self._view[at : at + _TEXT]
        at += _TEXT
        self.histograms: dict[str, Histogram] = {}
        for name in HISTOGRAMS:
            words = self._view[at : at + 8 * Histogram.WORDS].cast("Q")
            self.histograms[name] = Histogram(words)
            at += 8 * Histogram.WORDS
        self.report: Ring = Ring(self._view[at : at + Ring.size(_REPORT)], _REPORT)
        at += Ring.size(_REPORT)
        self.ring: Ring = Ring(self._view[at : at + Ring.size(capacity, extra)], capacity, extra)

    @staticmethod
    def _size(config: LaneConfig) -> int:
        fixed = _HEADER.size + _CONFIG + 16 * _WORDS + _TEXT + Ring.size(_REPORT)
        counts = 8 * Histogram.WORDS * len(HISTOGRAMS)
        return fixed + counts + Ring.size(config.feeding.capacity, config.sent.extra)

    @classmethod
    def make(cls, config: LaneConfig, *, shared: bool) -> Block:
        """Make a block.

        Args:
            config: the lane's configuration.
            shared: whether another process is to open it, by its `descriptor`.
        """
        size = cls._size(config)
        if not shared:
            return cls(mmap.mmap(-1, size), config)
        descriptor = os.memfd_create("aioduco-stream", os.MFD_CLOEXEC)
        try:
            os.ftruncate(descriptor, size)
            return cls(mmap.mmap(descriptor, size), config, descriptor)
        except BaseException:
            os.close(descriptor)
            raise

    @classmethod
    def open(cls, descriptor: int) -> Block:
        """Open a block that another process made, and close its descriptor."""
        try:
            return cls(mmap.mmap(descriptor, os.fstat(descriptor).st_size))
        finally:
            os.close(descriptor)

    @property
    def text(self) -> str:
        """Why the stream ended, in words."""
        return bytes(self._text[: self.status[Status.TEXT]]).decode("utf-8", "replace")

    @text.setter
    def text(self, text: str) -> None:
        encoded = text.encode()[:_TEXT]
        self._text[: len(encoded)] = encoded
        self.status[Status.TEXT] = len(encoded)

    def close_descriptor(self) -> None:
        """Close the program's descriptor, once the lane's process has its own."""
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1

    def close(self) -> None:
        """Let go of the memory, and of what the system holds open for it."""
        self.close_descriptor()
        for histogram in self.histograms.values():
            histogram.close()
        self.ring.close()
        self.report.close()
        for view in (self.control, self.status, self._text, self._view):
            view.release()
        self._memory.close()
