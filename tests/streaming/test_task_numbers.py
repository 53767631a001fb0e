"""Another caller's stop is noticed at any time, and nothing else counts as one."""

from __future__ import annotations

from dataclasses import dataclass, field

from for_each import for_each
from hypothesis import example, given
from hypothesis import strategies as st

from aioduco.models.enums import TaskState
from aioduco.streaming.worker.task_numbers import TaskNumbers

#: seconds between set-points, and for which the arm brakes after a stop
TICK = 0.01
BRAKES = 0.3


@dataclass
class Controller:
    """Numbers tasks, each by as much, and knows how they ended."""

    step: int
    number: int = 100
    running: int = 0
    states: dict[int, TaskState] = field(default_factory=dict)
    brakes: list[tuple[int, float]] = field(default_factory=list)

    def task(self) -> int:
        self.number += self.step
        return self.number

    def follows(self) -> int:
        """Carry out a set-point in place of the one before."""
        if self.running:
            self.states[self.running] = TaskState.FINISHED
        self.running = self.task()
        self.states[self.running] = TaskState.RUNNING
        return self.running

    def stop(self, now: float) -> None:
        if self.running:
            self.brakes.append((self.running, now + BRAKES))
            self.running = 0
        self.task()

    def poll(self, task: int, now: float) -> TaskState:
        for each, until in self.brakes:
            if now >= until:
                self.states[each] = TaskState.STOPPED
        return self.states[task]


def stopped_at(doings: list[str], step: int) -> int | None:
    """Lead an arm beside another caller; the set-point at which a stop is noticed.

    Args:
        doings: what the other does between two set-points.
        step: by how much the controller's numbers rise.
    """
    controller, numbers = Controller(step), TaskNumbers()
    for index, doing in enumerate(doings):
        now = index * TICK
        numbers.sent(controller.follows(), now)
        for task in numbers.in_question:
            if numbers.polled(task, controller.poll(task, now), now):
                return index
        for each in doing:
            if each == "s":
                controller.stop(now)
            else:
                controller.task()
    return None


@given(
    st.integers(1, 3),
    st.lists(st.sampled_from(["", "", "", "t", "tt"]), max_size=19),
    st.sampled_from(["s", "ts", "st", "ss"]),
    st.lists(st.sampled_from(["", "", "t", "s"]), max_size=10),
)
@example(1, ["", "t"], "s", [])  # a stop one tick after a task of the same caller
@example(2, ["t"], "s", [])
def test_a_stop_is_noticed(step: int, before: list[str], stop: str, after: list[str]) -> None:
    rest = round(BRAKES / TICK) + 2
    doings = [*before, stop, *after, *[""] * rest]
    found = stopped_at(doings, step)
    assert found is not None
    # At the next set-point it is in question, and it is known as soon as the arm has braked.
    assert len(before) < found <= len(before) + rest


@given(st.integers(1, 3), st.lists(st.sampled_from(["", "", "t", "tt"]), max_size=60))
def test_nothing_else_is_taken_for_one(step: int, doings: list[str]) -> None:
    assert stopped_at([*doings, *[""] * 10], step) is None


@for_each("step", [0, 1, 2, 7])
def test_alone_the_tasks_are_not_polled_for_long(step: int) -> None:
    """Each poll is a call in the tick of a set-point."""
    controller, numbers = Controller(step), TaskNumbers()
    polls = []
    for index in range(60):
        now = index * TICK
        numbers.sent(controller.follows(), now)
        polls.append(len(numbers.in_question))
        for task in numbers.in_question:
            numbers.polled(task, controller.poll(task, now), now)
    assert max(polls) <= 1
    assert sum(polls[25:]) == 0
    assert bool(sum(polls)) == (step > 1)


def test_a_task_that_goes_on_is_given_up() -> None:
    numbers = TaskNumbers()
    for task in (1, 2, 4):
        numbers.sent(task, 0.0)
    assert numbers.in_question == (2,)
    assert not numbers.polled(2, TaskState.RUNNING, 4.9)
    assert numbers.in_question == (2,)
    assert not numbers.polled(2, TaskState.RUNNING, 5.1)
    assert not numbers.in_question


def test_several_tasks_are_in_question_at_once() -> None:
    numbers = TaskNumbers()
    for task in (1, 2, 4, 6):
        numbers.sent(task, 0.0)
    assert numbers.in_question == (2, 4)
    assert not numbers.polled(2, TaskState.RUNNING, 0.1)
    assert numbers.polled(4, TaskState.STOPPED, 0.1)
    assert not numbers.in_question
