"""Writes messages about a robot, on a thread of its own: to a file, or to watchers.

Guarantees:
- `MessageWriter.put` neither raises nor waits, from any thread. An item that does not fit into the
  queue is dropped and counted.
- The thread ends with the recording or publication, and does not keep the interpreter from exiting.
- Every `FLUSH_EVERY` seconds the thread writes its data to the file, as a complete chunk. If the
  program is killed, the file can be read up to the last chunk.
- An error with the file ends only the recording: the error is kept and logged, and the file is
  truncated after its last complete chunk.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import os
import threading
import time
from abc import ABC, abstractmethod
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from aioduco._process.platform import BINARY, CLOSE_ON_EXEC, PRIVATE
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.wakeup import Wakeup
from aioduco.errors import MissingExtra
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from aioduco.recording.channels import FileChannels, MessageChannels, ServerChannels


_log = BackgroundLogger(__name__)

#: seconds between two chunks; data that is not in a chunk yet is lost if the process is killed
FLUSH_EVERY: Final = 0.75
#: seconds between two polls of an empty queue
_PAUSE: Final = 0.03
#: maximum number of waiting items
_QUEUE_LIMIT: Final = 20_000
#: number of names that are tried if the file exists
_NAMES: Final = 10_000
#: seconds to wait at the end until the watchers' connections are closed
_CLOSE_WAIT: Final = 0.5
#: seconds to wait when the interpreter ends until the file is closed
_AT_EXIT: Final = 1.0

C = TypeVar("C", bound="MessageChannels")


class ChunkBuffer:
    """The library's target: it keeps the bytes until the thread writes them to the file."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._position = 0

    def write(self, data: bytes | bytearray) -> int:
        """Append some bytes."""
        self._bytes += data
        self._position += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Return the position; seeking to another one raises, since bytes are only appended."""
        if (whence, offset) not in ((0, self._position), (1, 0), (2, 0)):
            raise OSError("a recording is written from its beginning to its end")
        return self._position

    def flush(self) -> None:
        """Do nothing."""

    def take(self) -> bytearray:
        """Return the bytes that were written since the last call."""
        taken, self._bytes = self._bytes, bytearray()
        return taken


class MessageWriter(ABC, Generic[C]):
    """Writes messages to channels. It can be started once.

    Args:
        name: name of its thread.

    Attributes:
        error: why it ended early; None if it did not.
        dropped: items that did not fit into the queue.
        written: messages that were written; an item may be several, or none if nothing changed.
    """

    def __init__(self, name: str) -> None:
        self.error: Exception | None = None
        self.dropped: int = 0
        self.written: int = 0
        self._name = name
        self._queue: SimpleQueue[tuple[Any, ...] | None] = SimpleQueue()
        self._finishing = Wakeup()
        self._accepts = False
        self._process = os.getpid()
        self._thread: threading.Thread | None = None

    @property
    def accepts(self) -> bool:
        """Whether items are accepted."""
        return self._accepts

    @property
    def begun(self) -> bool:
        """Whether its thread was started."""
        return self._thread is not None

    @property
    @abstractmethod
    def target(self) -> str:
        """Description of the target, for messages."""

    def begin(
        self,
        metadata: dict[str, str],
        opened: Callable[[], None],
        ended: Callable[[], None],
    ) -> None:
        """Start the thread, which opens the target.

        Args:
            metadata: texts about the robot and the clocks, for the beginning.
            opened: called on the thread when the target is open, or has failed to open: see
                `error`.
            ended: called on the thread when the writer has ended, for whatever reason.
        """
        self._thread = threading.Thread(
            target=self._run, name=self._name, daemon=True, args=(metadata, opened, ended)
        )
        self._thread.start()

    def put(self, *item: Any) -> None:
        """Queue an item: the name of a method of `MessageChannels`, and its arguments."""
        if not self._accepts:
            return
        if self._queue.qsize() >= _QUEUE_LIMIT:
            self.dropped += 1
            return
        self._queue.put(item)

    def finish(self) -> None:
        """Write the waiting items, and end; this returns at once."""
        self._accepts = False
        self._queue.put(None)
        self._finishing.set()

    def join(self, timeout: float) -> bool:
        """Wait until the thread has ended. Returns whether it has."""
        if self._thread is None:
            return True
        self._thread.join(timeout)
        return not self._thread.is_alive()

    @abstractmethod
    def _open(self, metadata: dict[str, str]) -> C:
        """Open the target."""

    @abstractmethod
    def _save(self, channels: C) -> None:
        """Save the written items; called every `FLUSH_EVERY` seconds if there are new ones."""

    @abstractmethod
    def _end(self, channels: C) -> None:
        """End normally, after the last item."""

    @abstractmethod
    def _close(self, channels: C) -> None:
        """Close the target, after a normal end or an error."""

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
            _log.error("%s ended early: %s", self.target, exc)
        finally:
            self._accepts = False
            self._close(channels)
            atexit.unregister(self._at_exit)
            ended()

    def _write_all(self, channels: C) -> None:
        due = time.monotonic() + FLUSH_EVERY
        fresh = 0
        while True:
            now = time.monotonic()
            if now >= due:
                if fresh:
                    self._save(channels)
                    fresh = 0
                due = max(due + FLUSH_EVERY, now)
            try:
                item = self._queue.get_nowait()
            except Empty:
                # The thread polls: waking it for each item would take as long as writing the item.
                self._finishing.wait(_PAUSE)
                continue
            if item is None:
                break
            method, *arguments = item
            getattr(channels, method)(*arguments)
            self.written = channels.messages
            fresh += 1
        self._end(channels)

    def _at_exit(self) -> None:
        """End the writer if it still runs when the interpreter ends."""
        if self._process == os.getpid():
            self.finish()
            self.join(_AT_EXIT)


class RecordingWriter(MessageWriter["FileChannels"]):
    """Writes one file.

    Args:
        path: the file. An existing file is kept: a number is added to the name.
        figures: function that returns the texts for the end of the file.

    Attributes:
        path: the file that is written.
        size: number of bytes that were written.
    """

    def __init__(self, path: Path, figures: Callable[[], dict[str, str]]) -> None:
        super().__init__("aioduco-recording")
        self.path: Path = path
        self.size: int = 0
        self._figures = figures
        self._buffer = ChunkBuffer()
        self._file = -1
        #: messages in whole chunks of the file
        self._saved = 0

    @property
    def target(self) -> str:
        """The file and its size."""
        return f"the recording {self.path}, of {self.size} bytes,"

    def _open(self, metadata: dict[str, str]) -> FileChannels:
        with MissingExtra.named("a recording", "record"):
            from aioduco.recording.channels import FileChannels  # noqa: PLC0415 - an extra
        self.path, self._file = _created(self.path)
        channels: FileChannels | None = None
        try:
            channels = FileChannels(self._buffer, metadata)
            self._save(channels)
        except BaseException:
            if channels is not None:
                with contextlib.suppress(Exception):
                    channels.close()
            with contextlib.suppress(OSError):
                os.close(self._file)
            with contextlib.suppress(OSError):
                self.path.unlink()  # no message was written to it
            raise
        return channels

    def _save(self, channels: FileChannels) -> None:
        channels.flush()
        self._write_out()
        self._saved = channels.messages

    def _end(self, channels: FileChannels) -> None:
        channels.metadata("aioduco.end", self._figures())
        channels.close()
        self._write_out()

    def _close(self, channels: FileChannels) -> None:
        if self.error is not None:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self.size)
            self.written: int = self._saved
        with contextlib.suppress(Exception):
            channels.close()  # after an error this does not complete the file
        with contextlib.suppress(OSError):
            os.close(self._file)

    def _write_out(self) -> None:
        data = memoryview(self._buffer.take())
        done = 0
        while done < len(data):
            done += os.write(self._file, data[done:])
        self.size += done


class PublicationWriter(MessageWriter["ServerChannels"]):
    """Sends messages to the watchers of a WebSocket server.

    Args:
        host: address to listen on.
        port: port to listen on; 0 for a free one.

    Attributes:
        host: the address.
        port: the port; once it is open, the one that is in use.
    """

    def __init__(self, host: str, port: int) -> None:
        super().__init__("aioduco-publication")
        self.host: str = host
        self.port: int = port

    @property
    def target(self) -> str:
        """The address that it listens on."""
        return f"the publication on {host_port(self.host, self.port)}"

    def _open(self, metadata: dict[str, str]) -> ServerChannels:
        with MissingExtra.named("a publication", "record"):
            from aioduco.recording.channels import ServerChannels  # noqa: PLC0415 - an extra
        channels = ServerChannels(self.host, self.port, metadata)
        self.port = channels.port
        return channels

    def _save(self, channels: ServerChannels) -> None:
        """Do nothing: each message is sent at once."""

    def _end(self, channels: ServerChannels) -> None:
        """Do nothing: connected watchers get the messages that were sent."""

    def _close(self, channels: ServerChannels) -> None:
        # If a watcher reads nothing, the library takes a minute to close: do not wait for that.
        closing = threading.Thread(target=channels.close, name=f"{self._name}-end", daemon=True)
        closing.start()
        closing.join(_CLOSE_WAIT)


def _created(path: Path) -> tuple[Path, int]:
    """Create a new file; an existing one is kept, and a number is added to the name."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY | CLOSE_ON_EXEC
    for number in range(_NAMES):
        tried = path if number == 0 else path.with_stem(f"{path.stem}-{number}")
        with contextlib.suppress(FileExistsError):
            return tried, os.open(tried, flags, PRIVATE)
    raise FileExistsError(f"{path} and {_NAMES - 1} numbered files beside it exist")
