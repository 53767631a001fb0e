"""Ctrl-C: the arm has been stopped when KeyboardInterrupt goes on."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest
from api.desk import Desk

import aioduco.sync
from aioduco import Outcome, StopUnconfirmed
from aioduco.sync import Robot
from aioduco.sync._runner import uninterrupted
from aioduco.testing import eventually
from sync.conftest import HOME, Interrupts, meanwhile, raised_by_ctrl_c

WAYS: dict[str, Callable[[Robot], object]] = {
    "call": lambda robot: robot.motion.movej2(HOME, v=1.0, a=1.0),
    "wait": lambda robot: robot.motion.movej2.start(HOME, v=1.0, a=1.0).wait(),
    "wait in time": lambda robot: robot.motion.movej2.start(HOME, v=1.0, a=1.0).wait(timeout=30),
    "states": lambda robot: list(robot.motion.movej2.start(HOME, v=1.0, a=1.0).states()),
    "run": lambda robot: robot.motion.run(robot.motion.movej2.prepare(HOME, v=1.0, a=1.0)),
    "jog": lambda robot: robot.motion.speedl([0, 0, -0.02, 0, 0, 0], a=1.0, time=None),
}


@pytest.mark.parametrize("way", WAYS)
def test_the_arm_stands_before_it_goes_on(
    way: str, robot: Robot, desk: Desk, interrupts: Interrupts
) -> None:
    desk.motion_time = 30.0

    def waited_for() -> bool:
        # followed for so long that the program is not on its way into the wait any more
        return desk.moving() and len(desk.received("get_noneblock_taskstate")) > 10

    with interrupts(waited_for), pytest.raises(KeyboardInterrupt):
        WAYS[way](robot)
    assert not desk.moving()
    assert "stop" in desk.commands
    desk.motion_time = 0.05
    assert robot.motion.movej2(HOME, v=1.0, a=1.0) is Outcome.FINISHED  # all is well afterwards


@pytest.mark.parametrize("kind", [KeyboardInterrupt, SystemExit, LookupError])
def test_a_second_one_does_not_cut_the_stop_short(
    kind: type[BaseException], robot: Robot, desk: Desk, interrupts: Interrupts
) -> None:
    desk.motion_time = 30.0
    desk.braking_time = 0.5
    stopping = lambda: "stop" in desk.commands  # noqa: E731  # read better in one line
    with (
        raised_by_ctrl_c(kind),
        interrupts(desk.moving, stopping, stopping),
        pytest.raises(kind),
    ):
        robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert not desk.moving()


def test_a_motion_on_its_way_is_stopped(robot: Robot, desk: Desk, interrupts: Interrupts) -> None:
    """The interrupt comes while the controller has the motion, and has not answered yet."""
    desk.motion_time = 30.0
    start = desk._answers["movej2"]
    gate = desk.hold("movej2", start)

    interrupted = threading.Event()

    def noted(*_: object) -> None:
        interrupted.set()
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, noted)
    try:
        with (
            meanwhile(interrupted.wait, gate.set),
            interrupts(lambda: desk.received("movej2")),
            pytest.raises(KeyboardInterrupt),
        ):
            robot.motion.movej2.start(HOME, v=1.0, a=1.0)
    finally:
        signal.signal(signal.SIGINT, before)
    assert not desk.moving()
    assert robot.tasks == ()


def test_a_read_is_given_up_and_nothing_is_stopped(
    robot: Robot, desk: Desk, interrupts: Interrupts
) -> None:
    desk.hold("get_tcp_pose")
    begin = time.monotonic()
    with (
        interrupts(lambda: desk.received("get_tcp_pose")),
        pytest.raises(KeyboardInterrupt),
    ):
        robot.state.get_tcp_pose()
    assert time.monotonic() - begin < 2.0  # the call's own limit
    assert desk.commands == []


@pytest.mark.slow
def test_a_stop_that_failed_is_its_cause(desk: Desk, interrupts: Interrupts) -> None:
    desk.motion_time = 30.0
    desk.answer("stop", -1)
    robot = aioduco.sync.connect(desk.host, desk.port, stop_timeout=0.2)
    robot.open()
    with interrupts(desk.moving), pytest.raises(KeyboardInterrupt) as caught:
        robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert isinstance(caught.value.__cause__, StopUnconfirmed)
    with pytest.raises(StopUnconfirmed):
        robot.close()


@pytest.mark.parametrize("kind", [KeyboardInterrupt, SystemExit])
def test_one_at_the_end_of_closing_is_not_lost(
    desk: Desk, interrupts: Interrupts, kind: type[BaseException]
) -> None:
    robot = aioduco.sync.connect(desk.host, desk.port)
    robot.open()
    with ThreadPoolExecutor(1) as pool:
        call = pool.submit(robot.sleep, 600.0)  # so that the loop ends a while after the robot
        eventually(lambda: len(robot._runner._calls) == 1)
        with (
            raised_by_ctrl_c(kind),
            interrupts(lambda: robot._runner.closing),
            pytest.raises(kind),
        ):
            robot.close()
        assert not robot._runner.running
        assert isinstance(call.exception(), aioduco.RobotStateError)


def test_outside_of_a_call_leaving_the_block_stops_the_arm(
    desk: Desk, interrupts: Interrupts
) -> None:
    desk.motion_time = 30.0
    elsewhere = threading.Event()

    def program() -> None:
        with aioduco.sync.connect(desk.host, desk.port) as robot:
            robot.motion.movej2.start(HOME, v=1.0, a=1.0)
            elsewhere.set()
            threading.Event().wait(10.0)

    with interrupts(elsewhere.is_set), pytest.raises(KeyboardInterrupt):
        program()
    assert not desk.moving()


def test_what_a_signal_handler_raises_does_the_same(robot: Robot, desk: Desk) -> None:
    desk.motion_time = 30.0

    def out_of_time(*_: object) -> None:
        raise LookupError

    before = signal.signal(signal.SIGUSR1, out_of_time)
    main = threading.get_ident()
    try:
        with (
            meanwhile(
                lambda: eventually(desk.moving), lambda: signal.pthread_kill(main, signal.SIGUSR1)
            ),
            pytest.raises(LookupError),
        ):
            robot.motion.movej2(HOME, v=1.0, a=1.0)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert not desk.moving()


def test_a_signal_handler_that_raises_again_and_again_cuts_no_step_short() -> None:
    left = [LookupError(number) for number in range(5)]

    def step() -> None:
        if left:
            raise left.pop()

    assert len(uninterrupted(step)) == 5

    def fails() -> None:
        raise ValueError("a defect")

    with pytest.raises(ValueError, match="a defect"):
        uninterrupted(fails)
