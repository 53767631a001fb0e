"""Wrong settings of a robot, wrong options of `run` and of a trajectory: nothing is sent."""

from __future__ import annotations

import inspect
import math
from typing import Any

import pytest
from for_each import for_each

import aioduco
from aioduco import ParameterError
from client.bench import HOME, Bench


@for_each(
    "arguments, parameter",
    [
        ({"host": 5}, "host"),
        ({"port": 0}, "port"),
        ({"call_timeout": None}, "call_timeout"),
        ({"pool_size": 0}, "pool_size"),
        ({"pool_size": 2.5}, "pool_size"),
        ({"heartbeat": 0.1}, "heartbeat"),
        ({"heartbeat": 61.0}, "heartbeat"),
        ({"heartbeat": False}, "heartbeat"),
        ({"loop_stall_limit": math.inf}, "loop_stall_limit"),
        ({"loop_stall_limit": 0.001}, "loop_stall_limit"),
        ({"lag_limit": 0.001}, "lag_limit"),
        ({"on_cancel": "go on"}, "on_cancel"),
        ({"trace": "log.txt"}, "trace"),
    ],
)
def test_bad_settings_are_refused_by_name(arguments: dict[str, Any], parameter: str) -> None:
    with pytest.raises(aioduco.ParameterError) as caught:
        aioduco.connect(**{"host": "127.0.0.1", **arguments})
    assert caught.value.parameter == parameter


async def test_what_is_run_or_followed_is_checked_before_anything_is_sent(
    robot: aioduco.Robot, bench: Bench
) -> None:
    for ahead in (math.nan, "3", 0, -1, True, 1.5, None):
        motion = robot.motion.movej2(HOME, 1.0, 1.0)
        with pytest.raises(ParameterError, match="ahead"):
            await robot.motion.run(motion, ahead=ahead)  # type: ignore[arg-type]  # the wrong type is the point
    with pytest.raises(ParameterError, match="on_cancel"):
        await robot.motion.movej2(HOME, 1.0, 1.0).start(on_cancel=math.nan)  # type: ignore[arg-type]  # likewise
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
