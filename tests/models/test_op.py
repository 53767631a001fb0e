"""Outputs that a motion sets: what the builders take, and what they put on the wire."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco._wire import rpc
from aioduco.errors import ParameterError
from aioduco.models.op import (
    ControllerEvent,
    Op,
    Output,
    PointOp,
    bool_register,
    event,
    float_register,
    output,
    tool_output,
    wire_op,
    word_register,
)
from aioduco.models.pose import Joints, Pose

targets = st.one_of(
    st.integers(1, 16).map(output),
    st.integers(1, 27).map(bool_register),
    st.text("abc工具", min_size=1).map(event),
)
parts = st.fixed_dictionaries(
    {
        "target": targets,
        "value": st.booleans(),
        "time": st.floats(-1e6, 1e6),
        "distance": st.floats(-5.0, 5.0),
    }
)


def test_an_op_of_nothing_is_all_zeros_on_the_wire() -> None:
    assert Op().wire() == rpc.Op()
    assert wire_op("op", None) == rpc.Op()


def test_times_are_milliseconds_on_the_wire() -> None:
    op = (
        Op.at_start(output(3), time=0.2)
        | Op.near_end(output(4), False, distance=0.05)
        | Op.on_stop(event("e"), time=-0.5)
    )
    assert op.wire() == rpc.Op(
        time_or_dist_1=1,
        trig_io_1=3,
        trig_value_1=True,
        trig_time_1=200.0,
        time_or_dist_2=2,
        trig_io_2=4,
        trig_dist_2=0.05,
        time_or_dist_3=1,
        trig_value_3=True,
        trig_time_3=-500.0,
        trig_event_3="e",
    )


@given(parts, parts, parts)
def test_each_trigger_goes_into_its_own_fields(
    start: dict[str, Any], end: dict[str, Any], stop: dict[str, Any]
) -> None:
    by_time = Op.at_start(start["target"], start["value"], time=abs(start["time"]))
    by_distance = Op.near_end(end["target"], end["value"], distance=end["distance"])
    on_stop = Op.on_stop(stop["target"], stop["value"], time=stop["time"])
    wire = (on_stop | by_distance | by_time).wire()
    assert wire == (by_time | (by_distance | on_stop)).wire()
    assert (wire.time_or_dist_1, wire.time_or_dist_2, wire.time_or_dist_3) == (1, 2, 1)
    assert wire.trig_time_1 == abs(start["time"]) * 1000
    assert wire.trig_dist_2 == end["distance"]
    assert wire.trig_time_3 == stop["time"] * 1000
    assert wire.trig_dist_1 == wire.trig_time_2 == wire.trig_dist_3 == 0.0
    for number, part in enumerate((start, end, stop), 1):
        target = part["target"]
        assert getattr(wire, f"trig_value_{number}") is part["value"]
        index, name = getattr(wire, f"trig_io_{number}"), getattr(wire, f"trig_event_{number}")
        if isinstance(target, ControllerEvent):
            assert (index, name) == (0, target.name)
        else:
            assert (index, name) == (target.index, "")
            assert 1 <= index <= 127


@for_each(
    "make, first, most",
    [
        (output, 1, 16),
        (bool_register, 101, 64),
        (word_register, 201, 32),
        (float_register, 301, 32),
        (tool_output, 401, 2),
    ],
)
def test_targets_have_the_manuals_index_and_range(make: Any, first: int, most: int) -> None:
    assert (make(1).index, make(most).index) == (first, first + most - 1)
    for num in (0, most + 1, 1.0, True, "1"):
        with pytest.raises(ParameterError):
            make(num)


@for_each(
    "target",
    [bool_register(28), bool_register(64), word_register(1), float_register(1), tool_output(1)],
)
def test_what_a_signed_byte_cannot_carry_is_refused_with_the_reason(target: Output) -> None:
    for make in (Op.at_start, Op.near_end, Op.on_stop):
        with pytest.raises(ParameterError, match="signed byte") as caught:
            make(target)
        assert str(target) in str(caught.value)
        assert str(target.index) in str(caught.value)
    Op.at_start(bool_register(27))


@for_each("make", [Op.at_start, Op.near_end])
def test_a_distance_in_millimetres_is_refused(make: Any) -> None:
    with pytest.raises(ParameterError, match=r"distance is 50, .* 5\.02 m \(millimetres\?\)"):
        make(output(1), distance=50)


def test_a_distance_is_refused_in_motions_of_joints() -> None:
    for op in (Op.at_start(output(1), distance=0.1), Op.near_end(output(1), distance=0.1)):
        assert op.wire() == wire_op("op", op)
        with pytest.raises(ParameterError, match="without effect") as caught:
            wire_op("op", op, joint_motion=True)
        assert caught.value.parameter == "op"
    by_time = Op.at_start(output(1), time=0.1) | Op.on_stop(output(2))
    assert by_time.wire(joint_motion=True) == by_time.wire()


def test_what_makes_no_sense_is_refused() -> None:
    for op in (
        lambda: Op.at_start(output(1), time=-0.1),
        lambda: Op.at_start(output(1), distance=-0.1),
        lambda: Op.at_start(output(1), time=0.1, distance=0.1),
        lambda: Op.at_start(output(1), time=math.nan),
        lambda: Op.near_end(output(1), distance=math.inf),
        lambda: Op.near_end(output(1), 1),  # type: ignore[arg-type]  # what is tested
        lambda: Op.at_start(3),  # type: ignore[arg-type]  # what is tested
        lambda: Op(output(3)),  # type: ignore[arg-type]  # what is tested
        lambda: Op(stop=True),  # type: ignore[arg-type]  # what is tested
        lambda: event(""),
        lambda: Op.at_start(output(1)) | Op.at_start(output(2)),
        lambda: wire_op("op", rpc.Op()),  # type: ignore[arg-type]  # what is tested
        lambda: PointOp([0.0] * 5),
        lambda: PointOp([0.0] * 6, rpc.Op()),  # type: ignore[arg-type]  # what is tested
        lambda: PointOp(Joints(0, 0, 7, 0, 0, 0)),
    ):
        with pytest.raises(ParameterError):
            op()
    with pytest.raises(TypeError):
        Op() | 1  # type: ignore[operator]  # what is tested


def test_ops_are_values() -> None:
    op = Op.at_start(output(1), time=0.1)
    more = op | Op.on_stop(output(2))
    assert op == Op.at_start(output(1), time=0.1) != more
    assert op.stop is None
    assert len({op, more, Op.at_start(output(1), time=0.1)}) == 2
    with pytest.raises(dataclasses.FrozenInstanceError):
        op.start = None  # type: ignore[misc]  # what is tested
    first, second = op.wire(), op.wire()
    assert first == second
    assert first is not second


def test_points_carry_poses_or_joints() -> None:
    six = [0.5, 0.1, 0.4, 3.1, 0.0, -1.5]
    op = Op.at_start(output(1), distance=0.1)
    assert PointOp(six).pos == Pose(*six)
    assert PointOp(six, op).wire() == rpc.PointOp(six, op.wire())
    assert PointOp(six) == PointOp(Pose(*six), Op())
    joints = PointOp(Joints(*six), Op.at_start(output(1), time=0.1))
    assert joints.wire().pos == six
    with pytest.raises(ParameterError, match="without effect"):
        PointOp(Joints(*six), op).wire()
