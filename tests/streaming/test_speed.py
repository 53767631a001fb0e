"""Speeds with a dead-man time."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.api.streams.speed import Speed
from aioduco.errors import ParameterError, StreamStarved
from aioduco.streaming.shared.options import WorkerOptions

from .conftest import Controller, fed

THREAD = WorkerOptions(run_in="thread")


async def test_joint_speeds_carry_the_dead_man_time_and_end_by_speed_stop(
    controller: Controller,
) -> None:
    opened = Speed(controller.endpoint).joints(
        a=2.0, v=0.5, dead_man=0.15, hold=10.0, options=THREAD
    )
    async with opened as stream:
        async for tick in stream.ticks():
            await stream.send([1.0, 0.0, 0.0, 0.0, 0.0, -0.1])
            if tick.number == 25:
                break
    calls = controller.server.received("speedj")
    speeds = np.array([call.args[0] for call in calls])
    assert {call.args[1:] for call in calls} == {(2.0, 150, False)}
    assert speeds.max() == 0.5
    assert np.abs(np.diff(speeds, axis=0)).max() <= 2.0 / 50 * (1 + 1e-6)
    assert not speeds[-1].any()
    assert controller.names()[-1] == "speed_stop"


async def test_a_tool_speed_without_a_hand_on_it_ends_at_zero(controller: Controller) -> None:
    opened = Speed(controller.endpoint).linear(a=0.5, dead_man=0.2, hold=0.06, options=THREAD)
    with pytest.raises(StreamStarved):
        await fed(opened, [[0.05, 0.0, 0.0, 0.0, 0.0, 0.2]], opened.ended)
    speeds = np.array([call.args[0] for call in controller.server.received("speedl")])
    assert np.linalg.norm(np.diff(speeds[:, :3], axis=0), axis=1).max() <= 0.5 / 50 * (1 + 1e-6)
    assert not speeds[-1].any()
    assert controller.names()[-2:] == ["speed_stop", "stop"]


def test_a_dead_man_time_is_no_less_than_two_calls_and_not_for_ever() -> None:
    speed = Speed(Controller.nowhere())
    for make in (speed.joints, speed.linear):
        for wrong in (0.03, None, 200):  # milliseconds
            with pytest.raises(ParameterError, match="dead_man"):
                make(a=1.0, rate=50.0, dead_man=wrong)  # type: ignore[arg-type]  # that is the test
