"""Heartbeat, stream and guard for the explorer, and the faults of their processes.

`LivingWorld` has three operating system's processes: the program, the worker of its stream, and its
guard. Each may be frozen, thawed and killed; the event loop may hang; the computer may sleep.
The drivers mirror `supervision.heartbeat`, `streaming.worker.main` and `drivers`,
`streaming.session` and `supervision.guard.process`; the decisions are those of `Gate`,
`HeartbeatMachine`, `StreamPermit` and `TaskNumbers`.

Assumed: a controller that gets no heartbeat stops the arm between the heartbeat time and `SLACK`
later, once, and nothing that a dead program has sent arrives later than that.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from aioduco.errors import StopUnconfirmed
from aioduco.streaming.shared.words import ControlWord, Reason
from aioduco.streaming.worker.permit import StreamPermit
from aioduco.streaming.worker.task_numbers import TaskNumbers
from aioduco.supervision.gate import PermitEnding
from aioduco.supervision.heartbeat import HeartbeatMachine, HeartbeatState
from aioduco.supervision.unanswered import NextStep, UnansweredMotion

from .arm import POINTS, ArmWorld
from .program import HEARTBEAT, STALL, Program
from .world import TICK, Action, Process, Steps, canonical

#: seconds that a controller waits beyond the heartbeat time, and for which a worker may be away
SLACK: Final = 0.5
AWAY: Final = 0.25
#: ticks for a worker to become silent
SILENCE: Final = 1

#: words of a stream's block that are times
_TIMES: Final = (ControlWord.ALIVE, ControlWord.LEASE)
#: what belongs to each of the operating system's processes
PARTS: Final = {"program": ("loop", "threads"), "worker": ("worker",), "guard": ("guard",)}


class LivingWorld(ArmWorld):
    """A world in which processes and computers stand still.

    Attributes:
        stamp: the event loop's last keep-alive that counts [s].
        killed: when the program was killed [ticks].
        still: number of ticks for which its event loop has not run.
        others_stop: the number of another program's stop.
        freezable: what may be frozen: names of `PARTS`, or "loop" for a loop that hangs.
        mortal: what may be killed.
    """

    freezable: tuple[str, ...] = ("program",)
    mortal: tuple[str, ...] = ()
    heartbeat = True
    prompt = True
    long_ago = 2.5

    def __init__(self, kinds: Mapping[str, str]) -> None:
        super().__init__(kinds)
        self.stamp = self.boot()
        self.killed: int | None = None
        self.still = 0
        self.others_stop: int | None = None
        self.program = LivingProgram(self)

    def parts(self) -> Iterable[object]:
        yield from super().parts()
        yield self.program.key()
        killed = None if self.killed is None else min(self.now - self.killed, 9)
        yield self.ago(self.stamp, self.boot()), killed, min(self.still, 6)
        yield None if self.others_stop is None else self.controller.task - self.others_stop

    def environment(self) -> Iterable[Action]:
        yield from super().environment()
        if self.asleep:
            yield "wake", None
            return
        if self.may("suspend"):
            yield "suspend", None
        for name in self.freezable:
            parts = PARTS.get(name, (name,))
            if parts[0] in self.dead:
                continue
            if self.frozen.issuperset(parts):
                yield "thaw", name
            elif self.may("freeze"):
                yield "freeze", name
        if self.may("kill"):
            yield from (("kill", name) for name in self.mortal if PARTS[name][0] not in self.dead)
        if self.may("exit") and "loop" not in self.dead:
            yield "exit", None
        if self.may("other stop") and self.controller.followed is not None:
            yield "other_stop", None
        if self.may("other task"):
            yield "other_task", None
        beat = self.controller.beat
        if beat is not None and (self.now - beat) * TICK > HEARTBEAT:
            yield "lapse", None

    def do_exit(self, _: object) -> None:
        """`Supervisor._stop_at_loop_end`, and what follows it."""
        self.spend("exit")
        self.say("the event loop ends, and the program with it")
        self.program.gate.close("the event loop of the robot has ended")
        if self.program.moving:
            with self.program.gate.stop():
                self.say("the controller stops")
                self.controller.stop()
        self.die("program")

    def do_other_stop(self, _: object) -> None:
        """The next set-point moves the arm once more: its number tells of the stop."""
        self.spend("other stop")
        self.say("another program stops the arm")
        self.controller.stop()
        self.others_stop = self.controller.task

    def do_other_task(self, _: object) -> None:
        self.spend("other task")
        self.say("another program sets an output")
        self.controller.task += 1

    def do_suspend(self, _: object) -> None:
        self.spend("suspend")
        self.say("the computer is suspended")
        self.asleep = True

    def do_wake(self, _: object) -> None:
        self.say("the computer runs again")
        self.asleep = False

    def do_freeze(self, name: str) -> None:
        self.spend("freeze")
        self.say(f"the {name} is frozen")
        self.frozen.update(PARTS.get(name, (name,)))

    def do_thaw(self, name: str) -> None:
        self.say(f"the {name} runs again")
        self.frozen.difference_update(PARTS.get(name, (name,)))

    def do_kill(self, name: str) -> None:
        self.spend("kill")
        self.say(f"the {name} is killed")
        self.die(name)

    def die(self, name: str) -> None:
        self.dead.update(PARTS[name])
        if name == "program":
            self.killed = self.now
            for call in self.calls.values():
                if call.state in ("sent", "served"):
                    call.reset(self.time())
                    call.until = self.time() + SLACK

    def do_lapse(self, _: object) -> None:
        self.say("the controller stops by itself, since no heartbeat came")
        self.controller.beat = None
        self.controller.stop()
        self.void_unsent("the controller has stopped by itself")
        for command in self.commands.values():
            if command.kind == POINTS and command.asked:
                self.void("the controller has stopped by itself", command)

    def passed(self) -> None:
        super().passed()
        beat = self.controller.beat
        if beat is not None and (self.now - beat) * TICK > HEARTBEAT + SLACK:
            self.do_lapse(None)
        controller = self.controller
        if controller.followed is not None and self.now - controller.pointed > 1:
            self.void("the arm has stood for want of set-points", controller.followed)
            controller.followed = None
        if self.killed is not None and (self.now - self.killed) * TICK > HEARTBEAT + SLACK:
            self.void("the program ended long ago")
        self.still = self.still + 1 if "loop" in self.frozen or self.asleep else 0
        if self.still * TICK > STALL + HEARTBEAT + SLACK and self.heartbeat:
            self.void("the program has stood still for long")


class LivingProgram(Program):
    """A program with keep-alives, a heartbeat and a stream."""

    world: LivingWorld

    def __init__(self, world: LivingWorld) -> None:
        super().__init__(world, HEARTBEAT if world.heartbeat else None)
        self.machine = HeartbeatMachine(HEARTBEAT, STALL, world.boot())
        #: words of the stream's shared block; empty if there is no stream
        self.control: list[int] = []
        self.worker: Process | None = None
        self.session: Process | None = None

    def key(self) -> object:
        world = self.world
        control = [
            world.ago(word * 1e-9, world.boot()) if index in _TIMES else word
            for index, word in enumerate(self.control)
        ]
        return super().key(), canonical(self.machine, world), *control

    # -- keep-alives and heartbeat -------------------------------------------------------------

    def lives(self) -> Steps[None]:
        """`Supervisor._live`: the event loop's keep-alives."""
        world = self.world
        while True:
            if self.gate.alive(world.boot()):
                world.stamp = world.boot()
                if self.control:
                    self.control[ControlWord.ALIVE] = nanoseconds(world.boot())
            then = world.now
            yield lambda: world.now > then  # noqa: B023  # asked before the next turn

    def beats(self) -> Steps[None]:
        """`Heartbeat._run`."""
        world, machine = self.world, self.machine
        while True:
            before = machine.state
            may = machine.may_beat(world.boot(), world.stamp)
            if machine.state is HeartbeatState.STALLED and before is not machine.state:
                self.gate.hang()
                if world.claim:
                    world.say("the heartbeat's thread stops the arm of a program that hangs")
                    world.controller.stop()
            elif may:
                self.beat()
            then = world.now
            yield lambda: world.now > then  # noqa: B023

    def beat(self) -> None:
        world = self.world
        if world.down:
            self.machine.missed_beat(world.boot())
            return
        world.controller.beat = world.now
        self.machine.beaten(world.boot())
        self.gate.beaten(world.boot())
        if self.control:
            self.control[ControlWord.LEASE] = nanoseconds(self.lease)

    @property
    def lease(self) -> float:
        return self.gate.lease if self.world.heartbeat else 1e9

    def drops_claim(self) -> Steps[None]:
        """`Dispatcher.note_rest`."""
        world = self.world
        while True:
            if world.claim and not self.busy:
                stands = not (yield from self.look())
                self.gate.seen(world.boot(), standing=stands)
                if stands and not self.moving and not self.locked:
                    world.claim = False
            then = world.now
            yield lambda: world.now > then  # noqa: B023

    # -- the guard -------------------------------------------------------------------------------

    def guards(self) -> Steps[None]:
        """The guard's process: `GuardedRobot` with its heartbeat."""
        world, machine = self.world, self.machine
        then = world.now
        while "loop" not in world.dead:
            if (world.now - then) * TICK > HEARTBEAT:
                machine.suspended(world.boot())
            before = machine.state
            may = machine.may_beat(world.boot(), world.stamp)
            if machine.state is HeartbeatState.STALLED and before is not machine.state:
                self.gate.hang()
                self.guard_stops()
            elif may and world.heartbeat:
                self.beat()
            then = world.now
            yield lambda: world.now > then or "loop" in world.dead  # noqa: B023
        now = world.monotonic()
        self.guard_stops()
        motion = UnansweredMotion(now, now, now + 30.0)
        motion.connection_reset(now)
        motion.stopped(now, now)
        while (step := motion.step(world.monotonic())) is not NextStep.DONE:
            now = world.monotonic()
            if step is NextStep.STOP:
                self.guard_stops()
                motion.stopped(now, now)
            moving = world.controller.moving
            motion.seen(now, now, moving=moving)
            then = world.now
            yield lambda: world.now > then or world.controller.moving != moving  # noqa: B023

    def guard_stops(self) -> None:
        lapsed = self.world.heartbeat and self.world.controller.beat is None
        if self.world.claim and not lapsed:
            self.world.say("the guard stops the arm")
            self.world.controller.stop()

    def loses_guard(self) -> Steps[None]:
        """`Supervisor._guard_lost`."""
        world = self.world
        yield lambda: "guard" in world.dead
        world.say("the program notices the guard's death")
        self.gate.lapse("the guard's process is gone")
        if self.moving:
            yield from self.halt()

    # -- the stream ------------------------------------------------------------------------------

    def ended(self, ending: PermitEnding) -> None:
        if not self.control:
            return
        if ending.stops:
            self.control[ControlWord.HALT] = 1
        else:
            self.control[ControlWord.WITHDRAW] = Reason.LAPSED

    def opens(self, name: str, mode: str = "") -> None:
        """Open a stream, in a mode if it has one."""
        world = self.world
        stream = world[name]
        world.ask(stream)
        self.gate.ask(name, world.boot())
        self.control = [0] * (max(ControlWord) + 1)
        self.control[ControlWord.ALIVE] = nanoseconds(world.boot())
        self.control[ControlWord.LEASE] = nanoseconds(self.lease)
        if mode:
            world.ask(world[mode])
            self.note_mode(world[mode])
        self.worker = world.start("worker", self.works(name, mode), "worker")
        self.session = world.start("session", self.supervises(name, mode))

    @property
    def busy(self) -> bool:
        return super().busy or self.streaming

    @property
    def streaming(self) -> bool:
        """Whether a stream is open."""
        return self.session is not None and not self.session.over

    def works(self, name: str, mode: str) -> Steps[bool]:
        """`StreamWorker.run`. Returns whether the mode may be on."""
        world, controller = self.world, self.world.controller
        due, numbers = world.monotonic(), TaskNumbers()
        permit = StreamPermit(self.control, STALL, AWAY, self.times)
        if mode:
            world.say(f"{mode} is entered")
            world.controller.begin(world[mode])
        last = False
        while not permit.look(nanoseconds(due)) and not last:
            last = "loop" in world.dead  # the last set-point brings the arm to rest
            yield None
            if world.down or permit.look():
                break
            world.say("the worker sends a set-point")
            controller.begin(world[name])
            controller.pointed = world.now
            numbers.sent(controller.task, world.monotonic())
            if any(
                numbers.polled(task, controller.state_of(task), world.monotonic())
                for task in numbers.in_question
            ):
                world.say("the worker sees that another program stopped the arm, and stops it")
                controller.stop()
                break
            due += TICK
            yield lambda: world.monotonic() >= due  # noqa: B023
        else:
            yield None
        return (yield from self.ends_on_controller(permit, mode))

    def ends_on_controller(self, permit: StreamPermit, mode: str) -> Steps[bool]:
        """`StreamWorker._end_on_controller`. Returns whether the mode may be on."""
        world = self.world
        until = world.now + 1
        if mode:
            yield lambda: not world.down or world.now >= until
            if not world.down:
                world.say(f"the worker ends {mode}")
                world.controller.end(world[mode])
        if permit.reason is not Reason.STOPPED or "loop" in world.dead:
            yield lambda: not world.down or world.now >= until
            if not world.down:
                world.say("the worker stops the arm")
                world.controller.stop()
        return bool(mode) and world.controller.mode is not None

    def supervises(self, name: str, mode: str) -> Steps[None]:
        """`Session._supervise` and `Session._end`."""
        world, worker = self.world, self.worker
        assert worker is not None
        yield lambda: worker.over or "worker" in world.dead
        if "worker" in world.dead or worker.value:
            try:
                yield from self.halt()
            except StopUnconfirmed:
                world.say("it is not known that the arm stands")
        if mode and ("worker" in world.dead or worker.value):
            if world[mode] in self.modes and world[mode] not in self.overdue:
                self.overdue.append(world[mode])
        elif mode and world[mode] in self.modes:
            self.modes.remove(world[mode])
        world.void("the stream has ended", world[name])

    def send_stop(self) -> Steps[None]:
        world, worker = self.world, self.worker
        if worker is not None and self.streaming:
            self.control[ControlWord.HALT] = 1
            yield from self.call_stop()
            until = world.now + SILENCE
            yield lambda: worker.over or "worker" in world.dead or world.now >= until
            if not worker.over and "worker" not in world.dead:
                world.say("the worker does not end, and is killed")
                world.die("worker")
        yield from super().send_stop()

    def times(self) -> tuple[int, int]:
        return nanoseconds(self.world.monotonic()), nanoseconds(self.world.boot())


def nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)
