"""The life of a continuous motion: the state machine."""

from __future__ import annotations

from collections.abc import Callable

import hypothesis.strategies as st
from for_each import for_each
from hypothesis import given

from aioduco.models.enums import Outcome, TaskState
from aioduco.supervision.task_state import ContinuousMotion, TaskLifecycle

MOTION = ContinuousMotion("speed_stop", time=1.0)
GUIDING = ContinuousMotion("end_teach_mode", until_commanded=True)
JOG = ContinuousMotion("stop")


def running(held: ContinuousMotion = MOTION) -> TaskLifecycle:
    made = TaskLifecycle(blends=not held.until_commanded, continuous=held)
    made.observe(TaskState.RUNNING)
    return made


def sees(state: TaskState) -> Callable[[TaskLifecycle], object]:
    return lambda life: life.observe(state)


FINISHED, INTERRUPTED = sees(TaskState.FINISHED), sees(TaskState.INTERRUPT)
STOPPED, STANDS = sees(TaskState.STOPPED), TaskLifecycle.mark_standing
END, STOP = TaskLifecycle.end_sent, TaskLifecycle.stop_sent
SENT, ACCEPTED = TaskLifecycle.successor_sent, TaskLifecycle.successor_accepted

#: what happens to a motion that runs, and how it has ended then
STORIES: dict[
    str, tuple[ContinuousMotion, list[Callable[[TaskLifecycle], object]], Outcome | None]
] = {
    "its task ends": (MOTION, [FINISHED, sees(TaskState.IDLE)], None),
    # whenever that is: what the controller calls finished is not interrupted by our clock
    "the arm stands after its task": (MOTION, [FINISHED, STANDS], Outcome.FINISHED),
    "the arm stands while its task runs": (MOTION, [STANDS], None),
    "a guided arm stands": (GUIDING, [FINISHED, STANDS], None),
    "guiding is ended": (GUIDING, [FINISHED, STANDS, END], Outcome.FINISHED),
    "it is told to end, and has not done it": (MOTION, [END, sees(TaskState.RUNNING)], None),
    "it is told to end, and paused": (MOTION, [END, sees(TaskState.PAUSED)], None),
    "it is told to end, and its task is finished": (MOTION, [END, FINISHED], Outcome.FINISHED),
    "it is told to end, and interrupted": (MOTION, [END, INTERRUPTED], Outcome.FINISHED),
    "it is told to end, and stopped": (MOTION, [END, STOPPED], Outcome.FINISHED),
    "it fails when told to end": (MOTION, [END, sees(TaskState.ERROR)], Outcome.FAILED),
    "it is illegal when told to end": (MOTION, [END, sees(TaskState.ILLEGAL)], Outcome.ILLEGAL),
    "its state is unknown when told to end": (MOTION, [END, sees(TaskState(42))], Outcome.UNKNOWN),
    # a stop is no end of its own
    "it is stopped after its task": (MOTION, [FINISHED, STOP], Outcome.STOPPED),
    "it is told to end, then stopped": (MOTION, [END, STOP, STOPPED], Outcome.STOPPED),
    # but of a jog a stop may be what ends it
    "a jog is ended": (JOG, [END, STOP, STOPPED], Outcome.FINISHED),
    "a jog is stopped by somebody else": (JOG, [STOP, STOPPED], Outcome.STOPPED),
    "another motion is sent": (MOTION, [FINISHED, SENT], None),
    "another motion takes over": (MOTION, [FINISHED, SENT, ACCEPTED], Outcome.BLENDED),
    "no motion takes over from guiding": (GUIDING, [FINISHED, SENT, ACCEPTED], None),
}


@for_each("story", STORIES)
def test_how_it_ends(story: str) -> None:
    held, steps, outcome = STORIES[story]
    motion = running(held)
    for step in steps:
        step(motion)
    assert motion.outcome is outcome
    assert motion.ended is (outcome is not None)


def test_the_end_of_the_task_is_not_the_end_of_the_motion() -> None:
    motion = running()
    motion.observe(TaskState.FINISHED)
    assert motion.continues_after_task
    assert motion.state is TaskState.FINISHED
    assert not motion.observe(TaskState.IDLE)  # nothing more is to be learned from the task


def test_its_limits() -> None:
    assert MOTION.limit == 3.0  # its time, and two seconds in which it slows down
    assert GUIDING.limit is None
    modes = [held.mode for held in (MOTION, GUIDING, JOG)]
    assert modes == [None, (GUIDING.ending, (False,)), None]
    assert not ContinuousMotion("stop", until_commanded=True).mode


EVENTS: dict[str, Callable[[TaskLifecycle], object]] = {
    "finished": FINISHED,
    "interrupted": INTERRUPTED,
    "stopped": STOPPED,
    "idle": sees(TaskState.IDLE),
    "stood": STANDS,
    "sent": SENT,
    "accepted": ACCEPTED,
    "refused": TaskLifecycle.successor_refused,
}


@given(events=st.lists(st.sampled_from(sorted(EVENTS))), held=st.sampled_from([MOTION, GUIDING]))
def test_it_has_not_finished_unless_it_was_told_to_or_the_arm_stands(
    events: list[str], held: ContinuousMotion
) -> None:
    """Whatever is seen: "finished" is never said of an arm that may still move by itself."""
    motion = running(held)
    for event in events:
        EVENTS[event](motion)
    if motion.outcome is Outcome.FINISHED:
        assert "finished" in events
        assert "stood" in events
        assert not held.until_commanded
