"""Each function on the wire: what arrives, what comes back, what is refused before it is sent."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco.supervision.command import MotionCommand
from api.cases import MANUAL, NOBODY, Case, cases, refusal
from api.desk import HELD, Desk

#: parameters of the manual that ours do not have, and why
WITHOUT = {
    ("move_eaxis", "def_acc"): "the wire has none",
    ("modbus_write_multiple_regs", "len"): "the length of the list",
    ("modbus_write_multiple_coils", "len"): "the length of the list",
}

CALLS = [case for case in cases() if not case.moves]
#: what a robot asks for by itself, too, or what depends on what was asked for before
OWN = [
    case
    for case in CALLS
    if case.by_itself
    or case.section in ("", "state")
    or case.name in ("fc_stop", "trackEnqueue", "trackEnqueueOp")
]
#: those that answer with the end state of a task; first what another one would be in the way of
TASKS = [
    case
    for case in sorted(CALLS, key=lambda case: case not in OWN)
    if type(case.answer) is int and case.answer == 4
]
#: hand guiding ends only when it is told to, which has tests of its own
MOTIONS = [case for case in cases() if case.moves and case.name != "teach_mode"]


@pytest.mark.cases(10)
@pytest.mark.parametrize("case", OWN, ids=str)
async def test_a_call_of_a_robot_of_its_own(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    await called(robot, desk, case)


@for_each("case", [case for case in CALLS if case not in OWN])
async def test_a_call(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    await called(robot, desk, case)


async def called(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    """Call it: what arrives, and what comes back."""
    before = len(desk.received(case.name))
    with desk.otherwise():
        if not case.by_itself:
            for name, answer in ((case.name, case.answer), *case.also.items()):
                desk.answer(name, answer)
        result = await case.method(robot)(**case.args)
    (call,) = desk.received(case.name)[before:]
    assert call.args == case.wire
    if isinstance(case.result, type):
        assert type(result) is case.result
    else:
        same(result, case.result)


def same(result: Any, expected: Any) -> None:
    """Equal, of the same types; arrays cannot be changed."""
    assert type(result) is type(expected)
    if isinstance(result, np.ndarray):
        assert np.array_equal(result, expected)
        assert not result.flags.writeable
    elif isinstance(result, tuple) and result and isinstance(result[0], np.ndarray):
        assert len(result) == len(expected)
        for one, other in zip(result, expected, strict=True):
            same(one, other)
    else:
        assert _fields(result) == _fields(expected)


def _fields(value: Any) -> Any:
    """A tuple's items and a class's fields as tuples, which take a NaN for equal to itself."""
    if isinstance(value, tuple):
        return tuple(map(_fields, value))
    return dataclasses.astuple(value) if dataclasses.is_dataclass(type(value)) else value


@for_each("case", TASKS)
async def test_a_call_that_is_refused(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    for answer, error in ((7, aioduco.TaskIllegal), (8, aioduco.TaskParameterMismatch)):
        with desk.otherwise():
            desk.answer(case.name, answer)
            with pytest.raises(error, match=case.name):
                await case.method(robot)(**case.args)


@for_each("case", MOTIONS)
async def test_a_motion(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    desk.motion_time = 0.01
    if case.name not in HELD:
        desk.moves(case.name)
    motion = case.method(robot)(**case.args)
    assert isinstance(motion, MotionCommand)
    assert desk.received(case.name) == ()  # a motion is a value until it is awaited
    assert await motion is aioduco.Outcome.FINISHED
    (call,) = desk.received(case.name)
    assert call.args == case.wire
    assert not robot.tasks
    assert not desk.moving()


@for_each("case", MOTIONS)
async def test_cancelling_a_motion_leaves_a_standing_arm(
    robot: aioduco.Robot, desk: Desk, case: Case
) -> None:
    desk.motion_time = 30.0
    if case.name not in HELD:
        desk.moves(case.name)
    task = await case.method(robot)(**case.args | _forever(case)).start()
    with pytest.raises(ZeroDivisionError):
        async with case.method(robot)(**case.args | _forever(case)):
            _ = 1 / 0
    assert task.done
    assert not desk.moving()
    assert "stop" in desk.commands


def _forever(case: Case) -> dict[str, None]:
    return {"time": None} if "time" in case.parameters else {}


@for_each("case", cases())
def test_the_sample_is_whole_and_taken(case: Case) -> None:
    assert set(case.args) == set(case.parameters)
    assert refusal(case) is None


@for_each("case", cases())
def test_parameters_are_those_of_the_manual_in_its_order(case: Case) -> None:
    function = MANUAL.get(case.name)
    if function is None:
        assert "Not in the manual" in str(case.method(NOBODY).__doc__) or "manual 4.3" in str(
            case.method(NOBODY).__doc__
        )
        return
    names = [one["name"] for one in function["parameters"] if not one.get("out")]
    expected = [n for n in names if n != "block" and (case.name, n) not in WITHOUT]
    ours = {case.manual_name(name): one for name, one in case.parameters.items()}
    assert set(expected) == set(ours) - {None}
    positional = [
        name for name, one in ours.items() if name is not None and one.kind is not one.KEYWORD_ONLY
    ]
    assert positional == [name for name in names if name in positional]
