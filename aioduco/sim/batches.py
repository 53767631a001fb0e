"""Cycles in batches: while there are no requests, the simulation's thread sleeps past some cycles.

In real time, waking up costs several times as much as a cycle. Callers do not notice that cycles
ran later: before a caller reads anything or gives a command, the cycles that are due run.
"""

from __future__ import annotations

import math
import threading
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim.clock import CycleSchedule


#: while there are no requests: largest number of cycles in one batch, and longest real time between
#: two batches [s]
_CYCLES = 16
_LONGEST = 0.016
#: real time after a request in which each cycle runs when it is due [s]: a caller with frequent
#: requests does not wait each time until the thread has woken up
_ACTIVE_WINDOW = 0.003
#: longest real time that a caller waits for the cycles that are due [s]: the thread may be blocked
_WAIT_TIMEOUT = 0.02


class Batches:
    """Lets the thread sleep past some cycles, and lets callers wait until these have run.

    Any thread may call `catch_up`; only the simulation's thread may call the other methods.

    Args:
        pace: schedule of the cycles.
        wake: event that wakes the thread.
        has_waiters: whether a caller waits for one of the next cycles.

    Attributes:
        late: delay with which the running cycle began [s].
    """

    def __init__(
        self, pace: CycleSchedule, wake: threading.Event, has_waiters: Callable[[], bool]
    ) -> None:
        self._pace = pace
        self._wake = wake
        self._has_waiters = has_waiters
        #: released when the cycles that are due have run; None unless the thread sleeps past some.
        #: A condition would make the thread wait for its lock before it can wake the callers.
        self._asleep: threading.Lock | None = None
        #: number of cycles that were due when the thread woke up, and have not run yet
        self._owed = 0
        #: real time of the last request [s]
        self._asked_at = -math.inf
        self.late: float = 0.0

    @property
    def longest(self) -> float:
        """Longest simulated time that the thread sleeps past [s]."""
        return _CYCLES * self._pace.cycle

    @property
    def asleep(self) -> bool:
        """Whether the thread sleeps past some cycles, or has not yet run them."""
        return self._asleep is not None

    def catch_up(self, *, wait: bool) -> None:
        """Run the cycles that are due, so that the caller reads or changes the present state.

        Args:
            wait: whether to wait for them; False where the caller holds the lock that they need, or
                runs on the simulation's thread.
        """
        self._asked_at = time.monotonic()
        asleep = self._asleep
        if asleep is None or not wait:
            return
        self._wake.set()
        if asleep.acquire(timeout=_WAIT_TIMEOUT):
            asleep.release()

    def await_cycle(self, now: float) -> float | None:
        """Sleep until the next cycle is due, and give the time at which it begins [s].

        None if the thread slept past some cycles: the caller must check again what is due.

        Args:
            now: real time [s].
        """
        begun, delay = now, self._pace.delay(now)
        if delay > 0.0:
            self.end()
            if now - self._asked_at > _ACTIVE_WINDOW and not self._has_waiters():
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
        # A caller before this line has the present snapshot; a caller after it wakes the thread.
        if self._wake.wait(until - now):
            self._wake.clear()
        woken = time.monotonic()
        self._owed = self._pace.due(woken)
        self.late = max(0.0, woken - until)

    def ran(self) -> None:
        """Note that a cycle has run."""
        if self._owed:
            self._owed -= 1
        # Also if none was owed: a cycle may have become due since the thread woke up.
        if not self._owed:
            self.end()

    def end(self) -> None:
        """Resume the callers that wait for the cycles that are due."""
        self._owed = 0
        self.late = 0.0
        asleep, self._asleep = self._asleep, None
        if asleep is not None:
            asleep.release()
