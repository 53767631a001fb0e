"""What rate this machine and the network to the arm can hold: measured, not guessed."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import anyio

from aioduco.api import ranges
from aioduco.streaming.config import Sent
from aioduco.streaming.endpoint import Endpoint
from aioduco.streaming.limits import Limits
from aioduco.streaming.report import times_table
from aioduco.streaming.settings import Feeding, LaneOptions
from aioduco.streaming.stream import Stream

if TYPE_CHECKING:
    from rich.table import Table

    from aioduco.streaming.report import StreamStatistics
    from aioduco.streaming.statistics import Percentiles

__all__ = ["RATES", "Examination", "examine"]

#: rates that streams are used at [Hz]
RATES = (1000.0, 500.0, 250.0, 125.0, 60.0, 30.0)

_SECONDS = 3.0


@dataclass(frozen=True, slots=True)
class Examination:
    """What was measured. Nothing was moved.

    Attributes:
        plain: a lane's figures under the system's usual schedule.
        urgent: the same under SCHED_FIFO; None where the system does not allow it.
        processors: processors that this process may use.
        governor: how the system sets the processor's clock; empty where it does not tell.
        rate: greatest of `RATES` at which 999 ticks of 1000 fit into their period [Hz]; 0: none.
        urgent_rate: the same under SCHED_FIFO [Hz]; 0: none, or not allowed.
    """

    plain: StreamStatistics
    urgent: StreamStatistics | None
    processors: int
    governor: str
    rate: float
    urgent_rate: float

    @property
    def advice(self) -> tuple[str, ...]:
        """What would make it better, in words."""
        found: list[str] = []
        if self.processors < 2:
            found.append("one processor: a lane shares it with the program; two or more are better")
        if self.governor not in ("", "performance"):
            found.append(
                f"the processor's clock is set by {self.governor!r}: under 'performance' the "
                "lane wakes up sooner"
            )
        if self.urgent is None:
            found.append(
                "SCHED_FIFO is not allowed: 'ulimit -r 50', or CAP_SYS_NICE, lets a lane run "
                "before everything else, with LaneOptions(priority=50)"
            )
        elif self.urgent_rate > self.rate:
            found.append(
                f"with LaneOptions(priority=50) {self.urgent_rate:g} Hz can be held instead of "
                f"{self.rate:g} Hz"
            )
        if self.plain.round_trip.p999 > 4 * self.plain.round_trip.p50 + 1e-3:
            found.append(
                "the answers are uneven: a cable instead of Wi-Fi, no switch shared with cameras"
            )
        if self.rate < 125.0:
            found.append(
                "send at a low rate through the realtime queue, whose depth bridges what is late"
            )
        return tuple(found)

    def __rich__(self) -> Table:
        """The table that `rich` prints."""
        rows: list[tuple[str, Percentiles]] = []
        for label, figures in (("", self.plain), (", SCHED_FIFO", self.urgent)):
            if figures is not None:
                rows.append((f"lateness{label}", figures.lateness))
                rows.append((f"round trip{label}", figures.round_trip))
        table = times_table(f"{self.rate:g} Hz can be held", rows)
        table.caption = "\n".join(self.advice)
        return table


async def examine(host: str, port: int = 7003, *, seconds: float = _SECONDS) -> Examination:
    """Measure how late a lane is here, and how soon the controller answers it.

    It asks for the robot's state a thousand times a second, from a lane's process of its own:
    what a stream costs, without moving anything.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        seconds: how long to measure, for each way to schedule [s].

    Returns:
        What was measured.

    Raises:
        StreamLost: there is no controller, or it does not answer.
    """
    endpoint = Endpoint(host, port)
    plain = await _measure(endpoint, LaneOptions(watch=0), seconds)
    urgent = await _measure(endpoint, LaneOptions(watch=0, priority=50), seconds)
    allowed = None if "priority" in urgent.unmet else urgent
    return Examination(
        plain=plain,
        urgent=allowed,
        processors=len(os.sched_getaffinity(0)),
        governor=_governor(),
        rate=holdable(plain),
        urgent_rate=0.0 if allowed is None else holdable(allowed),
    )


def holdable(figures: StreamStatistics) -> float:
    """The greatest of `RATES` at which 999 ticks of 1000 fit into their period; 0: none."""
    # A tick that was skipped counts in the lateness, so a lane that stood still is not flattered.
    needed = figures.lateness.p999 + figures.work.p999
    return next((rate for rate in RATES if needed <= 1 / rate), 0.0)


async def _measure(endpoint: Endpoint, options: LaneOptions, seconds: float) -> StreamStatistics:
    sent = Sent(name="probe", in_joints=True, limits=Limits((1.0,) * 6, (1.0,) * 6), drive=None)
    stream = Stream(endpoint, Feeding(rate=RATES[0]), options, sent, ranges.JOINTS)
    async with stream:
        await anyio.sleep(seconds)
    return stream.statistics()


def _governor() -> str:
    try:
        return Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor").read_text().strip()
    except OSError:
        return ""
