"""Sections: what they send, and the types that they return."""

from __future__ import annotations

from typing import Literal

import pytest
from api.cases import END_ERRORS
from for_each import for_each

import aioduco
from aioduco._wire import rpc
from aioduco.api.section import check_finished
from client.bench import HOME, POSE, Bench


def test_a_robot_has_every_section_that_it_declares() -> None:
    robot = aioduco.connect("192.0.2.1")
    declared = aioduco.Robot.__annotations__
    assert len(declared) > 20
    made = {name: type(getattr(robot, name)).__name__ for name in declared}
    assert made == {**declared, "settings": "Settings"}


async def test_what_is_left_out_goes_out_as_nothing(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time = 0.01
    await robot.motion.movel(POSE, 0.1, 0.2)
    (call,) = bench.received("movel")
    assert call.args == (POSE, 0.1, 0.2, 0.0, [], "", "", False, rpc.Op(), False)


PLACES = (
    *("get_actual_joints_position", "get_target_joints_position"),
    *("get_tcp_pose", "get_tcp_pose_coord", "get_flange_pose"),
)


@pytest.mark.parametrize("name", PLACES)
async def test_a_place_that_is_not_known_yet(robot: aioduco.Robot, bench: Bench, name: str) -> None:
    for wire in ([], [float("nan")] * 6):
        bench.answer(name, wire)
        with pytest.raises(aioduco.StaleState, match="still starting"):
            await getattr(robot.state, name)()


@pytest.mark.parametrize("through", ["servoj", "realtime"])
async def test_a_trajectory_from_a_place_that_is_not_known(
    robot: aioduco.Robot, bench: Bench, through: Literal["servoj", "realtime"]
) -> None:
    bench.answer("get_actual_joints_position", [0.0] * 5)
    path = aioduco.JointTrajectory([HOME, [*HOME[:5], 0.1]], [0.0, 1.0])
    with pytest.raises(aioduco.StaleState, match="5 of 6 joint angles"):
        await robot.motion.follow_joint_trajectory(path, v=1.0, a=5.0, through=through)
    assert not robot.statistics().tasks


async def test_samples_are_numbered(robot: aioduco.Robot) -> None:
    status = await robot.state.getRobotStatus()
    assert list(status.joints) == HOME
    assert (await robot.state.getRobotStatus()).sequence == status.sequence + 1


async def test_a_type_of_fewer_words_has_no_serial_number(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.answer("get_robot_type", ["GCR5"])
    assert (await robot.version.get_robot_type()).serial_number == ""


async def test_an_end_that_is_refused(robot: aioduco.Robot, bench: Bench) -> None:
    bench.answer("shutdown", -1)
    with pytest.raises(aioduco.Refused, match=r"refused shutdown \(answer -1\)"):
        await robot.system.shutdown()


REFUSED = dict.fromkeys((0, 1, -1, 99), aioduco.Refused)


@for_each("answer, error", [*END_ERRORS.items(), *REFUSED.items()])
def test_end_states_that_are_no_success(answer: int, error: type[Exception]) -> None:
    with pytest.raises(error, match="set_it"):
        check_finished("set_it", answer)
