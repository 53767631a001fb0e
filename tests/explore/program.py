"""The program's side for the explorer: the machines of the package, and what drives them.

`Program` mirrors what the coroutines of `supervision.dispatcher`, `supervision.stop_coordinator`,
`supervision.rest`, `supervision.task_follower` and `supervision.supervisor` do between two
awaits: each `yield` is one of their awaits. The decisions are those of the package: `Gate`,
`UnansweredMotion`, `TaskLifecycle`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Final, TypeVar

from aioduco.errors import (
    DucoError,
    NotSent,
    OutcomeUnknown,
    Refused,
    RobotStateError,
    StopUnconfirmed,
)
from aioduco.models.enums import Outcome
from aioduco.supervision.gate import Gate, Permit, PermitEnding
from aioduco.supervision.task_state import TaskLifecycle
from aioduco.supervision.unanswered import NextStep, UnansweredMotion

from .arm import MODE, ArmWorld, Call, Command
from .world import TICK, Cancelled, Named, Steps, Violation, World, canonical

T = TypeVar("T")

#: ticks for an answer, for a late one after that, for a stop, and for a standstill
CALL: Final = 1
LATE: Final = 2
STOP: Final = 3
STAND: Final = 3
#: seconds of the heartbeat and of the stall limit
HEARTBEAT: Final = 1.0
STALL: Final = 1.0


class Pending(Named):
    """A command on its way: `_wire.channel.LaneCall`."""

    __slots__ = ("answered", "at", "call", "command", "error", "given_up", "over", "permit")

    def __init__(self, command: Command, permit: Permit) -> None:
        super().__init__(command.name)
        self.command = command
        self.permit = permit
        self.call: Call | None = None
        self.error: DucoError | None = None
        self.over = self.answered = self.given_up = False
        self.at = 0.0

    def key(self, world: World) -> object:
        at = world.ago(self.at, world.monotonic()) if self.over else None
        return self.over, self.answered, self.given_up, at, type(self.error).__name__

    @property
    def settled(self) -> bool:
        """Whether the wait for its answer ends."""
        call = self.call
        return self.given_up or call is None or call.broken or call.state == "answered"


class Task(Named):
    """A task that is followed."""

    __slots__ = ("command", "done", "life", "stops")

    def __init__(self, command: Command, stops: int) -> None:
        super().__init__(command.name)
        self.command = command
        self.life = TaskLifecycle(blends=command.blends)
        self.stops = stops
        self.done = False


def to_completion(step: Callable[[], Steps[T]]) -> Steps[tuple[T, Cancelled | None]]:
    """`supervision.concurrency.run_to_completion`."""
    cancelled: Cancelled | None = None
    while True:
        try:
            return (yield from step()), cancelled
        except Cancelled as exc:
            cancelled = exc


class Program:
    """One program with one robot."""

    polls = False

    def __init__(self, world: ArmWorld, heartbeat: float | None = None) -> None:
        self.world = world
        self.gate = Gate(heartbeat, STALL, world.boot(), self.ended)
        self.locked = False
        self.pending: list[Pending] = []
        self.sent: list[Pending] = []
        self.tasks: list[Task] = []
        self.last: Task | None = None
        self.modes: list[Command] = []
        self.overdue: list[Command] = []
        self.unfollowed = False
        self.permits: list[Permit] = []

    def ended(self, ending: PermitEnding) -> None:
        """`StopCoordinator.permits_ended`: what sends by itself is told."""

    def key(self) -> object:
        return (
            canonical(self.gate, self.world),
            self.locked,
            self.unfollowed,
            *[(permit.name, permit.epoch.ending, permit.stops) for permit in self.permits],
            *[canonical(task.life, self.world) for task in self.tasks],
            *sorted(each.name for each in self.pending),
            *[each.key(self.world) for each in sorted(self.sent, key=lambda one: one.name)],
            *[(task.name, task.done) for task in self.tasks],
            *[mode.name for mode in self.modes],
            *[mode.name for mode in self.overdue],
        )

    @property
    def busy(self) -> bool:
        """`StopCoordinator.busy`."""
        return self.unfollowed or bool(self.modes or self.pending or self.tasks)

    @property
    def moving(self) -> bool:
        """`StopCoordinator.moving`."""
        return self.gate.resumed or self.busy

    # -- calls whose answers come for certain, if the network works ------------------------------

    def up(self) -> Steps[None]:
        """Wait until the network carries something."""
        yield (lambda: not self.world.down) if self.world.down else None

    def call_stop(self) -> Steps[None]:
        """`StopChannel.stop`."""
        world = self.world
        sent, until = world.time(), world.now + STOP
        yield lambda: not world.down or world.now >= until
        if world.down:
            raise StopUnconfirmed("no stop was accepted")
        world.say("the controller stops")
        world.controller.stop()
        yield lambda: not world.down or world.now >= until
        if world.down:
            raise StopUnconfirmed("no stop was accepted")
        world.stop_answered(sent)

    def look(self) -> Steps[bool | None]:
        """Ask whether the arm moves; None if no answer comes."""
        return (yield from self.looks(1))

    def looks(self, times: int) -> Steps[bool | None]:
        """Ask whether the arm moves, until it does, but `times` times at most."""
        world = self.world
        until = world.now + 1
        yield lambda: not world.down or world.now >= until
        moving = False
        for _ in range(times):
            if not moving and not world.down:
                moving = world.controller.moving
                yield lambda: not world.down or world.now >= until
        return None if world.down else moving

    def still(self, until: int) -> Steps[bool]:
        """`StopChannel.standstill`: whether the arm was seen to stand."""
        world = self.world
        while True:
            over = world.now >= until
            moving = yield from self.looks(2)
            if moving is False:
                return True
            if over:
                return False
            if moving:
                yield lambda: not world.controller.moving or world.now >= until

    def standstill(self) -> Steps[None]:
        if not (yield from self.still(self.world.now + STAND)):
            raise StopUnconfirmed("the arm still moves")

    # -- the dispatcher ------------------------------------------------------------------------

    def acquire(self) -> Steps[None]:
        yield lambda: not self.locked
        self.locked = True

    def after_stops(self, permit: Permit) -> Steps[None]:
        """`Permits.after_stops`."""
        gate = self.gate
        if gate.stopping:
            while gate.waits(permit, self.world.boot()):
                yield lambda: not gate.stopping or gate.ending(permit) is not None

    def launch(self, command: Command, *, reads: bool) -> Steps[Task]:
        """`Dispatcher.launch`."""
        permit = self.ask(command)
        yield from self.acquire()
        try:
            yield from self.after_stops(permit)
            yield from self.leave_overdue()
            if reads:
                yield from self.up()
            self.admit(permit)
            return (yield from self.launched(command, permit))
        finally:
            self.locked = False
            self.permits.remove(permit)

    def ask(self, command: Command) -> Permit:
        self.world.ask(command)
        permit = self.gate.ask(command.name, self.world.boot())
        self.permits.append(permit)
        return permit

    def admit(self, permit: Permit) -> None:
        """`Dispatcher._admit`."""
        self.gate.check(permit, self.world.boot())
        self.world.claim = True

    def launched(self, command: Command, permit: Permit) -> Steps[Task]:
        """`Dispatcher._launch`."""
        before = self.last
        if before is not None:
            before.life.successor_sent()
        try:
            pending, cancelled = yield from self.answered(permit, command, followed=True)
        except StopUnconfirmed:
            if before is not None:
                before.life.successor_refused()
            raise
        error = cancelled or pending.error
        if pending.error is not None:
            if before is not None:
                before.life.successor_refused()
            assert error is not None
            raise error
        if before is not None:
            before.life.successor_accepted()
        task = self.last = Task(command, permit.stops)
        self.tasks.append(task)
        self.world.start(f"follower of {command.name}", self.follow(task))
        if self.overtaken(permit):
            _, again = yield from to_completion(self.halt)
            cancelled = again or cancelled
        if cancelled is not None:
            yield from self.cancelled_while_waiting(task)
            raise cancelled
        return task

    def conduct(self, command: Command) -> Steps[None]:
        """`Dispatcher.conduct`, as `Section._enter` uses it."""
        permit = self.ask(command)
        yield from self.after_stops(permit)
        yield from self.leave_overdue()
        self.admit(permit)
        pending, cancelled = yield from self.answered(permit, command, followed=False)
        if cancelled is not None:
            raise cancelled
        if pending.error is not None:
            raise pending.error

    # -- commands on their way -------------------------------------------------------------------

    def answered(
        self, permit: Permit, command: Command, *, followed: bool
    ) -> Steps[tuple[Pending, Cancelled | None]]:
        """`StopCoordinator.answered`."""
        pending = Pending(command, permit)
        if command.kind == MODE:
            self.note_mode(command)
        self.pending.append(pending)
        self.sent.append(pending)
        self.world.start(f"sender of {command.name}", self.carry_out(pending))
        try:
            return (yield from self.certain(pending, permit, followed=followed))
        finally:
            self.forget(pending)

    def forget(self, pending: Pending) -> None:
        """the end of `StopCoordinator.answered`."""
        if pending in self.pending:
            self.pending.remove(pending)

    def certain(
        self, pending: Pending, permit: Permit, *, followed: bool
    ) -> Steps[tuple[Pending, Cancelled | None]]:
        cancelled: Cancelled | None = None
        if followed:
            _, cancelled = yield from to_completion(lambda: self.wait(pending, CALL))
        else:
            try:
                yield from self.wait(pending, CALL)
            except Cancelled as exc:
                cancelled = exc
        if not pending.over and pending.call is None:
            pending.given_up = True
            _, again = yield from to_completion(lambda: self.wait(pending))
            cancelled = again or cancelled
        unsure = not pending.over or isinstance(pending.error, OutcomeUnknown)
        if not followed and pending.error is None:
            unsure = unsure or cancelled is not None or self.overtaken(permit)
        if unsure:
            _, again = yield from to_completion(lambda: self.stop_unanswered(pending))
            cancelled = again or cancelled
            if pending.error is None:
                pending.error = OutcomeUnknown(pending.name, "it was answered late")
        elif pending.error is not None and pending.command in self.modes:
            self.modes.remove(pending.command)
        return pending, cancelled

    def overtaken(self, permit: Permit) -> bool:
        """Whether the arm was stopped after it was asked for, perhaps before it was served."""
        return self.gate.ending(permit) not in (None, PermitEnding.PAUSED)

    def wait(self, pending: Pending, ticks: int | None = None) -> Steps[None]:
        world = self.world
        until = None if ticks is None else world.now + ticks
        yield lambda: pending.over or (until is not None and world.now >= until)

    def carry_out(self, pending: Pending) -> Steps[None]:
        """`WireLane.send`, and what comes of it."""
        world, command = self.world, pending.command
        until = world.now + CALL + LATE
        try:
            if pending.given_up:
                raise NotSent("it was given up before")
            self.gate.check(pending.permit, world.boot())
            call = pending.call = world.send(command)
            yield lambda: pending.settled or world.now >= until
            if call.state == "answered":
                if call.answer < 0:
                    raise Refused(command.name, -1, "no reason is given")
            else:
                call.reset(world.time())
                raise OutcomeUnknown(command.name, "no answer came")  # noqa: TRY301
        except OutcomeUnknown as exc:
            pending.error = exc
        except DucoError as exc:
            pending.error, pending.answered = exc, True
        else:
            pending.answered = True
        finally:
            pending.over, pending.at = True, world.monotonic()

    def stop_unanswered(self, *pending: Pending) -> Steps[None]:
        """`StopCoordinator._stop_unanswered`."""
        with self.world.confirms(), self.gate.stop():
            yield from self.stop_until_certain(*pending)

    def stop_until_certain(self, *pending: Pending) -> Steps[None]:
        """`StopCoordinator.stop_until_certain`, with that of `supervision.rest`."""
        world = self.world
        self.unfollowed = True
        now = world.monotonic()
        motion = UnansweredMotion(now, now + LATE * TICK, now + (LATE + STOP + STAND) * TICK)
        looks = 0
        while True:
            if all(each.over for each in pending):
                if all(each.answered for each in pending):
                    motion.answered(world.monotonic())
                else:
                    motion.connection_reset(max(each.at for each in pending))
            now = world.monotonic()
            match motion.step(now):
                case NextStep.DONE:
                    self.enter_again(pending)
                    yield from self.leave_modes()
                    break
                case NextStep.GIVE_UP:
                    raise StopUnconfirmed("it is not known what became of it")
                case NextStep.RESET:
                    for each in pending:
                        each.given_up = True
                    yield None
                case NextStep.STOP:
                    self.enter_again(pending)
                    try:
                        yield from self.send_stop()
                    except StopUnconfirmed:
                        motion.poll_failed(now, world.monotonic())
                        yield None
                    else:
                        motion.stopped(now, world.monotonic())
                    looks = 0
                case NextStep.LOOK:
                    moving = yield from self.look()
                    if moving is None:
                        motion.poll_failed(now, world.monotonic())
                    else:
                        motion.seen(now, world.monotonic(), moving=moving)
                    looks += 1
                    if looks >= 2:  # from now on once in a tick
                        then, over = world.now, [each.over for each in pending]
                        yield lambda: world.now > then or [each.over for each in pending] != over  # noqa: B023
        self.unfollowed = False

    def enter_again(self, pending: tuple[Pending, ...]) -> None:
        """Note the modes that they enter: a mode that was left may be entered late."""
        for each in pending:
            if each.command.kind == MODE:
                self.note_mode(each.command)

    # -- stops -----------------------------------------------------------------------------------

    def halt(self) -> Steps[None]:
        """`StopCoordinator.halt`."""
        with self.world.confirms(), self.gate.stop():
            overtaken = tuple(self.pending)
            yield from self.send_stop()
            yield from self.rest(overtaken)

    def send_stop(self) -> Steps[None]:
        """`StopCoordinator.send_stop`."""
        if self.modes:
            try:
                yield from self.call_stop()
            except (StopUnconfirmed, Cancelled):
                yield from self.leave_modes()
                raise
            yield from self.leave_modes()
        yield from self.call_stop()

    def leave_modes(self) -> Steps[None]:
        """`Modes.leave`."""
        for mode in tuple(self.modes):
            yield from self.leave_mode(mode)

    def leave_mode(self, mode: Command) -> Steps[None]:
        world = self.world
        self.modes.remove(mode)
        until = world.now + 1
        yield lambda: not world.down or world.now >= until
        if not world.down:
            world.say(f"{mode.name} is ended")
            world.controller.end(mode)
            yield lambda: not world.down or world.now >= until
        if world.down:
            self.note_mode(mode)
            if mode not in self.overdue:
                self.overdue.append(mode)
        elif mode in self.overdue:
            self.overdue.remove(mode)

    def note_mode(self, mode: Command) -> None:
        """`Modes.enter`."""
        if mode not in self.modes:
            self.modes.append(mode)

    def leave_overdue(self) -> Steps[None]:
        """`Modes.leave_overdue`."""
        for mode in tuple(self.overdue):
            yield from self.leave_mode(mode)
        if self.overdue:
            raise RobotStateError("a mode may be on")

    def rest(self, overtaken: tuple[Pending, ...] = ()) -> Steps[None]:
        """`StopCoordinator.rest`, with `StopChannel.rest`."""
        until = self.world.now + STAND
        while not (yield from self.still(self.world.now + 1)):
            if self.world.now >= until:
                raise StopUnconfirmed("the arm still moves")
            yield from self.call_stop()
        if on_their_way := {*overtaken, *self.pending}:
            yield from self.stop_until_certain(*on_their_way)
        self.unfollowed = False

    def cancelled_while_waiting(self, task: Task) -> Steps[None]:
        if not task.done:
            yield from to_completion(self.halt)
            yield from to_completion(self.motions_ended)

    def motions_ended(self) -> Steps[None]:
        world = self.world
        until = world.now + 2
        tasks = tuple(self.tasks)
        for task in tasks:
            yield lambda task=task: task.done or world.now >= until  # type: ignore[misc]

    def pause(self) -> Steps[None]:
        """`StopCoordinator.pause`."""
        with self.world.confirms(), self.gate.stop(PermitEnding.PAUSED):
            yield from self.up()
            self.world.say("the controller pauses")
            self.world.controller.pause()
            yield from self.up()
            yield from self.standstill()

    def resume(self, command: Command) -> Steps[None]:
        """`StopCoordinator.resume`."""
        permit = self.ask(command)
        yield from self.after_stops(permit)
        self.admit(permit)
        self.gate.resume()
        pending, cancelled = yield from self.answered(permit, command, followed=False)
        if cancelled is not None:
            raise cancelled
        if pending.error is not None:
            raise pending.error

    # -- tasks -----------------------------------------------------------------------------------

    def follow(self, task: Task) -> Steps[None]:
        """`TaskFollower`, for one task."""
        world, gate, life = self.world, self.gate, task.life
        seen = -1
        while not life.ended:
            # the variable does not change before this is true
            yield (
                lambda: (
                    life.state is not task.command.state
                    or seen != gate.stops  # noqa: B023
                    or life.ended
                )
            )
            seen = gate.stops
            self.note_stop(task)
            if not life.undecided:
                yield lambda: not world.down
                state = task.command.state
                if self.polls:
                    yield lambda: not world.down
                    self.note_stop(task)
                life.observe(state)
        if life.outcome is Outcome.STOPPED:
            yield from self.standstill()
        task.done = True
        self.tasks.remove(task)

    def envelope(self) -> Steps[None]:
        """`EnvelopeKeeper._rest`."""
        self.world.say("the arm is about to leave its envelope")
        with self.world.confirms(), self.gate.stop(PermitEnding.ENVELOPE):
            yield from self.send_stop()
            yield from self.rest()

    def note_stop(self, task: Task) -> None:
        if self.gate.stops != task.stops:
            task.life.stop_sent()

    # -- leaving ---------------------------------------------------------------------------------

    def leave(self) -> Steps[None]:
        """`Supervisor.aclose`."""
        self.gate.close("the robot is closed, or is being closed")
        yield from self.acquire()
        self.locked = False
        if self.moving:
            yield from self.send_stop()
            yield from self.rest()
        if self.modes:
            yield from self.leave_modes()

    # -- what a program does -----------------------------------------------------------------------

    def awaits(self, name: str, *, reads: bool = False) -> Steps[None]:
        """Await a motion."""
        command = self.world[name]
        with self.tells_errors(command):
            task = yield from self.launch(command, reads=reads)
            try:
                yield lambda: task.done
            except Cancelled:
                yield from self.cancelled_while_waiting(task)
                raise
        outcome = task.life.outcome
        assert outcome is not None
        if outcome.success and command.cut:
            raise Violation(f"the await of {name} returns {outcome.value}, although it was stopped")
        self.told(command, outcome.value)

    @contextlib.contextmanager
    def tells_errors(self, command: Command) -> Iterator[None]:
        """Note that the program is told of a command's error: then it must not move the arm."""
        try:
            yield
        except StopUnconfirmed:
            self.world.say(f"{command.name} raises StopUnconfirmed")
            raise
        except (DucoError, Cancelled) as exc:
            self.told(command, type(exc).__name__)
            raise

    def told(self, command: Command, what: str) -> None:
        self.world.void(f"the program was told {what} of {command.name}", command)

    def enters(self, name: str) -> Steps[None]:
        """Enter a mode."""
        command = self.world[name]
        with self.tells_errors(command):
            yield from self.conduct(command)

    def resumes(self, name: str) -> Steps[None]:
        """Resume what is paused."""
        command = self.world[name]
        with self.tells_errors(command):
            yield from self.resume(command)

    def stops(self) -> Steps[None]:
        """`robot.stop()`."""
        world = self.world
        asked = world.asks
        world.say("the program calls robot.stop()")
        world.void_unsent("robot.stop() was called after it was asked for")
        _, cancelled = yield from to_completion(self.halt)
        if cancelled is not None:
            raise cancelled
        yield from self.motions_ended()
        world.void("robot.stop() has returned", before=asked)

    def stops_now(self) -> Steps[None]:
        """`robot.stop_now()`: what is on its way may arrive later, and is then stopped."""
        world = self.world
        under_way = [
            command
            for command in world.commands.values()
            if command.asked is not None
            and (command.name not in world.calls or world.calls[command.name].state != "answered")
        ]
        world.void_unsent("robot.stop_now() was called after it was asked for")
        with self.gate.stop():
            yield None
            world.say("the controller stops")
            world.controller.stop()
            yield None
        then = world.now
        yield lambda: world.now > then
        if under_way:
            world.void("robot.stop_now() returned long ago", *under_way)

    def leaves(self) -> Steps[None]:
        """Leave the robot's block."""
        self.world.say("the program leaves the robot")
        self.world.void_unsent("the program has begun to leave the robot")
        yield from self.leave()
        self.world.void("the program has left the robot")
