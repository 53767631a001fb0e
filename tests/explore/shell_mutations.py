"""What the runs of `programs.py` must find: each mend taken out of the package's own coroutines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from aioduco.supervision.dispatcher import Dispatcher
from aioduco.supervision.envelope_watch import EnvelopeWatch
from aioduco.supervision.gate import Gate, PermitEnding
from aioduco.supervision.motion_sources import Modes
from aioduco.supervision.permits import Permits
from aioduco.supervision.stop_coordinator import StopCoordinator
from aioduco.supervision.unanswered import UnansweredMotion

from . import programs
from .mutations import Mutation, _ends_permits_alone, _same_epoch, _without_watch

__all__ = ["SHELL_MUTATIONS", "ShellMutation"]


@dataclass(frozen=True)
class ShellMutation(Mutation):
    """A mend that is taken out of the coroutines.

    Attributes:
        scenario: the program in which it is found.
        depth: number of departures within which it is found.
    """

    scenario: type[programs.Program]
    depth: int = 1


async def _asks_at_lock(
    self: Dispatcher,
    command: Any,
    *,
    deadline: float | None = None,
    on_cancel: Any = None,
) -> Any:
    async with self._order:
        permit = self._asked(command)
        command = await self._prepared(command, permit)
        errors = await self._coordinator.follower.error_list()
        self._admit(command, permit)
        return await self._launch(command, permit, errors, deadline, on_cancel)


async def _rests_beside_the_gate(self: EnvelopeWatch, accepted: Any) -> None:
    settings = self._settings
    self._coordinator.gate.end(PermitEnding.ENVELOPE)
    await self._coordinator.send_stop(settings.stop_timeout)
    accepted.set()
    await self._coordinator.rest(settings.stop_timeout, settings.standstill_timeout)


async def _aborts_alone(self: StopCoordinator) -> None:
    with self.gate.stop():
        await self._controlled("abort")
        await self.standstill()


def _nothing(*_: object, **__: object) -> None:
    """Do nothing."""


async def _awaits_nothing(*_: object, **__: object) -> None:
    """Do nothing."""


def _never(*_: object, **__: object) -> bool:
    return False


SHELL_MUTATIONS = (
    ShellMutation(
        "1: a permit is asked for when it is a motion's turn",
        Dispatcher,
        "launch",
        _asks_at_lock,
        programs.Stopped,
    ),
    ShellMutation("1: a stop ends no permits", Gate, "end", _same_epoch, programs.Stopped),
    ShellMutation(
        "4: a stop that is being confirmed ends permits, and no more",
        Gate,
        "stop",
        _ends_permits_alone,
        programs.Envelope,
    ),
    ShellMutation(
        "4: the stop at the envelope is no stop for the gate",
        EnvelopeWatch,
        "_rest",
        _rests_beside_the_gate,
        programs.Envelope,
    ),
    ShellMutation(
        "5: what the program resumes is not its own", Gate, "resume", _nothing, programs.Resumed
    ),
    ShellMutation(
        "6: a mode that may be on is not left before a motion",
        Modes,
        "leave_overdue",
        _awaits_nothing,
        programs.Overdue,
    ),
    ShellMutation(
        "an abort does not wait for what it may have overtaken",
        StopCoordinator,
        "abort",
        _aborts_alone,
        programs.Aborted,
    ),
    ShellMutation(
        "a command that was overtaken by a stop is left alone",
        StopCoordinator,
        "overtaken",
        _never,
        programs.StoppedNow,
    ),
    ShellMutation(
        "a blocking call is sent when its connection is free, whatever has happened",
        Permits,
        "last_check",
        lambda *_: _nothing,
        programs.Blocked,
    ),
    ShellMutation(
        "a mode is left once, although it may be entered late",
        StopCoordinator,
        "_enter_again",
        _never,
        programs.Mode,
    ),
    ShellMutation(
        "a lost motion is not waited for after the stop",
        UnansweredMotion,
        "_certain",
        _without_watch,
        programs.Lost,
        2,
    ),
    ShellMutation(
        "a cancelled await does not stop the arm",
        StopCoordinator,
        "cancelled_while_waiting",
        _awaits_nothing,
        programs.Cancelled,
    ),
)
