"""An absolute schedule, and a sleep that ends close to the moment asked for."""

from __future__ import annotations

import os
import struct
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Schedule", "sharpen_sleep", "shorten_slice", "sleep_until"]

#: number of the system call sched_setattr, by machine; glibc has a name for it only from 2.41 on
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274, "riscv64": 274, "armv7l": 380}
#: size, policy, flags, nice, priority, runtime, deadline, period
_ATTRIBUTES = struct.Struct("=IIQiIQQQ")


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
        self.period = period
        self.due = start
        self.missed = 0

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
    at once (timer slack). A lane cannot use that.

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


def shorten_slice(nanoseconds: int) -> bool:
    """Ask the system to give the calling thread short slices of a processor, but soon.

    A thread that wakes up to work for a moment then goes before one that has been working for
    milliseconds, such as the program's own loop, instead of waiting for the end of its slice. It
    gets no more of the processor by this, so everybody may ask for it. Linux does it since 6.12;
    earlier ones take no notice.

    Args:
        nanoseconds: the length of a slice, 100 µs to 100 ms.

    Returns:
        Whether the system took it.
    """
    # imported here: only a lane needs it
    import ctypes  # noqa: PLC0415

    number = _SCHED_SETATTR.get(os.uname().machine)
    if number is None:
        return False
    attributes = _ATTRIBUTES.pack(
        _ATTRIBUTES.size, os.SCHED_OTHER, 0, os.nice(0), 0, nanoseconds, 0, 0
    )
    return bool(ctypes.CDLL(None).syscall(number, 0, attributes, 0) == 0)
