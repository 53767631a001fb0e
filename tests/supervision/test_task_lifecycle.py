"""The life of a task: the state machine."""

from __future__ import annotations

from collections.abc import Callable

import hypothesis.strategies as st
from for_each import for_each
from hypothesis import given

from aioduco.models.enums import Outcome, TaskState
from aioduco.supervision.task_state import IDLE_AGAIN_LIMIT, TaskLifecycle


@for_each(
    "state, outcome",
    [
        (TaskState.STOPPED, Outcome.STOPPED),
        (TaskState.FINISHED, Outcome.FINISHED),
        (TaskState.INTERRUPT, Outcome.INTERRUPTED),
        (TaskState.ERROR, Outcome.FAILED),
        (TaskState.ILLEGAL, Outcome.ILLEGAL),
        (TaskState.PARAMETER_MISMATCH, Outcome.PARAMETER_MISMATCH),
        (TaskState(9), Outcome.UNKNOWN),
        (TaskState(-1), Outcome.UNKNOWN),
    ],
)
def test_each_terminal_state_has_its_outcome(state: TaskState, outcome: Outcome) -> None:
    life = TaskLifecycle()
    assert life.observe(TaskState.RUNNING)
    assert life.outcome is None
    assert life.observe(state)
    assert life.outcome is outcome


def test_the_same_state_twice_is_no_change() -> None:
    life = TaskLifecycle()
    assert not life.observe(TaskState.IDLE)
    assert not life.started
    assert life.observe(TaskState.RUNNING)
    assert not life.observe(TaskState.RUNNING)
    assert life.started


def test_it_shows_its_state_and_its_end() -> None:
    life = TaskLifecycle()
    assert repr(life) == "<TaskLifecycle IDLE live, successor none>"
    life.observe(TaskState.FINISHED)
    assert repr(life) == "<TaskLifecycle FINISHED finished, successor none>"


@for_each("late", list(TaskState))
def test_an_end_is_final(late: TaskState) -> None:
    life = TaskLifecycle()
    life.observe(TaskState.FINISHED)
    life.stop_sent()
    life.mark_lost()
    assert not life.observe(late)
    assert life.outcome is Outcome.FINISHED
    assert life.state is TaskState.FINISHED


SENT, ACCEPTED = TaskLifecycle.successor_sent, TaskLifecycle.successor_accepted
REFUSED, STOPPED = TaskLifecycle.successor_refused, TaskLifecycle.stop_sent


def interrupted(life: TaskLifecycle) -> None:
    life.observe(TaskState.INTERRUPT)


#: what happens to a motion with a blend radius that runs, and how it has ended then
STORIES: dict[str, tuple[list[Callable[[TaskLifecycle], object]], Outcome | None]] = {
    "the next was accepted": ([SENT, ACCEPTED, interrupted], Outcome.BLENDED),
    "the next is on its way": ([SENT, interrupted], None),
    "the next was accepted afterwards": ([SENT, interrupted, ACCEPTED], Outcome.BLENDED),
    "the next was refused": ([SENT, interrupted, REFUSED], Outcome.INTERRUPTED),
    "there is no next": ([interrupted], Outcome.INTERRUPTED),
    "a stop was sent before": ([SENT, STOPPED, interrupted, ACCEPTED], Outcome.INTERRUPTED),
    "a stop was sent after": ([SENT, interrupted, STOPPED, ACCEPTED], Outcome.INTERRUPTED),
    "those after it were interrupted too": (
        [ACCEPTED, TaskLifecycle.all_interrupted, interrupted],
        Outcome.INTERRUPTED,
    ),
    "another one after the next was refused": (
        [SENT, ACCEPTED, SENT, REFUSED, interrupted],
        Outcome.BLENDED,
    ),
}


@for_each("story", STORIES)
def test_a_motion_that_was_interrupted_has_blended_or_not(story: str) -> None:
    steps, outcome = STORIES[story]
    life = TaskLifecycle(blends=True)
    life.observe(TaskState.RUNNING)
    for step in steps:
        step(life)
    assert life.outcome is outcome
    assert life.undecided is (outcome is None)


def test_without_a_blend_radius_it_was_interrupted() -> None:
    life = TaskLifecycle(blends=False)
    life.observe(TaskState.RUNNING)
    for step in (SENT, ACCEPTED, interrupted):
        step(life)
    assert life.outcome is Outcome.INTERRUPTED


@for_each("before", [lambda life: life.observe(TaskState.RUNNING), TaskLifecycle.stop_confirmed])
def test_idle_for_long_after_running_or_a_stop_means_that_the_controller_forgot_the_task(
    before: Callable[[TaskLifecycle], object],
) -> None:
    life = TaskLifecycle()
    before(life)
    for _ in range(IDLE_AGAIN_LIMIT - 1):
        assert not life.observe(TaskState.IDLE)
    assert life.outcome is None
    assert life.observe(TaskState.IDLE)
    assert life.outcome is Outcome.UNKNOWN


def test_a_motion_that_a_confirmed_stop_found_idle_moves_nothing() -> None:
    life, moves_nothing = TaskLifecycle(), []
    for step in (TaskLifecycle.stop_confirmed, lambda it: it.observe(TaskState.RUNNING)):
        moves_nothing.append(life.idle_after_stop)
        step(life)
    assert [*moves_nothing, life.idle_after_stop] == [False, True, False]


def test_idle_now_and_then_after_running_does_not() -> None:
    life = TaskLifecycle()
    for _ in range(2 * IDLE_AGAIN_LIMIT):
        life.observe(TaskState.RUNNING)
        life.observe(TaskState.IDLE)
    assert life.outcome is None


def test_a_task_that_was_lost_has_no_known_outcome() -> None:
    life = TaskLifecycle()
    life.mark_lost()
    assert life.outcome is Outcome.UNKNOWN


DEEDS = st.sampled_from(
    ["successor_sent", "successor_accepted", "successor_refused", "stop_sent", "mark_lost"]
)
STATES = st.integers(-1, 10).map(TaskState)


@given(st.booleans(), st.lists(st.one_of(STATES, DEEDS), max_size=60))
def test_no_sequence_of_events_makes_a_false_success(
    blends: bool, events: list[TaskState | str]
) -> None:
    life = TaskLifecycle(blends=blends)
    seen: list[TaskState] = []
    first: Outcome | None = None
    for event in events:
        if isinstance(event, str):
            getattr(life, event)()
        else:
            life.observe(event)
            seen.append(event)
        if first is None:
            first = life.outcome
        assert life.outcome is first
    if first is Outcome.FINISHED:
        assert TaskState.FINISHED in seen
    if first is Outcome.BLENDED:
        assert blends
        assert not life.stop_seen
        assert TaskState.INTERRUPT in seen
        assert "successor_accepted" in events
    if any(state.ended for state in seen) and not life.undecided:
        assert first is not None
