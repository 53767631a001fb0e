"""One run: a program moves the arm, its processes are frozen and thawed, and the arm is watched."""

from __future__ import annotations

import itertools
import math
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from . import processes
from .arm import Arm
from .cells import GUARDS, PAUSE, Cell, Draw
from .clock import StandingClock, compiled, now
from .judge import ERROR, REST_LIMIT, Line, Verdict, Way, judge
from .judge import goes_on_by_design as by_design

_TESTS = Path(__file__).parents[2]

#: until the arm moves, after the program was started [s]
_START = 60.0
#: speed from which it moves [rad/s]
_MOVING = 0.05
#: between two looks at the arm [s]
_LOOK = 0.03
#: for which the arm is watched after it had to be at rest [s]
_AFTER = 1.5
#: for which it is watched if nothing of the program is left, or if it goes on by design [s]
_GONE, _ON = 0.7, 1.2


@dataclass(frozen=True, slots=True)
class Patience:
    """How much of the machine a verdict asks for.

    Attributes:
        rest: time from the thaw within which a moving arm must have come to rest [s].
        late: by which the simulator and this process may be late, before a run is begun anew [s];
            a quarter of it for the end of a short freeze.
        quiet: for which an arm has stood when the run is over before its time [s].
        attempts: how often a run is begun that nothing can be said about.
    """

    rest: float = REST_LIMIT
    late: float = 0.4
    quiet: float = math.inf
    attempts: int = 6


#: for verdicts that do not depend on how busy the machine is; no program ends before `rest`
PATIENT = Patience(rest=10.0, late=math.inf, quiet=3.0, attempts=20)


class Ended(Exception):
    """All runs are to end."""


class Again(Exception):
    """Nothing can be said about a run: the machine was too slow for it."""


class Tools:
    """What all runs need: made once, in a folder that is removed at the end."""

    def __init__(self, *, plans: bool, suspends: bool) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="freeze-")
        folder = Path(self._folder.name)
        self.plan = folder / "plan"
        self.library = compiled(folder) if suspends else None
        self.ended = threading.Event()
        self._prefix, self._numbers = f"{os.getpid()}-{time.time_ns()}", itertools.count()
        if plans:
            # in a process of its own: planning takes seconds and a lot of memory
            command = [sys.executable, "-m", "hostile.freeze.planned", str(self.plan)]
            subprocess.run(command, env=_environment(), check=True)

    def mark(self) -> str:
        """A mark that no other run has."""
        return f"{self._prefix}-{next(self._numbers)}"

    def close(self) -> None:
        """Remove the folder."""
        self._folder.cleanup()

    def wait(self, until: float) -> None:
        """Wait until a time."""
        if self.ended.wait(max(until - now(), 0.0)):
            raise Ended


@dataclass
class Result:
    """What came of a run.

    Attributes:
        cell: what was tried.
        seed: its number.
        verdict: what is said about the arm.
        told: what the program was told first, and when since the thaw; empty if nothing.
        retries: why it was begun anew.
        said: all that the program said, with times since the thaw.
        seconds: how long it took, with all attempts.
    """

    cell: Cell
    seed: int
    verdict: Verdict = field(default_factory=lambda: Verdict(ERROR, ""))
    told: str = ""
    retries: list[str] = field(default_factory=list)
    said: list[Line] = field(default_factory=list)
    seconds: float = 0.0

    def __str__(self) -> str:
        told = f"; told {self.told[:90]}" if self.told else "; not told"
        again = f"; retried: {', '.join(self.retries)}" if self.retries else ""
        verdict = self.verdict
        return f"{verdict.kind:7} {self.cell}, seed {self.seed}: {verdict.text}{told}{again}"


def trial(cell: Cell, seed: int, arm: Arm, tools: Tools, patience: Patience) -> Result:
    """Try it, again if the machine was too slow. What goes wrong with the run is its result."""
    result = Result(cell, seed)
    begin = now()
    while result.verdict.kind == ERROR and len(result.retries) < patience.attempts:
        try:
            _Trial(result, arm, tools, patience).run()
        except Again as exc:
            result.verdict = Verdict(ERROR, f"{patience.attempts} times nothing could be said")
            result.retries.append(str(exc))
        except (OSError, TimeoutError, EOFError) as exc:
            result.verdict = Verdict(ERROR, f"{type(exc).__name__}: {exc}")
            break
    result.seconds = now() - begin
    return result


class _Trial:
    def __init__(self, result: Result, arm: Arm, tools: Tools, patience: Patience) -> None:
        self._result = result
        self._cell = result.cell
        self._draw = Draw.of(result.cell, result.seed)
        self._arm = arm
        self._tools = tools
        self._patience = patience
        self._mark = tools.mark()
        self._said: list[Line] = []

    def run(self) -> None:
        """Run the program, and judge what came of it."""
        with ExitStack() as stack:
            port = self._arm.begin()
            stack.callback(self._arm.end)
            clock = None
            if self._cell.how == "suspended":
                assert self._tools.library is not None
                clock = stack.enter_context(StandingClock(self._tools.library))
            program = stack.enter_context(self._program(port, clock))
            self._until_it_moves(program)
            frozen, thawed = self._freeze(program, clock)
            self._watch(program, thawed)
            way = Way(self._arm.seen)
        self._say(way, frozen, thawed)

    @contextmanager
    def _program(self, port: int, clock: StandingClock | None) -> Iterator[subprocess.Popen[str]]:
        cell = self._cell
        options = (str(port), cell.scene, GUARDS[cell.guarded], str(self._draw.variant))
        with subprocess.Popen(
            [sys.executable, "-m", "hostile.freeze.program", *options, str(self._tools.plan)],
            env={
                **_environment(),
                processes.MARK: self._mark,
                **({} if clock is None else clock.environment),
            },
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            # a Ctrl-C at the terminal is for the tests
            start_new_session=True,
        ) as process:
            reader = threading.Thread(target=self._read, args=(process.stdout,))
            reader.start()
            try:
                yield process
            finally:
                processes.kill(self._mark)
                reader.join()

    def _read(self, lines: Iterable[str]) -> None:
        for line in lines:
            at, what, *text = line.rstrip("\n").split(" ", 2)
            self._said.append(Line(float(at), what, " ".join(text)))

    def _until_it_moves(self, program: subprocess.Popen[str]) -> None:
        """Wait until the arm is as it is to be when the processes are frozen."""
        until = now() + _START
        while Way(self._arm.seen).speed() < _MOVING:
            self._goes_on(program)
            if now() > until:
                raise Again(f"the arm did not move within {_START:g} s")
            self._tools.wait(now() + _LOOK)
        if not self._pauses:
            self._tools.wait(now() + self._draw.delay)
        else:
            seen = len(self._said)
            while not any(line.what == "pause" for line in self._said[seen:]):
                self._goes_on(program)
                self._tools.wait(now() + _LOOK / 10)
            # in the first half of the pause
            self._tools.wait(self._said[-1].at + self._draw.delay * PAUSE / 2)
        self._goes_on(program)

    @property
    def _pauses(self) -> bool:
        """Whether the arm is to stand between two motions."""
        return self._cell.scene == "motion" and not self._draw.variant

    def _goes_on(self, program: subprocess.Popen[str]) -> None:
        told = next((line.text for line in self._said if line.what == "told"), None)
        if told is not None or program.poll() is not None:
            raise Again(f"it ended before the freeze ({told or 'without a word'})")

    def _freeze(
        self, program: subprocess.Popen[str], clock: StandingClock | None
    ) -> tuple[float, float]:
        """Freeze processes, and thaw them. Returns when that was [s]."""
        cell, draw = self._cell, self._draw
        found = processes.roles_of(self._mark, program.pid)
        if not cell.roles <= set(found.values()):
            raise Again(f"there were only {', '.join(found.values())}")
        every = cell.frozen.startswith("all")
        chosen = [
            pid
            for role, pid in sorted((role, pid) for pid, role in found.items())
            if role in cell.roles or (every and role == "other")
        ]
        chance = random.Random(draw.order)
        chance.shuffle(chosen)
        frozen = now()
        processes.freeze(chosen)
        stopped = now()
        if not self._pauses and Way(self._arm.seen).left(frozen - 0.2) > frozen:
            raise Again("the arm had stopped before the freeze")
        if draw.killed is not None:
            self._tools.wait(stopped + draw.killed)
            program.kill()
        self._tools.wait(stopped + draw.seconds)
        if clock is not None:
            clock.stand(now() - stopped)
        chance.shuffle(chosen)
        thawed = now()
        processes.thaw(chosen)
        late = self._patience.late * (0.25 if cell.how == "0.3" else 1.0)
        if thawed - frozen > draw.seconds + late:
            raise Again(f"it was frozen for {thawed - frozen:.2f} s")
        if any(line.what == "told" and line.at < frozen for line in self._said):
            raise Again("it ended before the freeze")
        return frozen, thawed

    def _watch(self, program: subprocess.Popen[str], thawed: float) -> None:
        """Wait until enough was seen of the arm."""
        patience, draw = self._patience, self._draw
        on = by_design(self._cell, draw.variant, draw.seconds)
        while (after := now() - thawed) < patience.rest + _AFTER:
            self._tools.wait(now() + 4 * _LOOK)
            way = Way(self._arm.seen)
            if on and after > _ON and way.left(thawed) < math.inf:
                return
            stands = after - way.moved_last(thawed)
            if stands > patience.quiet:
                return
            gone = program.poll() is not None and not processes.of_run(self._mark)
            if gone and stands > _GONE:
                return

    def _say(self, way: Way, frozen: float, thawed: float) -> None:
        result = self._result
        result.said = [line._replace(at=line.at - thawed) for line in self._said]
        told = next((line for line in result.said if line.what == "told"), None)
        result.told = "" if told is None else f"at {told.at:+.2f} s: {told.text}"
        late = way.late(frozen - 0.2, thawed + 1.0)
        if late > self._patience.late:
            raise Again(f"the simulator was late by {late:.2f} s")
        result.verdict = judge(
            self._cell, self._draw.variant, way, (frozen, thawed), self._said, self._patience.rest
        )


def _environment() -> dict[str, str]:
    path = os.pathsep.join(filter(None, [str(_TESTS), os.environ.get("PYTHONPATH")]))
    return {**os.environ, "PYTHONPATH": path}
