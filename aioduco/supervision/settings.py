"""How a robot is supervised: the times and limits given when it is opened."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

from aioduco.errors import ParameterError
from aioduco.supervision.task import OnCancel

if TYPE_CHECKING:
    from aioduco.trace import Trace

__all__ = ["ExitLadder", "GuardKind", "Settings"]

GuardKind: TypeAlias = Literal["process"]

#: seconds for a command on its way, beyond its own limit
_GRACE = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ExitLadder:
    """The rungs on the way out of `async with robot`, the first one first.

        aioduco.connect(host, exit_ladder=aioduco.ExitLadder(stop=2.0, standstill=10.0))

    Each has the seconds in which it must be done. None leaves it out: then what it is for is not
    guaranteed. Only what this program moves is stopped, and only modes that it has entered are
    ended. The last rung has no time of its own and is never left out: the heartbeat ends, the guard
    lets go of the robot, connections and threads end.

    Attributes:
        settle: commands on their way are answered. Without it, one may be accepted after the stop.
        stop: a stop is accepted. Without it, what moves goes on, until the controller misses the
            heartbeat, if there is one; it has the time of `standstill` to end by itself.
        standstill: the arm is seen to stand; a stop that has no effect is repeated. Without it,
            the arm may still move when the block has been left.
        modes: modes that a stop leaves on are ended: hand guiding, realtime mode, and, if the arm
            is seen to stand, force control. Without it, force control stays on after the program,
            and so do the others if nothing was stopped.

    Raises:
        ParameterError: a time is not above 0 s.
    """

    settle: float | None = 8.0
    stop: float | None = 5.0
    standstill: float | None = 5.0
    modes: float | None = 2.0

    def __post_init__(self) -> None:
        for rung in fields(self):
            if (seconds := getattr(self, rung.name)) is not None:
                _positive(f"exit_ladder.{rung.name}", seconds)


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Times and limits. `aioduco.connect` describes them.

    Raises:
        ParameterError: one of them is out of its range.
    """

    call_timeout: float = 2.0
    connect_timeout: float = 3.0
    pool_size: int = 4
    heartbeat: float | None = 1.0
    loop_stall_limit: float = 1.0
    on_cancel: OnCancel = "stop"
    stop_timeout: float = 5.0
    standstill_timeout: float = 5.0
    exit_ladder: ExitLadder | None = None
    guard: GuardKind | None = None
    state_rate: float = 50.0
    lag_limit: float | None = 0.25
    trace: Trace | None = None

    def __post_init__(self) -> None:
        for name in ("call_timeout", "connect_timeout", "stop_timeout", "standstill_timeout"):
            _positive(name, getattr(self, name))
        _positive("loop_stall_limit", self.loop_stall_limit)
        if not (_number(self.state_rate) and 0 < self.state_rate <= 1000):
            raise ParameterError("state_rate", self.state_rate, "a number above 0, up to 1000 Hz")
        if self.lag_limit is not None:
            _positive("lag_limit", self.lag_limit)
        if self.heartbeat is not None and not (
            _number(self.heartbeat) and 0.2 <= self.heartbeat <= 60.0
        ):
            raise ParameterError(
                "heartbeat", self.heartbeat, "a number from 0.2 to 60 s, or None for no heartbeat"
            )
        if type(self.pool_size) is not int or not 1 <= self.pool_size <= 64:
            raise ParameterError("pool_size", self.pool_size, "a whole number from 1 to 64")
        if self.exit_ladder is not None and not isinstance(self.exit_ladder, ExitLadder):
            raise ParameterError("exit_ladder", self.exit_ladder, "an ExitLadder, or None")
        if self.guard is not None and self.guard not in get_args(GuardKind):
            raise ParameterError("guard", self.guard, '"process", or None for no guard')
        if self.on_cancel not in get_args(OnCancel):
            raise ParameterError("on_cancel", self.on_cancel, '"stop", "pause" or "detach"')

    @property
    def ladder(self) -> ExitLadder:
        """The way out: as it was given, or with the times that hold for every stop."""
        if self.exit_ladder is not None:
            return self.exit_ladder
        stop, standstill = self.stop_timeout, self.standstill_timeout
        # A command on its way may have to be stopped first, if its answer is lost.
        settle = self.call_timeout + stop + standstill + _GRACE
        return ExitLadder(settle=settle, stop=stop, standstill=standstill)


def _number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _positive(name: str, value: float) -> None:
    if not (_number(value) and 0 < value < math.inf):
        raise ParameterError(name, value, "a number above 0 s")
