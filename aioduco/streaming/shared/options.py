"""How the program feeds a stream, and how its worker runs: values that are checked when made.

The checks are loaded when they are needed: a worker gets values that the program has checked, and
stays small without them.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args

from aioduco.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rules import Number


#: largest number of set-points in the ring
MOST_POINTS = 16384
#: largest number of actions in a chunk
MOST_ACTIONS = 1000
_LATEST = 8  # slots of a ring of which only the newest counts
_SOURCE = "this package"
_Options = TypeVar("_Options", "WorkerOptions", "Feeding")

Upsampling = Literal["none", "linear", "cubic", "ruckig"]
#: the methods of up-sampling targets to the stream's rate; "ruckig" also keeps the jerk limit
UPSAMPLING: tuple[str, ...] = get_args(Upsampling)


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkerOptions:
    """How a stream's worker runs.

    Attributes:
        run_in: "process" for a separate process, which the program cannot delay; "thread" for
            light use, or if no process can be started.
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
        watch: time between two polls whether the controller still follows [s]; 0: only after a
            task of another caller.
        away_limit: time for which the worker may not run, 0.2 to 60 [s]. After a longer one, in
            which it was frozen, the computer slept or was too busy, it sends no set-point any more,
            but stops the arm. The time for which it waits for an answer does not count.
    """

    run_in: Literal["process", "thread"] = "process"
    cpus: Sequence[int] = ()
    priority: int | None = None
    spin: float = 0.0
    timeout: float = 1.0
    connect_timeout: float = 10.0
    watch: float = 0.1
    away_limit: float = 0.25

    def __post_init__(self) -> None:
        from aioduco.models.rules import Integer, Integers, Number, stored  # noqa: PLC0415 - not in a worker
        from aioduco.models.words import one_of  # noqa: PLC0415 - not in a worker

        one_of("run_in", self.run_in, ("process", "thread"))
        cpus = Integers(Integer(0, 4095, source=_SOURCE), source=_SOURCE)
        stored(self, cpus=lambda name, given: tuple(cpus(name, given)))
        if self.priority is not None:
            stored(self, priority=Integer(0, 99, source=_SOURCE))
        pause = Number(0.0, 3600.0, "s", source=_SOURCE)
        answer = Number(0.0, 3600.0, "s", open_low=True, source=_SOURCE)
        away = Number(0.2, 60.0, "s", source=_SOURCE)
        stored(self, spin=pause, watch=pause, away_limit=away)
        stored(self, timeout=answer, connect_timeout=answer)


@dataclass(frozen=True, slots=True, kw_only=True)
class Feeding:
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

    rate: float = 500.0
    source_rate: float | None = None
    latest: bool = False
    upsample: Upsampling = "none"
    hold: float = 0.5
    ahead: int | None = None
    max_step: Sequence[float] = ()
    reach: Sequence[float] = ()
    chunks: bool = False
    blend: float = 0.1

    def __post_init__(self) -> None:
        from aioduco.models.rules import Flag, Integer, Number, stored  # noqa: PLC0415 - not in a worker
        from aioduco.models.words import one_of  # noqa: PLC0415 - not in a worker

        rate, flag = rate_rule(), Flag(source=_SOURCE)
        stored(self, rate=rate, latest=flag)
        if self.source_rate is not None:
            stored(self, source_rate=rate)
        if self.source_rate is not None and self.source_rate > self.rate:
            raise ParameterError(
                "source_rate",
                self.source_rate,
                f"above 0 and up to the stream's rate, {self.rate:g} Hz",
            )
        one_of("upsample", self.upsample, UPSAMPLING)
        if self.upsample == "ruckig" and importlib.util.find_spec("ruckig") is None:
            raise ParameterError(
                "upsample", "ruckig", 'another one, or installed: pip install "aioduco[stream]"'
            )
        if self.upsample != "none" and not self.latest and self.source_rate is None:
            raise ParameterError(
                "source_rate",
                None,
                f"given (targets per second) with upsample={self.upsample!r}; or with latest=True, "
                "only the newest target counts, and its rate is measured",
            )
        stored(self, blend=Number(0.0, 10.0, "s", source=_SOURCE), chunks=flag)
        if self.chunks:
            self._check_chunks()
        stored(self, hold=Number(0.0, 60.0, "s", open_low=True, source=_SOURCE))
        if self.ahead is not None:
            stored(self, ahead=Integer(1, MOST_POINTS, "targets", source=_SOURCE))

    def _check_chunks(self) -> None:
        if self.latest:
            raise ParameterError("latest", True, "left out: of chunks every action counts")
        if self.source_rate is None:
            raise ParameterError("source_rate", None, "given: it is the rate of the actions")
        if self.upsample not in ("cubic", "ruckig"):
            raise ParameterError("upsample", self.upsample, '"cubic" or "ruckig" for chunks')

    @property
    def interval(self) -> float | None:
        """Time between two targets [s]; None: measured."""
        if self.source_rate is not None:
            return 1 / self.source_rate
        return None if self.latest else 1 / self.rate

    @property
    def queued(self) -> int:
        """Targets that `send` queues before it waits."""
        if self.ahead is not None:
            return self.ahead
        return max(2, round(0.05 * (self.source_rate or self.rate)))

    @property
    def capacity(self) -> int:
        """Set-points that fit into the ring: four seconds of them, so that arrays fit."""
        if self.latest:
            return _LATEST
        if self.chunks:
            return 2 * MOST_ACTIONS
        wanted = round(4 * (self.source_rate or self.rate))
        return min(MOST_POINTS, max(256, wanted, 2 * self.queued))


def rate_rule() -> Number:
    """The range of a rate: above 0 to 100,000 [Hz]."""
    from aioduco.models.rules import Number  # noqa: PLC0415 - not in a worker

    return Number(0.0, 100_000.0, "Hz", open_low=True, source=_SOURCE)


def without_checks(kind: type[_Options], values: dict[str, Any]) -> _Options:
    """Make options again from values that the program has checked."""
    made = object.__new__(kind)
    for name, value in values.items():
        object.__setattr__(made, name, value)
    return made


def checked(options: WorkerOptions | None) -> WorkerOptions:
    """The options of a worker; the defaults for None.

    Raises:
        ParameterError: `options` has another type.
    """
    if options is None:
        return WorkerOptions()
    if not isinstance(options, WorkerOptions):
        raise ParameterError("options", options, "WorkerOptions, or None")
    return options
