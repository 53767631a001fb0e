"""Tries every order in which things can happen in a small world, and finds the shortest bad one.

A world consists of processes, a controller and what may go wrong between them. A process is a
generator that mirrors a coroutine or a thread: each `yield` is a moment at which something else may
happen first, and yields when it goes on. A state is reached again by doing the same actions again,
so that the machines of the package need not be copied. States are equal if their keys are; each is
explored once.

Time passes in ticks, when nothing is left that a process could do at once: a process that is slow
is one of an operating system's process that is frozen.
"""

from __future__ import annotations

import contextlib
import gc
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from types import GeneratorType
from typing import Any, Final, TypeAlias, TypeVar

from aioduco.errors import DucoError
from aioduco.streaming.worker.permit import StreamPermit
from aioduco.streaming.worker.task_numbers import TaskNumbers
from aioduco.supervision.gate import Gate, Permit
from aioduco.supervision.heartbeat import HeartbeatMachine
from aioduco.supervision.task_state import TaskLifecycle
from aioduco.supervision.unanswered import UnansweredMotion

T = TypeVar("T")

#: when a process goes on: None for at once
Ready: TypeAlias = "Callable[[], bool] | None"
Steps: TypeAlias = "Generator[Ready, None, T]"
#: an action by its name and what it is done to
Action: TypeAlias = tuple[str, Any]

#: seconds of a tick
TICK: Final = 0.5


class Cancelled(BaseException):
    """What a cancelled coroutine gets."""


class Violation(Exception):
    """The promise is broken."""


class Named:
    """A part of a world that has its own key there; elsewhere its name stands for it."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = name


class Process:
    """A coroutine or thread."""

    __slots__ = ("error", "home", "key", "name", "over", "ready", "started", "steps", "value")

    def __init__(self, name: str, steps: Steps[Any], home: str) -> None:
        self.name = name
        self.steps = steps
        self.home = home
        self.ready: Ready = None
        self.started = self.over = False
        self.value: Any = None
        self.error: BaseException | None = None
        #: its key, since its last step; None if it was not needed yet
        self.key: int | None = None

    def new_key(self, world: World) -> int:
        """Compute its key."""
        if self.over:
            self.key = hash((type(self.error).__name__, canonical(self.value, world)))
        else:
            self.key = hash((self.started, *_frames(self.steps, world)))
        return self.key


#: variables that never change; times in ticks; times in seconds of `World.monotonic`
_NO_STATE: Final = frozenset({"self", "world"})
_TICKS: Final = frozenset({"until", "then"})
_SECONDS: Final = frozenset({"now", "sent", "due", "at", "reset_at", "till"})


def _frames(steps: Any, world: World) -> list[object]:
    """Where a generator and those that it waits for are, with their variables."""
    found: list[object] = []
    while isinstance(steps, GeneratorType):
        frame = steps.gi_frame
        if frame is None:
            break
        found.append(frame.f_lasti)
        for name, value in frame.f_locals.items():
            if name in _NO_STATE:
                continue
            if name in _TICKS:
                found.append(world.ago(value * TICK if value is not None else None, world.boot()))
            elif name in _SECONDS:
                found.append(world.ago(value, world.monotonic()))
            else:
                found.append(canonical(value, world))
        steps = steps.gi_yieldfrom
    return found


def _gate(gate: Gate, world: World) -> object:
    times = gate._alive, gate.lease, gate._standing_since
    states = gate.closed, gate.hung, gate.stops, gate.unconfirmed, gate.resumed
    return len(gate._stopping), *states, *[world.ago(time, world.boot()) for time in times]


def _unanswered(motion: UnansweredMotion, world: World) -> object:
    values = [getattr(motion, name) for name in UnansweredMotion.__slots__]
    now = world.monotonic()
    return (*[world.ago(value, now) if type(value) is float else value for value in values],)


def _life(life: TaskLifecycle, world: World) -> object:
    return (*[canonical(getattr(life, name), world) for name in TaskLifecycle.__slots__],)


def _machine(machine: HeartbeatMachine, world: World) -> object:
    now = world.boot()
    return machine.state, world.ago(machine._beaten, now), world.ago(machine.suspended_at, now)


def _stream_permit(permit: StreamPermit, world: World) -> object:
    boot, ahead = world.boot(), world.boot() - world.monotonic()
    return permit.reason, world.ago(permit._seen * 1e-9, boot), permit._ahead * 1e-9 - ahead


def _task_numbers(numbers: TaskNumbers, world: World) -> object:
    questions = [
        (numbers._last - task, world.ago(until, world.monotonic()))
        for task, until in numbers._in_question.items()
    ]
    return bool(numbers._last), numbers._least, numbers._times, *questions


def _sequence(values: Iterable[Any], world: World) -> object:
    return (*[canonical(value, world) for value in values],)


def _itself(value: Any, _: World) -> object:
    return value


def _name(value: Any, _: World) -> object:
    return value.name  # the world has its key


def _kind(value: Any, _: World) -> object:
    return type(value).__name__


def _nothing(value: Any, _: World) -> object:
    return None  # it has a key elsewhere, or never changes


_KEYS: dict[type, Callable[[Any, World], object]] = {
    **dict.fromkeys((int, float, str, bool, type(None)), _itself),
    **dict.fromkeys((list, tuple), _sequence),
    UnansweredMotion: _unanswered,
    TaskLifecycle: _life,
    HeartbeatMachine: _machine,
    StreamPermit: _stream_permit,
    TaskNumbers: _task_numbers,
    Gate: _gate,
    Permit: _name,
}


def canonical(value: Any, world: World) -> Any:
    """Reduce a value to what distinguishes it from others in the same place."""
    found = _KEYS.get(type(value))
    if found is None:
        found = _KEYS[type(value)] = _key_of(value)
    return found(value, world)


def _key_of(value: Any) -> Callable[[Any, World], object]:
    for kind, key in ((Named, _name), (Enum, _itself), (BaseException, _kind)):
        if isinstance(value, kind):
            return key
    return _nothing


class World:
    """Processes, time, and what is left of the things that may go wrong.

    Attributes:
        now: ticks since the beginning.
        slept: ticks for which the computer was suspended.
        asleep: whether it is suspended.
        left: how often each thing may still go wrong.
        frozen: the operating system's processes that are stopped.
        dead: those that were killed.
        words: what has happened.
    """

    #: ticks after which the world ends; None: it does not
    horizon: int | None = None
    #: processes with a turn in each tick, which is their first thing if they are on time
    periodic: tuple[str, ...] = ()
    #: seconds after which a past time makes no difference any more: longer than all limits
    long_ago = 6.0

    def __init__(self) -> None:
        self.now = 0
        self.slept = 0
        self.asleep = False
        self.left: dict[str, int] = {}
        self.processes: dict[str, Process] = {}
        self.frozen: set[str] = set()
        self.dead: set[str] = set()
        self.words: list[str] = []

    def say(self, words: str) -> None:
        """Note what happens, in plain words."""
        self.words.append(words)

    def time(self) -> float:
        """The time in the world [s]."""
        return self.now * TICK

    def boot(self) -> float:
        """Time of the clock that goes on while the computer sleeps [s]."""
        return self.now * TICK

    def monotonic(self) -> float:
        """Time of the clock that stands while the computer sleeps [s]."""
        return (self.now - self.slept) * TICK

    def start(self, name: str, steps: Steps[Any], home: str = "loop") -> Process:
        """Add a process; its first step is still to come."""
        process = self.processes[name] = Process(name, steps, home)
        return process

    # -- what may happen -----------------------------------------------------------------------

    def actions(self) -> list[Action]:
        """Return what may happen now."""
        found: list[Action] = [
            ("run", process.name)
            for process in self.processes.values()
            if self.may_run(process) and self.due(process)
        ]
        busy = bool(found)
        found += self.environment()
        if not busy and (self.horizon is None or self.now < self.horizon) and self.may_pass():
            found.append(("tick", None))
        return found

    def may_run(self, process: Process) -> bool:
        """Whether the operating system's process to which it belongs runs."""
        return not self.asleep and process.home not in self.frozen and process.home not in self.dead

    @staticmethod
    def due(process: Process) -> bool:
        """Whether a process has something to do."""
        return not process.over and (process.ready is None or process.ready())

    def environment(self) -> Iterable[Action]:
        """Return what may happen besides the processes."""
        return ()

    def may_pass(self) -> bool:
        """Whether time may pass now."""
        return True

    def do(self, action: Action) -> None:
        """Do an action."""
        name, what = action
        getattr(self, f"do_{name}")(what)

    def do_run(self, name: str) -> None:
        process = self.processes[name]
        process.started = True
        self._step(process, lambda: next(process.steps))

    def _step(self, process: Process, step: Callable[[], Ready]) -> None:
        process.key = None
        try:
            process.ready = step()
        except StopIteration as end:
            process.over, process.value = True, end.value
        except (DucoError, Cancelled) as exc:
            process.over, process.error = True, exc

    def do_tick(self, _: object) -> None:
        for process in self.processes.values():
            process.key = None
        on_time = [name for name in self.periodic if not self.due(self.processes[name])]
        self.now += 1
        self.slept += self.asleep
        self.say(f"-- {self.now * TICK:g} s --")
        self.passed()
        for name in on_time:
            if self.due(self.processes[name]) and self.may_run(self.processes[name]):
                self.do_run(name)

    def passed(self) -> None:
        """Do what happens by itself as time passes."""

    def check(self) -> None:
        """Check the promise."""

    def do_cancel(self, name: str) -> None:
        self.spend("cancel")
        self.say(f"{name} is cancelled")
        process = self.processes[name]
        self._step(process, lambda: process.steps.throw(Cancelled()))

    def spend(self, what: str) -> None:
        """Count something that may happen a few times only."""
        self.left[what] -= 1

    def may(self, what: str) -> bool:
        """Whether something may still happen."""
        return self.left.get(what, 0) > 0

    def key(self) -> int:
        """Return what distinguishes this state from others.

        Nothing but its own steps changes what a process remembers.
        """
        return hash(
            (
                self.now if self.horizon else 0,
                self.asleep,
                *self.left.values(),
                *sorted(self.frozen),
                "dead",
                *sorted(self.dead),
                *[
                    (name, process.key or process.new_key(self))
                    for name, process in sorted(self.processes.items())
                ],
                *self.parts(),
            )
        )

    def ago(self, then: float | None, now: float) -> float | None:
        """Return a time as what distinguishes it from others, by a clock that is at `now`."""
        # a quarter of a tick beside what ticks lead to: the hashes of -1.0 and -2.0 are the same
        return None if then is None else max(then - now, -self.long_ago) + TICK / 4

    def parts(self) -> Iterable[object]:
        """Return the keys of the other parts of this world."""
        return ()


@dataclass(frozen=True)
class Found:
    """What an exploration found."""

    states: int
    depth: int
    whole: bool
    seconds: float
    broken: str = ""
    order: tuple[str, ...] = ()

    def __str__(self) -> str:
        ending = "all there are" if self.whole else f"all within {self.depth} steps"
        figures = f"{self.states} states, {ending}, {self.depth} steps, {self.seconds:.1f} s"
        if not self.broken:
            return f"{figures}: the promise holds"
        return "\n".join([f"{figures}: {self.broken}", *[f"  {words}" for words in self.order]])


@contextlib.contextmanager
def few_collections() -> Iterator[None]:
    """Let Python look for garbage seldom: of the objects that it looks at, most are in use."""
    before = gc.get_threshold()
    gc.set_threshold(20_000, 100, 1_000)
    try:
        yield
    finally:
        gc.set_threshold(*before)


@few_collections()
def explore(make: Callable[[], World], depth: int) -> Found:
    """Try all orders of up to `depth` actions, the shortest first."""
    begin = time.process_time()
    world = make()
    seen = {world.key()}
    nodes: list[_Node] = [_Node((), world)]
    length = 0
    while nodes and length < depth:
        length += 1
        further: list[_Node] = []
        while nodes:
            node = nodes.pop()
            for action, world in node.successors(make):
                try:
                    world.do(action)
                    world.check()
                except Violation as exc:
                    seconds = time.process_time() - begin
                    return Found(len(seen), length, False, seconds, str(exc), tuple(world.words))
                if (key := world.key()) not in seen:
                    seen.add(key)
                    further.append(_Node((*node.path, action), world))
        further.reverse()
        nodes = further
    return Found(len(seen), length, not nodes, time.process_time() - begin)


class _Node:
    """A state to go on from."""

    __slots__ = ("path", "world")

    def __init__(self, path: tuple[Action, ...], world: World) -> None:
        self.path = path
        self.world = world

    def successors(self, make: Callable[[], World]) -> Iterator[tuple[Action, World]]:
        """Yield each action that is possible, with a world in which to do it."""
        actions = self.world.actions()
        if not actions:
            return
        keys = {name: process.key for name, process in self.world.processes.items()}
        for action in actions[1:]:
            world = make()
            for earlier in self.path:
                world.do(earlier)
            for name, process in world.processes.items():
                process.key = keys[name]
            yield action, world
        yield actions[0], self.world
