"""The kinds of rules: what they take, what they refuse, what they put on the wire."""

from __future__ import annotations

import enum
import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.pose import Joints, Pose
from aioduco.models.rules import (
    Choice,
    Duration,
    Flag,
    Flags,
    Integer,
    Integers,
    JointsRule,
    Number,
    OrCurrent,
    OrForever,
    Points,
    PoseRule,
    Rule,
    Signed,
    Text,
    Vector,
)

SPEED = Number(0.5, 2.0, "m/s", source="test")
OPEN = Number(0.0, 5.0, "m/s", open_low=True, source="test")
ANGLE = Number(-2 * math.pi, 2 * math.pi, "rad", source="test")
ANGLES = JointsRule(source="test")
POSE = PoseRule(source="test")
COUNT = Integer(1, 16, source="test")
MODE = Choice({0: "level", 1: "pulses"}, source="test")
POINTS = Points(POSE, 2, 3, source="test")
BYTES = Signed(8, "bytes", source="test")


class Kind(enum.IntEnum):
    LEVEL = 0
    PULSES = 1


class OwnSequence(list[float]):
    """A sequence of its own kind, as Pose and Joints are."""


class ArrayLike:
    """Something that numpy reads, as a tensor is."""

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return np.zeros(6)


def error(rule: Callable[[str, Any], object], value: object) -> ParameterError:
    with pytest.raises(ParameterError) as caught:
        rule("x", value)
    return caught.value


@given(st.floats())
def test_a_number_passes_exactly_when_it_lies_within(value: float) -> None:
    if 0.5 <= value <= 2.0:
        assert SPEED("v", value) == value
    elif not math.isclose(value, 0.5, rel_tol=1e-8) and not math.isclose(value, 2, rel_tol=1e-8):
        error(SPEED, value)


def test_an_open_bound_is_out_however_it_is_written() -> None:
    error(OPEN, 0.0)
    error(OPEN, 0)
    error(OPEN, -1e-300)
    assert OPEN("v", 5e-324) == 5e-324


def test_what_is_not_finite_is_out_of_no_bounds_too() -> None:
    for value in (math.nan, math.inf, -math.inf, 10**400):
        error(Number(source="test"), value)


def test_errors_say_name_value_range_and_unit() -> None:
    caught = error(SPEED, 3)
    assert (caught.parameter, caught.value) == ("x", 3)
    assert str(caught) == "x is 3, but must be a number from 0.5 to 2 m/s; nothing was sent"
    assert error(OPEN, 6).expected == "a number above 0, up to 5 m/s"
    assert "radians, not degrees" in error(ANGLE, 90).expected
    assert "radians" not in error(ANGLE, math.nan).expected
    assert error(ANGLES, [0, 0, 90, 0, 0, 0]).parameter == "x[2]"
    assert error(MODE, 2).expected == "0 (level) or 1 (pulses)"


@for_each("value", [3, np.int8(3), np.array(3)])
def test_integers(value: Any) -> None:
    result = COUNT("n", value)
    assert type(result) is int
    assert result == 3


@for_each("value", [0, 17, 3.0, np.float64(3), True, "3", None, math.nan])
def test_what_is_no_whole_number_within_is_refused(value: object) -> None:
    error(COUNT, value)


def test_choices_take_numbers_and_enums() -> None:
    assert MODE("m", 1) == 1
    assert type(MODE("m", Kind.PULSES)) is int
    assert MODE("m", np.int64(0)) == 0
    for value in (True, 1.0, "1", 2, -1, None):
        error(MODE, value)


def test_flags_are_bools_only() -> None:
    flag = Flag(source="test")
    assert flag("f", True) is True
    assert flag("f", np.False_) is False
    for value in (1, 0, "true", None, np.int8(1)):
        error(flag, value)
    flags = Flags(flag, length=3, source="test")
    assert flags("f", [True, False, True]) == [True, False, True]
    assert flags("f", np.array([True, False, True])) == [True, False, True]
    for wrong in ([True, False], [1, 0, 1], np.array([1, 0, 1]), "abc", None):
        error(flags, wrong)


def test_texts_are_measured_in_bytes() -> None:
    name = Text(min_bytes=1, max_bytes=6, source="test")
    assert name("n", "工具") == "工具"
    for value in ("", "工具1", "abcdefg", b"abc", None, 1, "\ud800"):
        error(name, value)


def test_times_go_out_in_milliseconds() -> None:
    time = Duration(0.001, 60.0, source="test")
    assert time("t", 0.2) == 200
    assert time("t", 1) == 1000
    for value in (0.0, -1, 61, None, True, math.nan):
        error(time, value)
    endless = OrForever(time)
    assert endless("t", None) == -1
    assert endless("t", 0.5) == 500
    assert "None for no end" in error(endless, -1).expected


@for_each(
    "value",
    [
        [0.0, 1, 2.0, -1, 0, 0],
        (0.0, 1.0, 2.0, -1.0, 0.0, 0.0),
        OwnSequence([0.0, 1.0, 2.0, -1.0, 0.0, 0.0]),
        np.array([0.0, 1, 2, -1, 0, 0]),
        np.array([0, 1, 2, -1, 0, 0]),
        np.array([0, 1, 2, -1, 0, 0], dtype=np.float32),
        [np.float64(0), np.float32(1), np.int8(2), -1, 0.0, 0],
    ],
)
def test_vectors_of_all_kinds_become_lists_of_floats(value: Any) -> None:
    for rule in (ANGLES, POSE, OrCurrent(ANGLES)):
        result = rule("q", value)
        assert result == [0.0, 1.0, 2.0, -1.0, 0.0, 0.0]
        assert {type(item) for item in result} == {float}
        assert result is not value


def test_a_pose_is_no_joint_vector() -> None:
    six = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    assert POSE("p", Pose(*six)) == list(six)
    assert ANGLES("q", Joints(*six)) == list(six)
    assert Vector(Number(source="test"), length=6)("v", Pose(*six)) == list(six)
    error(POSE, Joints(*six))
    error(ANGLES, Pose(*six))
    error(OrCurrent(ANGLES), Pose(*six))


def test_what_numpy_reads_is_a_vector() -> None:
    assert ANGLES("q", ArrayLike()) == [0.0] * 6  # type: ignore[arg-type]  # no static face


@for_each(
    "value",
    [
        [0.0] * 5,
        [0.0] * 7,
        np.zeros((1, 6)),
        np.zeros((6, 1)),
        np.zeros(6, dtype=bool),
        [True] * 6,
        ["0"] * 6,
        [None] * 6,
        "000000",
        b"000000",
        {0: 0.0},
        {0.0, 1.0, 2.0, 3.0, 4.0, 5.0},
        dict.fromkeys(range(6), 0.0),
        None,
        1.0,
        object(),
        [0.0] * 5 + [math.nan],
        np.array([0.0] * 5 + [math.inf]),
    ],
)
def test_what_is_no_vector_of_six_is_refused(value: object) -> None:
    error(ANGLES, value)
    error(POSE, value)


@given(st.lists(st.floats(-20, 20), min_size=6, max_size=6))
def test_a_pose_has_bounds_on_its_angles_and_is_not_in_millimetres(value: list[float]) -> None:
    for place in range(3):
        with pytest.raises(ParameterError, match=r"20 m \(millimetres\?\)"):
            POSE("p", [*value[:place], 492.0, *value[place + 1 : 3], 0.0, 0.0, 0.0])
    if all(abs(angle) <= 2 * math.pi for angle in value[3:]):
        assert POSE("p", value) == value
    elif any(abs(angle) > 2 * math.pi * (1 + 1e-8) for angle in value[3:]):
        error(POSE, value)


def test_nothing_means_the_present_value() -> None:
    near = OrCurrent(ANGLES)
    nothing: list[Any] = [None, [], (), np.array([])]
    for value in nothing:
        assert near("q", value) == []
    error(near, [0.0])
    error(near, "")
    error(near, {})


def test_vectors_of_any_length() -> None:
    free = Vector(Number(source="test"))
    assert free.length is None
    assert free("v", []) == []
    assert free("v", range(3)) == [0.0, 1.0, 2.0]
    assert error(free, [0.0, math.nan]).parameter == "x[1]"


def test_points_are_counted_and_each_is_checked() -> None:
    pose = [0.5, 0.0, 0.5, 0.0, 0.0, 0.0]
    assert POINTS("p", [pose, tuple(pose)]) == [pose, pose]
    assert POINTS("p", np.array([pose, pose, pose])) == [pose, pose, pose]
    assert error(POINTS, [pose]).value == "1 points"
    assert error(POINTS, [pose] * 4).value == "4 points"
    assert error(POINTS, [pose, [0, 0, 0, 90, 0, 0]]).parameter == "x[1][3]"
    for value in (None, 3, "abc", {1: pose, 2: pose}, [pose, pose[:5]], np.array(1.0)):
        error(POINTS, value)


@given(st.binary(min_size=1))
def test_bytes_keep_their_bits(data: bytes) -> None:
    signed = BYTES("d", data)
    assert all(-128 <= number <= 127 for number in signed)
    assert bytes(number & 0xFF for number in signed) == data
    assert BYTES("d", list(data)) == BYTES("d", bytearray(data)) == signed
    assert BYTES("d", np.frombuffer(data, dtype=np.uint8)) == signed
    assert BYTES("d", np.frombuffer(data, dtype=np.int8)) == BYTES("d", signed) == signed


def test_words_and_what_are_no_bytes() -> None:
    words = Signed(16, "words", source="test")
    assert words("w", [0, 0x7FFF, 0x8000, 0xFFFF]) == [0, 32767, -32768, -1]
    assert words("w", [40000, -25536]) == [-25536, -25536]
    for value in ([], b"", [256], [-129], [1.0], [True], "ab", None):
        error(BYTES, value)
    for value in ([65536], [-32769], b"ab"):
        error(words, value)


def test_lists_of_integers() -> None:
    logic = Integers(Choice({0: "off", 1: "and", 2: "or"}, source="test"), length=3, source="test")
    assert logic("l", (1, 0, 2)) == [1, 0, 2]
    assert logic("l", np.array([0, 0, 1])) == [0, 0, 1]
    for value in ([0, 0], [0, 0, 3], [0, 0, 1.0], "001", None):
        error(logic, value)


def test_pulses_last_a_millisecond() -> None:
    assert ranges.pulse(100, 10) == (100, 10)
    assert ranges.pulse(10, 1) == (10, 1)
    for freq, duty in ((100, 9), (11, 1), (0, 50), (101, 50), (50, 0), (50, 101)):
        with pytest.raises(ParameterError):
            ranges.pulse(freq, duty)
    with pytest.raises(ParameterError, match="at least 2 % at 11 Hz"):
        ranges.pulse(11, 1)


def test_a_direction_that_gives_way_has_damping() -> None:
    on = [False, False, True, False, False, True]
    damp = [0.0, 0.0, 1000.0, 0.0, 0.0, 57.0]
    assert ranges.damping(on, damp) == (on, damp)
    with pytest.raises(ParameterError, match="above 0") as caught:
        ranges.damping(on, [0.0, 0.0, 1000.0, 0.0, 0.0, 0.0])
    assert caught.value.parameter == "damp[5]"
    with pytest.raises(ParameterError):
        ranges.damping(on, [0.0, 0.0, -1000.0, 0.0, 0.0, 57.0])


@for_each("name", [name for name, rule in vars(ranges).items() if isinstance(rule, Rule)])
def test_each_named_rule_refuses_nonsense_by_its_name(name: str) -> None:
    rule: Any = getattr(ranges, name)
    for value in (object(), math.nan, 1j):
        assert error(rule, value).parameter.startswith("x")
    assert rule.source
    assert rule.expected
    assert list(inspect.signature(rule.__call__).parameters) == ["name", "value"]
    assert rule.expected in repr(rule)
