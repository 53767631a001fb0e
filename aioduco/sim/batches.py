"""Cycles at one go: while nobody asks, the simulation's thread sleeps past some of them.

In real time, waking up costs several times what a cycle does. Nobody sees that cycles ran later:
who asks for anything, or gives a command, first has those run that are due.
"""

from __future__ import annotations

import math
import threading
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim.clock import CycleSchedule

__all__ = ["Batches"]

#: while nobody asks for anything, at most so many cycles run at one go, and so much real time [s]
#: goes by between two of these
_CYCLES = 16
_LONGEST = 0.016
#: real time after somebody asked in which each cycle runs when it is due [s]: who asks often does
#: not wait each time until the thread is awake
_ATTENTION = 0.003
#: real time that one who asks waits at most for the cycles that are due [s]: the thread may be held
_PATIENCE = 0.02


class Batches:
    """Whether the thread may sleep past some cycles, and who waits meanwhile.

    `catch_up` is called from any thread, and all others on the simulation's.

    Args:
        pace: when cycles are due.
        wake: what wakes the thread.
        attended: whether somebody waits for one of the next cycles.

    Attributes:
        late: how late the cycle that runs began [s].
    """

    def __init__(
        self, pace: CycleSchedule, wake: threading.Event, attended: Callable[[], bool]
    ) -> None:
        self._pace = pace
        self._wake = wake
        self._attended = attended
        #: free when the cycles that are due have run; None unless the thread sleeps past some.
        #: Whoever ends a sleep waits for nobody, as at a condition.
        self._asleep: threading.Lock | None = None
        #: cycles that were due when the thread woke up, and have not run
        self._owed = 0
        #: when somebody asked last, in real time [s]
        self._asked_at = -math.inf
        self.late: float = 0.0

    @property
    def longest(self) -> float:
        """The most simulated time that the thread sleeps past [s]."""
        return _CYCLES * self._pace.cycle

    @property
    def asleep(self) -> bool:
        """Whether the thread sleeps past some cycles, or has not caught up with them."""
        return self._asleep is not None

    def catch_up(self, *, wait: bool) -> None:
        """Have the cycles run that are due: what is read next, or changed, is that of now.

        Args:
            wait: whether to wait for them; not where the caller holds what they need.
        """
        self._asked_at = time.monotonic()
        asleep = self._asleep
        if asleep is None or not wait:
            return
        self._wake.set()
        if asleep.acquire(timeout=_PATIENCE):
            asleep.release()

    def await_cycle(self, now: float) -> float | None:
        """Sleep until the next cycle is due: when it begins [s].

        None if this slept past some: what is due has to be looked at anew.

        Args:
            now: real time [s].
        """
        begun, delay = now, self._pace.delay(now)
        if delay > 0.0:
            self.end()
            if now - self._asked_at > _ATTENTION and not self._attended():
                self._sleep_past(now, delay)
                return None
            time.sleep(delay)
            begun = time.monotonic()
        if not self._owed:
            self.late = begun - now - delay
        return begun

    def _sleep_past(self, now: float, delay: float) -> None:
        until = now + min(delay + (_CYCLES - 1) * self._pace.period, max(delay, _LONGEST))
        asleep = threading.Lock()
        asleep.acquire()
        self._asleep = asleep
        # Who asked before this has a snapshot of now; who asks after it wakes this up.
        if self._wake.wait(until - now):
            self._wake.clear()
        woken = time.monotonic()
        self._owed = self._pace.due(woken)
        self.late = max(0.0, woken - until)

    def ran(self) -> None:
        """A cycle has run."""
        if self._owed:
            self._owed -= 1
        # Also if none was owed: one may have come to be due since the thread woke up.
        if not self._owed:
            self.end()

    def end(self) -> None:
        """Have those go on who wait for the cycles that are due."""
        self._owed = 0
        asleep, self._asleep = self._asleep, None
        if asleep is not None:
            asleep.release()
