"""Settings of the supervision: the times and limits given when a robot is opened."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from aioduco.errors import ParameterError
from aioduco.models.controller_clock import Clock
from aioduco.models.ranges import FILE, STATE_RATE, TIMEOUT
from aioduco.models.rules import LONGEST, Integer, Number
from aioduco.models.trace import guarded
from aioduco.models.words import one_of
from aioduco.supervision.task import OnCancel

if TYPE_CHECKING:
    from collections.abc import Callable
    from os import PathLike

    from aioduco.models.trace import Trace


GuardKind: TypeAlias = Literal["process"]

#: seconds for a command on its way, beyond its own limit
_GRACE = 1.0

_SOURCE = "this package"
_POOL_SIZE = Integer(1, 64, source=_SOURCE)
_HEARTBEAT = Number(0.2, 60.0, "s", source="1.3.1")
_STALL = Number(0.05, LONGEST, "s", source=_SOURCE)
_LAG = Number(0.01, LONGEST, "s", source=_SOURCE)
_LAG.expected += ", or None for no warnings"
_HEARTBEAT.expected += ", or None for no heartbeat"


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosingSteps:
    """The steps when `async with robot` is left, in their order.

        aioduco.connect(host, closing_steps=aioduco.ClosingSteps(stop=2.0, standstill=10.0))

    Each step has a time limit [s]. None skips the step: its effect is then not guaranteed. Only
    motions of this program are stopped, and only modes that it has entered are ended. The last step
    has no time limit of its own and is never skipped: the heartbeat ends, the guard releases the
    robot, connections and threads end.

    If the last set-point of a stream was not answered, leaving the stream's block, or the step
    `stop` if that was not left, lasts until the set-point cannot move the arm any more: up to the
    `unanswered_timeout` of `connect`, some seconds to stand, and `stop_timeout`.

    Attributes:
        answers: time to wait for the answers of commands on their way [s]. Without it, a command
            may be accepted after the stop.
        stop: time for a stop to be accepted [s]. Without it, a motion continues until the
            controller misses the heartbeat, if there is one; the motion has the time of
            `standstill` to end by itself.
        standstill: time for the arm to stand [s]; a stop that has no effect is repeated. Without
            it, the arm may still move when the block has been left. Also the longest wait for a
            stop, a pause or an abort that another task of the program has asked for.
        modes: time to end modes that a stop leaves on [s]: hand guiding, realtime mode, and, if
            the arm stands, force control; and to empty a track pool into which this program has
            put points. Without it, force control stays on after the program, and so do the other
            modes and the points if nothing was stopped.

    Raises:
        ParameterError: a time is not above 0 s.
    """

    answers: float | None = 8.0
    stop: float | None = 5.0
    standstill: float | None = 5.0
    modes: float | None = 2.0

    def __post_init__(self) -> None:
        for step in fields(self):
            if (seconds := getattr(self, step.name)) is not None:
                seconds = TIMEOUT(f"closing_steps.{step.name}", seconds)
                object.__setattr__(self, step.name, seconds)


def _within(rule: Callable[[str, Any], object], *, off: bool = False) -> dict[str, Any]:
    """Say the range of a setting, and whether it may be None besides."""
    return {"rule": rule, "off": off}


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSettings:
    """Times and limits. `aioduco.connect` describes them, and has their defaults.

    Raises:
        ParameterError: one of them is out of its range.
    """

    call_timeout: float = field(metadata=_within(TIMEOUT))
    connect_timeout: float = field(metadata=_within(TIMEOUT))
    pool_size: int = field(metadata=_within(_POOL_SIZE))
    heartbeat: float | None = field(metadata=_within(_HEARTBEAT, off=True))
    loop_stall_limit: float = field(metadata=_within(_STALL))
    on_cancel: OnCancel
    stop_timeout: float = field(metadata=_within(TIMEOUT))
    standstill_timeout: float = field(metadata=_within(TIMEOUT))
    unanswered_timeout: float = field(metadata=_within(TIMEOUT))
    closing_steps: ClosingSteps | None
    guard: GuardKind | None
    state_rate: float = field(metadata=_within(STATE_RATE))
    lag_limit: float | None = field(metadata=_within(_LAG, off=True))
    trace: Trace | None
    record: str | PathLike[str] | None
    clock: Clock

    def __post_init__(self) -> None:
        for setting in fields(self):
            value, rule = getattr(self, setting.name), setting.metadata.get("rule")
            if rule is not None and not (value is None and setting.metadata["off"]):
                object.__setattr__(self, setting.name, rule(setting.name, value))
        if self.closing_steps is not None and not isinstance(self.closing_steps, ClosingSteps):
            raise ParameterError("closing_steps", self.closing_steps, "ClosingSteps, or None")
        if self.guard is not None:
            one_of("guard", self.guard, get_args(GuardKind), besides="None for no guard")
        if self.record is not None:
            FILE("record", self.record)
        if not isinstance(self.clock, Clock):
            raise ParameterError("clock", self.clock, "a Clock, such as Simulator.clock, or None")
        if self.trace is not None:
            if not callable(self.trace):
                raise ParameterError("trace", self.trace, "a function of an event, or None")
            object.__setattr__(self, "trace", guarded(self.trace))
        one_of("on_cancel", self.on_cancel, get_args(OnCancel))

    @property
    def steps(self) -> ClosingSteps:
        """The closing steps: as they were given, or with the time limits of every stop."""
        if self.closing_steps is not None:
            return self.closing_steps
        stop, standstill = self.stop_timeout, self.standstill_timeout
        # A command on its way may have to be stopped first, if its answer is lost.
        answers = self.call_timeout + self.unanswered_timeout + stop + standstill + _GRACE
        return ClosingSteps(answers=answers, stop=stop, standstill=standstill)
