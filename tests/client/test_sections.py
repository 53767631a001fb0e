"""Sections: what goes over the wire, and what comes back as."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import aioduco
from aioduco import Joints, Op, Pose, TaskState, output
from aioduco._wire import rpc
from aioduco.api.section import check_finished
from client.bench import HOME, POSE, Bench

NONE = rpc.Op()


def test_a_robot_has_every_section_that_it_declares() -> None:
    robot = aioduco.connect("192.0.2.1")
    declared = aioduco.Robot.__annotations__
    assert len(declared) > 20
    made = {name: type(getattr(robot, name)).__name__ for name in declared}
    assert made == {**declared, "settings": "Settings"}


MOTIONS: list[tuple[str, Callable[[aioduco.Robot], aioduco.MotionCommand], tuple[Any, ...]]] = [
    (
        "movej2",
        lambda r: r.motion.movej2(Joints(*HOME), 1.0, 2.0, r=0.1, def_acc=True),
        (HOME, 1.0, 2.0, 0.1, False, NONE, True),
    ),
    (
        "movej2",
        lambda r: r.motion.movej2(np.array(HOME), 1, 2, op=Op.at_start(output(3), time=0.5)),
        (
            HOME,
            1.0,
            2.0,
            0.0,
            False,
            rpc.Op(time_or_dist_1=1, trig_io_1=3, trig_value_1=True, trig_time_1=500.0),
            False,
        ),
    ),
    (
        "movej_pose2",
        lambda r: r.motion.movej_pose2(POSE, 1.0, 2.0, q_near=HOME, tool="grip", wobj="table"),
        (POSE, 1.0, 2.0, 0.0, HOME, "grip", "table", False, NONE, False),
    ),
    (
        "movel",
        lambda r: r.motion.movel(Pose(*POSE), 0.1, 0.2, r=0.01),
        (POSE, 0.1, 0.2, 0.01, [], "", "", False, NONE, False),
    ),
    (
        "movec",
        lambda r: r.motion.movec(POSE, POSE, 0.1, 0.2, mode=2, tool="grip"),
        (POSE, POSE, 0.1, 0.2, 0.0, 2, [], "grip", "", False, NONE, False),
    ),
    (
        "tcp_move",
        lambda r: r.motion.tcp_move([0, 0, 0.1, 0, 0, 0], 0.1, 0.2, tool="grip"),
        ([0, 0, 0.1, 0, 0, 0], 0.1, 0.2, 0.0, "grip", False, NONE, False),
    ),
]


@pytest.mark.parametrize(("name", "make", "args"), MOTIONS)
async def test_a_motion_on_the_wire(
    robot: aioduco.Robot,
    bench: Bench,
    name: str,
    make: Callable[[aioduco.Robot], aioduco.MotionCommand],
    args: tuple[Any, ...],
) -> None:
    bench.motion_time = 0.01
    await make(robot)
    (call,) = bench.received(name)
    assert call.args == args


VECTORS = {
    "get_actual_joints_speed": "joints",
    "get_target_joints_speed": "joints",
    "get_actual_joints_acceleration": "joints",
    "get_target_joints_acceleration": "joints",
    "get_actual_joints_torque": "joints",
    "get_target_joints_torque": "joints",
    "get_ext_torque": "joints",
    "get_tcp_speed": "tool",
    "get_tcp_acceleration": "tool",
    "get_tcp_force": "tool",
    "get_tcp_force_tool": "tool",
    "get_flange_speed": "flange",
    "get_flange_acceleration": "flange",
}
PLACES: dict[str, type[Joints | Pose]] = {
    "get_actual_joints_position": Joints,
    "get_target_joints_position": Joints,
    "get_tcp_pose": Pose,
    "get_tcp_pose_coord": Pose,
    "get_flange_pose": Pose,
}


@pytest.mark.parametrize("name", VECTORS)
async def test_a_vector_that_is_read(robot: aioduco.Robot, bench: Bench, name: str) -> None:
    bench.answer(name, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    vector = await getattr(robot.state, name)()
    np.testing.assert_array_equal(vector, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert not vector.flags.writeable


@pytest.mark.parametrize("name", PLACES)
async def test_a_place_that_is_read(robot: aioduco.Robot, bench: Bench, name: str) -> None:
    bench.answer(name, POSE)
    place = await getattr(robot.state, name)()
    assert isinstance(place, PLACES[name])
    assert list(place) == POSE
    for wire in ([], [float("nan")] * 6):
        bench.answer(name, wire)
        with pytest.raises(aioduco.StaleState, match="still starting"):
            await getattr(robot.state, name)()


async def test_states_status_errors_and_tasks(robot: aioduco.Robot, bench: Bench) -> None:
    bench.errors = ["one", "two"]
    assert (await robot.state.get_robot_state()).safety is aioduco.SafetyState.RUN
    status = await robot.state.getRobotStatus()
    assert list(status.joints) == HOME
    assert (await robot.state.getRobotStatus()).sequence == status.sequence + 1
    assert (await robot.state.getRobotIOStatus()).digital_inputs == (True,) * 16
    assert await robot.state.get_last_error() == ("one", "two")
    assert await robot.state.robotmoving() is False
    assert await robot.state.get_noneblock_taskstate(1) is TaskState.IDLE


async def test_inputs_and_outputs(robot: aioduco.Robot, bench: Bench) -> None:
    for name in (
        "get_standard_digital_out",
        "get_standard_digital_in",
        "get_tool_digital_out",
        "get_tool_digital_in",
        "get_function_digital_in",
        "get_function_digital_out",
    ):
        bench.answer(name, lambda num: num == 2)
        assert await getattr(robot.io, name)(2) is True
        assert await getattr(robot.io, name)(1) is False
    for name in ("set_standard_digital_out", "set_tool_digital_out"):
        bench.answer(name, 4)
        await getattr(robot.io, name)(2, True)
        assert bench.received(name)[0].args == (2, True, True)


async def test_version_and_type(robot: aioduco.Robot, bench: Bench) -> None:
    bench.answer("get_robot_version", "V3.8.0")
    bench.answer("get_robot_type", ["GCR5", "910", "", "SN123"])
    assert await robot.version.get_robot_version() == "V3.8.0"
    assert await robot.version.get_robot_type() == ("GCR5", "910", "", "SN123")
    bench.answer("get_robot_type", ["GCR5"])
    assert (await robot.version.get_robot_type()).serial_number == ""


async def test_the_mode_and_the_end(robot: aioduco.Robot, bench: Bench) -> None:
    for name in ("switch_mode", "shutdown", "restart"):
        bench.answer(name, 4)
    await robot.system.switch_mode(aioduco.OperationMode.MANUAL)
    assert bench.received("switch_mode")[0].args == (0,)
    await robot.system.shutdown()
    await robot.system.restart()
    bench.answer("restart", 7)
    with pytest.raises(aioduco.TaskIllegal):
        await robot.system.restart()
    bench.answer("shutdown", -1)
    with pytest.raises(aioduco.Refused, match=r"refused shutdown \(answer -1\)"):
        await robot.system.shutdown()
    bench.answer("switch_mode", 7)
    with pytest.raises(aioduco.TaskIllegal, match=r"^switch_mode is not allowed"):
        await robot.system.switch_mode(1)


@pytest.mark.parametrize(
    ("answer", "error"),
    [
        (3, aioduco.TaskStopped),
        (5, aioduco.TaskInterrupted),
        (6, aioduco.TaskFailed),
        (7, aioduco.TaskIllegal),
        (8, aioduco.TaskParameterMismatch),
        (0, aioduco.Refused),
        (1, aioduco.Refused),
        (-1, aioduco.Refused),
        (99, aioduco.Refused),
    ],
)
def test_end_states_that_are_no_success(answer: int, error: type[Exception]) -> None:
    with pytest.raises(error, match="set_it"):
        check_finished("set_it", answer)


async def test_answers_that_are_a_success(robot: aioduco.Robot, bench: Bench) -> None:
    check_finished("set_it", 4)
    bench.answer("set_system_value_str", 0)
    await robot.registers.set_system_value_str("cell", "on")
    bench.answer("set_system_value_str", 2)
    with pytest.raises(aioduco.Refused, match=r"refused set_system_value_str \(answer 2\)"):
        await robot.registers.set_system_value_str("cell", "on")
