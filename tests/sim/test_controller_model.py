"""Invariants after commands and accidents in any order."""

from __future__ import annotations

from typing import cast

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from quick import examples

from aioduco.models.enums import OperationMode, RobotState, SafetyState, TaskState
from aioduco.sim.controller.programs import ProgramRun

from .fakes import Bench, FakeRun, impossible, leg

POWER = ["power_on", "enable", "disable", "power_off", "restart"]


class Commands(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.bench = Bench()
        self.controller = self.bench.controller
        self.last: dict[int, TaskState] = {}
        self.runs: dict[int, FakeRun] = {}

    @rule(name=st.sampled_from(POWER), wait=st.booleans())
    def power(self, name: str, wait: bool) -> None:
        id_ = self.controller.power.request(name)
        if wait:
            self.bench.ended(id_)

    @rule()
    def bring_up(self) -> None:
        """What every program does after a safety stop (facts of public applications)."""
        self.controller.release_emergency_stop()
        self.controller.heartbeat.beat(self.bench.time, 60_000)
        self.bench.ended(self.controller.stop())
        self.bench.power("power_off", "power_on", "enable")
        assert self.bench.state[0] == RobotState.ENABLE
        assert self.bench.state[2] == SafetyState.RUN

    @rule(
        joint=st.floats(-3.0, 3.0),
        cycles=st.integers(1, 200),
        blends=st.booleans(),
        count=st.integers(1, 3),
    )
    def move(self, joint: float, cycles: int, blends: bool, count: int) -> None:
        before = self.controller.view()
        id_ = 0
        for _ in range(count):
            id_ = self.controller.move("movej2", leg(joint, cycles, blends=blends))
        if before.robot is not RobotState.ENABLE or before.safety is not SafetyState.RUN:
            assert self.controller.tasks.state(id_) is TaskState.ILLEGAL

    @rule(code=st.sampled_from(["unreachable", "parameter"]))
    def move_nowhere(self, code: str) -> None:
        self.controller.move("movel", impossible(code))

    @rule(cycles=st.integers(1, 100), breaks=st.booleans())
    def run_program(self, cycles: int, breaks: bool) -> None:
        run = FakeRun(self.controller, cycles, breaks=breaks)
        id_ = self.controller.run_program(cast("ProgramRun", run))
        if not self.controller.tasks.state(id_).ended:
            self.runs[id_] = run
            assert (
                self.controller.tasks.state(self.controller.move("movej2", leg(0.1)))
                is TaskState.ILLEGAL
            )

    @rule(wait=st.booleans())
    def stop(self, wait: bool) -> None:
        before = self.controller.tasks.unfinished()
        id_ = self.controller.stop()
        if wait:
            assert self.bench.ended(id_) == TaskState.FINISHED
            assert not self.controller.view().moving
            motions = [task.id for task in before if task.name.startswith("move")]
            assert all(self.controller.tasks.state(motion).ended for motion in motions)

    @rule()
    def abort(self) -> None:
        self.controller.abort()

    @rule(wait=st.booleans())
    def pause(self, wait: bool) -> None:
        id_ = self.controller.pause()
        if wait:
            assert self.bench.ended(id_) == TaskState.FINISHED

    @rule()
    def resume(self) -> None:
        self.controller.resume()

    @rule(mode=st.sampled_from([OperationMode.MANUAL, OperationMode.AUTO]))
    def switch_mode(self, mode: OperationMode) -> None:
        self.controller.switch_mode(mode)

    @rule()
    def emergency_stop(self) -> None:
        self.controller.press_emergency_stop()

    @rule()
    def release(self) -> None:
        self.controller.release_emergency_stop()

    @rule(joint=st.integers(1, 6))
    def collide(self, joint: int) -> None:
        self.controller.collide(joint)

    @rule()
    def safety_limit(self) -> None:
        self.controller.fault(SafetyState.STOP1, "safety limit")

    @rule(time=st.integers(200, 500))
    def beat(self, time: int) -> None:
        self.controller.heartbeat.beat(self.bench.time, time)

    @rule(cycles=st.integers(1, 300))
    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            before = self.bench.q
            self.bench.tick()
            assert self.bench.drive is not None
            if self.bench.drive.brake:
                assert (self.bench.q == before).all()
            else:
                assert self.bench.state[0] == RobotState.ENABLE
                assert self.bench.state[2] != SafetyState.STOP0

    @invariant()
    def tasks_that_ended_stay_as_they_were(self) -> None:
        for id_, state in self.last.items():
            assert self.controller.tasks.state(id_) is state
        for id_ in self.controller.tasks.take_answered():
            assert id_ not in self.last
            state = self.controller.tasks.state(id_)
            if state.ended:  # not one that was passed on
                self.last[id_] = state

    @invariant()
    def a_run_is_closed_once_when_its_task_ends(self) -> None:
        for id_, run in self.runs.items():
            assert run.closed == self.controller.tasks.state(id_).ended

    @invariant()
    def the_program_stands_when_no_task_is_left(self) -> None:
        self.bench.tick(2)
        if not self.controller.tasks.unfinished():
            assert self.bench.state[1] == 0

    def teardown(self) -> None:
        """Whatever happened: what is under way ends by itself, or by a stop."""
        self.bench.ended(self.controller.stop())
        self.bench.until(lambda: not self.controller.busy)
        assert self.controller.tasks.unfinished() == ()


TestCommands = Commands.TestCase
TestCommands.settings = settings(max_examples=examples(40), stateful_step_count=25, deadline=None)
