"""Finds out what blocks the event loop, and says where.

A program that computes, or sleeps, on the event loop keeps it from noticing the end of a motion,
and from sending set-points in time. Asyncio's debug mode finds that afterwards; this looks at the
loop's thread while it is blocked.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
import traceback
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

    from aioduco.supervision.heartbeat import SignOfLife

__all__ = ["LagMonitor", "culprit"]

_log = logging.getLogger(__name__)

#: lines of the call stack that are kept
_DEPTH = 12


class LagMonitor:
    """Watches the sign of life of an event loop from a thread of its own.

    Args:
        life: the loop's sign of life.
        limit: seconds without one after which the loop counts as blocked.
        blocked: called on the thread when the loop runs again, with how long it did not [s], and
            where it was.
    """

    def __init__(
        self, life: SignOfLife, limit: float, blocked: Callable[[float, str], None]
    ) -> None:
        self._life = life
        self._limit = limit
        self._blocked = blocked
        self._loop_thread = threading.get_ident()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="aioduco-lag", daemon=True)

    def start(self) -> None:
        """Begin to watch the loop of the calling thread."""
        self._loop_thread = threading.get_ident()
        self._thread.start()

    def end(self) -> None:
        """Watch no more."""
        self._ended.set()

    def join(self, timeout: float) -> bool:
        """Wait for the thread's end. Returns whether it ended."""
        if self._thread.ident is not None:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while True:
            stamp = self._life.stamp
            if self._ended.wait(max(0.0, stamp + self._limit - time.monotonic())):
                return
            if self._life.stamp != stamp:
                continue
            # Now, while it is blocked: afterwards nobody knows where it was.
            where = culprit(sys._current_frames().get(self._loop_thread))
            while self._life.stamp == stamp:
                if self._ended.wait(self._limit / 4):
                    return
            seconds = self._life.stamp - stamp
            _log.warning("the event loop was blocked for %.2f s by:\n%s", seconds, where)
            self._blocked(seconds, where)


def culprit(frame: FrameType | None) -> str:
    """The call stack of a thread, its innermost calls, as Python prints it; "" if it is idle."""
    if frame is None:
        return ""
    stack = traceback.extract_stack(frame)[-_DEPTH:]
    # A loop that waits in its selector is not blocked, but starved: by the GIL or by the machine.
    if stack and stack[-1].name in {"select", "poll"}:
        return ""
    return "".join(traceback.format_list(stack))
