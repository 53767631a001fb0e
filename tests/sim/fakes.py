"""A mover and an arm that are simple enough to be predicted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aioduco.kinematics import arm
from aioduco.sim.cabinet.script import ProgramError
from aioduco.sim.controller.state_machine import Controller
from aioduco.sim.cycle import DriveCommand, SensedState
from aioduco.sim.force.control import ForceControl
from aioduco.sim.planner.path import JointSetPoint, PlanError
from aioduco.sim.planner.slices import yield_now

Vector = NDArray[np.float64]
HOME = np.zeros(6)
CYCLE = 0.001


@dataclass(frozen=True)
class Leg:
    """A motion at constant speed: so many cycles, then so many to stop or pause it."""

    target: Vector
    cycles: int
    blends: bool = False

    @property
    def radius(self) -> float:
        return 0.01 if self.blends else 0.0


def leg(joint: float, cycles: int = 10, *, blends: bool = False) -> Callable[[Vector], Any]:
    """A plan: all joints to one angle."""
    return lambda _start: Leg(np.full(6, joint), cycles, blends)


def impossible(code: Any = "unreachable") -> Callable[[Vector], Any]:
    def plan(_start: Vector) -> Leg:
        raise PlanError(code, "out of reach")

    return plan


class FakeDrafted(NamedTuple):
    key: int
    segment: Any


class FakeDraft(NamedTuple):
    key: int
    plan: Callable[[Vector], Any]
    start: Vector

    def work(self) -> FakeDrafted:
        segment = self.plan(self.start)
        yield_now()
        return FakeDrafted(self.key, segment)


class FakeMover:
    """Moves at constant speed; takes `BRAKING` cycles to stand."""

    BRAKING = 3
    latest: ClassVar[FakeMover | None] = None

    #: until the running motion is at its end: not known
    time_left = 0.0
    cycle = CYCLE

    def __init__(self, q: Vector) -> None:
        FakeMover.latest = self
        self.setpoint = JointSetPoint.at_rest(np.array(q))
        self.fraction = 1.0
        self.axes: dict[int, float] = {}
        self.paused = False
        self._queue: list[tuple[int, Callable[[Vector], Any]]] = []
        self._active: tuple[int, Leg] | None = None
        self._left = 0
        self._braking = 0
        self._then = ""

    @property
    def moving(self) -> bool:
        waiting = bool(self._queue) and not self.paused
        return waiting or self._braking > 0 or (self._active is not None and not self.paused)

    @property
    def active(self) -> int | None:
        return None if self._active is None else self._active[0]

    @property
    def progress(self) -> float:
        return 1.0 if self._active is None else 1.0 - self._left / self._active[1].cycles

    def append(self, key: int, plan: Callable[[Vector], Any]) -> None:
        if self._active is None and not self._queue:
            made = plan(self.setpoint.q)
            self._queue.append((key, lambda _q: made))
        else:
            self._queue.append((key, plan))

    def draft(self, key: int, plan: Callable[[Vector], Any]) -> FakeDraft:
        return FakeDraft(key, plan, self.setpoint.q)

    def take(self, drafted: FakeDrafted) -> bool:
        self._queue.append((drafted.key, lambda _q: drafted.segment))
        return True

    def tick(self) -> Any:
        events: list[tuple[int, str]] = []
        if self._braking:
            self._braking -= 1
            if not self._braking and self._then == "stop":
                if self._active is not None:
                    events.append((self._active[0], "stopped"))
                self._active, self._queue = None, []
            return _Tick(self.setpoint, tuple(events))
        if self.paused:
            return _Tick(self.setpoint, ())
        while self._active is None and self._queue:
            key, plan = self._queue.pop(0)
            try:
                planned = plan(self.setpoint.q)
            except PlanError:
                continue  # the queue has ended its task already
            self._active, self._left = (key, planned), planned.cycles
            events.append((key, "started"))
        if self._active is not None:
            key, planned = self._active
            q = self.setpoint.q + (planned.target - self.setpoint.q) / self._left
            self.setpoint = JointSetPoint.at_rest(q)
            self._left -= 1
            if not self._left:
                events.append((key, "blended" if planned.blends and self._queue else "finished"))
                self._active = None
        return _Tick(self.setpoint, tuple(events))

    def pause(self) -> None:
        self._brake("pause")
        self.paused = True

    def resume(self) -> None:
        self.paused = False
        self._braking = 0

    def stop(self) -> None:
        if self.paused and not self._braking:
            self._active, self._queue = None, []
        self.paused = False
        if self._active is None:
            self._queue = []
        else:
            self._brake("stop")

    def set_speed(self, fraction: float) -> None:
        self.fraction = fraction

    def _brake(self, then: str) -> None:
        self._then = then
        self._braking = self.BRAKING


class FakeRun:
    """A program of so many cycles, which queues a motion in the first, and may break in the last.

    Args:
        controller: which is asked for the motion.
        cycles: how many it takes.
        breaks: whether it cannot go on in its last.
    """

    def __init__(self, controller: Controller, cycles: int, *, breaks: bool = False) -> None:
        self.controller = controller
        self.left = cycles
        self.breaks = breaks
        self.closed = 0
        self.motion: int | None = None

    def go_on(self, passed: float) -> bool:
        assert passed >= 0.0
        assert not self.closed
        if self.motion is None:
            self.motion = self.controller.move("movej2", leg(0.5, 5))
        self.left -= 1
        if self.left > 0:
            return False
        if self.breaks:
            raise ProgramError("broken")
        return True

    def close(self) -> None:
        self.closed += 1


@dataclass(frozen=True)
class _Tick:
    setpoint: JointSetPoint
    events: tuple[tuple[int, str], ...]


def controller_of(mover: type[FakeMover], q: Vector = HOME) -> Controller:
    """A controller with a stand-in for the planner."""
    force = ForceControl(arm("gcr5_910"), CYCLE)
    return Controller(mover, q, force)  # type: ignore[arg-type]  # the stand-in


class Bench:
    """A controller with an arm that follows its set-points at once, cycle by cycle."""

    def __init__(self) -> None:
        self.controller = controller_of(FakeMover)
        self.q = HOME.copy()
        self.wrench = np.zeros(6)
        self.external = np.zeros(6)
        self.cycle = 0
        self.drive: DriveCommand | None = None

    @property
    def time(self) -> float:
        return self.cycle * CYCLE

    @property
    def state(self) -> list[int]:
        view = self.controller.view()
        return [int(view.robot), int(view.program), int(view.safety), int(view.mode)]

    def tick(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.cycle += 1
            still = np.zeros(6)
            sensed = SensedState(self.time, self.time, self.q, still, self.wrench, self.external)
            drive = self.controller.tick(sensed)
            if not drive.brake:
                self.q = drive.setpoint.q
            self.drive = drive

    def until(self, done: Callable[[], bool], cycles: int = 100_000) -> None:
        for _ in range(cycles):
            if done():
                return
            self.tick()
        raise AssertionError(f"not within {cycles} cycles")

    def ended(self, id_: int) -> int:
        """Run until a task has ended; its state."""
        self.until(lambda: self.controller.tasks.state(id_).ended)
        return int(self.controller.tasks.state(id_))

    def power(self, *changes: str) -> Bench:
        """Change the power so, one change after the other."""
        for name in changes:
            assert self.ended(self.controller.power.request(name)) == 4
        return self

    def enabled(self) -> Bench:
        return self.power("power_on", "enable")

    def begun(self, cycles: int = 1000) -> int:
        """A motion of so many cycles, of which ten have passed."""
        id_ = self.controller.move("movej2", leg(1.0, cycles))
        self.tick(10)
        return id_
