"""A wrong argument never reaches the socket, whatever the function and whatever the argument."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from for_each import for_each
from hypothesis import given, settings
from hypothesis.strategies import SearchStrategy

import aioduco
from aioduco import Jog, JogDirections, Joints, Op, ParameterError, Pose
from aioduco._wire import idl
from aioduco.models import ranges
from api.cases import Case, cases, nobody, refusal
from api.desk import Desk
from api.limits import NEVER, NOT_FINITE, edges, rules_of, wrong
from api.test_reachable import EXCEPTIONS, reachable

CASES = {case.name: case for case in cases()}
PARAMETERS = [(case, name) for case in cases() for name in case.parameters]

#: checked by no rule: values of classes that check what is in them, and lists of such values
BUILT = {
    ("combine_motion_config", "op_list"),
    ("combine_motion_config", "time"),  # two rules, one for each number in it
    ("set_eaxis_param", "param"),
    ("set_eaxiss_scheme_param", "param"),
    ("spline_op", "points"),
    ("trackEnqueueOp", "points"),
    ("realtime_data_enqueue", "points"),
    ("servo_tcp", "frame"),  # one of three names
    ("speedl", "frame"),
}
BUILT_KINDS = (Op, Jog, JogDirections)
#: an edge that another argument must go with
TOGETHER: dict[tuple[str, str], dict[str, Any]] = {
    ("set_digital_output_mode", "freq"): {"duty_cycle": 100},
    ("set_digital_output_mode", "duty_cycle"): {"freq": 1},
    ("fc_config", "damp"): {"direction": [False] * 6},
    ("fc_config", "direction"): {"damp": [1000.0] * 6},
    ("speedl", "wobj"): {"frame": "wobj"},
    ("speedj", "time"): {"velocities": [0.0] * 6},
    ("speedl", "time"): {"twist": [0.0] * 6},
    ("servo_tcp", "wobj"): {"frame": "wobj"},
}
#: lists whose numbers may be 0, but not all of them
NOT_ALL_ZERO = {("fc_wait_pos", "range"), ("fc_wait_vel", "range"), ("fc_wait_ft", "range")}


def test_there_is_a_case_for_every_function() -> None:
    """Whatever a section has: found by looking, not by a list."""
    found = set(reachable()) & set(idl.functions())
    assert {case.name for case in cases()} == found
    assert found == set(idl.functions()) - set(EXCEPTIONS)
    assert len(cases()) == len(found)


def by_kind(case: Case, name: str) -> list[SearchStrategy[Any]]:
    """By kinds, values that a parameter must refuse for what it is, whatever rule there is."""
    sample, annotation = case.args[name], str(case.parameters[name].annotation)
    values: list[SearchStrategy[Any]] = [st.sampled_from(NEVER)]
    if "None" not in annotation:
        values.append(st.none())
    if isinstance(sample, str):
        values += [st.integers(), st.floats(), st.booleans(), st.binary()]
    elif isinstance(sample, bool):
        values += [st.integers(), st.floats(), st.text(), st.binary()]
    elif isinstance(sample, (int, float)):
        values += [NOT_FINITE, st.booleans(), st.lists(st.floats(), min_size=1), st.text()]
    elif isinstance(sample, (bytes, bytearray)):
        values += [st.text(), st.integers(), st.lists(st.just(256), min_size=1)]
    elif isinstance(sample, Op):
        values += [st.integers(), st.floats(), st.lists(st.integers()), st.text()]
    elif isinstance(sample, (list, tuple, Pose, Joints, np.ndarray)):
        values += [st.integers(), st.floats(), st.booleans(), st.lists(NOT_FINITE, min_size=1)]
        values += [st.just([object()]), st.text()]
    else:
        values += [st.integers(100), st.floats(), st.text(), st.just([1.0])]
    return values


def plain(points: object) -> bool:
    """Whether points are no more than six finite numbers each."""
    return isinstance(points, list) and all(
        isinstance(point, (list, tuple))
        and len(point) == 6
        and all(isinstance(number, float) and math.isfinite(number) for number in point)
        for point in points
    )


@cache
def refused(function: str, name: str) -> SearchStrategy[tuple[Any, ...]]:
    """Values that a parameter of a function must refuse, one of each kind and by each rule."""
    case = CASES[function]
    rules = rules_of(case)[name]
    each = [*by_kind(case, name), *(wrong(rule, case.args[name]) for rule in rules)]
    if case.name == "trackEnqueue":
        # Six plain numbers may be joints or a pose, so they are taken for either.
        each = [values.filter(lambda value: not plain(value)) for values in each]
    if "None" in str(case.parameters[name].annotation):
        each = [values.filter(lambda value: value is not None) for values in each]
    return st.tuples(*each)


@pytest.mark.slow
@pytest.mark.timeout(600)
@for_each("case, name", PARAMETERS)
@settings(max_examples=2)
@given(data=st.data())
def test_a_wrong_argument_is_refused(case: Case, name: str, data: st.DataObject) -> None:
    robot = nobody()  # one for all of them: none may leave anything behind
    for value in data.draw(refused(case.name, name)):
        error = refusal(case, robot, **{name: value})
        assert isinstance(error, ParameterError), (value, error)
        assert error.parameter.partition("[")[0].partition(".")[0] == name
        assert str(error).endswith("nothing was sent")
        assert isinstance(error, ValueError)


@pytest.mark.slow
@for_each("case, name", PARAMETERS)
def test_the_edges_are_taken(case: Case, name: str) -> None:
    rules = rules_of(case)[name]
    built = (case.name, name) in BUILT or isinstance(case.args[name], BUILT_KINDS)
    assert bool(rules) != built, f"what checks {name}?"
    for rule in rules:
        for value in edges(rule, case.args[name]):
            if (case.name, name) in NOT_ALL_ZERO and not any(value):
                continue
            changed = TOGETHER.get((case.name, name), {}) | {name: value}
            error = refusal(case, **changed)
            assert error is None, (rule, value)


@for_each(
    "function, fewest, most",
    [
        ("spline_op", 1, 50),
        ("trackEnqueueOp", 1, 1000),
        ("spline", 1, 50),
        ("trackEnqueue", 1, 1000),
    ],
)
def test_points_are_counted(function: str, fewest: int, most: int) -> None:
    (case,) = [one for one in cases() if one.name == function]
    name = "poses" if function == "spline" else "points"
    first = list(case.args[name])[:1]
    assert refusal(case, **{name: first * fewest}) is None
    assert refusal(case, **{name: first * most}) is None
    for count in (fewest - 1, most + 1):
        assert isinstance(refusal(case, **{name: first * count}), ParameterError)


async def test_the_controller_sees_nothing(robot: aioduco.Robot, desk: Desk) -> None:
    """On an open robot, where nothing but the check is in the way."""
    for case in cases():
        if not case.by_itself:
            desk.answer(case.name, case.answer)
    for case, name in PARAMETERS:
        for value in (*NEVER, float("nan"), b"wrong", [[object()]]):
            if isinstance(value, bytes) and isinstance(case.args[name], (bytes, bytearray, list)):
                continue
            with pytest.raises(ParameterError) as raised:
                await case.method(robot)(**(case.args | {name: value}))
            assert raised.value.expected
    asked = {call.method for call in desk.received()} - SUPERVISION
    assert not asked


#: what an open robot asks for by itself
SUPERVISION = {"rpc_heartbeat", "get_robot_state", "get_robot_version"}


@for_each(
    "make, most",
    [
        (lambda motion, t: motion.speedl([0, 0, -0.02, 0, 0, 0], a=0.5, time=t), 251.0),
        (lambda motion, t: motion.speedl([0, 0, 0, 0, 0.1, 0], a=0.5, time=t), 40 * math.pi),
        (lambda motion, t: motion.speedl([0.01, 0, 0, 0.1, 0, 0], a=0.5, time=t), 40 * math.pi),
        (lambda motion, t: motion.speedj([0, 0.1, 0, -0.2, 0, 0], a=1.0, time=t), 20 * math.pi),
    ],
)
def test_a_time_in_milliseconds_is_refused_for_what_the_arm_would_move(
    make: Any, most: float
) -> None:
    motion = aioduco.connect("127.0.0.1").motion
    for time in (most + 0.001, 1000):
        with pytest.raises(ParameterError, match=f"at most {most:.3g} s: .*not milliseconds"):
            make(motion, time)


def test_a_time_is_as_long_as_the_arm_could_move_at_its_speeds() -> None:
    assert ranges.run_time("time", 2.0, (3.0, 6.0), (0.0, 1.0)) == 2000
    assert ranges.run_time("time", 1000, (0.0, 1.0)) == 1_000_000  # it stands
    assert ranges.run_time("time", None, (3.0, 6.0)) == -1
    with pytest.raises(ParameterError, match="at most 2 s"):
        ranges.run_time("time", 2.001, (3.0, 6.0), (1.0, 6.0))


def test_the_blend_radius_of_movej_is_a_percentage_below_50() -> None:
    assert ranges.BLEND_PERCENT("r", 49.9) == 49.9
    with pytest.raises(ParameterError, match="from 0 to 49"):
        ranges.BLEND_PERCENT("r", 50.1)


@for_each("rule, value", [(ranges.BLEND_RADIUS, 20), (ranges.WEAVE_OFFSET, 5)])
def test_a_length_in_millimetres_is_refused(rule: Any, value: Any) -> None:
    with pytest.raises(ParameterError, match=r"\(millimetres\?\)"):
        rule("length", value)
