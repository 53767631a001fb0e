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
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

    from aioduco.supervision.heartbeat import SignOfLife

__all__ = ["LagMonitor", "Watched", "culprit", "monitors"]

_log = logging.getLogger(__name__)

#: lines of the call stack that are kept
_DEPTH = 12


class Watched:
    """An event loop's sign of life, as one robot gives it, and who wants to hear of a stall.

    Args:
        life: the sign of life.
        limit: seconds without one after which the loop counts as blocked.
        blocked: called on the monitor's thread when the loop runs again, with how long it did
            not [s], and where it was.
    """

    def __init__(
        self, life: SignOfLife, limit: float, blocked: Callable[[float, str], None]
    ) -> None:
        self.life = life
        self.limit = limit
        self.blocked = blocked


class LagMonitor:
    """Watches the loop of one thread, for all robots on it: it is blocked for all of them alike.

    Args:
        loop_thread: identifier of the loop's thread.
    """

    def __init__(self, loop_thread: int) -> None:
        self._loop_thread = loop_thread
        self._watched: tuple[Watched, ...] = ()
        self._changed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="aioduco-lag", daemon=True)

    def add(self, watched: Watched) -> None:
        """Watch for one more."""
        first = not self._watched
        self._watched += (watched,)
        if first:
            self._thread.start()

    def remove(self, watched: Watched) -> bool:
        """Watch for one less. Returns whether nobody is left, and the thread ends."""
        self._watched = tuple(other for other in self._watched if other is not watched)
        if self._watched:
            return False
        self._changed.set()
        return True

    def join(self, timeout: float) -> bool:
        """Wait for the thread's end. Returns whether it ended."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while watched := self._watched:
            stamp = max(one.life.stamp for one in watched)
            limit = min(one.limit for one in watched)
            if self._changed.wait(max(0.0, stamp + limit - time.monotonic())):
                return
            if self._latest() != stamp:
                continue
            # Now, while it is blocked: afterwards nobody knows where it was.
            where = culprit(sys._current_frames().get(self._loop_thread))
            while self._latest() == stamp:
                if self._changed.wait(limit / 4):
                    return
            self._report(watched, self._latest() - stamp, where)

    def _latest(self) -> float:
        return max((one.life.stamp for one in self._watched), default=0.0)

    def _report(self, watched: tuple[Watched, ...], seconds: float, where: str) -> None:
        if where:
            _log.warning("the event loop was blocked for %.2f s by:\n%s", seconds, where)
        else:
            _log.warning("the event loop did not get to run for %.2f s", seconds)
        for one in watched:
            if seconds > one.limit:
                one.blocked(seconds, where)


class _Monitors:
    """The monitors of this process, one per thread with an event loop."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._by_thread: dict[int, LagMonitor] = {}

    def watch(self, watched: Watched) -> LagMonitor:
        """Watch the loop of the calling thread."""
        thread = threading.get_ident()
        with self._lock:
            monitor = self._by_thread.setdefault(thread, LagMonitor(thread))
            monitor.add(watched)
        return monitor

    def leave(self, monitor: LagMonitor, watched: Watched, timeout: float) -> None:
        """Watch no more, and wait for the thread's end if nobody is left."""
        with self._lock:
            if not monitor.remove(watched):
                return
            for thread, other in list(self._by_thread.items()):
                if other is monitor:
                    del self._by_thread[thread]
        monitor.join(timeout)


#: one per process: a loop's thread is blocked for all robots on it, and is looked at once
monitors: Final = _Monitors()


def culprit(frame: FrameType | None) -> str:
    """The call stack of a thread, its innermost calls, as Python prints it; "" if it is idle."""
    if frame is None:
        return ""
    stack = traceback.extract_stack(frame)[-_DEPTH:]
    # A loop that waits in its selector is not blocked, but starved: by the GIL or by the machine.
    if stack and stack[-1].name in {"select", "poll"}:
        return ""
    return "".join(traceback.format_list(stack))
