"""The worlds that are explored: each has a few actors and a few faults.

Attributes of each:
    gate: number of steps to which the gate explores it; the tests go less deep.
"""

from __future__ import annotations

from collections.abc import Iterable

from .arm import MODE, MOTION, POINTS, RESUME, ArmWorld
from .lives import LivingWorld
from .program import Program
from .world import Steps, Violation


class Scenario(ArmWorld):
    """A world with one program that always runs.

    Attributes:
        does: which function of the program each task begins with, by its name, which is that of the
            command if it has one.
    """

    gate = 12
    does: dict[str, str] = {}
    #: the kind of each command, by its name
    kinds: dict[str, str]
    #: how often each thing may go wrong
    wrong: dict[str, int] = {}

    def __init__(self) -> None:
        super().__init__(self.kinds)
        self.program = Program(self)
        self.left = dict(self.wrong)
        self.begin()

    def begin(self) -> None:
        """Start what runs at the beginning."""
        for name, work in self.does.items():
            command = [name] if name in self.kinds else []
            self.start(name, getattr(self.program, work)(*command))

    def parts(self) -> Iterable[object]:
        yield from super().parts()
        yield self.program.key()

    def passed(self) -> None:
        super().passed()
        self.program.gate.alive(self.boot())

    def quiet(self) -> None:
        """Do what can be done at once, in the order in which it comes."""
        while actions := [one for one in self.actions() if one[0] in ("run", "serve", "answer")]:
            self.do(actions[0])

    def runs(self, name: str) -> None:
        """Let a motion run that was accepted before."""
        self[name].asked = 0
        self.controller.begin(self[name])


class Stopped(Scenario):
    """Two motions are awaited, the second reads first; the arm is stopped; a third is awaited."""

    kinds = {"A": MOTION, "B": MOTION, "C": MOTION}
    gate = 13
    prompt = True
    wrong = {"break": 1}

    def begin(self) -> None:
        self.start("A", self.program.awaits("A"))
        self.start("B", self.program.awaits("B", reads=True))
        self.start("stop", self.stop())

    def stop(self) -> Steps[None]:
        yield from self.program.stops()
        yield from self.program.awaits("C")


class Refused(Stopped):
    """The same with a controller that may refuse a motion."""

    wrong = {"refuse": 1}


class StoppedNow(Scenario):
    """A motion and a mode are on their way when the arm is stopped by `robot.stop_now()`."""

    kinds = {"A": MOTION, "M": MODE}
    gate = 13
    prompt = True
    does = {"A": "awaits", "M": "enters", "stop": "stops_now"}


class StoppedInOutage(Scenario):
    """A motion is awaited, the arm stopped, and the network fails."""

    kinds = {"A": MOTION}
    gate = 15
    prompt = True
    wrong = {"down": 1}
    does = {"A": "awaits", "stop": "stops"}


class Late(Scenario):
    """A motion is awaited, and the arm stopped; each call may take any time or be lost."""

    kinds = {"A": MOTION}
    gate = 16
    wrong = {"break": 1}
    does = {"A": "awaits", "stop": "stops"}


class Outage(Scenario):
    """A motion is awaited and may be cancelled, and the network fails for any time."""

    kinds = {"A": MOTION}
    gate = 18
    victims = ("A",)
    wrong = {"down": 1, "cancel": 1}
    does = {"A": "awaits"}


class Cancelled(Scenario):
    """Two motions are awaited; the first await is cancelled, also twice."""

    kinds = {"A": MOTION, "B": MOTION}
    gate = 13
    prompt = True
    victims = ("A",)
    wrong = {"cancel": 2, "break": 1}
    does = {"A": "awaits", "B": "awaits"}


class Mode(Scenario):
    """A mode is entered, and the arm stopped; then a motion is awaited."""

    kinds = {"M": MODE, "A": MOTION}
    gate = 13
    prompt = True
    victims = ("M",)
    wrong = {"cancel": 1, "break": 1}

    def begin(self) -> None:
        self.start("M", self.program.enters("M"))
        self.start("stop", self.stop())

    def stop(self) -> Steps[None]:
        yield from self.program.stops()
        yield from self.program.awaits("A")


class ModeStopped(Scenario):
    """A mode is entered, and the arm stopped."""

    kinds = {"M": MODE}
    gate = 25
    prompt = True
    does = {"M": "enters", "stop": "stops"}


class ModeLeft(ModeStopped):
    """A mode is entered, and the robot left."""

    does = {"M": "enters", "leave": "leaves"}


class Resumed(Scenario):
    """The paused motion of another program is resumed, and the robot left, or the arm stopped."""

    kinds = {"foreign": MOTION, "R": RESUME}
    gate = 15
    prompt = True
    victims = ("R",)
    wrong = {"cancel": 1, "break": 1}
    does = {"R": "resumes", "leave": "leaves"}

    def begin(self) -> None:
        self.runs("foreign")
        self.controller.pause()
        super().begin()


class ResumedAndStopped(Resumed):
    """The same with a stop in place of leaving."""

    does = {"R": "resumes", "stop": "stops"}


class Paused(Scenario):
    """A motion is awaited, paused and resumed by another task, and stopped by a third."""

    kinds = {"A": MOTION, "R": RESUME}
    gate = 13
    prompt = True
    wrong = {"arrive": 1}

    def begin(self) -> None:
        self.start("A", self.program.awaits("A"))
        self.start("pause", self.pause())
        self.start("stop", self.program.stops())

    def pause(self) -> Steps[None]:
        yield from self.program.pause()
        yield from self.program.resumes("R")


class Envelope(Scenario):
    """The arm is stopped at a limit of its envelope while a motion is awaited."""

    kinds = {"A": MOTION, "B": MOTION}
    gate = 16
    prompt = True
    wrong = {"break": 1}
    does = {"B": "awaits", "envelope": "envelope"}

    def begin(self) -> None:
        self.runs("A")
        super().begin()


class Unconfirmed(Scenario):
    """A motion is awaited while the arm is being stopped, and the network fails."""

    kinds = {"A": MOTION, "B": MOTION}
    gate = 12
    wrong = {"down": 1}
    does = {"stop": "stops", "B": "awaits"}

    def begin(self) -> None:
        self.runs("A")
        super().begin()


class Tasks(Scenario):
    """A motion blends into the next one, is stopped, or arrives; its task is polled meanwhile."""

    kinds = {"A": MOTION, "B": MOTION}
    gate = 14
    prompt = True
    wrong = {"arrive": 2}

    def begin(self) -> None:
        self["A"].blends = True
        self.program.polls = True
        self.start("A", self.program.awaits("A"))
        self.quiet()
        self.start("B", self.program.awaits("B"))
        self.start("stop", self.program.stops())


class Left(Scenario):
    """The robot is left while a motion and a mode are on their way."""

    kinds = {"A": MOTION, "M": MODE}
    gate = 11
    prompt = True
    wrong = {"break": 1}
    does = {"A": "awaits", "M": "enters", "leave": "leaves"}


# -- processes that stand still --------------------------------------------------------------------


class Living(LivingWorld):
    """A program with keep-alives and a heartbeat."""

    gate = 12
    kinds: dict[str, str]
    wrong: dict[str, int] = {}

    def __init__(self) -> None:
        super().__init__(self.kinds)
        self.left = dict(self.wrong)
        program = self.program
        self.start("loop", program.lives())
        if self.guarded:
            self.start("guard", program.guards(), "guard")
            self.start("guard's death", program.loses_guard())
        elif self.heartbeat:
            self.start("heartbeat", program.beats(), "threads")
        self.periodic = tuple(self.processes)
        if self.guarded:
            self.start("claim", program.drops_claim())
        for name in self.periodic:
            self.do_run(name)
        self.begin()

    guarded = False

    def begin(self) -> None:
        """Start what runs at the beginning."""


class Frozen(Living):
    """A motion that reads first is awaited; the program freezes or hangs, the computer sleeps."""

    kinds = {"A": MOTION}
    gate = 13
    freezable: tuple[str, ...] = ("program", "loop")
    wrong = {"freeze": 1, "suspend": 1, "exit": 1}

    def begin(self) -> None:
        self.start("A", self.program.awaits("A", reads=True))


class Hung(Living):
    """A motion runs, and the event loop hangs."""

    kinds = {"A": MOTION}
    gate = 20
    freezable: tuple[str, ...] = ("loop",)
    wrong = {"freeze": 1}

    def begin(self) -> None:
        self["A"].asked = 0
        self.controller.begin(self["A"])
        self.claim = True


class Stream(Living):
    """A stream; program and worker are frozen, the program is killed, the computer sleeps."""

    kinds = {"S": POINTS}
    gate = 12
    freezable: tuple[str, ...] = ("program", "worker", "loop")
    mortal: tuple[str, ...] = ("program",)
    wrong = {"freeze": 2, "kill": 1}

    def begin(self) -> None:
        self.program.opens("S")


class StreamSuspended(Stream):
    """The same with a computer that sleeps."""

    wrong = {"suspend": 1, "freeze": 1}


class StreamWithoutHeartbeat(Stream):
    """A stream whose worker is frozen; no heartbeat would stop the arm."""

    heartbeat = False
    freezable: tuple[str, ...] = ("worker",)
    wrong = {"freeze": 1}


class StreamStopped(Living):
    """A stream, and a stop; the worker may be frozen."""

    kinds = {"S": POINTS}
    gate = 14
    freezable: tuple[str, ...] = ("worker",)
    wrong = {"freeze": 1}

    def begin(self) -> None:
        self.program.opens("S")
        self.start("stop", self.program.stops())


class StreamStoppedByAnother(Living):
    """A stream; another program sets an output, and stops the arm; the worker may be frozen."""

    kinds = {"S": POINTS}
    gate = 14
    freezable: tuple[str, ...] = ("worker",)
    wrong = {"other stop": 1, "other task": 1, "freeze": 1}

    def begin(self) -> None:
        self.program.opens("S")

    def check(self) -> None:
        super().check()
        controller, stop = self.controller, self.others_stop
        if stop is not None and controller.task > stop + 2 and controller.followed is not None:
            raise Violation("set-points go on moving the arm after another program's stop")


class StreamLost(Living):
    """A stream in a mode of the controller loses its connection; then a motion is awaited."""

    kinds = {"S": POINTS, "M": MODE, "A": MOTION}
    gate = 16
    freezable: tuple[str, ...] = ("worker",)
    mortal: tuple[str, ...] = ("worker",)
    heartbeat = False
    wrong = {"down": 1, "kill": 1}

    def begin(self) -> None:
        self.program.opens("S", "M")
        self.start("A", self.then())

    def check(self) -> None:
        super().check()
        mode, queue = self.controller.mode, self.controller.queue
        if mode is not None and queue:
            raise Violation(f"{queue[0].name} runs while {mode.name} is on")

    def then(self) -> Steps[None]:
        yield lambda: not self.program.streaming
        yield from self.program.awaits("A")


class Guarded(Living):
    """The paused motion of another program is resumed; program or guard are killed or frozen."""

    kinds = {"foreign": MOTION, "R": RESUME}
    gate = 11
    guarded = True
    freezable: tuple[str, ...] = ("program", "guard")
    mortal: tuple[str, ...] = ("program", "guard")
    wrong = {"freeze": 1, "kill": 2}

    def begin(self) -> None:
        self["foreign"].asked = 0
        self.controller.begin(self["foreign"])
        self.controller.pause()
        self.start("R", self.program.resumes("R"))


class GuardedWithoutHeartbeat(Guarded):
    """The same without a heartbeat: only the guard stops the arm of a killed program."""

    heartbeat = False
    freezable: tuple[str, ...] = ()
    mortal: tuple[str, ...] = ("program",)
    wrong = {"kill": 1}


ALL = [
    kind
    for kind in list(vars().values())
    if isinstance(kind, type) and issubclass(kind, (Scenario, Living)) and hasattr(kind, "kinds")
]
