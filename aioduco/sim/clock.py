"""When the next controller cycle is due: an absolute schedule at a chosen speed."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

#: real time that the schedule may fall behind before it gives up catching up [s]
_SLACK = 0.1


class CycleSchedule:
    """Schedule of cycles of simulated time, without a clock in it: `now` is an argument.

    Cycle n is due at start + n · cycle / speed, so that lateness of one never adds to the next.
    A machine that cannot keep up makes simulated time slower instead of ever more late; how much
    real time was given up is counted in `slipped`.

    Args:
        cycle: simulated time of one cycle [s].
        speed: simulated seconds in a real one; inf for as fast as possible.

    Attributes:
        slipped: real time that was given up [s].
        speed: the speed at which it goes.
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
        """Start the schedule anew at `now` [s].

        As fast as possible has no meaning while nothing happens: such a clock goes at the speed
        of real time while idle.
        """
        speed = 1.0 if idle and math.isinf(self.speed) else self.speed
        self.period = self.cycle / speed
        self._start = now
        self._count = 0

    def change(self, speed: float, now: float, *, idle: bool) -> None:
        """Go on at a speed, with a schedule anew from `now` [s] if it is another one."""
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
        """How many cycles are due at `now`."""
        if not self.period:
            return 1
        return max(0, math.floor((now - self._start) / self.period) - self._count)

    def drop(self, now: float) -> None:
        """Have nothing be due any more that was due before `now` [s]."""
        if now > self._start + self._count * self.period:
            self._start = now
            self._count = 0

    def ran(self, cycles: int = 1) -> None:
        """Count cycles that have run."""
        self._count += cycles


def checked_speed(speed: float) -> float:
    """A speed that a clock can go at.

    Raises:
        ValueError: It is not above zero.
    """
    if not speed > 0.0:
        raise ValueError(f"speed is {speed}, but must be above 0")
    return speed


class LoopStatistics(NamedTuple):
    """How well the simulated controller keeps its cycle; times of the last 4096 cycles [s].

    Attributes:
        cycles: how many have run.
        slipped: real time by which simulated time fell behind for good.
        late_p50, late_p99, late_max: from when a cycle was to begin to when it began. Where some
            run at one go, they are to begin with the last of them.
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
        """Note one cycle."""
        self.cycles += 1
        self._late.append(late)
        self._work.append(work)

    def statistics(self, slipped: float) -> LoopStatistics:
        """Percentiles of what was noted."""
        late, work = sorted(self._late.copy()), sorted(self._work.copy())
        return LoopStatistics(self.cycles, slipped, *_percentiles(late), *_percentiles(work))


def _percentiles(times: list[float]) -> tuple[float, float, float]:
    if not times:
        return 0.0, 0.0, 0.0
    return times[len(times) // 2], times[len(times) * 99 // 100], times[-1]
