"""Jogs and realtime commands: what the builders take, and what they put on the wire."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, get_args

import numpy as np
import pytest
from for_each import for_each

from aioduco._wire import rpc
from aioduco.errors import ParameterError
from aioduco.models.jog import Axis, Jog, JogDirections, JogFrame, directions_of
from aioduco.models.pose import Joints, Pose
from aioduco.models.realtime import RealtimeMode, RealtimePoint
from aioduco.models.version import ControllerVersion

SIX = [0.1, -0.2, 0.3, -0.4, 0.5, -0.6]


def test_a_joint_is_jogged_on_and_on_or_by_a_step() -> None:
    on = rpc.MoveJogTaskParam(jog_direction=-1, jog_type=2, axis_num=2, vel=20.5, jog_coordinate=1)
    assert Jog.joint(3, -1, 20.5).wire(JogDirections.MANUAL_3_8) == on
    step = dataclasses.replace(on, use_step=True, step_jointValue=0.01)
    assert Jog.joint(3, -1, 20.5, step=0.01).wire(JogDirections.MANUAL_3_8) == step


@pytest.mark.parametrize(("axis", "index"), [(a, i) for i, a in enumerate(get_args(Axis))])
@pytest.mark.parametrize("frame", list(JogFrame))
def test_a_direction_of_a_frame_is_jogged(axis: Axis, index: int, frame: JogFrame) -> None:
    wire = Jog.cartesian(axis, 1, 100, frame=frame, step=0.002).wire(JogDirections.MANUAL_3_8)
    assert (wire.jog_type, wire.axis_num, wire.jog_coordinate) == (1, index, frame)
    assert type(wire.jog_coordinate) is int
    assert wire.step_cartvalue == 0.002
    # either manual's field for steps about an axis has the step; lengths have one field only
    assert wire.step_jointValue == (0.002 if axis.startswith("r") else 0.0)


def test_directions_are_said_as_the_controller_understands_them() -> None:
    forward, back = Jog.joint(1, 1, 10), Jog.joint(1, -1, 10)
    assert forward.wire(JogDirections.MANUAL_3_8).jog_direction == 1
    assert back.wire(JogDirections.MANUAL_3_8).jog_direction == -1
    assert forward.wire(JogDirections.MANUAL_4_3).jog_direction == 0
    assert back.wire(JogDirections.MANUAL_4_3).jog_direction == 1


@for_each(
    "version, directions",
    [
        ("V2.6.1", JogDirections.MANUAL_3_8),
        ("3.8", JogDirections.MANUAL_3_8),
        ("GCR5-910 V3.8.2-r4", JogDirections.MANUAL_3_8),
        ("V4.3.0", JogDirections.MANUAL_4_3),
        ("DUCO_V5.0", JogDirections.MANUAL_4_3),
        ("10.1.2", JogDirections.MANUAL_4_3),
    ],
)
def test_the_version_tells_the_directions(version: str, directions: JogDirections) -> None:
    assert directions_of(None, ControllerVersion(version)) is directions


@for_each(
    "version",
    [
        *("", "unknown", "V3", "V3.9.1", "V4.0", "V4.2.9", "V0.9", "V3.8.0 V4.3.0", "GCR5-910"),
        *("2026.04.14", "V4.3.0 of 2026.04.14", "192.168.1.10"),
    ],
)
def test_an_unknown_version_tells_no_directions(version: str) -> None:
    with pytest.raises(ParameterError, match=r"JogDirections\.MANUAL_4_3"):
        directions_of(None, ControllerVersion(version))
    given = JogDirections.MANUAL_4_3
    assert directions_of(given, ControllerVersion(version)) is given


def test_jogs_out_of_range_are_refused() -> None:
    wrong: list[Callable[[], Jog]] = [
        lambda: Jog.joint(0, 1, 10),
        lambda: Jog.joint(7, 1, 10),
        lambda: Jog.joint(1, 0, 10),
        lambda: Jog.joint(1, 2, 10),
        lambda: Jog.joint(1, 1, 0),
        lambda: Jog.joint(1, 1, 100.1),
        lambda: Jog.joint(1, 1, 10, step=0),
        lambda: Jog.joint(1, 1, 10, step=-0.1),
        lambda: Jog.joint(1, 1, 10, step=10.0),
        lambda: Jog.cartesian("w", 1, 10),  # type: ignore[arg-type]  # what is tested
        lambda: Jog.cartesian("x", 1, 10, frame=4),  # type: ignore[arg-type]  # what is tested
        lambda: Jog.cartesian("rx", 1, 10, step=7.0),
        lambda: Jog.cartesian("x", 1, 10, step=math.inf),
    ]
    for jog in wrong:
        with pytest.raises(ParameterError):
            jog()


@for_each(
    "point, mode, field",
    [
        (RealtimePoint.joint_position(SIX), 0, "joint_pos_cmd"),
        (RealtimePoint.joint_position(Joints(*SIX)), 0, "joint_pos_cmd"),
        (RealtimePoint.joint_velocity(np.array(SIX)), 1, "joint_vel_cmd"),
        (RealtimePoint.joint_torque(SIX), 2, "joint_torq_cmd"),
        (RealtimePoint.pose(Pose(*SIX)), 3, "cart_pos_tool_wobj_cmd"),
        (RealtimePoint.twist(SIX), 4, "cart_vel_tool_wobj_cmd"),
    ],
)
def test_a_realtime_command_fills_the_field_of_its_mode(
    point: RealtimePoint, mode: int, field: str
) -> None:
    assert point.mode == mode
    expected = rpc.RealTimeControlData(status=True)
    setattr(expected, field, SIX)
    assert point.wire() == expected


@for_each("mode", list(RealtimeMode))
def test_realtime_commands_out_of_range_are_refused(mode: RealtimeMode) -> None:
    make: Any = getattr(RealtimePoint, mode.name.lower())
    wrong: list[Any] = [SIX[:5], [*SIX, 0.0], [math.nan, *SIX[1:]], [math.inf, *SIX[1:]], None]
    if mode is not RealtimeMode.JOINT_TORQUE:
        wrong.append([0.0] * 5 + [6.5])
    for values in wrong:
        with pytest.raises(ParameterError):
            make(values)
        with pytest.raises(ParameterError):
            RealtimePoint(mode, values)


@for_each("mode", [-1, 7, True, "joint_position", None])
def test_what_is_no_mode_makes_no_realtime_command(mode: Any) -> None:
    with pytest.raises(ParameterError, match="mode"):
        RealtimePoint(mode, tuple(SIX))


def test_poses_and_joints_are_not_mixed_up() -> None:
    with pytest.raises(ParameterError):
        RealtimePoint.joint_position(Pose(*SIX))
    with pytest.raises(ParameterError):
        RealtimePoint.pose(Joints(*SIX))


def test_a_frame_in_words_is_refused_with_the_names_to_write() -> None:
    frame: Any = "tool"  # as the streams take it
    with pytest.raises(ParameterError, match=r"frame is 'tool', .*2 \(JogFrame\.TOOL\)"):
        Jog.cartesian("z", 1, 10, frame=frame)
