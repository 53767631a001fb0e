"""Prepared calls are byte for byte what thriftpy2 writes."""

from __future__ import annotations

from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aioduco._wire import codec, idl
from aioduco._wire.connection import Connection
from aioduco._wire.rpc import Op, PointOp, RealTimeControlData
from aioduco.streaming.worker.encoding import Batch, Point, element_tail

NOBODY = cast("Connection", None)
SIX = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=6, max_size=6)

#: functions that carry one set-point, with arguments as programs use them
SINGLE: dict[str, tuple[Any, ...]] = {
    "servoj": (1.0, 1.0, False, 200.0, 25.0, 10.0, 1.0),
    "servoj_pose": (1.0, 1.0, [0.1] * 6, "gripper", "桌", False, 200.0, 25.0, 10.0, 1.0),
    "servo_tcp": (1.0, 1.0, "", False, 200.0, 25.0, 10.0, 1.0),
    "servol": (1.0, 1.0, [], "", "", False, 200.0, 25.0, 10.0, 1.0),
    "speedj": (1.0, 200, False),
    "speedl": (0.5, -1, False),
}


@pytest.mark.parametrize("name", SINGLE)
@given(values=SIX)
def test_one_set_point(name: str, values: list[float]) -> None:
    point = Point(NOBODY, name, lambda q: (q, *SINGLE[name]), 1.0)
    assert point.encode(values) == codec.encode(idl.functions()[name], (values, *SINGLE[name]))


@given(st.lists(SIX, max_size=20))
def test_a_list_of_realtime_points(points: list[list[float]]) -> None:
    def element(values: list[float]) -> RealTimeControlData:
        return RealTimeControlData(joint_vel_cmd=values, status=True)

    batch = Batch(NOBODY, "realtime_data_enqueue", element, 1.0)
    made = batch.encode([batch.element(values) for values in points])
    function = idl.functions()["realtime_data_enqueue"]
    assert made == codec.encode(function, ([element(values) for values in points], True))


@given(st.lists(SIX, max_size=20))
def test_a_list_of_points_of_a_track(points: list[list[float]]) -> None:
    batch = Batch(NOBODY, "trackEnqueue", list, 1.0)
    made = batch.encode([batch.element(values) for values in points])
    assert made == codec.encode(idl.functions()["trackEnqueue"], (points, True))


@given(st.lists(st.tuples(SIX, st.integers(0, 100), st.text(max_size=8)), max_size=8))
def test_points_of_a_track_with_operations(points: list[tuple[list[float], int, str]]) -> None:
    batch = Batch(NOBODY, "trackEnqueueOp", lambda q: PointOp(q, Op()), 1.0)
    elements, expected = [], []
    for values, output, event in points:
        op = Op(trig_io_1=output, trig_event_3=event)
        tail = element_tail("trackEnqueueOp", lambda q, op=op: PointOp(q, op))  # type: ignore[misc]  # mypy cannot infer a default of a lambda
        elements.append(batch.element(values, tail))
        expected.append(PointOp(values, op))
    assert batch.encode(elements) == codec.encode(
        idl.functions()["trackEnqueueOp"], (expected, True)
    )


def test_a_call_without_a_place_for_the_set_point_is_refused() -> None:
    with pytest.raises(ValueError, match="exactly once"):
        Point(NOBODY, "speed_stop", lambda _: (False,), 1.0)
