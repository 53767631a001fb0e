"""The life of a motion that goes on, as a pure state machine."""

from __future__ import annotations

import hypothesis.strategies as st
import pytest
from hypothesis import given

from aioduco.models.enums import Outcome, TaskState
from aioduco.supervision.task_state import ContinuousMotion, TaskLifecycle

MOTION = ContinuousMotion("speed_stop", time=1.0)
GUIDING = ContinuousMotion("end_teach_mode", until_commanded=True)
JOG = ContinuousMotion("stop")


def life(held: ContinuousMotion = MOTION) -> TaskLifecycle:
    made = TaskLifecycle(blends=not held.until_commanded, continuous=held)
    made.observe(TaskState.RUNNING)
    return made


def going(held: ContinuousMotion = MOTION) -> TaskLifecycle:
    made = life(held)
    made.observe(TaskState.FINISHED)
    return made


def test_the_end_of_the_task_is_not_the_end_of_the_motion() -> None:
    motion = going()
    assert motion.continues_after_task
    assert not motion.ended
    assert motion.state is TaskState.FINISHED
    assert not motion.observe(TaskState.IDLE)  # nothing more is to be learned from the task


def test_it_ends_when_the_arm_stands() -> None:
    """Whenever that is: what the controller calls finished is not interrupted by our clock."""
    motion = going()
    motion.mark_standing()
    assert motion.outcome is Outcome.FINISHED


def test_an_arm_that_stands_while_the_task_runs_means_nothing() -> None:
    motion = life()
    motion.mark_standing()
    assert not motion.ended


def test_hand_guiding_goes_on_though_the_arm_stands() -> None:
    motion = going(GUIDING)
    motion.mark_standing()
    assert not motion.ended
    motion.end_sent()
    assert motion.outcome is Outcome.FINISHED


@pytest.mark.parametrize("state", [TaskState.FINISHED, TaskState.INTERRUPT, TaskState.STOPPED])
def test_however_the_task_ends_after_it_was_told_to(state: TaskState) -> None:
    motion = life()
    motion.end_sent()
    assert not motion.ended  # it is told, but has not done it
    motion.observe(state)
    assert motion.outcome is Outcome.FINISHED


@pytest.mark.parametrize("state", [TaskState.ERROR, TaskState.ILLEGAL, TaskState(42)])
def test_what_fails_fails_though_it_was_told_to_end(state: TaskState) -> None:
    motion = life()
    motion.end_sent()
    motion.observe(state)
    assert motion.outcome not in {None, Outcome.FINISHED}


def test_a_stop_is_no_end_of_its_own() -> None:
    motion = going()
    motion.stop_sent()
    assert motion.outcome is Outcome.STOPPED
    motion = life()
    motion.end_sent()
    motion.stop_sent()
    motion.observe(TaskState.STOPPED)
    assert motion.outcome is Outcome.STOPPED


def test_a_stop_may_be_what_ends_it() -> None:
    motion = life(JOG)
    motion.end_sent()
    motion.stop_sent()
    motion.observe(TaskState.STOPPED)
    assert motion.outcome is Outcome.FINISHED
    motion = life(JOG)
    motion.stop_sent()  # of somebody who did not mean to end it
    motion.observe(TaskState.STOPPED)
    assert motion.outcome is Outcome.STOPPED


def test_another_motion_takes_over() -> None:
    motion = going()
    motion.successor_sent()
    assert not motion.ended
    motion.successor_accepted()
    assert motion.outcome is Outcome.BLENDED
    guided = going(GUIDING)
    guided.successor_sent()
    guided.successor_accepted()
    assert not guided.ended


def test_its_limits() -> None:
    assert MOTION.limit == 3.0  # its time, and two seconds in which it slows down
    assert GUIDING.limit is None
    assert [held.mode for held in (MOTION, GUIDING, JOG)] == [False, True, False]
    assert not ContinuousMotion("stop", until_commanded=True).mode


EVENTS = {
    "finished": lambda one: one.observe(TaskState.FINISHED),
    "interrupted": lambda one: one.observe(TaskState.INTERRUPT),
    "stopped": lambda one: one.observe(TaskState.STOPPED),
    "idle": lambda one: one.observe(TaskState.IDLE),
    "stood": TaskLifecycle.mark_standing,
    "sent": TaskLifecycle.successor_sent,
    "accepted": TaskLifecycle.successor_accepted,
    "refused": TaskLifecycle.successor_refused,
}


@given(events=st.lists(st.sampled_from(sorted(EVENTS))), held=st.sampled_from([MOTION, GUIDING]))
def test_it_has_not_finished_unless_it_was_told_to_or_the_arm_stands(
    events: list[str], held: ContinuousMotion
) -> None:
    """Whatever is seen: "finished" is never said of an arm that may still move by itself."""
    motion = life(held)
    for event in events:
        EVENTS[event](motion)
    if motion.outcome is Outcome.FINISHED:
        assert "finished" in events
        assert "stood" in events
        assert not held.until_commanded
