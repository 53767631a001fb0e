"""Faults that the runs of `programs.py` must find: safeguards removed from the coroutines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from aioduco.supervision.dispatcher import Dispatcher
from aioduco.supervision.envelope_watch import EnvelopeWatch
from aioduco.supervision.gate import Gate, PermitEnding
from aioduco.supervision.motion_sources import Modes
from aioduco.supervision.permits import Permits
from aioduco.supervision.stop_coordinator import StopCoordinator
from aioduco.supervision.unanswered import UnansweredMotion

from . import mutations, programs
from .mutations import Mutation, _ends_permits_alone, _same_epoch, _without_watch

T = TypeVar("T")

SHELL_MUTATIONS: list[Mutation] = []


def mend(
    name: str, owner: type, attribute: str, scenario: type[programs.Program], depth: int = 1
) -> Callable[[T], T]:
    """Note a mend that is taken out of the coroutines; `depth` is a number of departures."""
    return mutations.mend(name, owner, attribute, scenario, depth, SHELL_MUTATIONS)


mend("1: a stop ends no permits", Gate, "end", programs.Stopped)(_same_epoch)
mend(
    "4: a stop that is being confirmed ends permits, and no more", Gate, "stop", programs.Envelope
)(_ends_permits_alone)
mend("a mode is not noted when it is entered", Modes, "enter", programs.Mode)(lambda *_: False)
mend(
    "a lost motion is not waited for after the stop", UnansweredMotion, "_certain", programs.Lost, 2
)(_without_watch)


@mend("1: a permit is asked for when it is a motion's turn", Dispatcher, "launch", programs.Stopped)
async def _asks_at_lock(
    self: Dispatcher, command: Any, *, deadline: float | None = None, on_cancel: Any = None
) -> Any:
    async with self._order:
        permit = self._asked(command)
        command = await self._prepared(command, permit)
        errors = await self._coordinator.follower.error_list()
        self._admit(command, permit)
        return await self._launch(command, permit, errors, deadline, on_cancel)


@mend(
    "4: the stop at the envelope is no stop for the gate", EnvelopeWatch, "_rest", programs.Envelope
)
async def _rests_beside_the_gate(self: EnvelopeWatch, why: Any, accepted: Any) -> None:
    settings = self._settings
    self._coordinator.gate.end(PermitEnding.ENVELOPE)
    await self._coordinator.send_stop(settings.stop_timeout)
    accepted.set()
    await self._coordinator.rest(settings.stop_timeout, settings.standstill_timeout)


@mend(
    "an abort does not wait for what it may have overtaken",
    StopCoordinator,
    "abort",
    programs.Aborted,
)
async def _aborts_alone(self: StopCoordinator) -> None:
    with self.gate.stop():
        await self._controlled("abort")
        await self.standstill()


@mend("5: what the program resumes is not its own", Gate, "resume", programs.Resumed)
def _nothing(*_: object, **__: object) -> None:
    """Do nothing."""


@mend(
    "6: a mode that may be on is not left before a motion", Modes, "leave_overdue", programs.Overdue
)
@mend(
    "a cancelled await does not stop the arm",
    StopCoordinator,
    "cancelled_while_waiting",
    programs.Cancelled,
)
async def _awaits_nothing(*_: object, **__: object) -> None:
    """Do nothing."""


@mend(
    "a command that was overtaken by a stop is left alone",
    StopCoordinator,
    "overtaken",
    programs.StoppedNow,
    depth=2,
)
@mend(
    "a mode is left once, although it may be entered late",
    StopCoordinator,
    "_enter_again",
    programs.Mode,
)
def _never(*_: object, **__: object) -> bool:
    return False


@mend(
    "a blocking call is sent when its connection is free, whatever has happened",
    Permits,
    "last_check",
    programs.Blocked,
)
def _checks_nothing(*_: object) -> Callable[..., None]:
    return _nothing
