"""The program's side of a trial: where its connections lead, and what is noted of its calls."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from aioduco._process.trial import Trial
from aioduco.envelope.ways import WAYS
from aioduco.errors import EnvelopeViolated
from aioduco.models.host_port import host_port
from aioduco.supervision.settings import RobotSettings
from aioduco.testing.preflight import lines
from aioduco.testing.preflight.going_on import GOES_ON
from aioduco.testing.preflight.handlers import handled
from aioduco.testing.preflight.run_recorder import CHECKED, CheckedMotion, RunRecorder

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

    from _typeshed import DataclassInstance

    from aioduco.testing.preflight.program_clock import ProgramClock
    from aioduco.testing.preflight.tried_controller import ProgramSimulator

    Settings = TypeVar("Settings", bound=DataclassInstance)


_CONNECT_TIMEOUT = 15.0
#: least time-outs of robots and streams [s]: a busy computer is not the program's fault
_LEAST = {
    "call_timeout": 15.0,
    "connect_timeout": _CONNECT_TIMEOUT,
    "loop_stall_limit": 20.0,
    "timeout": 15.0,
    "away_limit": 20.0,
}
_HEARTBEAT = 30.0
#: modules through which a motion is started
_STARTING = frozenset({__name__, "aioduco._process.trial", "aioduco.supervision.command"})


class TriedProgram(Trial):
    """Leads the program to its simulator, and records what it does.

    Args:
        clock: the program's time.
        recorder: records the calls.
        simulator: the simulator to which connections lead.
    """

    def __init__(
        self, clock: ProgramClock, recorder: RunRecorder, simulator: ProgramSimulator
    ) -> None:
        self._clock = clock
        self._recorder = recorder
        self._simulator = simulator
        #: addresses of controllers that the program named
        self._arms: set[tuple[str, int]] = set()

    def endpoint(self, host: str, port: int, timeout: float) -> tuple[str, int, float]:
        """All connections lead to the simulator."""
        if (host, port) not in self._simulator.homes | self._arms:
            if self._arms:
                self._recorder.second_arm(f"connects to a second arm, {host_port(host, port)}")
            self._arms.add((host, port))
        return (*self._simulator.address(), max(_CONNECT_TIMEOUT, timeout))

    def settings(self, given: Settings) -> Settings:
        """Longer time-outs; a robot has the simulator's time, and no guard."""
        changed: dict[str, Any] = {
            name: max(least, getattr(given, name))
            for name, least in _LEAST.items()
            if hasattr(given, name)
        }
        if isinstance(given, RobotSettings):
            simulator = self._simulator.simulator
            assert simulator is not None  # it was asked for its address before
            changed.update(guard=None, lag_limit=None, clock=simulator.clock)
            if given.heartbeat is not None:
                changed["heartbeat"] = max(_HEARTBEAT, given.heartbeat)
        return replace(given, **changed)

    def call(
        self, name: str, args: tuple[Any, ...], *, vendor: bool = False
    ) -> Callable[[Any, BaseException | None], object]:
        """Record the call."""
        return self._recorder.call(name, args, vendor=vendor)

    def now(self) -> float:
        """The program's time."""
        return self._clock.now()

    def sleep(self, seconds: float) -> None:
        """Let the program's time pass."""
        self._clock.sleep(seconds)

    @contextmanager
    def untimed(self) -> Iterator[None]:
        """Hold the program's time."""
        self._clock.call_begins()
        try:
            yield
        finally:
            self._clock.call_ends()

    @contextmanager
    def waiting(self) -> Iterator[Callable[[], object]]:
        """Let the program's time pass until the thread of the robot has what is waited for."""
        with self._clock.waiting() as wait:
            yield lambda: self._clock.wake(wait)

    def at_own_pace(self, over: Callable[[], bool]) -> None:
        """Let the program's time pass as the wall clock's."""
        self._clock.stream_begins(over)

    # -- motions -------------------------------------------------------------------------------

    def made(self, motion: object) -> None:
        """Note the line that made a motion."""
        self._recorder.made[id(motion)] = lines.current()

    def forgotten(self, motion: object, text: str, *, used: bool) -> None:
        """Report a motion that was never sent."""
        origin = self._recorder.made.pop(id(motion), None)
        if not used:
            self._recorder.never_awaited(origin and origin.where, text)

    def started(self) -> AbstractContextManager[None]:
        """The program gets the errors of a motion that it starts by another line.

        This package gets those of the motions that it starts itself, but for blocking programs.
        """
        frame: FrameType | None = sys._getframe(1)
        while frame is not None and frame.f_globals.get("__name__") in _STARTING:
            frame = frame.f_back
        if frame is None:
            return nullcontext()
        module = str(frame.f_globals.get("__name__", ""))
        if module.startswith("aioduco.sync.") or lines.is_program(frame.f_code.co_filename):
            return lines.later()
        return nullcontext()

    # -- the envelope: a motion that leaves it is a finding, and is carried out ------------------

    def checked(self, name: str) -> None:
        """Note the motion that the running task sends next."""
        CHECKED.set(CheckedMotion(name))

    def beyond(self, name: str, found: object) -> bool:
        """A motion whose path is known is sent, unless the program handles the error."""
        origin, motion = lines.current(), CHECKED.get()
        if origin is None or motion is None or motion.name != name or name not in WAYS:
            return False
        if handled(origin.waiting, EnvelopeViolated):
            return False
        motion.impossible = f"it would lead beyond the envelope: {found}; {GOES_ON}"
        return True

    def slowed(self, share: float) -> None:
        """Note that the envelope slows the motion down."""
        if (motion := CHECKED.get()) is not None:
            motion.slowed *= share
