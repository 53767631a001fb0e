"""What is out of range is refused when the motion is made, and nothing is sent."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import aioduco
from aioduco import Joints, Op, ParameterError, Pose, output
from client.bench import HOME, POSE, Bench

#: the robot is Any here: wrong types are a part of what is tried
BAD: dict[str, tuple[Callable[[Any], Any], str]] = {
    "five joints": (lambda r: r.motion.movej2(HOME[:5], 1.0, 1.0), "joints .*six"),
    "seven joints": (lambda r: r.motion.movej2([*HOME, 0.0], 1.0, 1.0), "joints .*six"),
    "joints as text": (lambda r: r.motion.movej2("000000", 1.0, 1.0), "joints .*six"),
    "joint NaN": (lambda r: r.motion.movej2([math.nan] * 6, 1.0, 1.0), "joints"),
    "joint infinite": (lambda r: r.motion.movej2([0, 0, math.inf, 0, 0, 0], 1.0, 1.0), r"\[2\]"),
    "joint in degrees": (lambda r: r.motion.movej2([0, 0, 90, 0, -90, 0], 1.0, 1.0), "radians"),
    "joint out of range": (lambda r: r.motion.movej2([6.4, 0, 0, 0, 0, 0], 1.0, 1.0), r"\[0\]"),
    "joints of wrong shape": (lambda r: r.motion.movej2(np.zeros((2, 3)), 1.0, 1.0), "joints"),
    "a pose for joints": (lambda r: r.motion.movej2(Pose(*POSE), 1.0, 1.0), "joints"),
    "joints for a pose": (lambda r: r.motion.movel(Joints(*HOME), 0.1, 1.0), "pose"),
    "speed too high": (lambda r: r.motion.movej2(HOME, 4.0, 1.0), "v is 4.0.*rad/s"),
    "speed zero": (lambda r: r.motion.movej2(HOME, 0.0, 1.0), "v is 0.0.*rad/s"),
    "speed negative": (lambda r: r.motion.movel(POSE, -0.1, 1.0), "v is -0.1.*m/s"),
    "speed NaN": (lambda r: r.motion.movel(POSE, math.nan, 1.0), "v is nan"),
    "speed is a bool": (lambda r: r.motion.movel(POSE, True, 1.0), "v is True"),
    "speed is text": (lambda r: r.motion.movel(POSE, "0.1", 1.0), "v is '0.1'"),
    "speed of mm/s": (lambda r: r.motion.movel(POSE, 200.0, 1.0), "v is 200.0.*m/s"),
    "acceleration zero": (lambda r: r.motion.movel(POSE, 0.1, 0.0), "a is 0.0.*m/s²"),
    "acceleration infinite": (lambda r: r.motion.movej2(HOME, 1.0, math.inf), "a is inf"),
    "radius negative": (lambda r: r.motion.movel(POSE, 0.1, 1.0, r=-0.01), "r is -0.01.*m"),
    "radius NaN": (lambda r: r.motion.tcp_move(POSE, 0.1, 1.0, r=math.nan), "r is nan"),
    "five numbers of a pose": (lambda r: r.motion.movel(POSE[:5], 0.1, 1.0), "pose .*m"),
    "via NaN": (lambda r: r.motion.movec([math.nan] * 6, POSE, 0.1, 1.0), "via"),
    "arc mode": (lambda r: r.motion.movec(POSE, POSE, 0.1, 1.0, mode=3), "mode is 3"),
    "near of five": (lambda r: r.motion.movej_pose2(POSE, 1.0, 1.0, q_near=HOME[:5]), "q_near"),
    "tool name too long": (lambda r: r.motion.movel(POSE, 0.1, 1.0, tool="x" * 33), "tool"),
    "tool name is a number": (lambda r: r.motion.movel(POSE, 0.1, 1.0, tool=1), "tool is 1"),
    "op by distance for joints": (
        lambda r: r.motion.movej2(HOME, 1.0, 1.0, op=Op.at_start(output(1), distance=0.1)),
        "distance",
    ),
    "op of another type": (lambda r: r.motion.movel(POSE, 0.1, 1.0, op="out"), "op is 'out'"),
    "def_acc is a number": (lambda r: r.motion.movel(POSE, 0.1, 1.0, def_acc=2), "def_acc"),
}

BAD_CALLS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "output 0": (lambda r: r.io.set_standard_digital_out(0, True), "num is 0.*1 to 16"),
    "output 17": (lambda r: r.io.set_standard_digital_out(17, True), "num is 17.*1 to 16"),
    "output 1.5": (lambda r: r.io.set_standard_digital_out(1.5, True), "num is 1.5"),
    "value is text": (lambda r: r.io.set_standard_digital_out(1, "on"), "value is 'on'"),
    "tool output 3": (lambda r: r.io.set_tool_digital_out(3, True), "num is 3.*1 to 2"),
    "function input 9": (lambda r: r.io.get_function_digital_in(9), "num is 9.*1 to 8"),
    "task id negative": (lambda r: r.state.get_noneblock_taskstate(-1), "task_id is -1"),
    "mode remote": (lambda r: r.system.switch_mode(2), "mode is 2"),
}


@pytest.mark.parametrize(("make", "words"), BAD.values(), ids=BAD)
async def test_a_bad_motion_is_refused_when_it_is_made(
    robot: aioduco.Robot, bench: Bench, make: Callable[[aioduco.Robot], Any], words: str
) -> None:
    with pytest.raises(aioduco.ParameterError, match=words) as caught:
        make(robot)
    assert "nothing was sent" in str(caught.value)
    assert isinstance(caught.value, ValueError)
    assert bench.commands == []


@pytest.mark.parametrize(("call", "words"), BAD_CALLS.values(), ids=BAD_CALLS)
async def test_a_bad_call_is_refused_before_it_is_sent(
    robot: aioduco.Robot, bench: Bench, call: Callable[[aioduco.Robot], Any], words: str
) -> None:
    before = len(bench.received())
    with pytest.raises(aioduco.ParameterError, match=words) as caught:
        await call(robot)
    assert "nothing was sent" in str(caught.value)
    assert {call.method for call in bench.received()[before:]} <= {"rpc_heartbeat"}


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"host": ""}, "host"),
        ({"host": 5}, "host"),
        ({"port": 0}, "port"),
        ({"port": 70000}, "port"),
        ({"port": "7003"}, "port"),
        ({"call_timeout": 0.0}, "call_timeout"),
        ({"call_timeout": None}, "call_timeout"),
        ({"connect_timeout": math.nan}, "connect_timeout"),
        ({"pool_size": 0}, "pool_size"),
        ({"pool_size": 2.5}, "pool_size"),
        ({"heartbeat": 0.1}, "heartbeat"),
        ({"heartbeat": 61.0}, "heartbeat"),
        ({"heartbeat": False}, "heartbeat"),
        ({"loop_stall_limit": math.inf}, "loop_stall_limit"),
        ({"on_cancel": "go on"}, "on_cancel"),
        ({"stop_timeout": -1.0}, "stop_timeout"),
        ({"standstill_timeout": True}, "standstill_timeout"),
    ],
)
def test_bad_settings_are_refused_by_name(arguments: dict[str, Any], parameter: str) -> None:
    with pytest.raises(aioduco.ParameterError) as caught:
        aioduco.connect(**{"host": "127.0.0.1", **arguments})
    assert caught.value.parameter == parameter


#: times that nobody can wait for
BAD_TIMES = (math.nan, math.inf, -1.0, 0.0, True, "1", [1.0])


@pytest.mark.parametrize("time", BAD_TIMES, ids=str)
async def test_a_bad_time_is_refused_and_nothing_is_sent(
    robot: aioduco.Robot, bench: Bench, time: Any
) -> None:
    """Every function of the robot, of a motion and of the feed that waits for so long."""
    timed = {
        name: function
        for thing in (robot, robot.feed)
        for name, function in inspect.getmembers(thing, callable)
        if not name.startswith("_") and "timeout" in inspect.signature(function).parameters
    }
    assert set(timed) == {"bring_up", "recover", "rearm_heartbeat", "stop_now", "wait_for"}
    for name, function in timed.items():
        others = (lambda _: False,) if name == "wait_for" else ()
        with pytest.raises(ParameterError) as raised:
            await _awaited(function(*others, timeout=time))
        assert raised.value.parameter == "timeout"
    motion = robot.motion.movej2(HOME, 1.0, 1.0)
    with pytest.raises(ParameterError, match="deadline"):
        await motion.start(deadline=time)
    with pytest.raises(ParameterError, match="on_cancel"):
        await motion.start(on_cancel=time)
    assert not bench.commands


async def _awaited(made: Any) -> None:
    if inspect.isawaitable(made):
        await made


async def test_what_is_run_or_followed_is_checked_before_anything_is_sent(
    robot: aioduco.Robot, bench: Bench
) -> None:
    for ahead in (math.nan, "3", 0, -1, True, 1.5, None):
        motion = robot.motion.movej2(HOME, 1.0, 1.0)
        with pytest.raises(ParameterError, match="ahead"):
            await robot.motion.run(motion, ahead=ahead)  # type: ignore[arg-type]  # the wrong type is the point
    path = aioduco.JointTrajectory([HOME, HOME], [0.0, 1.0])
    wrong: dict[str, tuple[Any, ...]] = {
        "trajectory": ("x", None, [HOME, HOME]),
        "v": (math.nan, "1", True, None, 0.0),
        "a": (math.nan, "1", True, None, 0.0),
        "tolerances": ("x", 0.1),
        "feedback": ("x", 1),
        "through": ("x", 1, None),
        "rate": (math.nan, "x", -1, True, None),
        "reach": (math.nan, "x", -1, True, None),
        "switch": ("x", 1),
        "options": ("x", 1),
    }
    given: dict[str, Any] = {"trajectory": path, "v": 1.0, "a": 1.0}
    assert set(wrong) == set(inspect.signature(robot.motion.follow_joint_trajectory).parameters)
    for name, values in wrong.items():
        for value in values:
            with pytest.raises(ParameterError) as raised:
                await robot.motion.follow_joint_trajectory(**given | {name: value})
            assert raised.value.parameter == name
    assert not bench.commands
    assert not bench.received("get_realtime_data_queue_size")
