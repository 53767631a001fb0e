"""The thread of the event loop: its start, who may call it, and its end."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from unittest.mock import Mock

import anyio
import pytest
from api.desk import Desk
from interpreter import python

import aioduco.sync
from aioduco import ConnectError, Outcome, RobotStateError, TaskState, TaskStopped
from aioduco.supervision.gate import PermitEnding
from aioduco.sync import Robot
from aioduco.testing import eventually, no_leaks
from sync.conftest import HOME, meanwhile


def threads() -> list[str]:
    return [thread.name for thread in threading.enumerate() if "aioduco-sync" in thread.name]


def test_it_leaves_nothing_behind(desk: Desk) -> None:
    with aioduco.sync.connect(desk.host, desk.port):
        pass  # the controller, too, has all that it needs from here on
    with no_leaks(), aioduco.sync.connect(desk.host, desk.port) as robot:
        assert len(threads()) == 1
        robot.state.get_tcp_pose()
    assert threads() == []


def test_nobody_there(desk: Desk) -> None:
    desk.__exit__(None, None, None)
    with pytest.raises(ConnectError), aioduco.sync.connect(desk.host, desk.port):
        pass
    assert threads() == []


def test_a_robot_that_was_never_opened_names_its_own_block() -> None:
    with pytest.raises(RobotStateError, match=r"or `with aioduco\.sync\.connect"):
        aioduco.sync.connect("nowhere").stop_now()


FORKING = """
import os, sys
import aioduco, aioduco.sync

# nothing is to be said of a busy machine
with aioduco.sync.connect(sys.argv[1], int(sys.argv[2]), lag_limit=None) as robot:
    task = robot.motion.movej2.start([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0)
    child = os.fork()
    if child == 0:
        for use in (robot.stop, robot.stop_now, task.wait, robot.state.get_tcp_pose, robot.sleep):
            try:
                use(*([0.1] if use == robot.sleep else []))
            except aioduco.WrongProcess:
                continue
            os._exit(9)
        sys.exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    print(task.wait().value)
"""


@pytest.mark.slow
@pytest.mark.linux("os.fork")
def test_a_forked_child_is_refused_and_leaves_its_parents_robot_alone(desk: Desk) -> None:
    desk.motion_time = 0.5
    done = python("-W", "ignore", "-c", FORKING, desk.host, str(desk.port), timeout=30.0)
    assert (done.returncode, done.stdout, done.stderr) == (0, "finished\n", "")
    assert desk.commands == ["movej2"]


def test_a_call_that_was_under_way_at_a_fork_ends_without_an_answer_in_the_child(
    robot: Robot,
) -> None:
    """A handler of a signal may fork while its thread waits: only the parent has the loop."""
    runner = robot._runner
    call = runner.start(anyio.sleep_forever())
    runner.forked()
    call.wait()
    runner.in_forked_child = False  # this is the parent after all, and closes the robot
    assert isinstance(call.error, aioduco.WrongProcess)


def test_closing_stops_what_moves(desk: Desk) -> None:
    desk.motion_time = 30.0
    robot = aioduco.sync.connect(desk.host, desk.port)
    robot.open()
    task = robot.motion.movej2.start(HOME, v=1.0, a=1.0)
    robot.close()
    robot.close()
    assert task.outcome is Outcome.STOPPED
    assert desk.commands == ["movej2", "stop"]
    assert robot.statistics().stops == 1


@pytest.mark.parametrize("opened", [False, True])
def test_a_robot_that_is_not_open(desk: Desk, *, opened: bool) -> None:
    robot = aioduco.sync.connect(desk.host, desk.port)
    if opened:
        robot.open()
        robot.close()
        with pytest.raises(RobotStateError):
            robot.open()
    for call in (robot.stop, robot.state.get_tcp_pose, lambda: robot.sleep(0.0)):
        with pytest.raises(RobotStateError):
            call()
    with pytest.raises(RobotStateError):
        robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert robot.tasks == ()
    assert desk.commands == []


async def test_inside_a_running_loop(desk: Desk) -> None:
    """As in a notebook: the main thread has a loop of its own, and waits in a call."""
    assert asyncio.get_running_loop()
    with aioduco.sync.connect(desk.host, desk.port) as robot:
        assert robot.motion.movej2(HOME, v=1.0, a=1.0) is Outcome.FINISHED


@pytest.mark.parametrize("way", ["stop", "stop_now"])
def test_any_thread_may_stop(robot: Robot, desk: Desk, way: str) -> None:
    desk.motion_time = 30.0
    with (
        meanwhile(lambda: eventually(desk.moving), getattr(robot, way)),
        pytest.raises(aioduco.TaskStopped),
    ):
        robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.parametrize("way", ["stop_now", "pause"])
def test_a_stop_ends_what_another_thread_has_called_for(
    desk: Desk, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    """Although the loop has not begun it: it was called for before the stop."""
    held, called, free = threading.Event(), threading.Event(), threading.Event()

    def hand_over(work: Callable[[], object]) -> None:
        run(work)
        called.set()

    def hold() -> None:
        held.set()
        free.wait()

    with (
        aioduco.sync.connect(
            desk.host, desk.port, heartbeat=30.0, loop_stall_limit=30.0, lag_limit=None
        ) as robot,
        ThreadPoolExecutor() as threads,
    ):
        loop = robot._runner._loop
        holding = threads.submit(robot._runner.call_sync, hold)
        held.wait()
        run = loop.run
        monkeypatch.setattr(robot._runner, "_loop", Mock(run=hand_over))
        moved = threads.submit(robot.motion.movej2, HOME, v=1.0, a=1.0)
        called.wait()
        if way == "stop_now":
            robot.stop_now()
        else:
            robot._made._supervisor.gate.end(PermitEnding.PAUSED)
        free.set()
        holding.result()
        with pytest.raises(TaskStopped, match="not sent"):
            moved.result()
        assert "movej2" not in desk.commands
        robot.motion.movej2(HOME, v=1.0, a=1.0)  # one that is called for later is another one


def test_a_predicate_can_end_the_program(robot: Robot) -> None:
    def end(_: object) -> bool:
        raise SystemExit(3)

    with pytest.raises(SystemExit) as ended:
        robot.wait_for(end, timeout=30.0)
    assert ended.value.code == 3
    assert robot.state.get_robot_state()


@pytest.mark.cases(2)
@pytest.mark.parametrize("call", [lambda robot: robot.state.robotmoving(), Robot.close])
def test_a_predicate_cannot_call_the_robot(robot: Robot, call: Callable[[Robot], object]) -> None:
    with pytest.raises(RuntimeError, match="wait for itself"):
        robot.wait_for(lambda _: bool(call(robot)))
    assert robot.state.get_robot_state()


def test_one_left_open_is_closed_with_a_warning(desk: Desk) -> None:
    desk.motion_time = 30.0
    robot = aioduco.sync.connect(desk.host, desk.port)
    robot.open()
    robot.motion.movej2.start(HOME, v=1.0, a=1.0)
    kept = [robot]
    del robot
    with pytest.warns(ResourceWarning, match="unclosed <Robot"):
        kept.clear()
    eventually(lambda: threads() == [])
    assert desk.commands == ["movej2", "stop"]
    assert not desk.moving()


@pytest.mark.parametrize(
    ("wait", "polls"),
    [
        (lambda robot: robot.sleep(600.0), False),
        (lambda robot: robot.system.restart(timeout=600.0), True),
    ],
    ids=["sleep", "restart"],
)
def test_closing_ends_what_another_thread_waits_for(
    desk: Desk, wait: Callable[[Robot], object], polls: bool
) -> None:
    polled = threading.Event()  # then it is known that `restart` was answered

    def state(_: int) -> int:
        polled.set()
        return TaskState.FINISHED

    desk.answer("restart", 77)
    desk.answer("get_noneblock_taskstate", state)
    desk.states[0] = 1  # it initializes, and never ends that
    with ThreadPoolExecutor(1) as pool:
        with aioduco.sync.connect(desk.host, desk.port) as robot:
            call = pool.submit(wait, robot)
            eventually(lambda: len(robot._runner._calls) == 1 and polled.is_set() == polls)
            with meanwhile(lambda: eventually(lambda: robot._runner.closing), robot.close):
                robot.close()
        with pytest.raises(RobotStateError, match=r"the robot (is|was) closed"):
            call.result()


@pytest.mark.slow
def test_a_program_that_ends_without_closing(desk: Desk) -> None:
    desk.motion_time = 30.0
    program = (
        "import aioduco.sync\n"
        f"robot = aioduco.sync.connect({desk.host!r}, {desk.port})\n"
        "robot.open()\n"
        "robot.motion.movej2.start([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0)\n"
        "print('ends')\n"
    )
    done = python("-c", program)
    assert (done.stdout, done.returncode) == ("ends\n", 0)
    assert "left <Robot" in done.stderr
    assert desk.commands == ["movej2", "stop"]
    assert not desk.moving()
