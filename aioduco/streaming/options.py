"""The options of a stream, with checks: how the program feeds it, and how its worker runs.

The worker gets the same values without the checks (`shared.config`), because these need numpy.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models.rules import Flag, Integer, Number
from aioduco.streaming.shared.config import (
    MOST_POINTS,
    UPSAMPLING,
    FeedingSettings,
    Upsampling,
    WorkerSettings,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "Feeding",
    "FeedingOptions",
    "LaneOptions",
    "PacedOptions",
    "ServoOptions",
    "Upsampling",
    "checked",
    "per_group",
]

_FASTEST = 100_000.0

_SOURCE = "this package"
RATE = Number(0.0, _FASTEST, "Hz", open_low=True, source=_SOURCE)
_HOLD = Number(0.0, 60.0, "s", open_low=True, source=_SOURCE)
_AHEAD = Integer(1, MOST_POINTS, "targets", source=_SOURCE)
_TIME = Number(0.0, 3600.0, "s", source=_SOURCE)
_AWAY = Number(0.2, 60.0, "s", source=_SOURCE)
_ANSWER = Number(0.0, 3600.0, "s", open_low=True, source=_SOURCE)
_PRIORITY = Integer(0, 99, source=_SOURCE)
_LATEST_ONLY = Flag(source=_SOURCE)
_CHUNKS = Flag(source=_SOURCE)
_BLEND = Number(0.0, 10.0, "s", source=_SOURCE)
_LIMIT = Number(0.0, open_low=True, source=_SOURCE)


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneOptions(WorkerSettings):
    """How a stream's worker runs.

    Attributes:
        lane: "process" for a separate process, which the program cannot delay; "thread" for light
            use, or if no process can be started.
        cpus: processors that the worker may use; empty: all.
        priority: priority under SCHED_FIFO, 1 to 99, if the system allows it; 0: none. None: if the
            system allows it, a worker in a separate process takes the lowest priority by itself
            when it is woken late; it loses the priority if it works for 50 ms without a wait, or
            uses more than half of a processor.
        spin: time before each tick in which the worker polls the clock instead of sleeping [s]. It
            costs that share of a processor and removes the system's wake-up delay.
        timeout: time-out of one answer of the controller [s]; a controller that takes no point from
            a full realtime queue for so long counts as stuck.
        connect_timeout: time-out of the connection, and of the worker's start [s].
        watch: time between two polls whether the controller still follows [s]; 0: never.
        away_limit: time for which the worker may not run, 0.2 to 60 [s]. After a longer one, in
            which it was frozen, the computer slept or was too busy, it sends no set-point any more,
            but stops the arm. The time for which it waits for an answer does not count.
    """

    def __post_init__(self) -> None:
        if self.lane not in ("process", "thread"):
            raise ParameterError("lane", self.lane, '"process" or "thread"')
        if self.priority is not None:
            _PRIORITY("priority", self.priority)
        for name in ("spin", "watch"):
            _TIME(name, getattr(self, name))
        _AWAY("away_limit", self.away_limit)
        for name in ("timeout", "connect_timeout"):
            _ANSWER(name, getattr(self, name))


class FeedingOptions(TypedDict, total=False):
    """Keywords for how the program feeds a stream; `Feeding` describes them."""

    source_rate: float | None
    latest: bool
    upsample: Upsampling
    hold: float
    ahead: int | None


class PacedOptions(FeedingOptions, total=False):
    """The same keywords for streams whose rate to the controller can be chosen."""

    rate: float


class ServoOptions(PacedOptions, total=False):
    """The same keywords for streams of positions, which also take chunks of actions."""

    chunks: bool
    blend: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Feeding(FeedingSettings):
    """How the program feeds a stream, and how targets are processed.

    Attributes:
        rate: set-points sent to the controller per second [Hz].
        source_rate: targets that the program sends per second [Hz]; None: measured with `latest`,
            otherwise as many as `rate`.
        latest: whether only the newest target counts, and `send` never waits; otherwise every
            target counts, and `send` waits while enough are queued.
        upsample: how targets are up-sampled to `rate`: "none", "linear", "cubic" or "ruckig".
        hold: time without a target after which the stream ends [s].
        ahead: targets that `send` queues before it waits; None: those of 50 ms.
        max_step: largest step between two targets, per group [rad, m]; empty: not checked.
        reach: largest distance of the first target from the arm, per group [rad, m].
        chunks: whether the program sends chunks of actions by `send_chunk`, with `source_rate`
            actions per second.
        blend: time of the transition from an older chunk to a newer one [s].
    """

    def __post_init__(self) -> None:
        RATE("rate", self.rate)
        _LATEST_ONLY("latest", self.latest)
        if self.source_rate is not None and RATE("source_rate", self.source_rate) > self.rate:
            raise ParameterError(
                "source_rate",
                self.source_rate,
                f"above 0 and up to the stream's rate, {self.rate:g} Hz",
            )
        if self.upsample not in UPSAMPLING:
            raise ParameterError("upsample", self.upsample, f"one of {', '.join(UPSAMPLING)}")
        if self.upsample == "ruckig" and importlib.util.find_spec("ruckig") is None:
            raise ParameterError(
                "upsample", "ruckig", 'another one, or installed: pip install "aioduco[stream]"'
            )
        if self.upsample != "none" and not self.latest and self.source_rate is None:
            raise ParameterError(
                "source_rate", None, "given when every target counts and is up-sampled"
            )
        _BLEND("blend", self.blend)
        if _CHUNKS("chunks", self.chunks):
            self._check_chunks()
        _HOLD("hold", self.hold)
        if self.ahead is not None:
            _AHEAD("ahead", self.ahead)

    def _check_chunks(self) -> None:
        if self.latest:
            raise ParameterError("latest", True, "left out: of chunks every action counts")
        if self.source_rate is None:
            raise ParameterError("source_rate", None, "given: it is the rate of the actions")
        if self.upsample not in ("cubic", "ruckig"):
            raise ParameterError("upsample", self.upsample, '"cubic" or "ruckig" for chunks')


def per_group(name: str, value: float | Sequence[float], groups: int) -> tuple[float, ...]:
    """A limit for each group, from one number or one per group.

    Raises:
        ParameterError: the value has another shape, or is not above zero.
    """
    one: Any = value
    if isinstance(value, (list, tuple, np.ndarray)):
        if np.shape(value) != (groups,):
            raise ParameterError(name, value, f"one number, or {groups}")
        return tuple(_LIMIT(f"{name}[{group}]", each) for group, each in enumerate(value))
    return (_LIMIT(name, one),) * groups


def checked(options: LaneOptions | None) -> LaneOptions:
    """The options of a worker; the defaults for None.

    Raises:
        ParameterError: `options` has another type.
    """
    if options is None:
        return LaneOptions()
    if not isinstance(options, LaneOptions):
        raise ParameterError("options", options, "LaneOptions, or None")
    return options
