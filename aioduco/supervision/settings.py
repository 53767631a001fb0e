"""How a robot is supervised: the times and limits given when it is opened."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

from aioduco.errors import ParameterError
from aioduco.supervision.task import OnCancel

if TYPE_CHECKING:
    from aioduco.trace import Trace

__all__ = ["GuardKind", "Settings"]

GuardKind: TypeAlias = Literal["process"]


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
        if self.guard is not None and self.guard not in get_args(GuardKind):
            raise ParameterError("guard", self.guard, '"process", or None for no guard')
        if self.on_cancel not in get_args(OnCancel):
            raise ParameterError("on_cancel", self.on_cancel, '"stop", "pause" or "detach"')


def _number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _positive(name: str, value: float) -> None:
    if not (_number(value) and 0 < value < math.inf):
        raise ParameterError(name, value, "a number above 0 s")
