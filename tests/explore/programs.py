"""The programs that are run with the package's own coroutines: see `shells.py`."""

from __future__ import annotations

from .arm import MODE, MOTION, RESUME
from .departures import Choices, Tried, depart
from .shells import Robot, Run, virtual_time


class Program:
    """A program with a robot: what it begins with, and what may happen at any time.

    Attributes:
        departures: number of departures that the tests try.
        kinds: the kind of what moves the arm in it, by its name.
        breaks: how often a connection may break.
    """

    departures = 1
    kinds: dict[str, str]
    breaks = 1

    async def begin(self, robot: Robot) -> None:
        """Do what it begins with, and name what may happen, in its order."""
        raise NotImplementedError

    def prepare(self, run: Run) -> None:
        """Prepare the controller."""


class Stopped(Program):
    """Two motions are awaited and the arm is stopped; then another is awaited."""

    kinds = {"A": MOTION, "B": MOTION, "C": MOTION}

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

    kinds = {"A": MOTION}

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", robot.stops()))


class StoppedNow(Program):
    """A motion is awaited and a mode entered; the arm is stopped by `robot.stop_now()`."""

    kinds = {"A": MOTION, "M": MODE}

    async def begin(self, robot: Robot) -> None:
        robot.start("M", robot.enters("M"))
        robot.start("A", robot.awaits("A"))
        robot.may("robot.stop_now() is called", robot.stops_now)


class Cancelled(Program):
    """A motion is awaited, and another one after it; the first await is cancelled, also twice."""

    kinds = {"A": MOTION, "B": MOTION}

    async def begin(self, robot: Robot) -> None:
        first = robot.start("A", robot.awaits("A"))
        robot.may("the program awaits B", lambda: robot.start("B", robot.awaits("B")))
        robot.may("A is cancelled", first.cancel)
        robot.may("A is cancelled again", first.cancel)


class Blocked(Program):
    """A blocking call is stopped, or cancelled; another one waits for its connection."""

    kinds = {"A": MOTION, "B": MOTION}

    async def begin(self, robot: Robot) -> None:
        first = robot.start("A", robot.blocks("A"))
        robot.start("B", robot.blocks("B"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", robot.stops()))
        robot.may("A is cancelled", first.cancel)


class Mode(Program):
    """A mode is entered, and the arm stopped, or the task cancelled; then a motion is awaited."""

    kinds = {"M": MODE, "A": MOTION}

    async def begin(self, robot: Robot) -> None:
        async def stop() -> None:
            await robot.stops()
            await robot.awaits("A")

        first = robot.start("M", robot.enters("M"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", stop()))
        robot.may("M is cancelled", first.cancel)


class StoppedTwice(Program):
    """A mode is entered, and the arm stopped by two tasks."""

    kinds = {"M": MODE}

    async def begin(self, robot: Robot) -> None:
        robot.start("M", robot.enters("M"))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", robot.stops()))
        robot.may("another task does, too", lambda: robot.start("again", robot.stops()))


class Resumed(Program):
    """The paused motion of another program is resumed; then the robot is left, or R cancelled."""

    kinds = {"foreign": MOTION, "R": RESUME}

    def prepare(self, run: Run) -> None:
        run["foreign"].asked = 0
        run.controller.begin(run["foreign"])
        run.controller.pause()

    async def begin(self, robot: Robot) -> None:
        first = robot.start("R", robot.resumes("R"))
        robot.may("the program leaves the robot", lambda: robot.start("leave", robot.leaves()))
        robot.may("R is cancelled", first.cancel)


class Paused(Program):
    """A motion is awaited, paused, resumed and stopped."""

    kinds = {"A": MOTION, "R": RESUME}

    async def begin(self, robot: Robot) -> None:
        async def pause() -> None:
            await robot.pauses()
            await robot.resumes("R")

        robot.start("A", robot.awaits("A"))
        robot.may("the program pauses", lambda: robot.start("pause", pause()))
        robot.may("the program calls robot.stop()", lambda: robot.start("stop", robot.stops()))


class Envelope(Program):
    """The arm is stopped at a limit of its envelope while a motion is awaited."""

    kinds = {"A": MOTION, "B": MOTION}

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))
        robot.may(
            "the arm is about to leave its envelope",
            lambda: robot.start("envelope", robot.envelope()),
        )
        robot.may("the program awaits B", lambda: robot.start("B", robot.awaits("B")))


class Aborted(Program):
    """A motion is awaited and a mode entered; the arm is stopped by `robot.abort()`."""

    kinds = {"A": MOTION, "M": MODE}

    async def begin(self, robot: Robot) -> None:
        robot.start("M", robot.enters("M"))
        robot.start("A", robot.awaits("A"))
        robot.may("the program calls robot.abort()", lambda: robot.start("abort", robot.aborts()))


class Left(Program):
    """A motion is awaited and a mode entered; the robot is left."""

    kinds = {"A": MOTION, "M": MODE}

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))
        robot.may("the program enters a mode", lambda: robot.start("M", robot.enters("M")))
        robot.may("the program leaves the robot", lambda: robot.start("leave", robot.leaves()))


class Lost(Program):
    """A motion is awaited, and its connection breaks."""

    departures = 2

    kinds = {"A": MOTION}

    async def begin(self, robot: Robot) -> None:
        robot.start("A", robot.awaits("A"))


class Overdue(Program):
    """A stream has ended whose worker could not end its mode; a motion is awaited."""

    kinds = {"M": MODE, "A": MOTION}

    def prepare(self, run: Run) -> None:
        run["M"].asked = 0
        run.controller.begin(run["M"])
        run.apart = True

    async def begin(self, robot: Robot) -> None:
        modes = robot.coordinator.modes
        modes.enter("end_realtime_mode")
        modes.overdue("end_realtime_mode")
        robot.start("A", robot.awaits("A"))


ALL = Program.__subclasses__()


def tried(kind: type[Program], departures: int | None = None) -> Tried:
    """Try all runs of a program with up to a number of departures."""

    def once(choices: Choices) -> None:
        program = kind()
        run = Run(choices, program.kinds)
        run.breaks, run.arrivals = program.breaks, 9
        program.prepare(run)
        current[:] = [run]
        run.go(program.begin)

    with virtual_time() as current:
        return depart(once, kind.departures if departures is None else departures)
