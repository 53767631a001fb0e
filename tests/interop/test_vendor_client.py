"""The vendor's way of using a controller, with a client that shares no code with this package."""

from __future__ import annotations

import itertools
import math
import threading
from typing import Any

import pytest

from aioduco.testing import eventually

from .conftest import Connect, Generated

pytestmark = pytest.mark.interop

STOPPED, FINISHED = 3, 4  # task states (manual 3.8 section 1.2)
ENABLED = 6
BENT = [0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0]
TURNED = [1.0, 0.2, 1.4, 0.1, -1.4, 0.3]


def bring_up(robot: Any) -> None:
    assert robot.power_on(True) == FINISHED
    assert robot.enable(True) == FINISHED
    assert robot.get_robot_state()[0] == ENABLED


def far(a: list[float], b: list[float]) -> float:
    """The greatest difference of two joint vectors [rad]."""
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


def movej2(robot: Any, joints: list[float], *, block: bool, v: float = 2.0, r: float = 0.0) -> int:
    """A joint move as the vendor's wrapper sends it: op and def_acc left out."""
    answer: int = robot.movej2(joints, v, 4.0, r, block, None, None)
    return answer


def test_power_on_and_enable(connect: Connect) -> None:
    with connect() as robot:
        bring_up(robot)


def test_motion_is_illegal_before_the_arm_is_enabled(connect: Connect) -> None:
    with connect() as robot:
        assert movej2(robot, BENT, block=True) == 7


def test_blocking_motion_returns_finished_at_the_target(connect: Connect) -> None:
    with connect() as robot:
        bring_up(robot)
        assert far(robot.getRobotStatus().jointActualPosition, TURNED) > 0.5
        assert movej2(robot, TURNED, block=True) == FINISHED
        assert far(robot.getRobotStatus().jointActualPosition, TURNED) < 1e-3


def test_blocking_motion_with_a_whole_op(connect: Connect, generated: Generated) -> None:
    whole = generated.structs.Op(*[0, 0, False, 0.0, 0.0, ""] * 3)
    with connect() as robot:
        bring_up(robot)
        assert robot.movej2(TURNED, 2.0, 4.0, 0.0, True, whole, False) == FINISHED


def test_motion_without_blocking_is_followed_by_its_id(connect: Connect) -> None:
    with connect() as robot:
        bring_up(robot)
        first = movej2(robot, TURNED, block=False)
        second = movej2(robot, BENT, block=False)
        assert second > first > FINISHED, "ids rise, and none can be taken for a state"
        eventually(lambda: bool(robot.get_noneblock_taskstate(second) == FINISHED))
        assert robot.get_noneblock_taskstate(first) == FINISHED, "the queue keeps its order"
        assert far(robot.getRobotStatus().jointActualPosition, BENT) < 1e-3


def test_status_is_whole(connect: Connect) -> None:
    with connect() as robot:
        bring_up(robot)
        status = robot.getRobotStatus()
    for what, part in itertools.product(
        ("joint", "cart"),
        ("ExpectPosition", "ExpectVelocity", "ActualPosition", "ActualVelocity"),
    ):
        listed = getattr(status, what + part)
        assert len(listed) >= 6, what + part
        assert all(math.isfinite(number) for number in listed), what + part
    assert status.robotState == ENABLED
    assert status.collision is False


def test_line_keeps_the_orientation(connect: Connect) -> None:
    with connect() as robot:
        bring_up(robot)
        assert movej2(robot, BENT, block=True) == FINISHED
        pose = robot.get_tcp_pose()
        target = [pose[0] - 0.05, pose[1], pose[2] - 0.05, *pose[3:]]
        assert robot.movel(target, 0.5, 1.0, 0.0, None, None, None, True, None, None) == FINISHED
        reached = robot.get_tcp_pose()
        assert far(reached[:3], target[:3]) < 1e-3
        turn = [math.remainder(a - b, math.tau) for a, b in zip(reached[3:], pose[3:], strict=True)]
        assert max(map(abs, turn)) < 1e-3


def test_stop_from_a_second_connection_ends_a_blocking_motion(connect: Connect) -> None:
    """Manual 3.8 section 1.3.3: task control comes from a client of its own."""
    answers: list[int] = []

    def moving(robot: Any) -> bool:
        speeds: list[float] = robot.getRobotStatus().jointActualVelocity
        return max(map(abs, speeds)) > 0.05

    with connect() as robot, connect() as other:
        bring_up(robot)
        blocked = threading.Thread(
            target=lambda: answers.append(movej2(robot, TURNED, block=True, v=0.2)), daemon=True
        )
        blocked.start()
        eventually(lambda: moving(other))
        assert other.stop(True) == FINISHED
        blocked.join(20.0)
        assert answers == [STOPPED]
        assert not moving(other)
        assert far(other.getRobotStatus().jointActualPosition, TURNED) > 0.1
