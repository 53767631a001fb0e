"""Runs the package's own coroutines on an event loop whose time and events are chosen.

`Dispatcher`, `StopCoordinator`, `StopChannel`, `TaskFollower`, `LaneCall`, `Permits` and
`Gate` are those of the package. Only the lanes are scripted: they lead to the controller of
`arm.py`. A run is determined by its choices: in each turn of the loop, whether something happens
first, and what. Without choices, calls are served and answered in their order, what the program
does comes when nothing else is left to do, and time passes last. `depart` tries all runs that
depart from this up to a number of times, those with the fewest departures first.

Nothing may wait for a thread or for the clock of the wall, so a run takes a few milliseconds.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import logging
import selectors
import sys
import time
from collections import deque
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, cast
from unittest.mock import patch

import aioduco
from aioduco._wire.channel import Carrier, LaneCall
from aioduco._wire.idl import functions
from aioduco._wire.lane import WireLane
from aioduco.errors import CallTimeout, DucoError, NotSent, OutcomeUnknown, StopUnconfirmed
from aioduco.models.enums import TaskState
from aioduco.supervision.concurrency import BackgroundTasks, every
from aioduco.supervision.dispatcher import Dispatcher
from aioduco.supervision.envelope_watch import EnvelopeWatch
from aioduco.supervision.gate import Gate, PermitEnding
from aioduco.supervision.loop_watchdog import Liveness
from aioduco.supervision.permits import Permits
from aioduco.supervision.stop_channel import StopChannel
from aioduco.supervision.stop_coordinator import StopCoordinator
from aioduco.supervision.task_command import Command as WireCommand

from .arm import MODE, ArmWorld, Call, Command
from .departures import Broken, Choices
from .world import Violation

#: seconds after which a run must have ended, and turns of the loop that it may take
_LIMIT: Final = 200.0
_TURNS: Final = 3_000
#: seconds for which something is held: longer than it takes to see the arm stand
_HELD: Final = 0.1
#: those of the robots
_SETTINGS: Final = aioduco.connect(
    "192.0.2.1", heartbeat=None, loop_stall_limit=1e6, unanswered_timeout=4.0, stop_timeout=3.0
)._supervisor.settings
#: the motion that is sent by a blocking call
_BLOCKS: Final = "movel"
#: functions of the wire that move the arm, by the kinds of commands
_MOVES: Final = {
    "movej2": "motion",
    _BLOCKS: "motion",
    "resume": "resume",
    "start_realtime_mode": "mode",
}
_COMMANDS: Final = {*_MOVES, "stop", "pause", "abort", "end_realtime_mode"}


class _Selector(selectors.SelectSelector):
    """Lets the run choose what happens, where a loop asks the system."""

    turn: Callable[[float | None], None] = staticmethod(lambda _: None)

    def select(self, timeout: float | None = None) -> Any:
        self.turn(timeout)
        return []


class _Loop(asyncio.SelectorEventLoop):
    """An event loop in the time of a run."""

    def __init__(self, run: Run) -> None:
        self._run = run
        selector = _Selector()
        super().__init__(selector)
        selector.turn = run.turn

    def time(self) -> float:
        return self._run.seconds


@dataclass(slots=True, eq=False)
class _Call(LaneCall):
    """A call on a scripted lane.

    Attributes:
        call: what moves the arm by it; None for other functions.
        at: when it was sent [s].
        result: the answer, once it was served.
        served: whether the controller has carried it out.
        held_until: until when it comes only by choice, or if nothing else does [s].
        gone: whether nobody waits for the answer any more.
    """

    call: Call | None = None
    at: float = 0.0
    result: Any = None
    served: bool = False
    held_until: float = 0.0
    gone: bool = False

    @property
    def waits(self) -> bool:
        """Whether its motion has not ended, after which alone it is answered."""
        return self.name == _BLOCKS and self.call is not None and not self.call.command.state.ended

    def __str__(self) -> str:
        return self.call.command.name if self.call is not None else self.name


class _OwnerLoop:
    """The one loop."""

    in_forked_child = False

    def require(self, what: str) -> None:
        """Allow everything."""


class Lane:
    """A lane with one connection, as `WireLane` and `Channel`."""

    def __init__(self, run: Run, name: str) -> None:
        self._run = run
        self.name = name
        self.owner_loop = _OwnerLoop()
        self.call_timeout = 2.0
        self._busy: _Call | None = None
        self._waiting: deque[_Call] = deque()
        self._timers: dict[LaneCall, asyncio.TimerHandle] = {}

    async def call(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | None = 2.0,
        permit: Callable[[], object] | None = None,
    ) -> Any:
        call = self.prepare(name, args, timeout, permit)
        self.send(call)
        return await call.answer()

    def prepare(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | None = 2.0,
        permit: Callable[[], object] | None = None,
    ) -> _Call:
        run = self._run
        over, deadline = (
            run.loop.create_future(),
            None if timeout is None else run.seconds + timeout,
        )
        return _Call(
            *(functions()[name], b"", deadline, permit),
            args=args,
            over=over,
            ended=self._over,
            begun=run.seconds,
        )

    def send(self, call: _Call) -> None:
        if call.deadline is not None:
            self._timers[call] = self._run.loop.call_later(
                call.deadline - self._run.seconds, self._expire, call
            )
        self._start(call)

    def call_from_thread(self, *_: object) -> int:
        """Send a stop, which is served at once."""
        self._run.say("the controller stops")
        self._run.controller.stop()
        return 4

    def report(self, *_: object) -> None:
        """Report nothing."""

    def _start(self, call: _Call) -> None:
        if self._busy is not None:
            self._waiting.append(call)
            return
        try:
            if call.permit is not None:
                call.permit()
        except DucoError as exc:
            call.end(error=exc)
            return
        self._busy = call
        call.carrier = cast("Carrier", _Carrier())
        call.handed_over = True
        self._run.send(call)

    def _over(self, call: LaneCall) -> None:
        """Use the connection for the next call; one that was given up is reset."""
        if call in self._timers:
            self._timers.pop(call).cancel()
        if call in self._waiting:
            self._waiting.remove(cast("_Call", call))
        if self._busy is not call:
            return
        self._busy = None
        self._run.reset(call)
        if self._waiting:
            self._start(self._waiting.popleft())

    @staticmethod
    def _expire(call: _Call) -> None:
        if call.handed_over:
            call.end(error=lost(call))
        else:
            call.end(error=NotSent(f"{call.name} was not sent"))


class _Carrier:
    """Gives up a call that it carries."""

    call = None
    undelivered = 0

    def give_up(self, call: LaneCall, *_: object) -> None:
        """End a call that was abandoned."""
        call.end(error=lost(call))


def lost(call: LaneCall) -> DucoError:
    """The error of a call whose answer is lost."""
    if call.name in _COMMANDS:
        return OutcomeUnknown(call.name, "no answer came")
    return CallTimeout(f"{call.name} was not answered")


class Run(ArmWorld):
    """One run of a program, with the controller of `arm.py`.

    Args:
        choices: what happens.
        commands: what moves the arm in it.

    Attributes:
        seconds: the time.
        acts: what the program or something else may do next, by name; each once.
        watched: the tasks of the program: when all have ended, the run is over.
        breaks: how often a connection may still break.
        arrivals: how often a motion may still arrive at its target.
    """

    def __init__(self, choices: Choices, kinds: Mapping[str, str]) -> None:
        super().__init__(kinds)
        self._choices = choices
        self.seconds = 0.0
        self._wire: list[_Call] = []
        self._turns = 0
        self.acts: dict[str, Callable[[], object]] = {}
        self.watched: list[asyncio.Task[Any]] = []
        self._failed: BaseException | None = None
        self._ids: dict[int, Command] = {}
        #: whether a motion in a mode breaks the promise
        self.apart = False
        #: whether the program has ended
        self.ended = False
        self.breaks = self.arrivals = 0
        #: of what may happen now, what only defers something
        self._holds: list[Callable[[], object]] = []
        self.loop = _Loop(self)

    def check(self) -> None:
        super().check()
        mode, queue = self.controller.mode, self.controller.queue
        if self.apart and mode is not None and queue:
            raise Violation(f"{queue[0].name} runs while {mode.name} is on")

    # -- time --------------------------------------------------------------------------------------

    def time(self) -> float:
        return self.seconds

    def boot(self) -> float:
        return self.seconds

    def monotonic(self) -> float:
        return self.seconds

    # -- the loop ----------------------------------------------------------------------------------

    def turn(self, timeout: float | None) -> None:
        """Let something happen, instead of asking the system."""
        self._turns += 1
        if self._turns > _TURNS or self.seconds > _LIMIT:
            self._fail(RuntimeError("the run does not end"))
        while self._failed is None:
            events = self._events(timeout)
            if not events:
                self._fail(RuntimeError("nothing happens any more"))
                return
            number = 0
            if len(events) > 1 and not self._only_watched:
                number = self._choices.choose(len(events))
            try:
                events[number]()
                self.check()
            except Violation as exc:
                self._fail(exc)
            if events[number] not in self._holds:
                return

    @property
    def _only_watched(self) -> bool:
        """Whether all is over but that the standing arm is looked at: in whatever order."""
        return (
            self.ended
            and not (self.controller.movers or self.controller.queue or self.controller.slow)
            and not any(one.call or one.gone or one.name in _COMMANDS for one in self._wire)
        )

    def _events(self, timeout: float | None) -> list[Callable[[], object]]:
        """What may happen, first what comes without a choice."""
        self._holds = []
        if timeout == 0:  # the loop has something to do
            return [_nothing, *self._acts(), *self._answers(held=False)]
        prompt = [*self._serves(held=False), *self._answers(held=False)]
        held = [*self._serves(held=True), *self._answers(held=True)]
        events: list[Callable[[], object]] = [*prompt, *self._acts()]
        if timeout is not None:
            events.append(partial(self._pass, timeout))
        events += held
        if prompt:
            self._holds.append(partial(self._hold, prompt[0]))
        return [*events, *self._holds, *self._accidents()]

    def _hold(self, event: partial[None]) -> None:
        event.args[0].held_until = self.seconds + _HELD

    def _acts(self) -> list[Callable[[], object]]:
        found: list[Callable[[], object]] = [partial(self._act, name) for name in self.acts]
        if self.arrivals and self.controller.queue and not self.controller.paused:
            found.append(self._arrive)
        return found

    def _fail(self, error: BaseException) -> None:
        self._failed = self._failed or error
        self.loop.stop()

    def _arrive(self) -> None:
        self.arrivals -= 1
        self.do_arrive(None)

    def _pass(self, seconds: float) -> None:
        self.seconds += max(seconds, 1e-6)
        self.passed()

    def _act(self, name: str) -> None:
        self.say(name)
        self.acts.pop(name)()

    # -- the wire ----------------------------------------------------------------------------------

    def _serves(self, *, held: bool) -> list[partial[None]]:
        calls = [one for one in self._wire if not one.served and not one.gone]
        return [
            partial(self._serve, one) for one in calls if (one.held_until > self.seconds) is held
        ]

    def _answers(self, *, held: bool) -> list[partial[None]]:
        calls = [one for one in self._wire if one.served and not one.gone and not one.waits]
        return [
            partial(self._reply, one) for one in calls if (one.held_until > self.seconds) is held
        ]

    def _accidents(self) -> list[Callable[[], object]]:
        """What comes only by choice: bytes that arrive late, and connections that break."""
        late = [partial(self._serve, one) for one in self._wire if one.gone]
        breaks = [one for one in self._wire if self.breaks and not one.gone and one.call]
        return [*late, *[partial(self._break, one) for one in breaks]]

    def send(self, call: Any) -> Any:
        if isinstance(call, Command):
            return super().send(call)
        if call.name in _MOVES:
            kind = _MOVES[call.name]
            commands = [
                one
                for one in self.commands.values()
                if one.kind == kind and (kind == "resume" or one.name == call.args[0])
            ]
            try:
                call.call = super().send(commands[0])
            except Violation as exc:
                self._fail(exc)
        call.at = self.seconds
        self._wire.append(call)
        return None

    def reset(self, call: _Call) -> None:
        """Note that nobody waits for the answer of a call any more."""
        call.gone = True
        if call.call is not None and call.call.state in ("sent", "served"):
            call.call.reset(self.seconds)
        if call in self._wire and (call.served or call.call is None):
            self._wire.remove(call)

    def passed(self) -> None:
        super().passed()
        self._wire = [one for one in self._wire if one.call is None or one.call.state != "dropped"]

    def _serve(self, call: _Call) -> None:
        call.served, call.held_until = True, 0.0
        call.result = self._carry_out(call)
        if call.gone:
            self._wire.remove(call)

    def _reply(self, call: _Call) -> None:
        self._wire.remove(call)
        if call.call is not None:
            call.call.state = "answered"
            self.say(f"the answer to {call} arrives")
            if call.name == _BLOCKS:
                call.value = int(call.call.command.state)
        if call.name == "stop":
            self.stop_answered(call.at)
        self.loop.call_soon(self._settle, call)

    @staticmethod
    def _settle(call: _Call) -> None:
        call.end(call.result)

    def _break(self, call: _Call) -> None:
        self.breaks -= 1
        self.say(f"the connection of {call} breaks")
        call.end(error=lost(call))

    def _carry_out(self, call: _Call) -> Any:
        controller = self.controller
        if call.call is not None:
            late = " late" if call.gone else ""
            self.say(f"the controller gets {call}{late}, and accepts it")
            call.call.state = "dropped" if call.gone else "served"
            controller.begin(call.call.command)
            if controller.slow is not None:
                controller.set_off()
            number = 1000 + len(self._ids)
            self._ids[number] = call.call.command
            return 4 if call.call.command.kind == "mode" else number
        match call.name:
            case "stop" | "abort":
                self.say("the controller stops")
                controller.stop()
                return 4
            case "pause":
                self.say("the controller pauses")
                controller.pause()
                return 4
            case "end_realtime_mode":
                self.say("the mode is ended")
                controller.mode = None
                return 4
            case "clear_realtime_data_queue":
                return 4
            case "robotmoving":
                return controller.moving
            case "get_noneblock_taskstate":
                known = self._ids.get(call.args[0])
                return int(TaskState.FINISHED if known is None else known.state)
        return []

    # -- the program -------------------------------------------------------------------------------

    def go(self, program: Callable[[Robot], Awaitable[object]]) -> None:
        """Run a program to its end."""
        loop = self.loop

        async def main() -> None:
            robot = Robot(self)
            await program(robot)
            # the loop's time is made up: it passes at once, and nothing waits for a clock
            while self.acts or any(not task.done() for task in self.watched):  # noqa: ASYNC110
                await asyncio.sleep(0.05)
            self.ended = True
            # in that time, too: what is still on its way arrives
            await asyncio.sleep(6.0)
            await robot.background.aclose()

        asyncio.set_event_loop(loop)
        task = loop.create_task(main())
        task.add_done_callback(lambda _: loop.stop())
        try:
            loop.run_forever()
            if isinstance(self._failed, Violation):
                raise Broken(self._failed, self.words)
            if self._failed is not None:
                raise self._failed
            task.result()
        finally:
            asyncio.set_event_loop(None)
            self._abandon()

    def _abandon(self) -> None:
        """End what still runs now, since it must not go on in another run."""
        for task in asyncio.all_tasks(self.loop):
            task._log_destroy_pending = False  # type: ignore[attr-defined]
            coroutine = cast("Coroutine[Any, Any, Any]", task.get_coro())
            # it handles its end as a cancellation, and cannot wait for anything any more
            with contextlib.suppress(Exception):
                coroutine.close()
        self.loop.close()


class Robot:
    """The package's own shells, on scripted lanes."""

    def __init__(self, run: Run) -> None:
        self.run = run
        settings = _SETTINGS
        lanes = [
            cast("WireLane", Lane(run, name)) for name in ("stop", "control", "poll", "motion")
        ]
        self.calls = cast("WireLane", Lane(run, "call"))
        self.blocking = cast("WireLane", Lane(run, "blocking"))
        self.background = BackgroundTasks(self._crashed)
        self.gate = Gate(None, 1e6, 0.0, self._permits_ended)
        self.permits = Permits(self.gate)
        self.coordinator: StopCoordinator = StopCoordinator(
            StopChannel(lanes[0], lanes[1], lanes[2]),
            lanes[2],
            self.background,
            settings,
            Liveness(),
            lambda: False,
            self.permits,
        )
        self.dispatcher = Dispatcher(lanes[3], self.coordinator, settings)
        self.background.start(self.coordinator.follower.run(), "follower")
        self.background.start(self.dispatcher.note_rest(), "rest")
        self.background.start(self._live(), "keep-alive")

    async def _live(self) -> None:
        async for _ in every(0.1):
            self.dispatcher.look()

    def _permits_ended(self, ending: PermitEnding) -> None:
        self.coordinator.permits_ended(ending)

    def _crashed(self, error: BaseException) -> None:
        self.run._fail(error)

    def start(self, name: str, work: Coroutine[Any, Any, object]) -> asyncio.Task[Any]:
        """Start a task of the program; its end is waited for."""
        task = self.run.loop.create_task(work, name=name)
        self.run.watched.append(task)
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[Any]) -> None:
        if task.cancelled():
            return
        error = task.exception()
        if error is not None and not isinstance(error, DucoError):
            self.run._fail(error)

    def may(self, name: str, act: Callable[[], object]) -> None:
        """Let something happen at any time, once."""
        self.run.acts[name] = act

    # -- what a program does -----------------------------------------------------------------------

    async def awaits(self, name: str) -> None:
        """Await a motion."""
        command = self.run[name]
        self.run.ask(command)
        async with self._told(command):
            task = await self.dispatcher.launch(WireCommand("movej2", (name,)))
            outcome = await task
            if outcome.success and command.cut:
                raise Violation(f"the await of {name} returns {outcome.value}, although it stopped")

    async def blocks(self, name: str) -> None:
        """Carry out a motion by a blocking call."""
        command = self.run[name]
        self.run.ask(command)
        async with self._told(command):
            state = await self.dispatcher.block(WireCommand(_BLOCKS, (name,)), self.blocking)
            if state is TaskState.FINISHED and command.cut:
                raise Violation(f"the call of {name} returns {state.name}, although it stopped")

    async def enters(self, name: str) -> None:
        """Enter a mode, as `Section._enter`."""
        command, mode = self.run[name], ("end_realtime_mode", ())
        self.run.ask(command)
        async with self._told(command, on=True):
            await self.dispatcher.conduct(
                WireCommand("start_realtime_mode", (name,)), self.calls, 2.0, mode
            )

    @contextlib.asynccontextmanager
    async def _told(self, command: Command, *, on: bool = False) -> Any:
        try:
            yield
        except StopUnconfirmed:
            self.run.say(f"{command.name} raises StopUnconfirmed")
            raise
        except BaseException as exc:
            self._void(f"the program was told {type(exc).__name__} of {command.name}", command)
            raise
        if not on:
            self._void(f"the program was told the end of {command.name}", command)

    def _void(self, why: str, *commands: Command, before: int | None = None) -> None:
        self.run.void(why, *commands, before=before)
        try:
            self.run.check()
        except Violation as exc:
            self.run._fail(exc)

    async def stops(self) -> None:
        """Stop the arm."""
        asked = self.run.asks
        self.run.void_unsent("robot.stop() was called after it was asked for")
        await self.coordinator.stop()
        self._void("robot.stop() has returned", before=asked)

    def stops_now(self) -> None:
        """Stop the arm as a signal handler does; what is on its way is stopped by its sender.

        A mode takes longer than a motion: the event loop ends it, and tries that again.
        """
        run, asked = self.run, self.run.asks
        run.void_unsent("robot.stop_now() was called after it was asked for")
        under_way = [
            command
            for name, call in run.calls.items()
            if call.state in ("sent", "served") and not call.broken
            if (command := run.commands[name]).kind != MODE
        ]
        self.coordinator.stop_now(2.0)
        if under_way:
            soon = "robot.stop_now() returned a second ago"
            run.loop.call_later(1.0, lambda: self._void(soon, *under_way))
        why = "robot.stop_now() returned three seconds ago"
        run.loop.call_later(3.0, lambda: self._void(why, before=asked))

    async def aborts(self) -> None:
        """Abort."""
        asked = self.run.asks
        self.run.void_unsent("robot.abort() was called after it was asked for")
        await self.coordinator.abort()
        self._void("robot.abort() has returned", before=asked)

    async def pauses(self) -> None:
        """Pause."""
        with self.run.confirms():
            await self.coordinator.pause()

    async def resumes(self, name: str) -> None:
        """Resume what is paused, as `robot.resume()`; the scripted lane is told the command."""
        command = self.run[name]
        self.run.ask(command)
        async with self._told(command, on=True):
            await self.coordinator.resume()

    async def envelope(self) -> None:
        """Stop the arm at a limit of its envelope."""
        watch = object.__new__(EnvelopeWatch)
        watch._coordinator, watch._settings = self.coordinator, self.coordinator._settings
        with self.run.confirms():
            await watch._rest(DucoError(), asyncio.Event())  # type: ignore[arg-type]

    async def leaves(self) -> None:
        """Leave the robot, by the steps of `Supervisor.aclose`."""
        coordinator = self.coordinator
        self.run.void_unsent("the program has begun to leave the robot")
        self.gate.close("the robot is closed, or is being closed")
        await self.dispatcher.quiet(10.0)
        if coordinator.moving:
            await coordinator.send_stop(3.0)
            await coordinator.rest(3.0, 5.0)
        if coordinator.modes.any:
            await coordinator.leave_modes(2.0)
        self._void("the program has left the robot")


def _nothing() -> None:
    """Let the loop go on."""


@contextlib.contextmanager
def virtual_time() -> Iterator[list[Run]]:
    """Let the package read the time of the run in the list that this yields."""
    current: list[Run] = []

    def now(*_: object) -> float:
        return current[0].seconds if current else 0.0

    logging.disable(logging.CRITICAL)
    try:
        with (
            patch.object(time, "monotonic", now),
            patch.object(time, "clock_gettime", now),
            # coroutines of a run that was broken off
            patch.object(sys, "unraisablehook", lambda _: None),
        ):
            yield current
            current.clear()
            gc.collect()
    finally:
        logging.disable(logging.NOTSET)
