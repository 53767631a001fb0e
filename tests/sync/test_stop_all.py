"""Several arms are stopped at once, each whatever the others do, through any interrupt."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from api.desk import Desk

import aioduco.sync
from aioduco import Outcome
from aioduco.sync import Robot, stop_all
from sync.conftest import HOME, Interrupts, raised_by_ctrl_c


@pytest.fixture
def desks() -> Iterator[list[Desk]]:
    with ExitStack() as stack:
        yield [stack.enter_context(Desk()) for _ in range(3)]


@pytest.fixture
def robots(desks: list[Desk]) -> Iterator[list[Robot]]:
    with ExitStack() as stack:
        yield [
            stack.enter_context(
                aioduco.sync.connect(desk.host, desk.port, stop_timeout=0.5, hold_limit=None)
            )
            for desk in desks
        ]


def start_all(robots: list[Robot], desks: list[Desk]) -> None:
    for desk, robot in zip(desks, robots, strict=True):
        desk.motion_time = 600.0
        robot.motion.movej2.start(HOME, v=1.0, a=1.0)


def test_all_stand(robots: list[Robot], desks: list[Desk]) -> None:
    start_all(robots, desks)
    tasks = [robot.tasks[0] for robot in robots]
    stop_all(robots)
    assert not any(desk.moving() for desk in desks)
    assert [task.outcome for task in tasks] == [Outcome.STOPPED] * 3
    stop_all([])


@pytest.mark.slow
def test_who_fails_is_named_and_the_others_stand(robots: list[Robot], desks: list[Desk]) -> None:
    start_all(robots, desks)
    desks[0].answer("stop", -1)
    robots[2].close()
    with pytest.raises(aioduco.StopsUnconfirmed, match="of 2 of 3 arms") as caught:
        stop_all(robots)
    first, second, third = caught.value.errors
    assert isinstance(first, aioduco.StopUnconfirmed)
    assert second is None
    assert isinstance(third, aioduco.RobotStateError)
    assert f"{desks[0].host}:{desks[0].port}: " in str(caught.value)
    assert not desks[1].moving()
    desks[0].answer("stop", desks[0]._stop)


@pytest.mark.slow
def test_what_is_no_robot_keeps_no_other_from_its_stop(
    robots: list[Robot], desks: list[Desk]
) -> None:
    start_all(robots, desks)
    missing: Any = None
    with pytest.raises(aioduco.StopsUnconfirmed, match=r"\[1\]: None is no robot"):
        stop_all([robots[0], missing, *robots[1:]])
    assert not any(desk.moving() for desk in desks)


@pytest.mark.slow
def test_a_robot_in_place_of_a_list_is_stopped(robots: list[Robot], desks: list[Desk]) -> None:
    start_all(robots, desks)
    stop_all(robots[0])  # type: ignore[arg-type]  # that is the test
    assert [desk.moving() for desk in desks] == [False, True, True]
    with pytest.raises(aioduco.ParameterError, match="robots is 3"):
        stop_all(3)  # type: ignore[arg-type]  # that is the test
    stop_all(robots)


@pytest.mark.parametrize("kind", [KeyboardInterrupt, SystemExit])
def test_an_interrupt_goes_on_when_all_stand(
    kind: type[BaseException], robots: list[Robot], desks: list[Desk], interrupts: Interrupts
) -> None:
    start_all(robots, desks)
    for desk in desks:
        desk.braking_time = 0.3
    told = lambda: "stop" in desks[0].commands  # noqa: E731  # read better in one line
    with raised_by_ctrl_c(kind), interrupts(told, told), pytest.raises(kind):
        stop_all(robots)
    assert not any(desk.moving() for desk in desks)
