"""The programs that are run with the package's own coroutines: see `shells.py`."""

from __future__ import annotations

from .arm import MODE, RESUME, Command
from .shells import Choices, Robot, Run, Tried, depart, virtual_time


class Program:
    """A program with a robot: what it begins with, and what may happen at any time.

    Attributes:
        departures: number of departures that the tests try.
        commands: what moves the arm in it.
        breaks: how often a connection may break.
        fine: whether answers may arrive while the loop has something to do.
    """

    departures = 1
    breaks = 1
    fine = True

    def __init__(self) -> None:
        self.commands: tuple[Command, ...] = ()

    async def begin(self, robot: Robot) -> None:
        """Do what it begins with, and name what may happen, in its order."""
        raise NotImplementedError

    def prepare(self, run: Run) -> None:
        """Prepare the controller."""


class Stopped(Program):
    """Two motions are awaited and the arm is stopped; then another is awaited."""

    def __init__(self) -> None:
        self.commands = Command("A"), Command("B"), Command("C")

    async def begin(self, robot: Robot) -> None:
        async def stop() -> None:
            await robot.stops()
            await robot.awaits("C")

        robot.start("A", robot.awaits("A"))
        robot.start("B", robot.awaits("B"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", stop()))


class StoppedOnce(Program):
    """A motion is awaited, and the arm stopped."""

    departures = 2
    breaks = 0

    def __init__(self) -> None:
        self.commands = (Command("A"),)

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", robot.stops()))


class StoppedNow(Program):
    """A motion is awaited and a mode entered; the arm is stopped by `robot.stop_now()`."""

    def __init__(self) -> None:
        self.commands = Command("A"), Command("M", MODE)

    async def begin(self, robot: Robot) -> None:
        robot.start("M", robot.enters("M"))
        robot.start("A", robot.awaits("A"))
        robot.may("robot.stop_now() is called", robot.stops_now)


class Cancelled(Program):
    """A motion is awaited, and another one after it; the first await is cancelled, also twice."""

    def __init__(self) -> None:
        self.commands = Command("A"), Command("B")

    async def begin(self, robot: Robot) -> None:
        first = robot.start("A", robot.awaits("A"))
        robot.may("the program awaits B", lambda: robot.start("B", robot.awaits("B")))
        robot.may("A is cancelled", first.cancel)
        robot.may("A is cancelled again", first.cancel)


class Blocked(Program):
    """A blocking call is stopped, or cancelled; another one waits for its connection."""

    def __init__(self) -> None:
        self.commands = Command("A"), Command("B")

    async def begin(self, robot: Robot) -> None:
        first = robot.start("A", robot.blocks("A"))
        robot.start("B", robot.blocks("B"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", robot.stops()))
        robot.may("A is cancelled", first.cancel)


class Mode(Program):
    """A mode is entered, and the arm stopped, or the task cancelled; then a motion is awaited."""

    def __init__(self) -> None:
        self.commands = Command("M", MODE), Command("A")

    async def begin(self, robot: Robot) -> None:
        async def stop() -> None:
            await robot.stops()
            await robot.awaits("A")

        first = robot.start("M", robot.enters("M"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", stop()))
        robot.may("M is cancelled", first.cancel)


class Resumed(Program):
    """The paused motion of another program is resumed, and the robot left."""

    def __init__(self) -> None:
        self.commands = Command("foreign"), Command("R", RESUME)

    def prepare(self, run: Run) -> None:
        run["foreign"].asked = 0
        run.controller.begin(run["foreign"])
        run.controller.pause()

    async def begin(self, robot: Robot) -> None:
        robot.start("R", robot.resumes("R"))
        robot.may("the program leaves the robot", lambda: robot.start("leave", robot.leaves()))


class Paused(Program):
    """A motion is awaited, paused, resumed and stopped."""

    def __init__(self) -> None:
        self.commands = Command("A"), Command("R", RESUME)

    async def begin(self, robot: Robot) -> None:
        async def pause() -> None:
            await robot.pauses()
            await robot.resumes("R")

        robot.start("A", robot.awaits("A"))
        robot.may("the program pauses", lambda: robot.start("pause", pause()))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", robot.stops()))


class Envelope(Program):
    """The arm is stopped at a limit of its envelope while a motion is awaited."""

    def __init__(self) -> None:
        self.commands = Command("A"), Command("B")

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))
        robot.may(
            "the arm is about to leave its envelope",
            lambda: robot.start("envelope", robot.envelope()),
        )
        robot.may("the program awaits B", lambda: robot.start("B", robot.awaits("B")))


class Aborted(Program):
    """A motion is awaited, and aborted."""

    def __init__(self) -> None:
        self.commands = (Command("A"),)

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))
        robot.may("the program calls robot.abort()", lambda: robot.start("abort", robot.aborts()))


class Left(Program):
    """A motion is awaited and a mode entered; the robot is left."""

    def __init__(self) -> None:
        self.commands = Command("A"), Command("M", MODE)

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))
        robot.may("the program enters a mode", lambda: robot.start("M", robot.enters("M")))
        robot.may("the program leaves the robot", lambda: robot.start("leave", robot.leaves()))


class Lost(Program):
    """A motion is awaited, and its connection breaks."""

    departures = 2

    def __init__(self) -> None:
        self.commands = (Command("A"),)

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))


class Overdue(Program):
    """A stream has ended whose worker could not end its mode; a motion is awaited."""

    def __init__(self) -> None:
        self.commands = Command("M", MODE), Command("A")

    def prepare(self, run: Run) -> None:
        run["M"].asked = 0
        run.controller.begin(run["M"])
        run.apart = True

    async def begin(self, robot: Robot) -> None:
        modes = robot.coordinator.modes
        modes.enter("end_realtime_mode")
        modes.overdue("end_realtime_mode")
        robot.start("A", robot.awaits("A"))


ALL: tuple[type[Program], ...] = (
    Stopped,
    StoppedOnce,
    StoppedNow,
    Cancelled,
    Blocked,
    Mode,
    Resumed,
    Paused,
    Envelope,
    Aborted,
    Left,
    Lost,
    Overdue,
)


def tried(kind: type[Program], departures: int | None = None) -> Tried:
    """Try all runs of a program with up to a number of departures."""

    def once(choices: Choices) -> None:
        program = kind()
        run = Run(choices, *program.commands, fine=program.fine)
        run.breaks, run.arrivals = program.breaks, 9
        program.prepare(run)
        current[:] = [run]
        run.go(program.begin)

    with virtual_time() as current:
        return depart(once, kind.departures if departures is None else departures)
