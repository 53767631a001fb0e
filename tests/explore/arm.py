"""A controller and the wire to it, for the explorer, and the promise that is checked in each state.

The controller carries out one call after another, may refuse a motion, and may stop by itself. A
call is on its way until the controller serves it, and so is its answer until it arrives; meanwhile
its connection may break. Bytes that were sent before that may still arrive, as long as the package
assumes: at most as long after the next stop as that stop took.

The promise: each command has a word `void`, set when the program was told of its end, when a stop
that was requested after it has returned, and when its program has left or must have been stopped.
No void command moves the arm.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from aioduco.errors import StopUnconfirmed
from aioduco.models.enums import TaskState
from aioduco.supervision.unanswered import MAX_WATCH, MIN_WATCH

from .world import Action, Named, Violation, World

#: kinds of commands whose answer is the id of a task
MOTION, RESUME, MODE, POINTS = "motion", "resume", "mode", "points"

_GONE: Final = ("answered", "dropped")


class Command(Named):
    """Something that moves the arm, from the moment in which the program asks for it.

    Attributes:
        kind: what it is.
        asked: its number in the order of what was asked for; 0 for what was there at the beginning.
        void: why it must not move the arm any more; empty while it may.
        state: the state of its task.
        blends: whether it blends into the next motion.
        cut: whether a stop ended it.
    """

    __slots__ = ("asked", "blends", "cut", "kind", "state", "void")

    def __init__(self, name: str, kind: str = MOTION, *, blends: bool = False) -> None:
        super().__init__(name)
        self.kind = kind
        self.asked: int | None = None
        self.void = ""
        self.blends = blends
        self.cut = False
        self.state = TaskState.IDLE

    def key(self) -> object:
        return self.asked, bool(self.void), self.cut, self.state


class Call(Named):
    """The bytes of a command, and their answer.

    Attributes:
        command: the command.
        state: "sent", "served", "answered" or "dropped".
        broken: whether its connection broke, or was reset by the sender.
        reset_at: when that was [s]; None if it was not.
        until: when bytes that are still on their way have arrived or are lost [s].
        answer: the controller's answer.
    """

    __slots__ = ("answer", "broken", "command", "reset_at", "state", "until")

    def __init__(self, command: Command) -> None:
        super().__init__(command.name)
        self.command = command
        self.state = "sent"
        self.broken = False
        self.reset_at: float | None = None
        self.until: float | None = None
        self.answer = 0

    def key(self, world: World) -> object:
        if self.state in _GONE:
            return self.state
        now = world.time()
        times = world.ago(self.reset_at, now), world.ago(self.until, now)
        return self.state, self.broken, self.answer, *times

    def reset(self, now: float) -> None:
        """Close the connection: the answer is lost, and so are bytes that this system still has."""
        self.broken = True
        if self.reset_at is None:
            self.reset_at = now
        if self.state == "served":
            self.state = "dropped"


class Controller:
    """What moves the arm.

    Attributes:
        queue: the motions, the running one first.
        paused: whether the running motion is paused.
        resumed: the command that resumed the running motion.
        mode: the mode that is on.
        followed: the stream that it follows; without set-points it stands by itself.
        pointed: when the last set-point came [ticks].
        slow: a resume that was accepted and has not moved the arm yet.
        beat: when the last heartbeat came [ticks]; None before, and after it has stopped by itself.
        task: number of the last task; each set-point and each stop has one.
        followed_task: that of the last set-point.
        stopped_tasks: those of set-points that a stop ended.
    """

    def __init__(self) -> None:
        self.queue: list[Command] = []
        self.paused = False
        self.resumed: Command | None = None
        self.mode: Command | None = None
        self.followed: Command | None = None
        self.pointed = 0
        self.slow: Command | None = None
        self.beat: int | None = None
        self.task = self.followed_task = 0
        self.stopped_tasks: list[int] = []

    def key(self, world: World) -> object:
        return (
            *[command.name for command in self.queue],
            self.paused,
            *[one and one.name for one in (self.resumed, self.mode, self.followed, self.slow)],
            self.followed and world.now - self.pointed,
            None if self.beat is None else world.now - self.beat,
            self.task - self.followed_task,
            *[self.task - each for each in self.stopped_tasks],
        )

    @property
    def movers(self) -> list[Command]:
        """The commands that move the arm, or make it yield."""
        found = [self.mode] if self.mode is not None else []
        if self.queue and not self.paused:
            found.append(self.resumed or self.queue[0])
        if self.followed is not None:
            found.append(self.followed)
        return found

    @property
    def moving(self) -> bool:
        """What `robotmoving` answers."""
        return self.followed is not None or (bool(self.queue) and not self.paused)

    def begin(self, command: Command) -> None:
        """Carry out a command that moves the arm."""
        match command.kind:
            case "motion":
                self.queue.append(command)
                self._run()
            case "resume":
                self.slow = command if self.paused else None
                command.state = TaskState.FINISHED
            case "mode":
                self.mode = command
            case "points":
                self.followed = command
                self.task += 1
                self.followed_task = self.task

    def end(self, mode: Command) -> None:
        """End a mode."""
        if self.mode is mode:
            self.mode = None

    def _run(self) -> None:
        if self.queue:
            self.queue[0].state = TaskState.PAUSED if self.paused else TaskState.RUNNING

    def set_off(self) -> None:
        """Move on after a resume."""
        self.paused, self.resumed, self.slow = False, self.slow, None
        self._run()

    def arrive(self) -> None:
        """End the running motion at its target."""
        first = self.queue.pop(0)
        blended = first.blends and self.queue
        first.state = TaskState.INTERRUPT if blended else TaskState.FINISHED
        self.resumed = None
        self._run()

    def stop(self) -> None:
        """Stop; a motion that blends is reported as interrupted."""
        for command in self.queue:
            command.cut = True
            command.state = TaskState.INTERRUPT if command.blends else TaskState.STOPPED
        self.queue.clear()
        if self.followed is not None:
            self.stopped_tasks.append(self.followed_task)
        self.task += 1
        self.paused = False
        self.resumed = self.followed = self.slow = None

    def state_of(self, task: int) -> TaskState:
        """What `get_noneblock_taskstate` answers of a set-point that is not the last one."""
        return TaskState.STOPPED if task in self.stopped_tasks else TaskState.FINISHED

    def pause(self) -> None:
        """Pause the running motion, if there is one."""
        self.paused = bool(self.queue)
        self.resumed = self.followed = self.slow = None
        self._run()


class ArmWorld(World):
    """A world with a controller.

    Attributes:
        commands: all commands of this world, by name.
        calls: the calls on their way, and those that were.
        down: whether the network carries nothing.
        asks: number of commands that were asked for.
        confirming: how much had been asked for when each stop began that is being confirmed.
        claim: whether the program may be moving the arm, as its guard knows it.
    """

    def __init__(self, kinds: Mapping[str, str]) -> None:
        super().__init__()
        self.controller = Controller()
        self.commands = {name: Command(name, kind) for name, kind in kinds.items()}
        self.calls: dict[str, Call] = {}
        self.down = False
        self.asks = 0
        self.confirming: list[int] = []
        self.claim = False

    def __getitem__(self, name: str) -> Command:
        return self.commands[name]

    def parts(self) -> Iterable[object]:
        yield self.controller.key(self)
        yield self.down, self.asks, tuple(self.confirming), self.claim
        for command in self.commands.values():
            yield command.key()
        for name, call in sorted(self.calls.items()):
            yield name, call.key(self)

    # -- the promise ---------------------------------------------------------------------------

    def ask(self, command: Command) -> None:
        """Note that the program asks for a command."""
        self.asks += 1
        command.asked = self.asks
        self.say(f"the program asks for {command.name}")

    def void(self, why: str, *commands: Command, before: int | None = None) -> None:
        """Note that commands must not move the arm any more.

        Args:
            why: the reason.
            *commands: the commands; none: all.
            before: only those that were asked for by then.
        """
        self.say(why)
        for command in commands or self.commands.values():
            if command.asked is not None and (before is None or command.asked <= before):
                command.void = command.void or why

    def void_unsent(self, why: str) -> None:
        """Note that what was asked for and not sent must not be sent any more."""
        for command in self.commands.values():
            if command.asked and command.kind != POINTS and command.name not in self.calls:
                command.void = command.void or why

    def check(self) -> None:
        for command in self.controller.movers:
            if command.void:
                raise Violation(f"{command.name} moves the arm, although {command.void}")

    # -- the wire ------------------------------------------------------------------------------

    def send(self, command: Command) -> Call:
        """Hand the bytes of a command to a socket."""
        self.say(f"{command.name} is sent")
        if self.confirming:
            raise Violation(f"{command.name} is sent while a stop is being confirmed")
        if command.void:
            raise Violation(f"{command.name} is sent, although {command.void}")
        call = self.calls[command.name] = Call(command)
        return call

    @contextlib.contextmanager
    def confirms(self) -> Iterator[None]:
        """Note that a stop is being confirmed: nothing that moves the arm is sent meanwhile."""
        before = self.asks
        self.confirming.append(before)
        try:
            yield
        except StopUnconfirmed:
            for command in self.commands.values():
                if command.asked is not None and command.asked > before:
                    command.void = "it waited for a stop, and it is not known that the arm stands"
            raise
        finally:
            self.confirming.remove(before)

    def environment(self) -> Iterable[Action]:
        for name, call in self.calls.items():
            if self.down or call.state in _GONE:
                continue
            if call.state == "served":
                yield "answer", name
            else:
                yield "serve", name
                if not call.broken and call.command.kind != RESUME and self.may("refuse"):
                    yield "refuse", name
            if not call.broken and self.may("break"):
                yield "break", name
        if self.controller.slow is not None:
            yield "set_off", None
        if self.may("down"):
            yield "down", None
        if self.down:
            yield "up", None
        if self.controller.moving and self.may("arrive"):
            yield "arrive", None
        for name, process in self.processes.items():
            if self.may("cancel") and process.started and not process.over and name in self.victims:
                yield "cancel", name

    #: names of the processes that may be cancelled
    victims: tuple[str, ...] = ()
    #: whether no call and no answer takes longer than a tick
    prompt = False

    def may_pass(self) -> bool:
        return self.controller.slow is None and (
            not self.prompt
            or all(call.broken or call.state in _GONE for call in self.calls.values())
        )

    def do_serve(self, name: str) -> None:
        call = self.calls[name]
        late = " late" if call.broken else ""
        self.say(f"the controller gets {name}{late}, and accepts it")
        call.state = "dropped" if call.broken else "served"
        self.controller.begin(call.command)

    def do_refuse(self, name: str) -> None:
        self.spend("refuse")
        self.say(f"the controller refuses {name}")
        call = self.calls[name]
        call.state, call.answer = "served", -1

    def do_answer(self, name: str) -> None:
        self.say(f"the answer to {name} arrives")
        self.calls[name].state = "answered"

    def do_break(self, name: str) -> None:
        self.spend("break")
        call = self.calls[name]
        self.say(f"the connection of {name} breaks")
        call.reset(self.time())

    def do_down(self, _: object) -> None:
        self.spend("down")
        self.say("the network fails")
        self.down = True

    def do_up(self, _: object) -> None:
        self.say("the network works again")
        self.down = False

    def do_set_off(self, _: object) -> None:
        self.say(
            f"the arm moves on, by {self.controller.slow.name if self.controller.slow else ''}"
        )
        self.controller.set_off()

    def do_arrive(self, _: object) -> None:
        self.left["arrive"] = self.left.get("arrive", 1) - 1
        self.say(f"{self.controller.queue[0].name} arrives at its target")
        self.controller.arrive()

    def stop_answered(self, sent: float) -> None:
        """Note that a stop was answered: nothing that was older is much later than it."""
        now = self.time()
        for call in self.calls.values():
            if call.state == "sent" and call.reset_at is not None and sent >= call.reset_at:
                watch = min(max(now - call.reset_at, MIN_WATCH), MAX_WATCH)
                call.until = min(call.until or now + watch, now + watch)

    def passed(self) -> None:
        for call in self.calls.values():
            if call.state == "sent" and call.until is not None and self.time() >= call.until:
                call.state = "dropped"
