"""Tasks of the simulated controller."""

from __future__ import annotations

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, consumes, invariant, rule

from aioduco.models.enums import TaskState
from aioduco.sim.controller.tasks import FIRST_ID, TaskTable

RUNNING = st.sampled_from([TaskState.IDLE, TaskState.RUNNING, TaskState.PAUSED])
ENDED = st.sampled_from([state for state in TaskState if state.ended])


class Tables(RuleBasedStateMachine):
    """A table of tasks against a plain dictionary."""

    going = Bundle("going")

    def __init__(self) -> None:
        super().__init__()
        self.table = TaskTable()
        self.model: dict[int, TaskState] = {}
        self.news: list[int] = []
        self.passed: set[int] = set()

    @rule(target=going)
    def new(self) -> int:
        id_ = self.table.new("movej2")
        assert id_ >= FIRST_ID
        assert all(id_ > other for other in self.model)
        self.model[id_] = TaskState.IDLE
        return id_

    @rule(id_=going, state=RUNNING)
    def go_on(self, id_: int, state: TaskState) -> None:
        self.table.set(id_, state)
        self.model[id_] = state

    @rule(id_=going)
    def pass_on(self, id_: int) -> None:
        self.table.pass_on(id_)
        if id_ not in self.passed:
            self.passed.add(id_)
            self.news.append(id_)

    @rule(id_=consumes(going), state=ENDED, again=st.sampled_from(list(TaskState)))
    def end(self, id_: int, state: TaskState, again: TaskState) -> None:
        self.table.set(id_, state, "why")
        self.model[id_] = state
        if id_ not in self.news:
            self.news.append(id_)
        with pytest.raises(KeyError):
            self.table.set(id_, again)

    @rule()
    def take(self) -> None:
        assert self.table.take_answered() == self.news
        self.news = []

    @invariant()
    def agrees(self) -> None:
        for id_, state in self.model.items():
            assert self.table.state(id_) is state
            passed = id_ in self.passed
            assert self.table.answer(id_) is (TaskState.INTERRUPT if passed else state)
        unfinished = {task.id for task in self.table.unfinished()}
        assert unfinished == {id_ for id_, state in self.model.items() if not state.ended}


TestTables = Tables.TestCase


def test_an_unknown_id_reads_as_idle() -> None:
    assert TaskTable().state(1063) is TaskState.IDLE


def test_ids_rise_from_a_thousand() -> None:
    table = TaskTable()
    assert [table.new("stop") for _ in range(3)] == [1000, 1001, 1002]


def test_old_tasks_are_forgotten_and_running_ones_are_not() -> None:
    table = TaskTable(keep=3)
    running = table.new("movel")
    for _ in range(10):
        table.set(table.new("servoj"), TaskState.FINISHED)
    assert table.state(running) is TaskState.IDLE
    assert [table.get(FIRST_ID + 1 + n) is None for n in range(10)] == [True] * 7 + [False] * 3


def test_ids_begin_again_after_the_last_that_fits_the_wire() -> None:
    table = TaskTable()
    table._next = 2**31 - 1
    assert [table.new("stop") for _ in range(2)] == [2**31 - 1, FIRST_ID]
