"""The ticks of a program's loop, on an absolute schedule."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Self

import anyio

from aioduco.models.ranges import TIMEOUT

if TYPE_CHECKING:
    from collections.abc import Callable


class Tick(NamedTuple):
    """One tick of a program's loop.

    Attributes:
        number: number of the tick, from 0.
        time: time since the first tick [s].
        dt: measured time since the previous tick [s]; the period for the first tick.
        late: how late the tick is [s].
        skipped: ticks skipped before this one, because the program was not ready.
    """

    number: int
    time: float
    dt: float
    late: float
    skipped: int


class Ticks:
    """An iterator over ticks on an absolute schedule, which begins with the first tick.

    A tick for which the program is not ready in time is skipped.

    Args:
        period: time between two ticks [s].
        check: function called before each tick; it raises to end the ticks.

    Raises:
        ParameterError: the period is not above 0.
    """

    def __init__(self, period: float, check: Callable[[], object]) -> None:
        self._period = TIMEOUT("period", period)
        self._check = check
        self._start: float | None = None
        self._before = 0.0
        self._number = 0
        self._place = 0

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Tick:
        self._check()
        start = self._start = anyio.current_time() if self._start is None else self._start
        due = start + self._place * self._period
        await anyio.sleep_until(due)
        now = anyio.current_time()
        skipped = max(0, int((now - due) / self._period))
        dt = now - self._before if self._number else self._period
        late = now - due - skipped * self._period
        tick = Tick(self._number, now - start, dt, late, skipped)
        self._before = now
        self._number += 1
        self._place += 1 + skipped
        return tick
