"""An absolute schedule, and a sleep that ends close to the moment asked for."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["ProcessorShare", "Schedule", "sharpen_sleep", "sleep_until"]


class Schedule:
    """When ticks are due: at `start + k * period`, whatever happened before. Pure.

    A tick that cannot be served before the next one is due is missed: it is counted and
    skipped, never made up for by a burst.

    Args:
        period: time between two ticks [ns].
        start: when the first tick is due [ns].

    Attributes:
        due: when the current tick is due [ns].
        missed: ticks skipped so far.
    """

    __slots__ = ("due", "missed", "period")

    def __init__(self, period: int, start: int) -> None:
        if period <= 0:
            raise ValueError(f"period is {period} ns, but must be above zero")
        self.period: int = period
        self.due: int = start
        self.missed: int = 0

    def advance(self, now: int) -> int:
        """Go on to the next tick, over those for which it is too late.

        Args:
            now: the time at which the work of the current tick ended [ns].

        Returns:
            How many ticks were skipped. The new `due` lies at most one period before `now`.
        """
        self.due += self.period
        skipped = max(0, (now - self.due) // self.period)
        self.due += skipped * self.period
        self.missed += skipped
        return skipped


class ProcessorShare:
    """Whether a thread uses more than half of a processor, tenth of a second by tenth. Pure.

    Args:
        now: the time [ns].
        used: processor time that the thread has used [ns].
    """

    __slots__ = ("_since", "_used")

    #: how long it is watched before it is judged [ns]
    OVER: Final = 100_000_000

    def __init__(self, now: int, used: int) -> None:
        self._since = now
        self._used = used

    def exceeded(self, now: int, used: Callable[[], int]) -> bool:
        """Whether it did in the time that ends now, if that is long enough to judge.

        Args:
            now: the time [ns].
            used: gives the processor time that the thread has used [ns].
        """
        if now - self._since < self.OVER:
            return False
        total = used()
        most = (now - self._since) // 2
        spent, self._since, self._used = total - self._used, now, total
        return spent > most


def sleep_until(
    due: int,
    spin: int = 0,
    *,
    clock: Callable[[], int] = time.monotonic_ns,
    sleep: Callable[[float], None] = time.sleep,
) -> int:
    """Sleep until a moment of the monotonic clock.

    Args:
        due: the moment [ns].
        spin: how long before it to stop sleeping and to look at the clock instead [ns]. It
            costs that share of a processor, and buys the wake-up time of the system.
        clock: the clock.
        sleep: the sleep.

    Returns:
        The time at which it returned, never before `due` [ns].
    """
    while (rest := due - clock()) > spin:
        sleep((rest - spin) * 1e-9)
    while (now := clock()) < due:
        pass
    return now


def sharpen_sleep(thread: int) -> bool:
    """Ask the system not to round the wake-ups of a thread of this process.

    Linux delays the wake-up of ordinary threads by up to 50 µs, so that it can serve several
    at once (timer slack). A worker cannot use that.

    Args:
        thread: the system's id of the thread (`threading.get_native_id()`).

    Returns:
        Whether the system did it. If not, wake-ups are as late as everybody's.
    """
    try:
        Path(f"/proc/{thread}/timerslack_ns").write_text("1")
    except OSError:
        return False
    return True
