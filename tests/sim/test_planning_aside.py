"""While a motion is planned, commands, cycles and stops go on."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from aioduco._wire.rpc import Op
from aioduco.errors import ConnectionLost, ControllerError
from aioduco.models.enums import ProgramState, TaskState
from aioduco.models.pose import Pose
from aioduco.sim.controller.motion_queue import Planning
from aioduco.sim.controller.state_machine import Controller
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planning import PlanningThreads
from aioduco.sim.simulator import READY, Simulator
from aioduco.testing import eventually

from .conftest import Aside, Connect, Program, Started, let_pass
from .fakes import Bench, impossible, leg

LEFT, RIGHT = [0.3, *READY[1:]], [-0.3, *READY[1:]]


class Parking:
    """Parks planning in its middle: it comes to no further slice until it is let go."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.reached = threading.Event()
        self.go = threading.Event()
        self.turns = 0
        self.after = 10  # turns that it has before
        self.now: Callable[[], float] = lambda: 0.0
        self.times: list[float] = []  # simulated times of the turns
        yield_hook = PlanningThreads.yield_hook

        def parked(planning: PlanningThreads) -> None:
            self.turns += 1
            self.times.append(self.now())
            if self.turns > self.after:
                self.reached.set()
                while not self.go.wait(0.001):
                    yield_hook(planning)  # as between any two slices, but there is no next one
            yield_hook(planning)

        monkeypatch.setattr(PlanningThreads, "yield_hook", parked)

    def wait(self) -> None:
        assert self.reached.wait(30.0)


@pytest.fixture
def parking(monkeypatch: pytest.MonkeyPatch) -> Iterator[Parking]:
    parking = Parking(monkeypatch)
    yield parking
    parking.go.set()


@pytest.fixture
def real(connect: Connect) -> Iterator[tuple[Simulator, Program]]:
    """A simulator in real time, and a client whose robot is enabled."""
    with Simulator(programs={"weaves": [["movel", HERE, 0.1, 1.0]]}) as sim:
        robot = connect(sim)
        robot.bring_up()
        yield sim, robot


HERE = [0.0] * 6  # replaced by the place of the arm in each test that runs the program


def line(robot: Program, *, y: float = 0.1, block: bool = False) -> int:
    there = list(Pose.of(robot.get_tcp_pose()).shifted(y=y))
    return robot.movel(there, 0.1, 1.0, 0.0, [], "", "", block, Op(), False)


def controller_of(sim: Simulator) -> Controller:
    return sim._running().controller


def weave(robot: Program) -> None:
    """Have lines swing fifty times on 0.1 m."""
    config: Any = (2, 0, 50.0, 0.002, 0.0, 0.0, 0.0, [0, 0], False, [])
    assert robot.combine_motion_config(*config) == TaskState.FINISHED
    assert robot.enable_combine_motion() == TaskState.FINISHED


@pytest.mark.slow
@pytest.mark.parametrize("speed", [1.0, math.inf])
def test_a_stop_ends_what_is_being_planned(
    speed: float, started: Started, aside: Aside, parking: Parking
) -> None:
    sim, robot = started(speed=speed)
    weave(robot)
    before = robot.get_actual_joints_position()
    blocking = aside(sim, lambda other: line(other, block=True))
    parking.wait()
    assert robot.get_robot_state()[1] == ProgramState.RUNNING  # the motion is queued
    assert robot.speed(50.0) == TaskState.FINISHED
    assert not blocking.done()
    assert robot.stop(True) == TaskState.FINISHED
    assert blocking.result(30.0) == TaskState.STOPPED
    turns = parking.turns
    parking.go.set()
    # The next motion is planned, and from where the arm stands.
    assert robot.disable_combine_motion() == TaskState.FINISHED
    assert parking.turns == turns
    np.testing.assert_allclose(robot.get_actual_joints_position(), before, atol=1e-6)
    assert robot.to(*LEFT) == TaskState.FINISHED
    np.testing.assert_allclose(robot.get_actual_joints_position(), LEFT, atol=1e-3)


def test_a_call_that_does_not_block_is_answered_when_its_motion_was_stopped(
    sim: Simulator, robot: Program, aside: Aside, parking: Parking
) -> None:
    asked = aside(sim, line)
    parking.wait()
    robot.stop(True)
    assert robot.get_noneblock_taskstate(asked.result(30.0)) == TaskState.STOPPED


def test_the_arm_goes_on_while_the_next_motion_is_planned(
    real: tuple[Simulator, Program], aside: Aside, parking: Parking
) -> None:
    sim, robot = real
    parking.after = 10**9
    running = robot.to(1.5, *READY[1:], v=0.3, block=False)
    parking.after = parking.turns + 10
    asked = aside(sim, line)
    parking.wait()
    begun, at = sim.time, robot.get_actual_joints_position()[0]
    sim.wait_until(lambda: sim.time > begun + 0.2)
    assert robot.get_actual_joints_position()[0] > at + 0.02
    # Who gives a command meanwhile does not wait for many cycles that were slept past.
    batches = sim._running().runtime._batches
    sim.wait_until(lambda: sim.time > begun + 0.3)
    assert not batches.asleep
    robot.stop(True)
    tasks = [robot.get_noneblock_taskstate(id_) for id_ in (running, asked.result(30.0))]
    assert tasks == [TaskState.STOPPED, TaskState.STOPPED]


def test_without_a_clock_time_stands_while_a_motion_is_planned(
    sim: Simulator, robot: Program, parking: Parking
) -> None:
    parking.after, parking.now = 10**9, lambda: sim.time
    robot.to(1.5, *READY[1:], v=0.1, block=False)
    parking.times.clear()
    line(robot, y=0.05)
    assert len(parking.times) > 10
    assert len(set(parking.times)) == 1
    robot.stop(True)


@pytest.mark.slow
def test_motions_come_in_the_order_of_their_calls(
    sim: Simulator, robot: Program, aside: Aside, parking: Parking, connect: Connect
) -> None:
    weave(robot)
    first = aside(sim, line)
    parking.wait()
    controller = controller_of(sim)
    planned = controller.unplanned
    assert planned is not None
    second = aside(sim, lambda other: other.to(*LEFT, block=False))
    eventually(lambda: controller.unplanned != planned)
    third = aside(sim, lambda other: other.to(*RIGHT, block=False))
    eventually(lambda: controller.unplanned == planned + 2)
    assert not second.done()
    parking.go.set()
    ids = [call.result(30.0) for call in (first, second, third)]
    assert ids == sorted(ids)
    sim.wait_until(lambda: robot.get_noneblock_taskstate(ids[-1]) == TaskState.FINISHED)
    assert [robot.get_noneblock_taskstate(id_) for id_ in ids] == [TaskState.FINISHED] * 3
    np.testing.assert_allclose(robot.get_actual_joints_position(), RIGHT, atol=1e-3)


def test_an_error_in_a_later_slice_is_answered_as_ever(
    sim: Simulator, robot: Program, aside: Aside, parking: Parking
) -> None:
    parking.after = 1  # what is out of reach is further along
    far = aside(sim, lambda other: line(other, y=2.0, block=True))
    parking.wait()
    controller = controller_of(sim)
    planned = controller.unplanned
    behind = aside(sim, lambda other: other.to(*LEFT))
    eventually(lambda: controller.unplanned != planned)
    parking.go.set()
    assert far.result(30.0) == TaskState.ERROR
    assert behind.result(30.0) == TaskState.INTERRUPT
    assert robot.to(*LEFT) == TaskState.FINISHED


def test_a_program_plans_beside_the_cycle(
    real: tuple[Simulator, Program], aside: Aside, parking: Parking
) -> None:
    sim, robot = real
    HERE[:] = Pose.of(robot.get_tcp_pose()).shifted(y=0.1)
    parking.after = 3
    running = aside(sim, lambda other: other.run_program("weaves", True))
    parking.wait()
    let_pass(sim, 0.05)
    assert robot.stop(True) == TaskState.FINISHED
    assert running.result(30.0) == TaskState.STOPPED


def test_a_simulator_ends_while_it_plans(connect: Connect, aside: Aside, parking: Parking) -> None:
    with Simulator(speed=math.inf) as sim:
        robot = connect(sim)
        robot.bring_up()
        asked = aside(sim, lambda other: line(other, block=True))
        parking.wait()
    with pytest.raises((ConnectionLost, ControllerError)):
        asked.result(30.0)


# -- the controller alone --------------------------------------------------------------------------


def test_planning_waits_while_a_command_is_carried_out(monkeypatch: pytest.MonkeyPatch) -> None:
    controller = Bench().enabled().controller
    planning = PlanningThreads(controller, threading.Lock(), lambda: nullcontext(controller), print)
    slept: list[float] = []
    now = 0.0
    command = planning.giving_way()

    def sleep(seconds: float) -> None:
        nonlocal now
        slept.append(seconds)
        now += 0.0011
        if len(slept) == 3:
            command.__exit__(None, None, None)

    monkeypatch.setattr(
        "aioduco.sim.planning.time", SimpleNamespace(sleep=sleep, perf_counter=lambda: now)
    )
    command.__enter__()
    planning.yield_hook()
    assert len(slept) == 3
    with planning.giving_way():  # another that takes long: planning goes on beside it
        slept.clear()
        planning.yield_hook()
        assert len(slept) == 5


@pytest.fixture
def bench() -> Bench:
    bench = Bench().enabled()
    bench.controller.plan_in_background()
    return bench


def state(bench: Bench, id_: int) -> TaskState:
    return bench.controller.tasks.state(id_)


def begin(bench: Bench) -> Planning:
    planning = bench.controller.motion.next_plan()
    assert planning is not None
    return planning


def finish(bench: Bench, planning: Planning) -> None:
    """Plan it, and bring what comes of it."""
    came: Any
    try:
        came = planning.draft.work()
    except PlanError as exc:
        came = exc
    bench.controller.take_plan(planning, came)


def test_a_motion_waits_until_it_is_planned(bench: Bench) -> None:
    id_ = bench.controller.move("movej2", leg(1.0))
    assert bench.controller.unplanned == id_
    bench.tick(10)
    assert state(bench, id_) is TaskState.IDLE
    assert not bench.controller.idle
    planning = begin(bench)
    bench.tick(10)
    finish(bench, planning)
    assert not bench.controller.motion.awaits_plan(id_)
    assert bench.ended(id_) == TaskState.FINISHED
    np.testing.assert_allclose(bench.q, 1.0)


@pytest.mark.parametrize("begun", [False, True])
def test_what_ends_a_queued_motion_ends_one_that_is_planned(bench: Bench, begun: bool) -> None:
    def end(how: Callable[[], object]) -> TaskState:
        id_ = bench.controller.move("movej2", leg(1.0))
        planning = begin(bench) if begun else None
        how()
        assert bench.controller.unplanned is None
        assert bench.controller.motion.planning is None
        if planning is not None:
            finish(bench, planning)  # too late
        bench.tick(10)
        assert bench.controller.idle
        return state(bench, id_)

    controller = bench.controller
    assert end(controller.stop) is TaskState.STOPPED
    assert end(controller.abort) is TaskState.INTERRUPT
    np.testing.assert_array_equal(bench.q, np.zeros(6))
    assert end(controller.press_emergency_stop) is TaskState.ERROR


def test_what_is_behind_one_that_cannot_be_planned_goes_with_it(bench: Bench) -> None:
    ids = [bench.controller.move("movel", plan) for plan in (impossible(), leg(1.0), leg(0.5))]
    finish(bench, begin(bench))
    assert [state(bench, id_) for id_ in ids] == [
        TaskState.ERROR,
        TaskState.INTERRUPT,
        TaskState.INTERRUPT,
    ]
    assert bench.controller.motion.next_plan() is None
    assert bench.controller.view().errors


def test_a_plan_that_fails_during_a_pause_leaves_no_pause(bench: Bench) -> None:
    failing = bench.controller.move("movel", impossible())
    planning = begin(bench)
    pause = bench.controller.pause()
    assert bench.ended(pause) == TaskState.FINISHED
    finish(bench, planning)
    assert state(bench, failing) is TaskState.ERROR
    bench.tick()
    id_ = bench.controller.move("movej2", leg(1.0))
    finish(bench, begin(bench))
    assert bench.ended(id_) == TaskState.FINISHED


def test_a_motion_that_is_planned_during_a_pause_begins_behind_it(bench: Bench) -> None:
    id_ = bench.controller.move("movej2", leg(1.0))
    planning = begin(bench)
    assert bench.ended(bench.controller.pause()) == TaskState.FINISHED
    finish(bench, planning)
    bench.tick(50)
    np.testing.assert_array_equal(bench.q, np.zeros(6))
    bench.controller.resume()
    assert bench.ended(id_) == TaskState.FINISHED
