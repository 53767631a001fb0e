"""Log messages and trace events, passed to the program's own code on a separate thread.

Log handlers, filters, formatters and trace hooks belong to the program: they may raise, block, or
end their thread. Code that stops an arm must not run them. So this module only queues a message,
with its time, its place and its thread, and one daemon thread of the process passes it to
`logging`.

Guarantees:
- Reporting never raises, also without memory, and never waits for code of the program.
- The program gets messages and events in the order in which they were reported. If a handler is
  too slow and the queue is full, messages are dropped and counted, and their number is logged.
- An exception of a handler is printed to stderr, as `logging` does; the next message follows.
- The thread starts with the first message, in a forked child as well, and ends when the queue
  stays empty. Queued messages are written when a robot is closed and when the interpreter exits,
  within a time limit.
"""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
import sys
import threading
import traceback
from contextvars import copy_context
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final

from aioduco._process.copying import Uncopied
from aioduco._process.wakeup import Wakeup

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import CodeType

#: seconds to write the queued messages, when a robot is closed or the interpreter exits
FLUSH_LIMIT: Final = 1.0
#: maximum number of queued messages and events
_MOST: Final = 10_000
#: seconds with an empty queue after which the thread ends
_IDLE: Final = 0.25
#: attributes of a log record about its time and its thread
_MOMENT: Final = (
    *("created", "msecs", "relativeCreated"),
    *("thread", "threadName", "process", "processName", "taskName"),
)


class _Flush:
    """A marker in the queue, behind all reports before it.

    Args:
        written: called when those reports have been written.
    """

    def __init__(self, written: Callable[[], object]) -> None:
        self.written = written


class Reporter(Uncopied):
    """Calls the program's code on a separate thread, one call after another."""

    def __init__(self) -> None:
        self._renew()

    def _renew(self) -> None:
        self._process = os.getpid()
        self._queue: SimpleQueue[Callable[[], object] | _Flush] = SimpleQueue()
        # Reentrant: the garbage collector or a signal handler may report while this is held.
        self._lock = threading.RLock()
        self._thread: threading.Thread | None = None
        self._dropped = 0
        self._at_exit = False

    def put(self, work: Callable[[], object]) -> None:
        """Queue a function to be called in the caller's context; from any thread, without waiting.

        Args:
            work: the function; an exception that it raises is printed.
        """
        if self._process != os.getpid():
            # A forked child has neither this thread nor the threads that hold the locks.
            self._renew()
        if self._queue.qsize() >= _MOST:
            self._dropped += 1
            return
        try:
            context = copy_context()
            self._queue.put(lambda: context.run(work))
        except MemoryError:
            self._dropped += 1
            return
        self._begin()

    def drop(self) -> None:
        """Count a message that could not be made, since there was no memory for it."""
        self._dropped += 1

    def written(self, callback: Callable[[], object]) -> bool:
        """Have a function called when everything reported so far has been written.

        Args:
            callback: the function; it is called on the reporting thread.

        Returns:
            Whether there is something to write; if not, the function is not called.
        """
        if self._process != os.getpid() or (self._thread is None and self._queue.empty()):
            return False
        self._queue.put(_Flush(callback))
        self._begin()
        return True

    def flush(self, timeout: float = FLUSH_LIMIT) -> bool:
        """Wait until everything reported so far has been written.

        Args:
            timeout: seconds to wait.

        Returns:
            Whether it was written in time.
        """
        over = Wakeup()
        return not self.written(over.set) or over.wait(timeout)

    def _begin(self) -> None:
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                return
            if sys.is_finalizing():
                return  # a new thread would never run, and `start` would wait for it
            # If the system has no more threads or memory, the next message tries again.
            with contextlib.suppress(RuntimeError, MemoryError):
                if not self._at_exit:
                    atexit.register(self.flush)
                    self._at_exit = True
                thread = threading.Thread(target=self._run, name="aioduco-reports", daemon=True)
                thread.start()
                self._thread = thread

    def _run(self) -> None:
        while True:
            try:
                work = self._queue.get(timeout=_IDLE)
            except Empty:
                if self._over():
                    return
                continue
            if isinstance(work, _Flush):
                over = self._over()
                work.written()
                if over:
                    return
                continue
            try:
                if self._dropped:
                    self._say_dropped()
                work()
            except BaseException:
                # The error comes from the program's code: this thread continues.
                _show()
            del work

    def _over(self) -> bool:
        with self._lock:
            if self._queue.empty():
                self._thread = None
                return True
        return False

    def _say_dropped(self) -> None:
        dropped, self._dropped = self._dropped, 0
        logging.getLogger("aioduco").error(
            "%d messages and trace events were dropped: a log handler or a trace hook is too slow, "
            "or there was no memory",
            dropped,
        )


def _show() -> None:
    """Print what the program's code raised, as `logging` does."""
    if logging.raiseExceptions and sys.stderr is not None:
        with contextlib.suppress(BaseException):
            traceback.print_exc()


#: one per process, so that there is one order and one thread
reporter: Final = Reporter()


class BackgroundLogger(Uncopied):
    """A logger that neither raises nor waits. A message below the log level costs nothing.

    Args:
        name: name of the logger of `logging` that gets the messages.
    """

    def __init__(self, name: str) -> None:
        self._logger = logging.getLogger(name)

    def debug(self, message: str, *args: object) -> None:
        """Report a detail."""
        self._put(logging.DEBUG, message, args)

    def info(self, message: str, *args: object) -> None:
        """Report normal operation."""
        self._put(logging.INFO, message, args)

    def warning(self, message: str, *args: object, exc_info: BaseException | None = None) -> None:
        """Report a problem that was handled."""
        self._put(logging.WARNING, message, args, exc_info)

    def error(self, message: str, *args: object, exc_info: BaseException | None = None) -> None:
        """Report a failure."""
        self._put(logging.ERROR, message, args, exc_info)

    def exception(self, message: str, *args: object) -> None:
        """Report a failure, with the exception that is being handled."""
        self._put(logging.ERROR, message, args, sys.exc_info()[1])

    def critical(self, message: str, *args: object) -> None:
        """Report a problem that needs a person's attention."""
        self._put(logging.CRITICAL, message, args)

    def log(self, level: int, message: str, *args: object) -> None:
        """Report at any level."""
        self._put(level, message, args)

    def _put(
        self,
        level: int,
        message: str,
        args: tuple[object, ...],
        error: BaseException | None = None,
    ) -> None:
        logger = self._logger
        # Not `isEnabledFor`: it takes a lock that the program may hold.
        if logger.manager.disable >= level or logger.getEffectiveLevel() > level:
            return
        try:
            made = _record(logger, level, message, args, error)
        except MemoryError:
            reporter.drop()
            return
        reporter.put(lambda: _write(logger, made))


def _record(
    logger: logging.Logger,
    level: int,
    message: str,
    args: tuple[object, ...],
    error: BaseException | None,
) -> logging.LogRecord:
    try:
        text = message % args if args else message
    except Exception as exc:  # an argument's own representation failed
        text = f"{message} (its values cannot be shown: {type(exc).__name__})"
    code, line = _place()
    info = None if error is None else (type(error), error, error.__traceback__)
    return logging.LogRecord(
        logger.name, level, code.co_filename, line, text, (), info, code.co_name
    )


def _place() -> tuple[CodeType, int]:
    """Return the code and the line that called the logger's method."""
    frame = sys._getframe(4)
    return frame.f_code, frame.f_lineno


def _write(logger: logging.Logger, made: logging.LogRecord) -> None:
    # Made by the program's own factory of records, which must run only on this thread.
    record = logger.makeRecord(
        made.name,
        made.levelno,
        made.pathname,
        made.lineno,
        made.msg,
        (),
        made.exc_info,
        made.funcName,
    )
    for name in _MOMENT:
        if hasattr(made, name):
            setattr(record, name, getattr(made, name))
    logger.handle(record)
