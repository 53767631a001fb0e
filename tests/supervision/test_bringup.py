"""Bring-up from any state to readiness, or an error that says what a person must do."""

from __future__ import annotations

import asyncio
import itertools

import hypothesis.strategies as st
import pytest
from client.bench import Bench
from for_each import for_each
from hypothesis import given

import aioduco
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState, TaskState
from aioduco.models.state import RobotStates
from aioduco.supervision.bringup import BringUp, BringUpStep
from aioduco.testing import eventually_async


def seen(
    robot: int = 6, program: int = 0, safety: int = 5, mode: int = 1, sequence: int = 0
) -> RobotStates:
    return RobotStates(
        sequence=sequence,
        received_at=0.0,
        robot=RobotState(robot),
        program=ProgramState(program),
        safety=SafetyState(safety),
        mode=OperationMode(mode),
    )


def step(
    decide: BringUp, states: RobotStates, *, emergency_stop: bool = False, collision: bool = False
) -> BringUpStep:
    return decide.next(states, emergency_stop=emergency_stop, collision=collision)


def test_the_steps_from_power_off() -> None:
    decide = BringUp()
    assert step(decide, seen(robot=0, safety=13)) is BringUpStep.WAIT
    assert step(decide, seen(robot=4, safety=4)) is BringUpStep.POWER_ON
    assert step(decide, seen(robot=4, safety=4)) is BringUpStep.WAIT  # asked for once
    assert step(decide, seen(robot=5)) is BringUpStep.ENABLE
    assert step(decide, seen(robot=5)) is BringUpStep.WAIT
    assert step(decide, seen(robot=6)) is BringUpStep.DONE
    assert step(decide, seen(robot=6)) is BringUpStep.DONE


@for_each("safety", [7, 8, 9])
def test_the_steps_after_a_safety_stop(safety: int) -> None:
    decide = BringUp()
    assert step(decide, seen(robot=6, safety=safety)) is BringUpStep.POWER_OFF
    assert step(decide, seen(robot=6, safety=safety)) is BringUpStep.WAIT
    assert step(decide, seen(robot=4, safety=safety)) is BringUpStep.POWER_ON
    assert step(decide, seen(robot=5, safety=safety)) is BringUpStep.WAIT
    assert step(decide, seen(robot=5)) is BringUpStep.ENABLE
    # It comes back at once: the power is not switched for ever.
    assert step(decide, seen(robot=5, safety=safety)) is BringUpStep.WAIT


def test_a_collision_is_reset_once() -> None:
    decide = BringUp()
    assert step(decide, seen(), collision=True) is BringUpStep.RESET_COLLISION
    assert step(decide, seen()) is BringUpStep.DONE


def test_to_recover_stops_what_is_paused_and_waits_for_what_is_stopping() -> None:
    decide = BringUp(end_programs=True)
    assert step(decide, seen(program=1)) is BringUpStep.WAIT
    assert step(decide, seen(program=3)) is BringUpStep.STOP
    assert step(decide, seen(program=0)) is BringUpStep.DONE


def test_to_bring_up_leaves_what_is_paused_after_a_wait_alone() -> None:
    decide = BringUp()
    assert step(decide, seen(program=1)) is BringUpStep.WAIT
    with pytest.raises(aioduco.RobotStateError, match="is paused"):
        step(decide, seen(program=3))


@for_each("mode", [0, 1, 2])
def test_the_operation_mode_is_left_alone(mode: int) -> None:
    assert step(BringUp(), seen(mode=mode)) is BringUpStep.DONE


@for_each(
    "states, emergency_stop, words",
    [
        (seen(), True, "an emergency stop is pressed.*release the button"),
        (seen(safety=14), False, "fatal error: switch the cabinet off and on"),
        (seen(safety=6), False, "recovery mode: bring the arm back"),
        (seen(safety=3), False, "being configured"),
        (seen(safety=10), False, "model is being configured"),
        (seen(safety=99), False, "being updated"),
        (seen(robot=7), False, "being updated"),
        (seen(program=2), False, r"busy \(program RUNNING\).*robot.stop\(\)"),
        (seen(program=5), False, r"busy \(program TASK_RUNNING\)"),
        (seen(program=3), False, r"is paused.*robot.resume\(\).*Nothing was done to it"),
        (seen(program=4), False, r"is paused.*robot.recover\(\)"),
    ],
)
def test_what_needs_a_person_says_so(states: RobotStates, emergency_stop: bool, words: str) -> None:
    with pytest.raises(aioduco.RobotStateError, match=words):
        step(BringUp(), states, emergency_stop=emergency_stop)


@given(
    st.lists(
        st.tuples(st.integers(0, 7), st.integers(0, 5), st.sampled_from(list(SafetyState))),
        max_size=40,
    ),
    st.booleans(),
)
def test_no_sequence_of_states_asks_for_a_step_twice(
    sequence: list[tuple[int, int, SafetyState]], collision: bool
) -> None:
    decide = BringUp()
    asked: list[BringUpStep] = []
    for robot, program, safety in sequence:
        try:
            made = step(decide, seen(robot, program, int(safety)), collision=collision)
        except aioduco.RobotStateError:
            continue
        if made is BringUpStep.DONE:
            assert robot == RobotState.ENABLE
            assert program == ProgramState.STOPPED
        elif made is not BringUpStep.WAIT:
            asked.append(made)
    assert len(asked) == len(set(asked))


async def test_from_power_off_to_ready(robot: aioduco.Robot, bench: Bench) -> None:
    bench.states[:3] = [4, 0, 4]
    report = await robot.bring_up()
    assert report.states.robot is RobotState.ENABLE
    assert report.sensor_tared
    assert report.advice == "", "nothing was touched at the last stop"
    assert bench.commands == ["power_on", "enable"]


async def test_a_robot_that_is_ready_is_left_alone(robot: aioduco.Robot, bench: Bench) -> None:
    await robot.bring_up()
    assert bench.commands == []


async def test_what_can_be_cleared_is_cleared(robot: aioduco.Robot, bench: Bench) -> None:
    bench.collision = True
    bench.states[:3] = [6, 3, 7]
    await robot.bring_up()
    assert bench.commands == [
        "collision_detection_reset",
        "power_off",
        "power_on",
        "enable",
        "stop",
    ]


@pytest.mark.parametrize("name", ["bring_up", "recover"])
async def test_a_report_says_when_the_force_sensor_was_tared(
    robot: aioduco.Robot, bench: Bench, name: str
) -> None:
    make_ready = getattr(robot, name)
    report = await make_ready()
    assert not report.sensor_tared
    assert report.advice == ""
    assert str(report) == str(report.states)
    bench.collision = True
    bench.states[:3] = [6, 3, 7]
    report = await make_ready()
    assert report.collision
    assert report.sensor_tared
    assert "After the collision it may still touch something" in report.advice
    assert "fc_force_set_value" in str(report)
    bench.states[:3] = [6, 3, 7]
    report = await make_ready()
    assert "If it touches something" in report.advice


async def test_an_emergency_stop_is_for_a_person(robot: aioduco.Robot, bench: Bench) -> None:
    bench.emergency_stop = True
    bench.states[:3] = [4, 0, 9]
    with pytest.raises(aioduco.RobotStateError, match="release the button"):
        await robot.bring_up()
    assert bench.commands == []


async def test_states_that_lag_behind_are_waited_for(robot: aioduco.Robot, bench: Bench) -> None:
    """The task has ended, the states follow later: nothing is sent twice."""
    bench.states[0] = 4
    looks = itertools.count()

    def states() -> list[int]:
        look = next(looks)
        if look >= 12:
            return [6, 0, 5, 1]
        return [5, 0, 5, 1] if look >= 6 else [4, 0, 4, 1]

    bench.answer("get_robot_state", states)
    await robot.bring_up()
    assert bench.commands == ["power_on", "enable"]


async def test_a_controller_that_is_starting_is_waited_for(
    robot: aioduco.Robot, bench: Bench
) -> None:
    looks = itertools.count()
    bench.answer("get_robot_state", lambda: [] if next(looks) < 5 else [6, 0, 5, 1])
    await robot.bring_up()
    assert next(looks) > 5


async def test_a_restarted_controller_that_has_no_states_yet_is_waited_for(
    robot: aioduco.Robot, bench: Bench
) -> None:
    answers = iter([[], [], [1], [1, 0, 0, 1], [4, 0, 4, 1]])
    bench.answer("restart", lambda block: 1000)
    bench.answer("get_noneblock_taskstate", lambda number: TaskState.FINISHED)
    bench.answer("get_robot_state", lambda: next(answers))
    await robot.system.restart()
    assert next(answers, None) is None


async def test_not_ready_in_time_says_what_is_seen(robot: aioduco.Robot, bench: Bench) -> None:
    bench.states[:3] = [5, 0, 9]
    bench.errors = ["Safety input SI0 is open"]
    bench.answer("power_off", lambda block: bench._switch("power_off", 5))
    with pytest.raises(
        aioduco.RobotStateError,
        match=r"not ready after 0\.3 s: robot DISABLE.*safety STOP0.*Safety input SI0 is open",
    ):
        await robot.bring_up(timeout=0.3)


async def test_a_step_that_the_controller_does_not_take(robot: aioduco.Robot, bench: Bench) -> None:
    bench.states[:3] = [4, 0, 9]
    bench.errors = ["E-stop"]
    switch = bench._answers["power_on"]

    def failing(block: bool) -> int:
        task_id: int = switch(block)
        bench.tasks[task_id].state = aioduco.TaskState.ILLEGAL
        bench.states[:3] = [4, 0, 9]
        return task_id

    bench.answer("power_off", failing)
    with pytest.raises(
        aioduco.RobotStateError,
        match=r"did not power_off.*E-stop.*Is an emergency stop.*call recover\(\) again",
    ) as caught:
        await robot.recover()
    assert isinstance(caught.value.__cause__, aioduco.TaskIllegal)


@pytest.mark.parametrize("procedure", ["bring_up", "recover"])
@pytest.mark.parametrize("name", ["stop", "pause"])
async def test_who_stops_the_robot_meanwhile_does_not_see_it_switched_on(
    robot: aioduco.Robot, bench: Bench, procedure: str, name: str
) -> None:
    bench.states[:3] = [4, 0, 4]
    let = bench.hold("power_on", bench._answers["power_on"])
    going = asyncio.create_task(getattr(robot, procedure)())
    await eventually_async(lambda: bench.received("power_on"))
    await getattr(robot, name)()
    let.set()
    with pytest.raises(aioduco.TaskStopped, match=f"{procedure} was ended, since the arm was"):
        await going
    assert "enable" not in bench.commands


async def test_a_step_that_never_ends_has_a_deadline(robot: aioduco.Robot, bench: Bench) -> None:
    bench.states[:3] = [4, 0, 4]
    bench.answer("power_on", 77)  # a task that stays idle
    with pytest.raises(aioduco.RobotStateError, match="has not ended after"):
        await robot.bring_up(timeout=0.3)
    await eventually_async(lambda: len(robot.tasks) == 1)
