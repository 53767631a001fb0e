"""A wrong argument never reaches the socket, whatever the function and whatever the argument."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from aioduco import Joints, Op, ParameterError, Pose
from api.cases import Case, cases, refusal

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

PARAMETERS = [(case, name) for case in cases() for name in case.parameters]

#: no parameter takes any of these
NEVER: tuple[Any, ...] = (object(), 1j, {}, set(), b"\xff", Ellipsis, lambda: None)
#: texts that may be empty
EMPTY = {"path", "message", "value", "passwd", "info"}
NOT_FINITE = (math.nan, math.inf, -math.inf)
not_finite = st.sampled_from(NOT_FINITE)


def wrong(case: Case, name: str) -> SearchStrategy[Any]:
    """Values that a parameter must refuse."""
    sample, annotation = case.args[name], str(case.parameters[name].annotation)
    values: list[SearchStrategy[Any]] = [st.sampled_from(NEVER)]
    if "None" not in annotation:
        values.append(st.none())
    if isinstance(sample, str):
        values += [st.integers(), st.floats(), st.booleans(), st.just("\ud800")]
        if name in {"tool", "wobj"}:
            values.append(st.text(min_size=33))
        elif name not in EMPTY:
            values.append(st.just(""))
        return st.one_of(values)
    if isinstance(sample, (bytes, bytearray)) or (name, case.section) == ("tail", "bus"):
        none = st.sampled_from([value for value in NEVER if not isinstance(value, bytes)])
        wrong = st.lists(st.sampled_from([-1, 256, 1.5, True, None, "1"]), min_size=1)
        return st.one_of(none, wrong, st.none(), st.text(), st.integers(), st.just(b""))
    values += [st.text(), st.binary()]
    if isinstance(sample, bool):
        values += [st.integers(), st.floats()]
    elif isinstance(sample, (int, float)):
        values += [not_finite, st.booleans(), st.lists(st.floats(), min_size=1)]
        if isinstance(sample, int) and "float" not in annotation:
            values += [
                st.floats(),
                st.integers(min_value=2**31),
                st.integers(max_value=-(2**31) - 1),
            ]
    elif isinstance(sample, Op):
        values += [st.integers(), st.floats(), st.lists(st.integers())]
    elif isinstance(sample, (list, tuple, Pose, Joints, np.ndarray)):
        values += [st.integers(), st.floats(), st.booleans(), st.lists(not_finite, min_size=1)]
        values.append(st.just([[math.nan] * 6]))
        values.append(st.just([object()]))
        if not isinstance(sample[0], (list, tuple, np.ndarray, Pose, Joints)):
            values.append(st.just([[0.0] * 6] * 6))
    return st.one_of(values)


@pytest.mark.parametrize(("case", "name"), PARAMETERS, ids=str)
@settings(max_examples=10)
@given(data=st.data())
def test_a_wrong_argument_is_refused(case: Case, name: str, data: st.DataObject) -> None:
    value = data.draw(wrong(case, name))
    error = refusal(case, **{name: value})
    assert isinstance(error, ParameterError), (value, error)
    assert error.parameter.partition("[")[0].partition(".")[0] == name
    assert str(error).endswith("nothing was sent")
    assert isinstance(error, ValueError)


@pytest.mark.parametrize("case", cases(), ids=str)
def test_the_error_says_what_is_expected(case: Case) -> None:
    for name in case.parameters:
        error = refusal(case, **{name: object()})
        assert isinstance(error, ParameterError)
        assert error.expected
