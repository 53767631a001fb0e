"""The switches of 1.3.11 and their effect on later motions."""

from __future__ import annotations

import math

import pytest

from aioduco._wire.rpc import Op
from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.sim.simulator import READY, Simulator

from .conftest import Program, Started, advance_until, standing_time


def duration(sim: Simulator, robot: Program, angle: float, v: float = 0.5) -> float:
    begin = sim.time
    assert robot.to(angle, *READY[1:], v=v) == TaskState.FINISHED
    return sim.time - begin


@pytest.mark.slow
def test_speed_optimization_is_for_automatic_mode(sim: Simulator, robot: Program) -> None:
    # At 0.5 rad/s and 2 rad/s² it takes 2.25 s; a busy machine only makes it longer.
    assert duration(sim, robot, 1.0) > 2.2
    assert robot.enable_speed_optimization() == TaskState.FINISHED
    assert duration(sim, robot, 0.0) < 1.9
    assert robot.switch_mode(0) == TaskState.FINISHED
    assert duration(sim, robot, 1.0) > 2.2
    assert robot.switch_mode(1) == TaskState.FINISHED
    assert robot.disable_speed_optimization() == TaskState.FINISHED
    assert duration(sim, robot, 0.0) > 2.2


@pytest.mark.slow
def test_acceleration_optimization_shortens_a_motion(sim: Simulator, robot: Program) -> None:
    # At 2 rad/s² it takes 2.45 s, whatever the speed.
    assert duration(sim, robot, 3.0, 3.9) > 2.4
    assert robot.enable_acc_optimization() == TaskState.FINISHED
    assert duration(sim, robot, 0.0, 3.9) < 2.0
    assert robot.disable_acc_optimization() == TaskState.FINISHED
    assert duration(sim, robot, 3.0, 3.9) > 2.4


def test_what_has_no_effect_is_not_checked(robot: Program) -> None:
    def ends(v: float, a: float, *, chosen: bool = False) -> list[int]:
        joints, pose = list(READY), list(robot.get_tcp_pose())
        return [
            robot.movej2(joints, v, a, 0.0, True, Op(), chosen),
            robot.movel(pose, v, a, 0.0, [], "", "", True, Op(), chosen),
        ]

    assert ends(1.0, 0.0) == ends(0.0, 0.0, chosen=True) == [8, 8]
    assert ends(1.0, 0.0, chosen=True) == [4, 4]
    assert robot.enable_acc_optimization() == TaskState.FINISHED
    assert (ends(1.0, 0.0), ends(0.0, 0.0)) == ([4, 4], [8, 8])
    assert robot.disable_acc_optimization() == TaskState.FINISHED
    assert robot.enable_speed_optimization() == TaskState.FINISHED
    assert ends(0.0, 0.0) == [4, 4]


@pytest.mark.slow
def test_vibration_control_takes_time_if_the_simulator_is_told(started: Started) -> None:
    sim, robot = started(vibration_time=0.3)
    ids: list[int] = []

    def ended() -> bool:
        return robot.get_noneblock_taskstate(ids[-1]) == TaskState.FINISHED

    # At 1 rad/s and 2 rad/s² each of the ten takes 0.45 s.
    for switch, least, most in (
        (robot.enable_vibration_control, 7.4, math.inf),
        (robot.disable_vibration_control, 4.4, 7.3),
    ):
        assert switch() == TaskState.FINISHED
        with standing_time(sim):
            begin = sim.time
            ids[:] = [robot.to(0.1 * (1 - n % 2), *READY[1:], block=False) for n in range(10)]
            advance_until(sim, ended, 20.0, every=20)
            assert least <= sim.time - begin < most
    with pytest.raises(ValueError, match="vibration_time"):
        Simulator(vibration_time=-0.1)


@pytest.mark.slow
def test_a_line_through_a_singularity_is_gone_around(sim: Simulator, robot: Program) -> None:
    # Past the wrist's singularity: joint 5 changes its sign on the way.
    start = (0.0, 0.3, 1.2, 0.0, 0.2, 0.0)
    goal = list(Pose.from_matrix(sim.arm.fkine((0.0, 0.3, 1.2, 0.0, -0.2, 0.0))))
    assert robot.to(*start) == TaskState.FINISHED

    def line() -> int:
        return robot.movel(goal, 0.1, 1.0, 0.0, [], "", "", True, Op(), False)

    assert line() == TaskState.ERROR
    assert robot.enable_singularity_control() == TaskState.FINISHED
    assert line() == TaskState.ERROR  # vibration control goes first
    assert robot.disable_vibration_control() == TaskState.FINISHED
    assert line() == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    there = Pose.of(robot.get_tcp_pose())
    assert there.almost_equal(Pose.of(goal), position=1e-3, rotation=2e-3)
    back = list(Pose.from_matrix(sim.arm.fkine(start)))
    through = list(there.interpolate(Pose.of(back), 0.5).shifted(y=0.01))
    assert robot.movec(through, back, 0.1, 1.0, 0.0, 0, [], "", "", True, Op(), False) == 4
    sim.wait_until(lambda: not sim.moving)
    there = Pose.of(robot.get_tcp_pose())
    assert there.almost_equal(Pose.of(back), position=1e-3, rotation=2e-3)
    assert robot.enable_vibration_control() == TaskState.FINISHED
    assert robot.disable_singularity_control() == TaskState.FINISHED
