"""Measures which stream rate this machine and the network to the arm can hold."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import anyio

from aioduco._process.platform import processors
from aioduco.models import ranges
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.report import StreamStatistics, times_table
from aioduco.streaming.shared.config import StreamSpec
from aioduco.streaming.shared.options import Feeding, WorkerOptions
from aioduco.streaming.shared.space import Limits
from aioduco.streaming.stream import Stream

if TYPE_CHECKING:
    from rich.table import Table

    from aioduco.streaming.shared.histogram import Percentiles


#: how both workers run; nothing moves, so a worker that stood still need not end
_OPTIONS = WorkerOptions(watch=0, away_limit=60.0)
#: common rates of streams [Hz]
RATES = (1000.0, 500.0, 250.0, 125.0, 60.0, 30.0)

_SECONDS = 3.0
_HELD_UP = 0.5e-3  # seconds of lateness that an idle machine never has


@dataclass(frozen=True, slots=True)
class Examination:
    """The result of a measurement. The arm was not moved.

    Attributes:
        plain: statistics of a worker under the system's default scheduling.
        urgent: the same under SCHED_FIFO; None if the system does not allow it.
        processors: number of processors that this process may use.
        governor: the system's governor of the processor's clock; empty if it is unknown.
        rate: highest of `RATES` at which 999 ticks of 1000 fit into their period [Hz]; 0: none.
        urgent_rate: the same under SCHED_FIFO [Hz]; 0: none, or not allowed.
    """

    plain: StreamStatistics
    urgent: StreamStatistics | None
    processors: int
    governor: str
    rate: float
    urgent_rate: float

    @property
    def depth(self) -> int:
        """Points of a realtime queue that bridge twice the longest measured gap, 20 to 1000."""
        longest = self.plain.lateness.max + self.plain.round_trip.max
        return min(1000, max(20, math.ceil(2 * longest / 0.001)))

    @property
    def advice(self) -> tuple[str, ...]:
        """Advice for a higher rate, one text each."""
        found: list[str] = []
        late, answered = self.plain.lateness, self.plain.round_trip
        if self.processors < 2:
            found.append(
                "one processor: a worker shares it with the program; two or more are better"
            )
        if self.governor not in ("", "performance"):
            found.append(
                f"the processor's clock is set by {self.governor!r}: under 'performance' the "
                "worker wakes up sooner"
            )
        if late.p999 > _HELD_UP:
            found.append(
                f"this machine held the worker up for {late.p999 * 1e3:.1f} ms (p99.9): end what "
                "else works on it, or give it a processor of its own, WorkerOptions(cpus=...)"
            )
        if self.urgent is None:
            found.append(
                "SCHED_FIFO is not allowed: 'ulimit -r 50', or CAP_SYS_NICE, lets a worker run "
                "before everything else where it is woken late"
            )
        elif self.urgent_rate > self.rate:
            found.append(
                f"under SCHED_FIFO {self.urgent_rate:g} Hz can be held instead of {self.rate:g} "
                "Hz: workers take it by themselves where they are woken late"
            )
        if answered.p999 > 4 * answered.p50 + 1e-3 and answered.p999 > 2 * late.p999:
            found.append(
                "the controller's answers are uneven: a cable instead of Wi-Fi, and no switch "
                "shared with cameras"
            )
        if max(self.rate, self.urgent_rate) < RATES[0]:
            found.append(
                "through the realtime queue, if the controller has one, 1000 Hz can be held: "
                f"depth={self.depth} bridges twice the longest gap that was seen"
            )
        return tuple(found)

    def __rich__(self) -> Table:
        """The table that `rich` prints."""
        rows: list[tuple[str, Percentiles]] = []
        for label, figures in (("", self.plain), (", FIFO", self.urgent)):
            if figures is not None:
                rows.append((f"lateness (machine){label}", figures.lateness))
                rows.append((f"round trip (network){label}", figures.round_trip))
        held = f"{self.rate:g} Hz can be held" if self.rate else "no rate can be held"
        table = times_table(held, rows)
        table.caption = "\n".join(f"· {line}" for line in self.advice)
        table.caption_justify = "left"
        return table


async def examine(host: str, port: int = 7003, *, seconds: float = _SECONDS) -> Examination:
    """Measure how late a worker is on this machine, and how soon the controller answers.

    A worker in a separate process reads the robot's state a thousand times a second: this costs as
    much as a stream, but does not move the arm.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        seconds: time to measure, for each of the two scheduling policies [s].

    Returns:
        The result of the measurement.

    Raises:
        ParameterError: the time is not above 0.
        StreamLost: there is no controller, or it does not answer.
    """
    seconds = ranges.TIMEOUT("seconds", seconds)
    endpoint = StreamEndpoint(host, port)
    plain = await _measure(endpoint, replace(_OPTIONS, priority=0), seconds)
    urgent = await _measure(endpoint, replace(_OPTIONS, priority=50), seconds)
    allowed = None if "priority" in urgent.unmet else urgent
    return Examination(
        plain=plain,
        urgent=allowed,
        processors=processors(),
        governor=_governor(),
        rate=holdable(plain),
        urgent_rate=0.0 if allowed is None else holdable(allowed),
    )


def holdable(figures: StreamStatistics) -> float:
    """The highest of `RATES` at which 999 ticks of 1000 fit into their period; 0: none."""
    # Skipped ticks count in the lateness, so a worker that stood still does not look good.
    needed = figures.lateness.p999 + figures.work.p999
    return next((rate for rate in RATES if needed <= 1 / rate), 0.0)


async def _measure(
    endpoint: StreamEndpoint, options: WorkerOptions, seconds: float
) -> StreamStatistics:
    sent = StreamSpec(
        name="probe", in_joints=True, limits=Limits((1.0,) * 6, (1.0,) * 6), kind="probe"
    )
    stream = Stream(endpoint, Feeding(rate=RATES[0]), options, sent, ranges.JOINTS)
    async with stream:
        await anyio.sleep(seconds)
    return stream.statistics()


def _governor() -> str:
    try:
        return Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor").read_text().strip()
    except OSError:
        return ""
