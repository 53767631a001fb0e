"""An absolute schedule, and a sleep that ends close to the requested time."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable


class Schedule:
    """When ticks are due: at `start + k * period`, however late earlier ticks were. Pure.

    A tick that cannot run before the next one is due is missed: it is counted and skipped, and
    never made up for by a burst.

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
        """Advance to the next tick, and skip those for which it is too late.

        Args:
            now: the time at which the work of the current tick ended [ns].

        Returns:
            Number of skipped ticks. The new `due` is less than one period before `now`.
        """
        self.due += self.period
        skipped = max(0, (now - self.due) // self.period)
        self.due += skipped * self.period
        self.missed += skipped
        return skipped


class ProcessorShare:
    """Whether a thread uses more than half of a processor, checked per 0.1 s. Pure.

    Args:
        now: the time [ns].
        used: processor time that the thread has used [ns].
    """

    __slots__ = ("_since", "_used")

    #: shortest time over which the use is measured [ns]
    OVER: Final = 100_000_000

    def __init__(self, now: int, used: int) -> None:
        self._since = now
        self._used = used

    def exceeded(self, now: int, used: Callable[[], int]) -> bool:
        """Whether the thread did so since the last measurement; False if that was too recent.

        Args:
            now: the time [ns].
            used: returns the processor time that the thread has used [ns].
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
    """Sleep until a time of the monotonic clock.

    Args:
        due: the time [ns].
        spin: how long before `due` to stop sleeping and poll the clock instead [ns]. It costs that
            share of a processor, and avoids the wake-up delay of the system.
        clock: the clock.
        sleep: the sleep function.

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

    Linux delays the wake-up of ordinary threads by up to 50 µs, so that it can wake several threads
    at once (timer slack). A worker needs exact wake-ups instead.

    Args:
        thread: the system's id of the thread (`threading.get_native_id()`).

    Returns:
        Whether the system did it. If not, the thread wakes up as late as ordinary threads.
    """
    try:
        Path(f"/proc/{thread}/timerslack_ns").write_text("1")
    except OSError:
        return False
    return True
