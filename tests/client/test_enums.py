"""Enums of the wire: the manual's values, and those that it does not list."""

from __future__ import annotations

import json
import pickle
from enum import IntEnum
from itertools import product

import pytest
from for_each import for_each
from public_classes import public_classes

from aioduco.models.enums import (
    OperationMode,
    Outcome,
    ProgramState,
    RobotState,
    SafetyState,
    TaskState,
)


@for_each(
    "kind, value",
    product([OperationMode, ProgramState, RobotState, SafetyState, TaskState], [77, -1]),
)
def test_a_value_that_the_manual_does_not_list_survives(kind: type[TaskState], value: int) -> None:
    member = kind(value)
    assert member == value
    assert member.name == f"UNKNOWN_{value}"
    assert not member.known
    assert kind(0).known
    assert pickle.loads(pickle.dumps(member)) == member
    assert value not in [listed.value for listed in kind]


def test_a_value_that_is_no_integer_is_refused() -> None:
    with pytest.raises(ValueError, match="is not a valid TaskState"):
        TaskState("4")  # type: ignore[arg-type]  # the wrong type is the point


def test_only_terminal_task_states_have_ended() -> None:
    assert [state.name for state in TaskState if not state.ended] == ["IDLE", "RUNNING", "PAUSED"]
    assert not TaskState(9).ended


def test_success_is_finished_or_blended() -> None:
    assert {outcome for outcome in Outcome if outcome.success} == {
        Outcome.FINISHED,
        Outcome.BLENDED,
    }


@pytest.mark.slow
def test_a_person_reads_the_name_of_every_number() -> None:
    kinds = [kind for kind in public_classes() if issubclass(kind, IntEnum)]
    assert {TaskState, RobotState, SafetyState} <= set(kinds)
    for member in (member for kind in kinds for member in kind):
        assert (str(member), f"{member}", f"{member:>30}".strip()) == (member.name,) * 3
        assert f"{member:d}" == f"{member:3d}".strip() == json.dumps(member) == repr(int(member))
    assert str(TaskState(77)) == "UNKNOWN_77"
