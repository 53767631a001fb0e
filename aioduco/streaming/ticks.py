"""A program's own loop, on an absolute schedule."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import anyio

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

__all__ = ["Tick", "ticks"]


class Tick(NamedTuple):
    """One round of a program's own loop.

    Attributes:
        number: number of the tick, from 0.
        time: time since the first tick [s].
        dt: time since the tick before, as measured [s]; the period for the first.
        late: how late the tick is [s].
        skipped: ticks left out before this one, since the program was not ready.
    """

    number: int
    time: float
    dt: float
    late: float
    skipped: int


async def ticks(period: float, check: Callable[[], object]) -> AsyncIterator[Tick]:
    """Give a tick each period; those for which the program is not ready are left out.

    Args:
        period: time between two ticks [s].
        check: called before each; raises to end the ticks.
    """
    start = before = anyio.current_time()
    number = place = 0
    while True:
        check()
        due = start + place * period
        await anyio.sleep_until(due)
        now = anyio.current_time()
        skipped = max(0, int((now - due) / period))
        dt = now - before if number else period
        yield Tick(number, now - start, dt, now - due - skipped * period, skipped)
        before = now
        number += 1
        place += 1 + skipped
