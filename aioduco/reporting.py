"""Log messages and trace events, handed to the program's own code by a thread of their own.

Log handlers, filters, formatters and trace hooks belong to the program: they may raise, block, or
end their thread. Code that stops an arm must not run them. So a message is only queued here, with
its time, its place and its thread, and one daemon thread of the process gives it to `logging`.

Guarantees:
- Reporting raises nothing, and waits for nothing that belongs to the program.
- Messages and events come to the program in the order in which they were reported. Those that
  do not fit, since a handler is too slow, are counted, and their number is logged.
- What a handler raises is printed to stderr, as `logging` does; the next message follows.
- The thread begins with the first message, in a forked child as well, and ends when there is
  nothing to do. What is waiting is written when a robot is closed and when the interpreter ends,
  within a limit of time.
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

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import CodeType

__all__ = ["FLUSH_LIMIT", "BackgroundLogger", "Reporter", "reporter"]

#: seconds for what is waiting to be written, at the end of a robot or of the interpreter
FLUSH_LIMIT: Final = 1.0
#: messages and events that wait at most
_MOST: Final = 10_000
#: seconds without anything to do after which the thread ends
_IDLE: Final = 0.25
#: the attributes of a record about the moment and the thread in which it was made
_MOMENT: Final = (
    *("created", "msecs", "relativeCreated"),
    *("thread", "threadName", "process", "processName", "taskName"),
)


class _Flush:
    """A mark in the queue, behind everything that was reported before it.

    Args:
        written: called when that has been written.
    """

    def __init__(self, written: Callable[[], object]) -> None:
        self.written = written


class Reporter:
    """Calls the program's code on a thread of its own, one piece after another."""

    def __init__(self) -> None:
        self._renew()

    def _renew(self) -> None:
        self._process = os.getpid()
        self._queue: SimpleQueue[Callable[[], object] | _Flush] = SimpleQueue()
        # Reentrant: the garbage collector or a signal handler may report in the middle of this.
        self._lock = threading.RLock()
        self._thread: threading.Thread | None = None
        self._dropped = 0
        self._at_exit = False

    def put(self, work: Callable[[], object]) -> None:
        """Have something called, in the caller's context; from any thread, at once.

        Args:
            work: what is called; what it raises is printed.
        """
        if self._process != os.getpid():
            # In a forked child the thread, and the holders of the locks, belong to the parent.
            self._renew()
        if self._queue.qsize() >= _MOST:
            self._dropped += 1
            return
        context = copy_context()
        self._queue.put(lambda: context.run(work))
        self._begin()

    def written(self, callback: Callable[[], object]) -> bool:
        """Have a function called when everything reported so far has been written.

        Args:
            callback: called on the thread.

        Returns:
            Whether there is something to write; if not, nothing is called.
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
            Whether it was.
        """
        over = threading.Event()
        return not self.written(over.set) or over.wait(timeout)

    def _begin(self) -> None:
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                return
            if sys.is_finalizing():
                return  # no thread would ever run, and starting one would wait for it
            if not self._at_exit:
                self._at_exit = True
                atexit.register(self.flush)
            thread = threading.Thread(target=self._run, name="aioduco-reports", daemon=True)
            # If the system has no more threads, the next message tries again.
            with contextlib.suppress(RuntimeError):
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
                # Whatever it is, it is the program's, and ends nothing here.
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
            "%d messages and trace events were dropped: a log handler or a trace hook is too slow",
            dropped,
        )


def _show() -> None:
    """Print what the program's code raised, as `logging` does."""
    if logging.raiseExceptions and sys.stderr is not None:
        with contextlib.suppress(BaseException):
            traceback.print_exc()


#: one per process: so there is one order, and one thread
reporter: Final = Reporter()


class BackgroundLogger:
    """A logger that neither raises nor waits. A level that is off costs nothing.

    Args:
        name: name of the logger of `logging` that is given the messages.
    """

    def __init__(self, name: str) -> None:
        self._logger = logging.getLogger(name)

    def debug(self, message: str, *args: object) -> None:
        """Report a detail."""
        self._put(logging.DEBUG, message, args)

    def info(self, message: str, *args: object) -> None:
        """Report what goes as it should."""
        self._put(logging.INFO, message, args)

    def warning(self, message: str, *args: object, exc_info: BaseException | None = None) -> None:
        """Report what does not, and was dealt with."""
        self._put(logging.WARNING, message, args, exc_info)

    def error(self, message: str, *args: object, exc_info: BaseException | None = None) -> None:
        """Report what failed."""
        self._put(logging.ERROR, message, args, exc_info)

    def exception(self, message: str, *args: object) -> None:
        """Report what failed, with the exception that is being handled."""
        self._put(logging.ERROR, message, args, sys.exc_info()[1])

    def critical(self, message: str, *args: object) -> None:
        """Report what a person has to look at."""
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
            text = message % args if args else message
        except Exception as exc:  # an argument's own representation failed
            text = f"{message} (its values cannot be shown: {type(exc).__name__})"
        code, line = _place()
        info = None if error is None else (type(error), error, error.__traceback__)
        made = logging.LogRecord(
            logger.name, level, code.co_filename, line, text, (), info, code.co_name
        )
        reporter.put(lambda: _write(logger, made))


def _place() -> tuple[CodeType, int]:
    """Where the message comes from: what called the logger's method."""
    frame = sys._getframe(3)
    return frame.f_code, frame.f_lineno


def _write(logger: logging.Logger, made: logging.LogRecord) -> None:
    # By the program's own factory of records, which is called here and not before.
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
