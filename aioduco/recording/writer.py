"""Writes a recording, on a thread of its own.

Guarantees:
- `RecordingWriter.put` neither raises nor waits, from any thread. What does not fit into the queue
  is dropped and counted.
- The thread writes what it has each `FLUSH_EVERY` seconds, as a whole chunk. A program that is
  killed leaves a file that can be read up to the last chunk.
- Whatever goes wrong with the file ends the recording alone: the reason is kept and logged, and the
  file is cut off behind its last whole chunk.
- The thread ends with the recording, and never holds up the end of the interpreter.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import threading
import time
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final

from aioduco.errors import MissingExtra
from aioduco.reporting import BackgroundLogger

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from aioduco.recording.channels import MessageChannels

__all__ = ["FLUSH_EVERY", "RecordingWriter"]

_log = BackgroundLogger(__name__)

#: seconds between two chunks; what is not in a chunk yet is lost with the process
FLUSH_EVERY: Final = 0.75
#: items that wait at most
_MOST: Final = 20_000
#: names that are tried for a file that exists
_NAMES: Final = 10_000
#: seconds for the file to be closed when the interpreter ends
_AT_EXIT: Final = 1.0


class ChunkBuffer:
    """What the library writes to: it keeps the bytes, and the thread writes them to the file."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._position = 0

    def write(self, data: bytes | bytearray) -> int:
        """Keep some bytes."""
        self._bytes += data
        self._position += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Tell the position: nothing is ever written twice."""
        if (whence, offset) not in ((0, self._position), (1, 0), (2, 0)):
            raise OSError("a recording is written from its beginning to its end")
        return self._position

    def flush(self) -> None:
        """Nothing is done here."""

    def take(self) -> bytearray:
        """What was written since the last time."""
        taken, self._bytes = self._bytes, bytearray()
        return taken


class RecordingWriter:
    """Writes one file. It may be begun once.

    Args:
        path: where to write. A file that exists is kept: a number is added to the name.
        figures: gives what the file says about the recording at its end.

    Attributes:
        path: where it is written.
        error: why it ended early; None if it did not.
        dropped: items that did not fit into the queue.
        written: items that were written.
        size: bytes that were written.
    """

    def __init__(self, path: Path, figures: Callable[[], dict[str, str]]) -> None:
        self.path: Path = path
        self.error: Exception | None = None
        self.dropped: int = 0
        self.written: int = 0
        self.size: int = 0
        self._figures = figures
        self._queue: SimpleQueue[tuple[Any, ...] | None] = SimpleQueue()
        self._buffer = ChunkBuffer()
        self._accepts = False
        self._file = -1
        self._process = os.getpid()
        self._thread: threading.Thread | None = None

    @property
    def accepts(self) -> bool:
        """Whether what is put is written."""
        return self._accepts

    def begin(
        self,
        metadata: dict[str, str],
        opened: Callable[[], None],
        ended: Callable[[], None],
    ) -> None:
        """Start the thread, which opens the file.

        Args:
            metadata: what the file says about the recording at its beginning.
            opened: called on the thread when the file is open, or `error` says why it is not.
            ended: called on the thread when it has ended, for whatever reason.
        """
        self._thread = threading.Thread(
            target=self._run,
            name="aioduco-recording",
            daemon=True,
            args=(metadata, opened, ended),
        )
        self._thread.start()

    def put(self, *item: Any) -> None:
        """Have something written: the name of a method of `MessageChannels`, and its arguments."""
        if not self._accepts:
            return
        if self._queue.qsize() >= _MOST:
            self.dropped += 1
            return
        self._queue.put(item)

    def finish(self) -> None:
        """Write what waits, and close the file; this returns at once."""
        self._accepts = False
        self._queue.put(None)

    def join(self, timeout: float) -> bool:
        """Wait until the thread has ended. Returns whether it has."""
        if self._thread is None:
            return True
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(
        self, metadata: dict[str, str], opened: Callable[[], None], ended: Callable[[], None]
    ) -> None:
        try:
            channels = self._open(metadata)
        except Exception as exc:
            self.error = exc
            opened()
            ended()
            return
        self._accepts = True
        atexit.register(self._at_exit)
        opened()
        try:
            self._write_all(channels)
        except Exception as exc:
            self._accepts = False
            self.error = exc
            _log.error("the recording %s ended early, at %d bytes: %s", self.path, self.size, exc)
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self.size)
        finally:
            self._accepts = False
            with contextlib.suppress(Exception):
                channels.close()  # after an error it cannot end the file
            with contextlib.suppress(OSError):
                os.close(self._file)
            atexit.unregister(self._at_exit)
            ended()

    def _open(self, metadata: dict[str, str]) -> MessageChannels:
        try:
            from aioduco.recording.channels import MessageChannels  # noqa: PLC0415 - an extra
        except ModuleNotFoundError as exc:
            raise MissingExtra("a recording", exc.name or "foxglove-sdk", "record") from exc
        created, self._file = _created(self.path)
        self.path = created
        try:
            channels = MessageChannels(self._buffer, metadata)
            self._flush(channels)
        except BaseException:
            os.close(self._file)
            raise
        return channels

    def _write_all(self, channels: MessageChannels) -> None:
        due = time.monotonic() + FLUSH_EVERY
        fresh = 0
        while True:
            now = time.monotonic()
            if now >= due:
                if fresh:
                    self._flush(channels)
                    fresh = 0
                due = max(due + FLUSH_EVERY, now)
            try:
                item = self._queue.get(timeout=due - now if due > now else 0.0)
            except Empty:
                continue
            if item is None:
                break
            method, *arguments = item
            getattr(channels, method)(*arguments)
            self.written += 1
            fresh += 1
        channels.metadata("aioduco.end", self._figures())
        channels.close()
        self._save()

    def _flush(self, channels: MessageChannels) -> None:
        channels.flush()
        self._save()

    def _save(self) -> None:
        data = memoryview(self._buffer.take())
        done = 0
        while done < len(data):
            done += os.write(self._file, data[done:])
        self.size += done

    def _at_exit(self) -> None:
        """The interpreter ends, and the recording was not stopped."""
        if self._process == os.getpid():
            self.finish()
            self.join(_AT_EXIT)


def _created(path: Path) -> tuple[Path, int]:
    """Make a file that was not there; one that exists is kept."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
    for number in range(_NAMES):
        tried = path if number == 0 else path.with_stem(f"{path.stem}-{number}")
        with contextlib.suppress(FileExistsError):
            return tried, os.open(tried, flags, 0o644)
    raise FileExistsError(f"{path} and {_NAMES - 1} numbered files beside it exist")
