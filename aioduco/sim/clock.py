"""Absolute schedule of the controller's cycles at a chosen speed."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from aioduco.errors import ParameterError
from aioduco.models.numpy_on_use import is_number

#: longest delay that the schedule catches up with; it drops a longer one [s of real time]
_SLACK = 0.1
#: the largest speed, but for inf
_FASTEST = 1e9


class CycleSchedule:
    """Schedule of cycles of simulated time. It reads no clock: `now` is an argument.

    Cycle n is due at start + n · cycle / speed, so the delay of one cycle never adds to the next.
    On a machine that cannot keep up, simulated time runs slower instead of falling further and
    further behind; `slipped` counts the real time that the schedule dropped.

    Args:
        cycle: simulated time of one cycle [s].
        speed: simulated seconds per real second; inf for as fast as possible.

    Attributes:
        slipped: real time that the schedule dropped [s].
        speed: the present speed.
    """

    def __init__(self, cycle: float, speed: float) -> None:
        self.slipped: float = 0.0
        self.speed: float = checked_speed(speed)
        #: simulated time of a cycle [s]
        self.cycle: float = cycle
        #: real time of a cycle [s]; 0: as fast as possible
        self.period: float = 0.0
        self._start = 0.0
        self._count = 0

    def begin(self, now: float, *, idle: bool = False) -> None:
        """Restart the schedule at `now` [s].

        "As fast as possible" has no meaning while nothing happens: such a schedule runs at the
        speed of real time while idle.
        """
        speed = 1.0 if idle and math.isinf(self.speed) else self.speed
        self.period = self.cycle / speed
        self._start = now
        self._count = 0

    def change(self, speed: float, now: float, *, idle: bool) -> None:
        """Set the speed; another speed than before restarts the schedule at `now` [s]."""
        if speed != self.speed:
            self.speed = speed
            self.begin(now, idle=idle)

    def delay(self, now: float) -> float:
        """Real time until the next cycle is due [s]; negative when it is late."""
        if not self.period:
            return 0.0
        delay = self._start + (self._count + 1) * self.period - now
        if delay < -_SLACK and delay < -self.period:
            self.slipped -= delay
            self._start -= delay
            return 0.0
        return delay

    def due(self, now: float) -> int:
        """Number of cycles that are due at `now`, where they have a period."""
        return max(0, math.floor((now - self._start) / self.period) - self._count)

    def drop(self, now: float) -> None:
        """Drop the cycles that were due before `now` [s]."""
        if now > self._start + self._count * self.period:
            self._start = now
            self._count = 0

    def ran(self, cycles: int = 1) -> None:
        """Count cycles that have run."""
        self._count += cycles


def checked_speed(speed: float) -> float:
    """Give a speed if a clock can run at it.

    Raises:
        ParameterError: The speed is no number above zero.
    """
    if not is_number(speed) or (not 0.0 < speed < _FASTEST and speed != math.inf):
        raise ParameterError("speed", speed, "a number above 0, or inf for as fast as possible")
    return float(speed)


class LoopStatistics(NamedTuple):
    """Timing of the simulated controller's cycles; times are of the last 4096 cycles [s].

    Attributes:
        cycles: number of cycles that have run.
        slipped: real time by which simulated time fell behind for good.
        late_p50, late_p99, late_max: time from the scheduled to the actual start of a cycle. The
            cycles of a batch are all scheduled at the time of the last one.
        work_p50, work_p99, work_max: duration of a cycle's work.
    """

    cycles: int
    slipped: float
    late_p50: float
    late_p99: float
    late_max: float
    work_p50: float
    work_p99: float
    work_max: float


class LoopTimes:
    """Collects the times of cycles."""

    def __init__(self) -> None:
        self.cycles: int = 0
        self._late: deque[float] = deque(maxlen=4096)
        self._work: deque[float] = deque(maxlen=4096)

    def add(self, late: float, work: float) -> None:
        """Record one cycle."""
        self.cycles += 1
        self._late.append(late)
        self._work.append(work)

    def statistics(self, slipped: float) -> LoopStatistics:
        """Percentiles of the recorded times."""
        late, work = sorted(self._late.copy()), sorted(self._work.copy())
        return LoopStatistics(self.cycles, slipped, *_percentiles(late), *_percentiles(work))


def _percentiles(times: list[float]) -> tuple[float, float, float]:
    if not times:
        return 0.0, 0.0, 0.0
    return times[len(times) // 2], times[len(times) * 99 // 100], times[-1]
