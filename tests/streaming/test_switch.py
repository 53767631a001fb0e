"""From one trajectory into another: what is sent, without a controller."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from aioduco import JointTrajectory, SwitchPlace, Tolerances, TrajectorySwitch
from aioduco.api.motion.trajectory import _points, _send, _Way

HERE = np.array([0.0, 0.3, 1.2, 0.1, -1.5, 0.0])
WAY = np.array([0.5, -0.2, 0.1, 0.3, -0.4, 0.6])
INTERVAL = 0.002


class Sent(SimpleNamespace):
    """A stream that takes every point at once; at one of them something happens."""

    def __init__(self, number: int, happens: Any) -> None:
        super().__init__(points=[], number=number, happens=happens)

    @property
    def taken(self) -> int:
        return max(0, len(self.points) - 100)

    async def send(self, point: Any) -> None:
        self.points.append(np.array(point))
        if len(self.points) == self.number:
            self.happens()

    async def play(self, points: Any) -> None:
        await self.send(points[0])


async def send(switch: TrajectorySwitch, number: int, happens: Any) -> tuple[Sent, _Way]:
    curve = JointTrajectory([HERE, HERE + WAY], [0.0, 2.0]).curve(HERE.tolist())
    stream: Any = Sent(number, happens)
    way = _Way(curve, INTERVAL, Tolerances())
    await _send(stream, _points(curve, INTERVAL, 3.0), way, switch, 3.0)
    return stream, way


async def test_the_arm_goes_over_without_a_step() -> None:
    switch, places = TrajectorySwitch(), []

    def make(place: SwitchPlace) -> tuple[JointTrajectory, Tolerances]:
        places.append(place)
        goal = place.joints - 0.2
        return JointTrajectory([place.joints, goal], [0.0, 1.0], [place.speeds, [0.0] * 6]), limits

    limits = Tolerances(path=0.3)
    stream, way = await send(switch, 400, lambda: switch.ask(make))
    (place,) = places
    assert place.delay == pytest.approx(0.2)
    points = np.array(stream.points)
    np.testing.assert_allclose(points[400], place.joints)
    np.testing.assert_allclose(points[-1], place.joints - 0.2, atol=1e-9)
    speeds = np.diff(points, axis=0) / INTERVAL
    assert np.abs(np.diff(speeds, axis=0)).max() / INTERVAL < 8.0
    assert np.abs(speeds[300:450]).max(axis=1).min() > 0.2  # nor a rest
    assert len(points) == 400 + 501
    # the arm is compared with the one before, and then with the other
    np.testing.assert_allclose(
        way.at(np.array([100.0, 399.5, 500.0])), points[[100, 399, 500]], atol=2e-3
    )
    assert way.part(399).tolerances is not limits
    assert way.part(400).tolerances is way.last().tolerances is limits
    assert way.time(450) == pytest.approx(0.1)


async def test_one_that_is_not_made_changes_nothing() -> None:
    switch = TrajectorySwitch()
    asked: list[str] = []
    stream, _ = await send(
        switch,
        400,
        lambda: switch.ask(lambda place: asked.append("made"), lambda: asked.append("no")),
    )
    assert asked == ["made"]
    np.testing.assert_allclose(stream.points[-1], HERE + WAY)


@pytest.mark.parametrize("number", [1001, None])
async def test_it_is_said_when_it_is_too_late(number: int | None) -> None:
    switch = TrajectorySwitch()
    asked: list[str] = []

    def ask() -> None:
        switch.ask(lambda place: asked.append("made"), lambda: asked.append("no"))

    if number is None:
        ask()
    else:
        await send(switch, number, ask)
    assert asked == ["no"]
