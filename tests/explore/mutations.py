"""Faults that the explorer must find: each safeguard removed, in a machine or its driver.

The numbers are those of what was once wrong:

1. A motion that was awaited before a stop was sent after the stop had returned.
2. A stream that was frozen and thawed moved an arm that stood.
3. Time was judged by a clock that stands while the computer sleeps.
4. Motions were sent while a stop of the package's own was being confirmed.
5. A program resumed the motion of another one and left, and the arm moved on.
6. A mode stayed on when the connection of its stream broke, and the next motion was sent in it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar
from unittest.mock import patch

from aioduco.streaming.shared.words import Reason
from aioduco.streaming.worker.permit import StreamPermit
from aioduco.streaming.worker.task_numbers import TaskNumbers
from aioduco.supervision.gate import Gate, Permit, PermitEnding
from aioduco.supervision.heartbeat import HeartbeatMachine
from aioduco.supervision.task_state import TaskLifecycle
from aioduco.supervision.unanswered import UnansweredMotion

from . import scenarios
from .arm import Command
from .program import Pending, Program, Task
from .world import Steps, World

T = TypeVar("T")


@dataclass(frozen=True)
class Mutation:
    """A mend that is taken out."""

    name: str
    owner: type
    attribute: str
    instead: Any
    scenario: Any
    depth: int = 20

    def __str__(self) -> str:
        return self.name

    def made(self) -> Any:
        """Return a context in which it is in effect."""
        return patch.object(self.owner, self.attribute, self.instead)


MUTATIONS: list[Mutation] = []


def mend(
    name: str,
    owner: type,
    attribute: str,
    scenario: Callable[[], Any],
    depth: int = 20,
    noted: list[Mutation] = MUTATIONS,
) -> Callable[[T], T]:
    """Note a mend that is taken out by the function that follows, in place of an attribute."""

    def note(instead: T) -> T:
        noted.append(Mutation(name, owner, attribute, instead, scenario, depth))
        return instead

    return note


# -- 1: a motion that was awaited before a stop is sent after it


@mend("1: a permit is asked for when it is a motion's turn", Program, "launch", scenarios.Stopped)
def _asks_at_lock(self: Program, command: Command, *, reads: bool) -> Steps[Task]:
    self.world.ask(command)
    yield from self.acquire()
    try:
        permit = self.gate.ask(command.name, self.world.boot())
        self.permits.append(permit)
        yield from self.after_stops(permit)
        self.admit(permit)
        return (yield from self.launched(command, permit))
    finally:
        self.locked = False


@mend("1: a stop ends no permits", Gate, "end", scenarios.Stopped)
def _same_epoch(self: Gate, ending: PermitEnding) -> None:
    self.stops += ending is PermitEnding.STOPPED
    self._ended(ending)


# -- 2, 3: a stream restarts an arm that stood ----------


@mend(
    "2: a worker does not ask how long it stood",
    StreamPermit,
    "look",
    scenarios.StreamWithoutHeartbeat,
)
def _never_away(self: StreamPermit, due: int = 0) -> Reason:
    self._away_limit = 10**18
    return _look(self, due)


@mend("2: a worker's permit never ends", StreamPermit, "look", scenarios.Stream)
def _asks_nothing(self: StreamPermit, due: int = 0) -> Reason:
    return Reason.NONE


_look = StreamPermit.look

for name, scenario in (
    ("3: the program's clock stands while the computer sleeps", scenarios.Frozen),
    ("3: the worker's clocks stand while the computer sleeps", scenarios.StreamSuspended),
):
    MUTATIONS.append(Mutation(name, World, "boot", World.monotonic, scenario))


# -- 4: motions are admitted while a stop is being confirmed ----------


@mend(
    "4: a stop that is being confirmed ends permits, and no more", Gate, "stop", scenarios.Envelope
)
@contextlib.contextmanager
def _ends_permits_alone(self: Gate, ending: PermitEnding = PermitEnding.STOPPED) -> Iterator[None]:
    self.end(ending)
    yield


@mend(
    "4: the stop at the envelope is no stop for the gate", Program, "envelope", scenarios.Envelope
)
def _envelope_beside_the_gate(self: Program) -> Steps[None]:
    self.world.say("the arm is about to leave its envelope")
    with self.world.confirms():
        self.gate.end(PermitEnding.ENVELOPE)
        yield from self.send_stop()
        yield from self.rest()


@mend(
    "what waited for a stop is sent though it is not confirmed",
    Gate,
    "waits",
    scenarios.Unconfirmed,
)
def _waits_for_nothing_confirmed(self: Gate, permit: Permit, now: float) -> bool:
    self._require_current(permit.name, permit)
    return bool(self._stopping)


# -- others ----------


@mend("5: what the program resumes is not its own", Gate, "resume", scenarios.Resumed)
@mend(
    "a mode is left once, although it may be entered late",
    Program,
    "enter_again",
    scenarios.ModeStopped,
    30,
)
@mend("a motion that was stopped counts as blended", TaskLifecycle, "stop_sent", scenarios.Tasks)
@mend(
    "another program's stop is not looked for",
    TaskNumbers,
    "sent",
    scenarios.StreamStoppedByAnother,
)
def _nothing(*_: object, **__: object) -> None:
    return None


@mend(
    "5: what is resumed is its own until it is first seen to stand",
    Gate,
    "seen",
    scenarios.GuardedWithoutHeartbeat,
)
def _owns_until_it_stands(self: Gate, now: float, *, standing: bool) -> None:
    self.resumed = self.resumed and not standing


@mend("the gate does not notice a lapse or a hang by itself", Gate, "look", scenarios.Frozen)
def _sees_no_lapse(self: Gate, now: float) -> None:
    return None


@mend("a hung program's heartbeat beats", HeartbeatMachine, "may_beat", scenarios.Hung)
def _always_beats(self: HeartbeatMachine, now: float, alive: float) -> bool:
    return True


@mend(
    "a lost motion is not waited for after the stop", UnansweredMotion, "_certain", scenarios.Late
)
def _without_watch(self: UnansweredMotion) -> bool:
    stood = self._stopped is not None and self._standing >= 2
    return stood and (self._answered or self._reset_at is not None)


@mend(
    "the wait for a lost motion ends without a last look", UnansweredMotion, "step", scenarios.Late
)
def _watch_without_last_look(self: UnansweredMotion, now: float) -> object:
    self._looked = now
    return _step(self, now)


_step = UnansweredMotion.step


@mend("an answer needs no further stop", UnansweredMotion, "answered", scenarios.Late)
def _answer_needs_no_stop(self: UnansweredMotion, now: float) -> None:
    self._answered = True


@mend(
    "a stop does not wait for what it may have overtaken",
    Program,
    "rest",
    scenarios.StoppedInOutage,
)
def _leaves_overtaken(self: Program, overtaken: tuple[Pending, ...] = ()) -> Steps[None]:
    return (yield from _rest(self))


_rest = Program.rest


@mend(
    "a command is forgotten before its sender has its answer",
    Program,
    "carry_out",
    scenarios.ModeLeft,
    30,
)
def _forgets_when_over(self: Program, pending: Pending) -> Steps[None]:
    try:
        return (yield from _carry_out(self, pending))
    finally:
        self.forget(pending)


_carry_out = Program.carry_out


@mend(
    "6: a mode that may be on is not left before a motion",
    Program,
    "leave_overdue",
    scenarios.StreamLost,
)
def _settles_nothing(self: Program) -> Steps[None]:
    return
    yield


@mend(
    "a command that was overtaken by a stop is left alone",
    Program,
    "overtaken",
    scenarios.StoppedNow,
)
def _never_overtaken(self: Program, permit: Permit) -> bool:
    return False


_sent = TaskNumbers.sent


@mend(
    "the first rise of the numbers is taken for the usual one",
    TaskNumbers,
    "sent",
    scenarios.StreamStoppedByAnother,
)
def _is_sure_at_once(self: TaskNumbers, task: int, now: float) -> None:
    if self._last and task - self._last == self._least:
        self._last = task
    else:
        _sent(self, task, now)
