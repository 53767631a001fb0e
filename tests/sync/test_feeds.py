"""The feed and the events, read by blocking programs."""

from __future__ import annotations

import pytest
from api.desk import Desk

import aioduco.sync
from aioduco import RobotStateError, events
from aioduco.sync import Robot
from aioduco.testing import eventually


def test_samples_come_one_after_another(robot: Robot) -> None:
    with robot.feed.subscribe("every") as samples:
        numbers = [sample.sequence for sample, _ in zip(samples, range(5), strict=False)]
        assert samples.dropped == 0
    assert numbers == list(range(numbers[0], numbers[0] + 5))
    assert robot.feed.statistics().samples >= 5
    assert robot.feed.statistics().subscribers == 0
    assert robot.feed.rate == 50.0
    assert robot.feed.error is None
    assert robot.feed.latest().received_at <= robot.feed.heard_at


def test_waiting_for_a_sample(robot: Robot) -> None:
    assert robot.wait_for(lambda s: s.io.digital_inputs[2], timeout=20.0).io.digital_inputs[2]
    assert robot.feed.wait_for(lambda s: not s.status.collision, timeout=20.0)
    with pytest.raises(TimeoutError):
        robot.wait_for(lambda _: False, timeout=0.05)
    with pytest.raises(ZeroDivisionError):
        robot.wait_for(lambda _: bool(1 / 0))


def test_events_come_one_after_another(robot: Robot, desk: Desk) -> None:
    with robot.events.subscribe() as stream, robot.feed.subscribe() as samples:
        next(samples)
        desk.collision = True
        for event in stream:
            if isinstance(event, events.CollisionDetected):
                break
        with pytest.raises(TimeoutError):
            stream.next(timeout=0.0)


def test_an_item_that_waits_is_taken_without_a_wait(robot: Robot) -> None:
    with robot.feed.subscribe(size=2) as samples:
        eventually(lambda: samples._made.ready)
        first = samples.next(timeout=0)
        assert samples.next().sequence > first.sequence


def test_they_end_when_the_robot_closes(desk: Desk) -> None:
    robot = aioduco.sync.connect(desk.host, desk.port)
    robot.open()
    with robot.feed.subscribe() as samples:
        next(samples)
        robot.close()
        with pytest.raises(RobotStateError):
            list(samples)
    with pytest.raises(RobotStateError), robot.events.subscribe():
        pass
