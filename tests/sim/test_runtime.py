"""The loop: its pace, its sleep, its failure; handlers and commands beside it."""

from __future__ import annotations

import contextlib
import logging
import math
import threading
import time
from collections.abc import Iterator
from functools import partial
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from aioduco.sim import batches
from aioduco.sim import runtime as module
from aioduco.sim.cycle import PlantReading
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.refusal import Refusal
from aioduco.sim.runtime import SimulatedClock, SimulationRuntime
from aioduco.testing import eventually

from .fakes import HOME, FakeMover, controller_of, leg


class Follower:
    """An arm that is where it is told to be; counts its steps, and can break."""

    def __init__(self) -> None:
        self.q = HOME.copy()
        self.steps = 0
        self.broken = False
        self.braked: list[bool] = []

    def touched(self) -> str:
        return ""

    def step(self, setpoint: JointSetPoint) -> None:
        if self.broken:
            raise FloatingPointError("the arm fell apart")
        self.steps += 1
        if not self.braked[-1]:
            self.q = setpoint.q

    def brake(self, on: bool) -> None:
        self.braked.append(on)

    still = True

    def reading(self) -> PlantReading:
        q, none = self.q.copy(), np.zeros(6)
        return PlantReading(q, q, none, none, none, none, none, none)


@pytest.fixture
def arm() -> Follower:
    return Follower()


@contextlib.contextmanager
def running(arm: Follower, speed: float = 1.0) -> Iterator[SimulationRuntime]:
    """A runtime of this arm, in a block."""
    runtime = SimulationRuntime(controller_of(FakeMover), cast("World", arm), speed=speed)
    runtime.start()
    try:
        yield runtime
    finally:
        runtime.close()


@pytest.fixture
def runtime(arm: Follower) -> Iterator[SimulationRuntime]:
    with running(arm, math.inf) as runtime:
        yield runtime


def give(runtime: SimulationRuntime) -> None:
    """A command that changes nothing."""
    with runtime.command():
        pass


def enable(runtime: SimulationRuntime) -> None:
    for name in ("power_on", "enable"):
        with runtime.command() as controller:
            id_ = controller.power.request(name)
        assert runtime.wait(id_) == 4


def test_a_snapshot_never_changes(runtime: SimulationRuntime) -> None:
    enable(runtime)
    before = runtime.snapshot
    q, time_ = before.q.copy(), before.time
    with runtime.command() as controller:
        id_ = controller.move("movej2", leg(1.0, 100))
    assert runtime.wait(id_) == 4
    assert (before.q == q).all()
    assert before.time == time_
    assert runtime.snapshot.time > time_


def test_while_nothing_happens_time_passes_without_physics(
    runtime: SimulationRuntime, arm: Follower
) -> None:
    assert runtime.wait_until(lambda: runtime.snapshot.time > 0.5, 10.0)
    steps = arm.steps
    begin = time.monotonic()
    simulated = runtime.snapshot.time
    assert runtime.wait_until(lambda: runtime.snapshot.time > simulated + 0.5, 10.0)
    # As fast as possible means real time while idle: else a wait for nothing would be over at once.
    assert time.monotonic() - begin > 0.4
    assert arm.steps == steps
    enable(runtime)
    assert arm.steps > steps


def test_brakes_are_told_when_they_change(runtime: SimulationRuntime, arm: Follower) -> None:
    enable(runtime)
    assert runtime.wait_until(lambda: arm.braked[-1] is False, 10.0)
    with runtime.command() as controller:
        controller.press_emergency_stop()
    assert runtime.wait_until(lambda: arm.braked[-1], 10.0)
    assert arm.braked == [True, False, True]


def test_a_wait_for_what_never_comes_ends_in_simulated_time(runtime: SimulationRuntime) -> None:
    begin = runtime.snapshot.time
    assert not runtime.wait_until(lambda: False, 0.2)
    assert runtime.snapshot.time >= begin + 0.2


def test_a_predicate_may_wait_for_the_controller(runtime: SimulationRuntime) -> None:
    enable(runtime)

    def moved() -> bool:
        with runtime.command() as controller:
            id_ = controller.move("movej2", leg(1.0, 50))
        return runtime.wait(id_) == 4

    assert runtime.wait_until(moved, 10.0)


def test_a_command_that_fails_leaves_the_controller_usable(runtime: SimulationRuntime) -> None:
    def fail() -> None:
        with runtime.command() as controller:
            controller.set_speed(40)
            raise KeyError("bad handler")

    with pytest.raises(KeyError, match="bad handler"):
        fail()
    assert runtime.snapshot.view.speed == 40
    enable(runtime)


def test_closing_lets_go_of_waiters(arm: Follower) -> None:
    with running(arm) as runtime:
        with runtime.command() as controller:
            id_ = controller.tasks.new("never")
        ended = threading.Event()

        def wait() -> None:
            with pytest.raises(Refusal, match="ended before the task"):
                runtime.wait(id_)
            ended.set()

        waiter = threading.Thread(target=wait)
        waiter.start()
        assert runtime.wait_until(lambda: bool(runtime._waiters), 10.0)
    waiter.join(10)
    assert ended.is_set()
    with pytest.raises(Refusal):
        runtime.wait(id_)


def test_physics_that_fail_are_answered_by_errors_and_not_by_old_states(
    runtime: SimulationRuntime, arm: Follower, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.CRITICAL):
        enable(runtime)
        with runtime.command() as controller:
            id_ = controller.move("movej2", leg(1.0, 100_000))
        arm.broken = True
        with pytest.raises(Refusal, match="fell apart"):
            runtime.wait(id_)
    with pytest.raises(Refusal, match="fell apart"):
        _ = runtime.snapshot
    with pytest.raises(Refusal, match="fell apart"), runtime.command():
        pass
    with pytest.raises(Refusal, match="fell apart"):  # and is not waited for
        runtime.lock()


@pytest.mark.slow
@pytest.mark.usefixtures("real_cycle", "real_power")
def test_statistics_of_a_loop_in_real_time(arm: Follower) -> None:
    with running(arm) as runtime:
        enable(runtime)
        found = runtime.statistics()
    assert found.cycles > 500
    assert 0.0 <= found.work_p50 <= found.work_p99 <= found.work_max
    assert found.late_p50 <= found.late_p99 <= found.late_max


@contextlib.contextmanager
def in_batches(
    arm: Follower, monkeypatch: pytest.MonkeyPatch
) -> Iterator[tuple[SimulationRuntime, int, list[int]]]:
    """An arm that moves in real time, its task, and how many cycles were due after each sleep.

    The sleeps are longer than they are, so that they are seen.
    """
    for name, value in (("_CYCLES", 50), ("_LONGEST", 0.05), ("_WAIT_TIMEOUT", 60.0)):
        monkeypatch.setattr(batches, name, value)
    controller = controller_of(FakeMover)
    runtime = SimulationRuntime(controller, cast("World", arm), speed=1.0)
    owed: list[int] = []
    sleep_past = runtime._batches._sleep_past

    def noted(now: float, delay: float) -> None:
        sleep_past(now, delay)
        owed.append(runtime._batches._owed)

    monkeypatch.setattr(runtime._batches, "_sleep_past", noted)
    runtime.start()
    try:
        enable(runtime)
        with runtime.command() as controller:
            id_ = controller.move("movej2", leg(1.0, 100_000))
        yield runtime, id_, owed
    finally:
        runtime.close()


@pytest.mark.slow
def test_some_cycles_run_at_one_go_unless_somebody_asks(
    arm: Follower, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who asks ends the sleep, and finds the arm of now."""
    with in_batches(arm, monkeypatch) as (runtime, id_, owed):
        for ask in (
            lambda: runtime.snapshot,
            runtime.now,
            lambda: runtime.task_state(id_),
            lambda: give(runtime),
        ):
            slept = len(owed)
            eventually(lambda: runtime._batches.asleep, 60.0)
            asked = time.monotonic()
            ask()
            assert runtime._pace.due(asked) == 0
            assert len(owed) > slept
        begun = arm.steps
        eventually(lambda: arm.steps > begun + 500, 60.0)
        assert max(owed) > 10


def test_who_waits_for_the_end_of_a_motion_is_told_in_its_cycle(
    arm: Follower, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As long as the end is further off than a sleep is long, cycles run at one go."""
    with in_batches(arm, monkeypatch) as (runtime, id_, owed):
        waiting = threading.Thread(target=_wait_in_vain, args=(runtime, id_))
        waiting.start()
        eventually(lambda: runtime._waiters, 60.0)
        monkeypatch.setattr(FakeMover, "time_left", 10.0)
        eventually(lambda: runtime._batches.asleep, 60.0)
        monkeypatch.setattr(FakeMover, "time_left", 0.01)
        eventually(lambda: not runtime._batches.asleep, 60.0)
        slept, begun = len(owed), arm.steps
        eventually(lambda: arm.steps > begun + 100, 60.0)
        assert len(owed) == slept
        runtime.release()
        waiting.join()


def _wait_in_vain(runtime: SimulationRuntime, id_: int) -> None:
    with pytest.raises(Refusal, match="ended before"):
        runtime.wait(id_)


def test_time_can_be_held(
    runtime: SimulationRuntime, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """At a time, or now; it goes on when it is let go, or after a while."""
    monkeypatch.setattr(module, "_HOLD", 60.0)
    clock = SimulatedClock(runtime)
    at = clock.now() + 0.5
    let_go = clock.hold(at)
    eventually(lambda: clock.now() >= at, 30.0)
    assert clock.now() < at + 2.5 * runtime.cycle
    held = clock.now()
    with runtime.command() as controller:
        controller.set_speed(50)
    assert runtime.snapshot.view.speed == 50  # commands are taken meanwhile
    enabling = threading.Thread(target=enable, args=(runtime,))
    enabling.start()
    assert clock.now() == held
    let_go()
    let_go()
    enabling.join(30.0)
    assert clock.now() > held
    monkeypatch.setattr(module, "_HOLD", 0.01)
    let_go = clock.hold(-math.inf)
    at = clock.now() + 0.1
    eventually(lambda: clock.now() > at, 30.0)
    assert "simulated time was held for 0.01 s, and goes on" in caplog.text
    let_go()


def test_a_command_of_who_holds_time_comes_at_the_time_that_is_read(
    arm: Follower, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also while nothing happens, when many cycles go by at once, some of them due before it."""
    runtime = SimulationRuntime(controller_of(FakeMover), cast("World", arm), speed=math.inf)
    clock = SimulatedClock(runtime)
    wall = 0.0
    monkeypatch.setattr(
        module, "time", SimpleNamespace(perf_counter=lambda: wall, monotonic=lambda: wall)
    )
    allowed = runtime._allowed
    locked = []

    def look() -> int:
        locked.append(runtime._lock.locked())
        return allowed()

    monkeypatch.setattr(runtime, "_allowed", look)
    runtime._pace.begin(wall, idle=True)

    def go_on(seconds: float) -> int:
        nonlocal wall
        wall += seconds
        cycles = runtime._tick(wall, idle=True)
        runtime._pace.ran(cycles)
        return cycles

    assert go_on(0.0201) == 20
    let_go = clock.hold(clock.now())
    assert go_on(0.01) == 0
    let_go()  # before the loop has come to stand still
    read = clock.now()
    assert go_on(0.0) == 0
    assert clock.now() == read
    assert go_on(0.0031) == 3
    let_go()
    assert go_on(0.002) == 2
    clock.hold(clock.now() + 1.0)()  # time never stood by it
    assert go_on(0.002) == 2
    assert all(locked)  # so that no command comes between these cycles and their tick


def test_no_time_after_a_command_passes_before_it_counts(
    arm: Follower, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also while nothing happens, at a speed at which much passes until the thread runs."""
    runtime = SimulationRuntime(controller_of(FakeMover), cast("World", arm), speed=1000.0)
    wall = 0.0
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: wall))
    runtime._pace.begin(wall, idle=True)
    passed = []
    wall = 0.0205
    give(runtime)
    wall = 0.0505
    for _ in range(2):
        passed.append(runtime._tick(wall, idle=True))
        runtime._pace.ran(passed[-1])
    assert passed == [20_500, 30_000]


def _given_up(log: pytest.LogCaptureFixture, times: int) -> bool:
    return log.text.count("and goes on") == times


def test_time_that_is_held_to_last_stands_until_it_is_let_go(
    runtime: SimulationRuntime, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Also where others who held it were given up."""
    monkeypatch.setattr(module, "_HOLD", 0.01)
    clock = SimulatedClock(runtime)
    let_go = clock.hold(-math.inf, lasting=True)
    held = math.nan
    for number in range(1, 6):
        clock.hold(-math.inf)
        eventually(partial(_given_up, caplog, number), 30.0)
        if number == 1:
            held = clock.now()
    assert clock.now() == held
    let_go()
    eventually(lambda: clock.now() > held, 30.0)


def test_a_task_has_ended_only_when_its_snapshot_is_there(
    arm: Follower, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who asks for a task in the midst of a cycle is answered after it, and waits for no lock."""
    runtime = SimulationRuntime(controller_of(FakeMover), cast("World", arm))
    looks = []

    def look(seconds: float) -> None:
        looks.append(seconds)
        runtime._change = None

    stand_in = SimpleNamespace(sleep=look, monotonic=time.monotonic)
    monkeypatch.setattr(module, "time", stand_in)
    with runtime.command() as controller:
        id_ = controller.power.request("power_on")
        state = runtime.task_state(id_)
        assert len(looks) == 1
    assert runtime.task_state(id_) is state
    assert len(looks) == 1


def test_a_snapshot_derives_what_nobody_else_can_change(runtime: SimulationRuntime) -> None:
    snapshot = runtime.snapshot
    snapshot.external_torque[:] = 1.0
    assert not snapshot.external_torque.any()
    assert snapshot.seen(snapshot.view) is snapshot
    other = snapshot.view._replace(speed=5.0)
    assert snapshot.seen(other).view is other
    assert snapshot.seen(other).q is snapshot.q
